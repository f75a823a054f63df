// Legs of a test.
#include "program/case/test_legs.hpp"

namespace mlgimp
{

std::vector<TestLeg> LegsOf(std::vector<double> values, std::vector<double> times)
{
  std::vector<TestLeg> legs;
  if (values.front() != 0) values.insert(values.begin(), 0.0), times.insert(times.begin(), 0.0);
  const auto way = [](double from, double to) { return to > from ? 1 : to < from ? -1 : 0; };
  for (std::size_t k = 1; k < values.size(); ++k) {
    const int now = way(values[k - 1], values[k]);
    const bool goes_on = !legs.empty() && now == way(legs.back().values.front(), legs.back().values.back());
    if (!goes_on) legs.push_back({0, 0, {values[k - 1]}, {times[k - 1]}});
    legs.back().values.push_back(values[k]);
    legs.back().times.push_back(times[k]);
  }
  return legs;
}

std::vector<double> EndsOf(const std::vector<TestLeg> &legs)
{
  std::vector<double> ends = {legs.front().values.front()};
  for (const TestLeg &leg : legs) ends.push_back(leg.values.back());
  return ends;
}

} // namespace mlgimp
