// The watch over a slow test.
#include "program/slow_test/watch.hpp"

#include "program/system/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

static constexpr double kMinShare = 0.2; ///< of depth or load: before, shares of them say nothing
static constexpr int kSamples = 16;      ///< in a transit

/// What inertia and damping add to the load, N: no more than all of it, since other things than the tip move bodies too.
double QuasiStaticWatch::Added(const Sample &now, double load)
{
  constexpr double kMaxSpeed = 0.05;
  const double transit = plan_.pace.transit;
  if (window_.empty() || now.time - window_.back().time > transit / kSamples) window_.push_back(now);
  while (window_.size() > 1 && window_[1].time <= now.time - transit) window_.erase(window_.begin());
  const Sample &then = window_.front();
  const double time = now.time - then.time, moved = now.depth - then.depth;
  if (!(time > 0)) return 0;
  if (plan_.test.On() && time < (1 - 2.0 / kSamples) * transit) return 0; // a leg of the test has just begun
  speed_ = std::abs(moved) / time;
  const double min_moved = kMaxSpeed * now.depth / plan_.pace.transits * time / transit;
  const double added = moved != 0 ? (now.spent - then.spent) * moved / (moved * moved + min_moved * min_moved) : 0;
  return std::clamp(added, -std::abs(load), std::abs(load));
}

/// value: the load, or under load control the depth.
void QuasiStaticWatch::CheckHold(double time, double value)
{
  const auto in_last_transit = [&](const std::pair<double, double> &hold) {
    return time > hold.second - plan_.pace.transit && time <= hold.second;
  };
  const auto hold = std::find_if(plan_.holds.begin(), plan_.holds.end(), in_last_transit);
  if (hold == plan_.holds.end() || value == 0) return;
  double &least = largest_.hold_least, &most = largest_.hold_most;
  if (largest_.hold_end != hold->second) largest_.hold_end = hold->second, least = most = value;
  least = std::min(least, value), most = std::max(most, value);
  largest_.hold_drift = std::max(largest_.hold_drift, (most - least) / std::max(std::abs(most), std::abs(least)));
}

bool QuasiStaticWatch::IsLoaded(const Budgets &row) const
{
  const bool deep =
      plan_.depth > 0 ? row.depth > kMinShare * plan_.depth : row.load > std::pow(kMinShare, plan_.exponent) * plan_.load;
  return deep && row.load_quasi_static > kMinShare * largest_.load;
}

void QuasiStaticWatch::Record(Budgets &row)
{
  if (!plan_.on) return;
  if (const int leg = plan_.test.LegAt(row.schedule); leg != largest_.leg) window_.clear(), largest_.leg = leg;
  const double kinetic = row.kinetic_energy - row.noise_energy;
  row.load_quasi_static = row.load - Added({row.time, row.depth, kinetic + row.damping_work}, row.load);
  largest_.load = std::max<double>(largest_.load, row.load_quasi_static);
  CheckHold(row.schedule, plan_.depth > 0 ? row.load : row.depth);
  if (!IsLoaded(row)) return;
  const auto raise = [](double *largest, double now) { *largest = std::max(*largest, now); };
  raise(&largest_.speed, speed_);
  raise(&largest_.load_share, std::abs(row.load / row.load_quasi_static - 1));
  raise(&largest_.kinetic_share, kinetic / (plan_.rise > 0 ? row.indenter_work : row.strain_energy + row.plastic_work));
  raise(&largest_.noise_share, row.noise_energy / row.indenter_work);
}

std::vector<double> QuasiStaticWatch::State() const
{
  if (!plan_.on) return {};
  std::vector<double> state = ToNumbers(largest_);
  for (const Sample &sample : window_) state.insert(state.end(), {sample.time, sample.depth, sample.spent});
  return state;
}

void QuasiStaticWatch::SetState(const std::vector<double> &state)
{
  if (!plan_.on) return;
  largest_ = FromNumbers<Largest>(state.data());
  window_.clear();
  for (std::size_t k = kNumbersOf<Largest>; k < state.size(); k += kSample)
    window_.push_back({state[k], state[k + 1], state[k + 2]});
}

bool QuasiStaticWatch::IsState(const std::vector<double> &state) const
{
  return plan_.on ? state.size() >= kNumbersOf<Largest> && (state.size() - kNumbersOf<Largest>) % kSample == 0 : state.empty();
}

} // namespace mlgimp
