// Histories in time.
#pragma once

#include <vector>

namespace mlgimp
{

/// Piecewise-linear history of a quantity, constant before the first and after the last time; zero without any.
class PiecewiseLinear
{
public:
  PiecewiseLinear() = default;
  PiecewiseLinear(std::vector<double> times, std::vector<double> values) : times_(std::move(times)), values_(std::move(values)) {}
  double Value(double t) const;
  double Integral(double t) const { return Between(0, t); } ///< from 0 to t
  double Mean(double from, double to) const { return Between(from, to) / (to - from); }
  const std::vector<double> &Times() const { return times_; }
  double EndTime() const { return times_.empty() ? 0 : times_.back(); }
  double EndValue() const { return values_.empty() ? 0 : values_.back(); }
  /// The value at time 0, those where it turns from rising to falling or back, and that at the last time.
  std::vector<double> Turns() const;
  /// The same of the integral from 0 to `end`.
  std::vector<double> TurnsOfIntegral(double end) const;
  double LargestMagnitude(double from, double to) const;
  /// First t in (0, end] where the integral reaches `target` > 0; infinity where it does not.
  double TimeOfIntegral(double target, double end) const;

private:
  double Between(double from, double to) const; ///< the integral
  /// Where the straight lines between 0 and `end` end.
  std::vector<double> EndsOfPieces(double end) const;

  std::vector<double> times_, values_;
};

} // namespace mlgimp
