// The motion of a slow test: legs from turn to turn, without a jump in speed.
#pragma once

#include "base/piecewise_linear.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace mlgimp
{

/// How slowly a test goes, in transits: times that a wave takes from the contact to the farthest end of the bodies.
struct SlowPace {
  double transit = 0;          ///< s
  double transits = 0;         ///< of a loading from nothing, and at least of the first part of an unloading
  double max_speed = HUGE_VAL; ///< of any motion, per second
  double spring_back = 1;      ///< share of what was reached that the first part of an unloading gives back
  double start = 0;            ///< of the first leg, s

  static constexpr double kRamp = 0.2; ///< share of a leg's time in which its speed rises, and again in which it falls
  static constexpr double kHold = 8;   ///< transits of rest before an unloading
  static constexpr double kBack = 16;  ///< least transits of the first part of an unloading, whose slope is wanted
};

/// From 0 to a value along 3 s^2 - 2 s^3, in straight pieces, and constant then.
PiecewiseLinear SmoothRise(double value, double duration);

/// The history of a quantity x (a depth, or a root of a load) that begins with 0 and passes through given turns. A leg into the
/// body from x0 to x1 > x0 has the speed of a loading from nothing to x1 in the given transits, x1/((1 - r) N T), with S-shaped
/// ramps of r N T, r = kRamp. A hold follows. A leg back has first the speed of spring_back x in max(N, kBack) T, then that of a
/// loading.
/// Two equal turns are a rest of N T, which stands for a hold of a test; then no other hold comes before it.
class SlowSchedule
{
public:
  /// surface: the x from which on the body is met; the leg that leads to it counts from there.
  SlowSchedule(const SlowPace &pace, const std::vector<double> &turns, double surface = 0);

  /// dx/dt: straight lines between many times.
  PiecewiseLinear Speed() const { return {times_, speeds_}; }
  /// x^power, straight lines between more times.
  PiecewiseLinear Power(double power) const;
  double EndTime() const { return times_.back(); }
  double LargestSpeed() const;
  /// Begin and end of each rest, s.
  const std::vector<std::pair<double, double>> &Holds() const { return holds_; }
  /// Begin and end of the way to each turn after the first, without the hold that may follow, s.
  const std::vector<std::pair<double, double>> &Legs() const { return legs_; }

private:
  void Rest(double duration);
  void Ramp(double to, double duration);
  void Cruise(double distance);
  void Leg(double distance, double speed, double ramp);
  void Unload(double distance, double first, double slow, double fast, double ramp);

  std::vector<double> times_{0}, speeds_{0};
  std::vector<std::pair<double, double>> holds_, legs_;
};

} // namespace mlgimp
