// Principal values and directions of a symmetric tensor.
#pragma once

#include "base/tensor.hpp"

namespace mlgimp
{

/// value[k]: principal values in no order; the columns of `directions` are their directions, a rotation.
struct Spectrum {
  Vec3 value;
  Mat3 directions;

  /// The tensor with these directions and other principal values.
  Sym3 Compose(const Vec3 &v) const
  {
    const Mat3 &d = directions;
    return SymmetricProduct(
        {v[0] * d.xx, v[1] * d.xy, v[2] * d.xz, v[0] * d.yx, v[1] * d.yy, v[2] * d.yz, v[0] * d.zx, v[1] * d.zy, v[2] * d.zz}, d);
  }
};

/// Turns the plane of two axes so that `between`, their component of the tensor, vanishes. first, second: the diagonal;
/// first_other, second_other: components with the third axis; u, v: the columns of the directions.
inline void TurnPlane(double &first, double &second, double &between, double &first_other, double &second_other, Vec3 &u, Vec3 &v)
{
  const double twice = 2 * between, difference = second - first;
  if (std::abs(between) <= 1e-17 * (std::abs(first) + std::abs(second))) {
    between = 0;
    return;
  }
  // tan of the angle, at most 45 degrees, from the tangent of twice the angle
  const double t = twice / (difference + std::copysign(std::sqrt(difference * difference + twice * twice), difference));
  const double c = 1 / std::sqrt(1 + t * t), s = t * c, other = first_other;
  first -= t * between, second += t * between, between = 0;
  first_other = c * other - s * second_other, second_other = s * other + c * second_other;
  const Vec3 old = u;
  u = c * old - s * v, v = s * old + c * v;
}

/// By Jacobi's rotations: one where the tensor has a principal axis along z, some ten otherwise.
inline Spectrum Decompose(Sym3 a)
{
  Vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
  constexpr int kMaxSweeps = 12; // rounding
  for (int sweep = 0; sweep < kMaxSweeps && (a.xy != 0 || a.yz != 0 || a.xz != 0); ++sweep) {
    TurnPlane(a.xx, a.yy, a.xy, a.xz, a.yz, x, y);
    TurnPlane(a.yy, a.zz, a.yz, a.xy, a.xz, y, z);
    TurnPlane(a.xx, a.zz, a.xz, a.xy, a.yz, x, z);
  }
  return {{a.xx, a.yy, a.zz}, {x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]}};
}

} // namespace mlgimp
