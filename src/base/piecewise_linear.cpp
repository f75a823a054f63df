// Histories in time and their integrals.
#include "base/piecewise_linear.hpp"

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
  double value = Value(from);
  for (std::size_t k = 0; k < times_.size(); ++k)
    if (times_[k] > from && times_[k] < to) {
      sum += 0.5 * (value + values_[k]) * (times_[k] - from);
      from = times_[k];
      value = values_[k];
    }
  return sum + 0.5 * (value + Value(to)) * (to - from);
}

/// Of a list of values those at its ends and where it turns.
static std::vector<double> OnlyTurns(const std::vector<double> &values)
{
  std::vector<double> turns;
  for (double value : values) {
    const std::size_t n = turns.size();
    if (n > 0 && value == turns[n - 1]) continue;
    if (n > 1 && (turns[n - 1] > turns[n - 2]) == (value > turns[n - 1])) turns.pop_back();
    turns.push_back(value);
  }
  return turns;
}

std::vector<double> PiecewiseLinear::Turns() const
{
  std::vector<double> values = {Value(0)};
  for (std::size_t k = 0; k < times_.size(); ++k)
    if (times_[k] > 0) values.push_back(values_[k]);
  return OnlyTurns(values);
}

std::vector<double> PiecewiseLinear::EndsOfPieces(double end) const
{
  std::vector<double> ends;
  for (double time : times_)
    if (time > 0 && time < end) ends.push_back(time);
  ends.push_back(end);
  return ends;
}

std::vector<double> PiecewiseLinear::TurnsOfIntegral(double end) const
{
  std::vector<double> values = {0};
  double from = 0;
  for (double to : EndsOfPieces(end)) {
    const double v0 = Value(from), v1 = Value(to);
    if (v0 * v1 < 0) values.push_back(Integral(from + (to - from) * v0 / (v0 - v1)));
    values.push_back(Integral(to));
    from = to;
  }
  return OnlyTurns(values);
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
  double from = 0;
  for (double to : EndsOfPieces(end)) {
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
