// Legs, ramps and holds of a slow test.
#include "program/case/slow_schedule.hpp"

#include <algorithm>

namespace mlgimp
{

PiecewiseLinear SmoothRise(double value, double duration)
{
  constexpr int kPieces = 16; // size
  std::vector<double> times = {0}, values = {0};
  for (int k = 1; k <= kPieces; ++k) {
    const double s = static_cast<double>(k) / kPieces;
    times.push_back(s * duration);
    values.push_back(value * s * s * (3 - 2 * s));
  }
  return {times, values};
}

void SlowSchedule::Rest(double duration)
{
  times_.push_back(times_.back() + duration);
  speeds_.push_back(0);
}

/// Changes the speed. The straight pieces have the curve's integral, which is symmetric about its middle.
void SlowSchedule::Ramp(double to, double duration)
{
  const double start = times_.back(), from = speeds_.back();
  const PiecewiseLinear rise = SmoothRise(1, duration);
  for (std::size_t k = 1; k < rise.Times().size(); ++k) {
    times_.push_back(start + rise.Times()[k]);
    speeds_.push_back(from + (to - from) * rise.Value(rise.Times()[k]));
  }
  speeds_.back() = to; // without rounding
}

/// Goes on over a distance, which has the sign of the speed now.
void SlowSchedule::Cruise(double distance)
{
  const double duration = distance / speeds_.back();
  if (!(duration > 1e-9 * times_.back())) return; // rounding
  times_.push_back(times_.back() + duration);
  speeds_.push_back(speeds_.back());
}

/// From rest to rest; over a short distance the speed is not reached.
void SlowSchedule::Leg(double distance, double speed, double ramp)
{
  const double top = std::copysign(std::min(speed, std::abs(distance) / ramp), distance);
  Ramp(top, ramp);
  Cruise(distance - top * ramp);
  Ramp(0, ramp);
}

/// Back over a distance, slowly at first.
void SlowSchedule::Unload(double distance, double first, double slow, double fast, double ramp)
{
  const double rest = distance - first, change = 0.5 * (slow + fast) * ramp, stop = 0.5 * fast * ramp;
  if (!(fast > slow) || rest < change + stop) {
    Leg(-distance, slow, ramp);
    return;
  }
  Ramp(-slow, ramp);
  Cruise(-(first - 0.5 * slow * ramp));
  Ramp(-fast, ramp);
  Cruise(-(rest - change - stop));
  Ramp(0, ramp);
}

SlowSchedule::SlowSchedule(const SlowPace &pace, const std::vector<double> &turns, double surface)
{
  if (pace.start > 0) times_.push_back(pace.start), speeds_.push_back(0);
  const double duration = pace.transits * pace.transit, ramp = SlowPace::kRamp * duration;
  const double back = std::max(duration, SlowPace::kBack * pace.transit);
  const auto speed = [&](double x, double in) { return std::min(pace.max_speed, x / ((1 - SlowPace::kRamp) * in)); };
  for (std::size_t k = 1; k < turns.size(); ++k) {
    const double from = turns[k - 1], to = turns[k], distance = to - from, begin = times_.back();
    const bool then_rests = k + 1 < turns.size() && turns[k + 1] == to;
    if (distance > 0) {
      Leg(distance, speed(to > surface ? to - surface : distance, duration), ramp);
    } else if (distance < 0) {
      const double reached = from > surface ? from - surface : -distance, first = pace.spring_back * reached;
      Unload(-distance, first, speed(first, back), speed(reached, duration), ramp);
    } else {
      Rest(duration);
    }
    legs_.emplace_back(begin, times_.back());
    if (distance > 0 && !then_rests) {
      holds_.emplace_back(times_.back(), times_.back() + SlowPace::kHold * pace.transit);
      Rest(SlowPace::kHold * pace.transit);
    }
  }
}

double SlowSchedule::LargestSpeed() const { return PiecewiseLinear(times_, speeds_).LargestMagnitude(0, EndTime()); }

PiecewiseLinear SlowSchedule::Power(double power) const
{
  constexpr int kPieces = 16; // size
  const PiecewiseLinear speed = Speed();
  std::vector<double> times = {0}, values = {0};
  double x = 0, largest = 0;
  for (std::size_t k = 1; k < times_.size(); ++k) {
    const double T = times_[k] - times_[k - 1], v0 = speeds_[k - 1], v1 = speeds_[k];
    const bool resting = v0 == 0 && v1 == 0, cruising = v0 == v1 && !resting;
    const int pieces = cruising ? 4 * kPieces : resting ? 1 : 2;
    for (int piece = 1; piece <= pieces; ++piece) {
      const double t = T * piece / pieces;
      times.push_back(times_[k - 1] + t);
      values.push_back(std::pow(std::max(0.0, x + t * (v0 + 0.5 * (v1 - v0) * t / T)), power));
    }
    x += 0.5 * (v0 + v1) * T;
    largest = std::max(largest, x);
    if (x < 1e-12 * largest) x = values.back() = 0; // no load is none
  }
  return {times, values};
}

} // namespace mlgimp
