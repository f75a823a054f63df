// Histories in time and their integrals.
#include "pointwise/piecewise_linear.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

double PiecewiseLinear::Value(double t) const
{
  if (times_.empty()) return 0;
  if (t <= times_.front()) return values_.front();
  for (std::size_t k = 1; k < times_.size(); ++k)
    if (t < times_[k]) return values_[k - 1] + (values_[k] - values_[k - 1]) * (t - times_[k - 1]) / (times_[k] - times_[k - 1]);
  return values_.back();
}

double PiecewiseLinear::Between(double from, double to) const
{
  double sum = 0;
  for (double knot : times_)
    if (knot > from && knot < to) {
      sum += 0.5 * (Value(from) + Value(knot)) * (knot - from);
      from = knot;
    }
  return sum + 0.5 * (Value(from) + Value(to)) * (to - from);
}

double PiecewiseLinear::LargestMagnitude(double from, double to) const
{
  double largest = std::max(std::abs(Value(from)), std::abs(Value(to)));
  for (std::size_t k = 0; k < times_.size(); ++k)
    if (times_[k] > from && times_[k] < to) largest = std::max(largest, std::abs(values_[k]));
  return largest;
}

double PiecewiseLinear::TimeOfIntegral(double target, double end) const
{
  std::vector<double> knots;
  for (double knot : times_)
    if (knot > 0 && knot < end) knots.push_back(knot);
  knots.push_back(end);
  double from = 0;
  for (double to : knots) {
    // Within a piece the integral is I + v0 s + (v1 - v0) s^2/(2 T).
    const double v0 = Value(from), v1 = Value(to), T = to - from, need = target - Integral(from);
    const double a = 0.5 * (v1 - v0) / T, root2 = v0 * v0 + 4 * a * need;
    if (root2 >= 0) {
      const double s = 2 * need / (v0 + std::sqrt(root2)); // the smaller positive root, also where a = 0
      if (s >= 0 && s <= T * (1 + 1e-12)) return from + s;
    }
    from = to;
  }
  return HUGE_VAL;
}

} // namespace mlgimp
