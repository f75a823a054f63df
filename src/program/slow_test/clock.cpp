// The test's clock.
#include "program/slow_test/clock.hpp"

#include "hierarchy/run_budgets.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

static constexpr double kAtRest = 1e30;    // size: simulated time over that of a test whose time rests
static constexpr double kSmallTime = 1e-9; // rounding: of transits and of times of the test

/// In a state rate, more load and the largest value stand first, the transits of each leg so far behind them, then the samples.
static constexpr std::size_t kNumbers = 3, kSample = 4; // size

/// Depth or load that the schedule has at a time of its own.
double TestClock::ValueAt(double schedule) const
{
  const Indenter &indenter = *case_.model.indenter;
  return indenter.by_load ? indenter.by_load->Value(schedule) : indenter.Depth(indenter.Tip(schedule));
}

TimeStep TestClock::Step(double time, double dt)
{
  if (!On()) return {time, dt, case_.time.rate_scale};
  const auto &legs = case_.quasi_static.test.legs;
  const double schedule = time - state_.delay;
  const int at = case_.quasi_static.test.LegAt(schedule);
  if (at < 0) return {time, dt, kAtRest};
  const TestLeg &leg = legs[at];
  const double passes =
      leg.Holds() ? std::min(rate_ * dt, leg.times.back() - state_.time) : leg.TimeOf(ValueAt(schedule + dt)) - state_.time;
  state_.clock[kNumbers + at] += dt / case_.quasi_static.pace.transit;
  if (!(passes > 0)) return {time, dt, kAtRest};
  state_.time += passes;
  return {time, dt, std::min(dt / passes, kAtRest)};
}

/// Takes a sample of the tip and of what acts on it. Collective.
void TestClock::Look(Hierarchy &hierarchy, double time)
{
  const Indenter &indenter = *case_.model.indenter;
  double sums[2] = {};
  for (const Budgets *part : PartsOfBudgets(hierarchy.Connected()))
    sums[0] -= part->contact_impulse.value[indenter.up], sums[1] += part->damping_work;
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, hierarchy.Comm());
  window_.push_back({time, indenter.Depth(hierarchy.Tip().At(time)), sums[0], sums[1]});
  if (indenter.by_load)
    largest_ = std::max(largest_, window_.back().depth);
  else if (window_.size() > 1)
    largest_ = std::max(largest_, MeanLoad(window_[window_.size() - 2], window_.back()));
  while (window_.size() > 1 && window_[1].time <= time - case_.quasi_static.pace.transit) window_.erase(window_.begin());
}

/// Of the time since a hold began, what had passed before: that of the leg that leads to it, or, where the load is there at once,
/// a share of the hold.
double TestClock::ReferenceTime(int leg) const
{
  constexpr double kFirst = 1e-6;
  const auto &legs = case_.quasi_static.test.legs;
  const double before = leg > 0 ? legs[leg - 1].Duration() : 0;
  return before > 0 ? before : kFirst * legs[leg].Duration();
}

/// The mean rate of the leg before a hold.
double TestClock::StartRate(int leg) const
{
  const QuasiStaticPlan &plan = case_.quasi_static;
  return ReferenceTime(leg) / (plan.pace.transits * plan.pace.transit);
}

/// v*/v of the last transit, as far as r follows it: 1/2 to 2.
double TestClock::AllowedOverSpeed() const
{
  const QuasiStaticPlan &plan = case_.quasi_static;
  const Sample &then = window_.front(), &now = window_.back(), &middle = window_[window_.size() / 2];
  if (window_.size() < 3) return 1;
  double change = now.depth - then.depth, passed = now.time - then.time;
  if (!case_.model.indenter->by_load) {
    change = MeanLoad(middle, now) - MeanLoad(then, middle);
    passed *= 0.5;
  }
  const double allowed = plan.test.creep * largest_ * passed / plan.pace.transit;
  return std::abs(change) > 0.5 * allowed ? std::max(allowed / std::abs(change), 0.5) : 2;
}

/// Load that damping takes up, N: its work over the way of the tip in the last transit. Small ways, as those of a tip that swings
/// about, count less, as in QuasiStaticWatch.
double TestClock::Drag(double schedule) const
{
  const QuasiStaticPlan &plan = case_.quasi_static;
  const Sample &then = window_.front(), &now = window_.back();
  const double moved = now.depth - then.depth, work = now.drag - then.drag;
  const double least = plan.tolerance * std::abs(now.depth) / plan.pace.transits;
  const double drag = moved != 0 ? work * moved / (moved * moved + least * least) : 0;
  const double most = plan.tolerance * ValueAt(schedule);
  return std::clamp(drag, -most, most);
}

void TestClock::Check(Hierarchy &hierarchy, double time, double dt)
{
  constexpr double kGrowth = 4;
  if (!On()) return;
  const QuasiStaticPlan &plan = case_.quasi_static;
  const double elapsed = kControlInterval * dt, schedule = time - state_.delay;
  Look(hierarchy, time);
  const int at = plan.test.LegAt(schedule);
  const bool holds = at >= 0 && plan.test.legs[at].Holds();
  more_load_ = holds && case_.model.indenter->by_load ? Drag(schedule) : 0;
  if (!holds) {
    rate_ = 0;
  } else {
    const TestLeg &leg = plan.test.legs[at];
    const double since = state_.time - leg.times.front() + ReferenceTime(at), left = leg.times.back() - state_.time;
    rate_ = rate_ == 0 ? StartRate(at) : rate_ * std::pow(AllowedOverSpeed(), elapsed / plan.pace.transit);
    rate_ = std::min(rate_, kGrowth * plan.test.creep * since / plan.pace.transit);
    const bool ends = rate_ * elapsed >= left * (1 - kSmallTime);
    if (ends) rate_ = left / elapsed;
    const double share = std::log((since + rate_ * elapsed) / ReferenceTime(at)) / std::log1p(leg.Duration() / ReferenceTime(at));
    const double next = leg.begin + (leg.end - leg.begin) * share; // where the schedule is at the next check
    state_.delay = time + elapsed - (ends ? leg.end : std::clamp(next, leg.begin + elapsed, leg.end - elapsed));
  }
  hierarchy.Tip().SetClock({state_.delay, more_load_});
  KeepState();
}

void TestClock::KeepState()
{
  state_.clock.resize(kNumbers + case_.quasi_static.test.legs.size());
  state_.clock[0] = rate_, state_.clock[1] = more_load_, state_.clock[2] = largest_;
  for (const Sample &sample : window_)
    state_.clock.insert(state_.clock.end(), {sample.time, sample.depth, sample.impulse, sample.drag});
}

void TestClock::TakeState(Hierarchy &hierarchy)
{
  if (!On()) return;
  const std::size_t first = kNumbers + case_.quasi_static.test.legs.size();
  std::vector<double> &state = state_.clock;
  state.resize(std::max(state.size(), first));
  rate_ = state[0], more_load_ = state[1], largest_ = state[2];
  for (std::size_t k = first; k + kSample <= state.size(); k += kSample)
    window_.push_back({state[k], state[k + 1], state[k + 2], state[k + 3]});
  hierarchy.Tip().SetClock({state_.delay, more_load_});
}

double TestClock::TransitsOf(const std::vector<double> &state, std::size_t leg) { return state[kNumbers + leg]; }

bool TestClock::IsState(const std::vector<double> &state, std::size_t legs)
{
  return legs == 0 ? state.empty() : state.size() >= kNumbers + legs && (state.size() - kNumbers - legs) % kSample == 0;
}

} // namespace mlgimp
