// Area functions of tips.
#include "physics/tips/area_function.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// p of flanks that a calibration may leave hollow: it changes A/h^2 by a twentieth over an e-fold of the depth, as much as the
/// areas of one tip by two calibrations differ.
static constexpr double kMaxPower = 2.05;
/// Times h_m, up to where the function must be that of a tip: a decade, as calibrations span one or more.
static constexpr double kFaithful = 10;

double AreaFunction::Fitted(double depth) const
{
  double area = coefficients_[0] * depth * depth, root = depth;
  for (std::size_t k = 1; k < coefficients_.size(); ++k, root = std::sqrt(root)) area += coefficients_[k] * root;
  return area;
}

double AreaFunction::FittedSlope(double depth) const
{
  double slope = 2 * coefficients_[0] * depth, root = depth, exponent = 1;
  for (std::size_t k = 1; k < coefficients_.size(); ++k, root = std::sqrt(root), exponent /= 2)
    slope += coefficients_[k] * exponent * root / depth;
  return slope;
}

double AreaFunction::FittedPower(double depth) const
{
  const double area = Fitted(depth);
  return area > 0 ? depth * FittedSlope(depth) / area : NAN;
}

std::optional<AreaFunction> AreaFunction::Create(const std::vector<double> &coefficients, double least, double largest)
{
  constexpr int kDepths = 4000;                     // size
  constexpr double kNearZero = 1e-6, kPower = 1e-9; // rounding: of the largest depth; of p
  AreaFunction function(coefficients);
  const double lowest = std::max(least, kNearZero * largest);
  int below = kDepths; // the place of a depth from which on none has failed
  const auto depth_at = [&](int k) { return lowest * std::pow(largest / lowest, static_cast<double>(k) / kDepths); };
  for (int k = kDepths, failed = kDepths + 1; k >= 0; --k) {
    const double power = function.FittedPower(depth_at(k));
    if (!(power >= 1 - kPower && power <= kMaxPower)) failed = k;
    if (failed > k && (failed > kDepths || depth_at(failed) >= kFaithful * depth_at(k))) below = k;
  }
  const double begin = depth_at(below);
  if (!(function.FittedPower(begin) >= 1 - kPower && function.FittedPower(begin) <= kMaxPower)) return {};
  function.goes_on_ = below == 0 && least < lowest;
  function.begin_ = begin, function.area_ = function.Fitted(begin), function.power_ = function.FittedPower(begin);
  function.end_ = largest;
  for (int k = kDepths; k > below; --k) // beyond its last calibrated depth a function may fall again
    if (!(function.FittedPower(depth_at(k)) > 0)) function.end_ = depth_at(k - 1);
  return function;
}

double AreaFunction::Area(double depth) const
{
  return depth < begin_ ? area_ * std::pow(depth / begin_, power_) : Fitted(depth);
}

double AreaFunction::Slope(double depth) const
{
  return depth < begin_ ? power_ * area_ / begin_ * std::pow(depth / begin_, power_ - 1) : FittedSlope(depth);
}

/// By bisection.
double AreaFunction::Depth(double area) const
{
  if (area <= area_) return begin_ * std::pow(area / area_, 1 / power_);
  double low = begin_, high = end_;
  while (high - low > 1e-15 * high) { // rounding
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (Area(middle) < area ? low : high) = middle;
  }
  return (low + high) / 2;
}

HeightProfile AreaFunction::ProfileOf(double shape) const
{
  const double of_cone = power_ < 2 - 1e-9 ? 0 : begin_ * std::sqrt(shape / area_); // rounding: of p
  return {std::sqrt(Area(end_) / shape), [&](double s) -> HeightAndSlope {
            if (s == 0) return {0, of_cone};
            const double depth = Depth(shape * s * s);
            return {depth, 2 * shape * s / Slope(depth)};
          }};
}

} // namespace mlgimp
