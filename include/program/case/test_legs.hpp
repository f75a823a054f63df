// The test that a slow run stands for: its legs in its own time, which a laboratory's clock shows.
#pragma once

#include <cstddef>
#include <vector>

namespace mlgimp
{

/// A part of a test: the tip is driven one way, through given values (depths below the surface, m, or loads, N) at given times of
/// the test, s, along straight lines between them; or it rests.
struct TestLeg {
  double begin = 0, end = 0;         ///< in the schedule, s
  std::vector<double> values, times; ///< at least two; of a hold the values are the same
  bool Holds() const { return values.front() == values.back(); }
  double Duration() const { return times.back() - times.front(); }
  /// When the test passes a value, s: at the first time before it begins, at the last when it has ended.
  double TimeOf(double value) const
  {
    const double sign = values.back() > values.front() ? 1 : -1;
    if (sign * (value - values.front()) <= 0) return times.front();
    for (std::size_t k = 1; k < values.size(); ++k)
      if (sign * (value - values[k]) < 0)
        return times[k - 1] + (times[k] - times[k - 1]) * ((value - values[k - 1]) / (values[k] - values[k - 1]));
    return times.back();
  }
};

/// Where a test is: what its clock keeps from step to step.
struct TestState {
  double time = 0;           ///< of the test, s
  double delay = 0;          ///< by which the indenter's schedule has waited for its clock, s
  std::vector<double> clock; ///< numbers of TestClock
};

/// The legs of a test through values at times; without a time in the schedule. A test that does not begin with nothing begins
/// with a leg from nothing at time 0 on.
std::vector<TestLeg> LegsOf(std::vector<double> values, std::vector<double> times);

/// Values at the ends of the legs, from the first on: equal ones one after the other are a hold.
std::vector<double> EndsOf(const std::vector<TestLeg> &legs);

} // namespace mlgimp
