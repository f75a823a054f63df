// The largest of numbers for tests. std::max drops what is not a number, so that a law that gives nothing else would pass.
#pragma once

#include <cmath>
#include <initializer_list>

namespace mlgimp
{

/// The largest; NaN where any is NaN, which no limit holds for.
inline double Largest(std::initializer_list<double> values)
{
  double largest = -HUGE_VAL;
  for (const double value : values)
    if (!std::isnan(largest) && !(value <= largest)) largest = value;
  return largest;
}

} // namespace mlgimp
