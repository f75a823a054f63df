// Area functions of tips.
#include "physics/tips/area_function.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// p of flanks that a calibration may leave hollow: it changes A/h^2 by a twentieth over an e-fold of the depth, as much as the
/// areas of one tip by two calibrations differ.
static constexpr double kMaxPower = 2.05;

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

std::optional<AreaFunction> AreaFunction::Create(const std::vector<double> &coefficients, double least, double largest)
{
  constexpr int kDepths = 4000;                     // size
  constexpr double kNearZero = 1e-6, kPower = 1e-9; // rounding: of the largest depth; of p
  AreaFunction function(coefficients);
  const double lowest = std::max(least, kNearZero * largest);
  for (int k = 0; k <= kDepths; ++k) { // down from the largest
    const double depth = largest * std::pow(lowest / largest, static_cast<double>(k) / kDepths);
    const double area = function.Fitted(depth), power = depth * function.FittedSlope(depth) / area;
    const bool is_tip = area > 0 && power >= 1 - kPower && power <= kMaxPower;
    if (function.begin_ > 0 && !is_tip) break;
    if (is_tip) function.begin_ = depth, function.area_ = area, function.power_ = power;
    function.goes_on_ = is_tip && k == kDepths && least < lowest;
  }
  if (function.begin_ == 0) return {};
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

/// By bisection, below a depth.
double AreaFunction::Depth(double area, double most) const
{
  if (area <= area_) return begin_ * std::pow(area / area_, 1 / power_);
  double low = begin_, high = most;
  while (high - low > 1e-15 * high) { // rounding
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (Area(middle) < area ? low : high) = middle;
  }
  return (low + high) / 2;
}

HeightProfile AreaFunction::ProfileOf(double shape, double height) const
{
  const double of_cone = power_ < 2 - 1e-9 ? 0 : begin_ * std::sqrt(shape / area_); // rounding: of p
  return {std::sqrt(Area(height) / shape), [&](double s) -> HeightAndSlope {
            if (s == 0) return {0, of_cone};
            const double depth = Depth(shape * s * s, 2 * height);
            return {depth, 2 * shape * s / Slope(depth)};
          }};
}

} // namespace mlgimp
