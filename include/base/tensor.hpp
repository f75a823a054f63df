// Small vectors and tensors. In two dimensions the third component is zero.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace mlgimp
{

using Vec3 = std::array<double, 3>;

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double Dot(Vec3 a, Vec3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double Norm(Vec3 a) { return std::hypot(std::hypot(a[0], a[1]), a[2]); }

inline double LargestComponent(Vec3 a) { return std::max(a[0], std::max(a[1], a[2])); }

/// det F of a tensor stored by rows [dim][dim].
inline double Determinant(const double *F, int dim)
{
  if (dim == 2) return F[0] * F[3] - F[1] * F[2];
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

/// A vector of the plane turned by -90 degrees: from a tangent with the body on its left to the outward normal.
inline Vec3 TurnRight(Vec3 a) { return {a[1], -a[0], 0}; }

/// F a in the plane, for F stored as xx, xy, yx, yy.
inline Vec3 Multiply(const double F[4], Vec3 a) { return {F[0] * a[0] + F[1] * a[1], F[2] * a[0] + F[3] * a[1], 0}; }

} // namespace mlgimp
