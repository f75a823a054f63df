// A tip's area function, as it is calibrated: its projected area over the distance from its end.
#pragma once

#include "physics/tips/height_profile.hpp"

#include <optional>
#include <vector>

namespace mlgimp
{

/// A(h) = C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) + ..., Oliver and Pharr, J. Mater. Res. 7 (1992) 1564. A fitted function is no
/// tip down to h = 0, where its last terms rule: below h_m, the least depth from which up to ten times that its power p = h A'/A
/// is between that of a paraboloid, 1, and that of a cone, 2, or a little more, it goes on as A_m (h/h_m)^p, which keeps A, A'
/// and the place of the end.
class AreaFunction
{
public:
  /// coefficients: in m^2 of h in m. The function holds for depths from `least` to `largest`, m. Nothing where no depth between
  /// them may be h_m.
  static std::optional<AreaFunction> Create(const std::vector<double> &coefficients, double least, double largest);

  double Area(double depth) const;  ///< m2, of a depth in m
  double Slope(double depth) const; ///< m
  /// h_m, m; 0 where the function itself is that of a tip down to its end.
  double Begin() const { return goes_on_ ? 0 : begin_; }
  /// Up to which the area grows, at most the largest, m.
  double End() const { return end_; }

  /// The profile of a tip whose section, where its half width (of a pyramid the radius of the inscribed circle) is s, has the
  /// area shape s^2.
  HeightProfile ProfileOf(double shape) const;

private:
  explicit AreaFunction(const std::vector<double> &coefficients) : coefficients_(coefficients) {}
  double Fitted(double depth) const;
  double FittedSlope(double depth) const;
  double FittedPower(double depth) const; ///< not a number where there is no area
  double Depth(double area) const;

  std::vector<double> coefficients_;
  double begin_ = 0, area_ = 0, power_ = 2; ///< h_m, A_m and p
  double end_ = 0;                          ///< largest depth up to which the area grows, m
  bool goes_on_ = false;                    ///< the search for h_m found none above rounding
};

} // namespace mlgimp
