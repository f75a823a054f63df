// Small vectors and tensors. In two dimensions the third component of a vector is zero.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace mlgimp
{

inline constexpr double kThird = 1.0 / 3; // exact

using Vec3 = std::array<double, 3>;

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Vec3 Cross(Vec3 a, Vec3 b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }
inline double Dot(Vec3 a, Vec3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double Norm(Vec3 a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

inline double LargestComponent(Vec3 a) { return std::max(a[0], std::max(a[1], a[2])); }

/// 3 x^2 - 2 x^3, from 0 at 0 to 1 at 1, and beyond as there.
inline double SmoothStep(double x)
{
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

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

// Loops over points vectorise only where all that they call is inlined; the attribute makes GCC inline in large loops too.

/// A second-order tensor by rows.
struct Mat3 {
  double xx, xy, xz, yx, yy, yz, zx, zy, zz;
};

/// A symmetric one.
struct Sym3 {
  double xx, yy, zz, xy, yz, xz;
};

inline Sym3 operator+(const Sym3 &a, const Sym3 &b)
{
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.yz + b.yz, a.xz + b.xz};
}
inline Sym3 operator-(const Sym3 &a, const Sym3 &b)
{
  return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.yz - b.yz, a.xz - b.xz};
}
inline Sym3 operator*(double s, const Sym3 &a) { return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.yz, s * a.xz}; }
/// p I.
inline Sym3 Sphere(double p) { return {p, p, p, 0, 0, 0}; }
inline double Trace(const Sym3 &a) { return a.xx + a.yy + a.zz; }
/// a : b.
[[gnu::always_inline]] inline double Contract(const Sym3 &a, const Sym3 &b)
{
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2 * (a.xy * b.xy + a.yz * b.yz + a.xz * b.xz);
}

inline double Determinant(const Mat3 &a)
{
  return a.xx * (a.yy * a.zz - a.yz * a.zy) - a.xy * (a.yx * a.zz - a.yz * a.zx) + a.xz * (a.yx * a.zy - a.yy * a.zx);
}
inline double Determinant(const Sym3 &a)
{
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
}
/// det(a) a^-1.
[[gnu::always_inline]] inline Sym3 Adjugate(const Sym3 &a)
{
  return {a.yy * a.zz - a.yz * a.yz, a.xx * a.zz - a.xz * a.xz, a.xx * a.yy - a.xy * a.xy,
          a.xz * a.yz - a.xy * a.zz, a.xy * a.xz - a.xx * a.yz, a.xy * a.yz - a.xz * a.yy};
}
inline Mat3 Transposed(const Mat3 &a) { return {a.xx, a.yx, a.zx, a.xy, a.yy, a.zy, a.xz, a.yz, a.zz}; }
/// (a + a^T)/2.
inline Sym3 SymmetricPart(const Mat3 &a)
{
  return {a.xx, a.yy, a.zz, 0.5 * (a.xy + a.yx), 0.5 * (a.yz + a.zy), 0.5 * (a.xz + a.zx)};
}
/// The symmetric a b^T.
[[gnu::always_inline]] inline Sym3 SymmetricProduct(const Mat3 &a, const Mat3 &b)
{
  return {a.xx * b.xx + a.xy * b.xy + a.xz * b.xz, a.yx * b.yx + a.yy * b.yy + a.yz * b.yz,
          a.zx * b.zx + a.zy * b.zy + a.zz * b.zz, a.xx * b.yx + a.xy * b.yy + a.xz * b.yz,
          a.yx * b.zx + a.yy * b.zy + a.yz * b.zz, a.xx * b.zx + a.xy * b.zy + a.xz * b.zz};
}
/// a s a^T. in_plane: of what has z to itself only zz is not zero.
template <bool in_plane = false> [[gnu::always_inline]] inline Sym3 Push(const Mat3 &a, const Sym3 &s)
{
  if constexpr (in_plane) {
    const double xx = a.xx * s.xx + a.xy * s.xy, xy = a.xx * s.xy + a.xy * s.yy; // a s
    const double yx = a.yx * s.xx + a.yy * s.xy, yy = a.yx * s.xy + a.yy * s.yy;
    return {xx * a.xx + xy * a.xy, yx * a.yx + yy * a.yy, a.zz * a.zz * s.zz, xx * a.yx + xy * a.yy, 0, 0};
  }
  const Mat3 product = {
      a.xx * s.xx + a.xy * s.xy + a.xz * s.xz, a.xx * s.xy + a.xy * s.yy + a.xz * s.yz, a.xx * s.xz + a.xy * s.yz + a.xz * s.zz,
      a.yx * s.xx + a.yy * s.xy + a.yz * s.xz, a.yx * s.xy + a.yy * s.yy + a.yz * s.yz, a.yx * s.xz + a.yy * s.yz + a.yz * s.zz,
      a.zx * s.xx + a.zy * s.xy + a.zz * s.xz, a.zx * s.xy + a.zy * s.yy + a.zz * s.yz, a.zx * s.xz + a.zy * s.yz + a.zz * s.zz};
  return SymmetricProduct(product, a);
}

} // namespace mlgimp
