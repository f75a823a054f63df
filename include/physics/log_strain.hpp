// Logarithmic strain of metals: the logarithm and the exponential of tensors, in loops that vectorise.
//
// In the plane both are functions of the two by two of x and y, and of zz by itself. In space a function of a tensor y without
// trace is c0 I + c1 y + c2 y^2, as y^3 = (y:y/2) y + det(y) I: the powers of a series need no tensors. Elastic strains of metals
// are small, and few terms give all digits; large ones go by principal values.
#pragma once

#include "base/log.hpp"
#include "base/spectral.hpp"
#include "base/tensor.hpp"

#include <cmath>

namespace mlgimp
{

/// The deviator of (ln b)/2 of a symmetric positive tensor b.
struct LogStrain {
  Sym3 deviator; ///< e'
  double norm2;  ///< about 4 e':e'; where it is above kLargestNorm2, LogarithmicStrain is not to be used
};
inline constexpr double kLargestNorm2 = 0.01; // rounding

/// Where b has the plane's components only: by ln b = (ln det)/2 I + atanh(s) n in the plane, with n the deviator of the two by
/// two over its size, s its size over half its trace; and by the ratio of those two and zz.
[[gnu::always_inline]] inline LogStrain LogarithmicStrainInPlane(const Sym3 &b)
{
  const double middle = 0.5 * (b.xx + b.yy), d = 0.5 * (b.xx - b.yy);
  const double radius2 = d * d + b.xy * b.xy, determinant = middle * middle - radius2, zz2 = b.zz * b.zz;
  const double sum = determinant + zz2, inverse_both = 1 / (middle * sum), inverse = sum * inverse_both; // one division
  const double s2 = radius2 * inverse * inverse, ratio = (determinant - zz2) * middle * inverse_both;
  const double shear = 0.5 * AtanhRatio(s2) * inverse, e = 0.5 * kThird * ratio * AtanhRatio(ratio * ratio);
  return {{e + shear * d, e - shear * d, -2 * e, shear * b.xy, 0, 0}, 2 * s2 + 2 * kThird * ratio * ratio};
}

/// cosh x and sinh(x)/x by their series in x^2, to round-off for |x| < 0.1.
struct Hyperbolic {
  [[gnu::always_inline]] explicit Hyperbolic(double x2)
  {
#pragma GCC unroll 4
    for (int k = 6; k >= 0; k -= 2) even = even * x2 + kInverseFactorial[k], odd = odd * x2 + kInverseFactorial[k + 1];
  }
  double even = kInverseFactorial[8], odd = kInverseFactorial[9];
};

/// exp(a) of a tensor of the plane without trace.
[[gnu::always_inline]] inline Sym3 ExponentialInPlane(const Sym3 &a)
{
  const double middle = 0.5 * (a.xx + a.yy), d = 0.5 * (a.xx - a.yy);
  const Hyperbolic shear(d * d + a.xy * a.xy), both(middle * middle);
  const double growth = both.even + middle * both.odd, inverse = both.even - middle * both.odd; // exp(middle), exp(-middle)
  const double spread = growth * shear.odd;
  return {growth * shear.even + spread * d, growth * shear.even - spread * d, inverse * inverse, spread * a.xy, 0, 0};
}

/// y y for a symmetric y.
inline Sym3 Square(const Sym3 &y)
{
  return {y.xx * y.xx + y.xy * y.xy + y.xz * y.xz, y.xy * y.xy + y.yy * y.yy + y.yz * y.yz,
          y.xz * y.xz + y.yz * y.yz + y.zz * y.zz, y.xx * y.xy + y.xy * y.yy + y.xz * y.yz,
          y.xy * y.xz + y.yy * y.yz + y.yz * y.zz, y.xx * y.xz + y.xy * y.yz + y.xz * y.zz};
}

/// The next power of a tensor without trace, as coefficients of I, y and y^2. half: y:y/2.
struct PowerOf {
  double c0, c1, c2;
  PowerOf Next(double half, double determinant) const { return {determinant * c2, c0 + half * c2, c1}; }
};

/// From the series of ln(1 + y), y = b/(tr b/3) - I.
template <bool in_plane> [[gnu::always_inline]] inline LogStrain LogarithmicStrain(const Sym3 &b)
{
  if constexpr (in_plane) return LogarithmicStrainInPlane(b);
  constexpr int kTerms = 14; // rounding
  const Sym3 y = (3 / Trace(b)) * b - Sphere(1), square = Square(y);
  const double norm2 = Trace(square), determinant = kThird * Contract(square, y);
  PowerOf power = {0, 1, 0};
  double c1 = 1, c2 = 0;
#pragma GCC unroll 14
  for (int k = 2; k <= kTerms; ++k) {
    power = power.Next(0.5 * norm2, determinant);
    const double factor = (k % 2 ? 1.0 : -1.0) / k;
    c1 += factor * power.c1, c2 += factor * power.c2;
  }
  return {0.5 * (c1 * y + c2 * (square - Sphere(kThird * norm2))), norm2};
}

/// exp(a) of a tensor without trace, a:a at most kLargestNorm2 or little more.
template <bool in_plane> [[gnu::always_inline]] inline Sym3 Exponential(const Sym3 &a)
{
  if constexpr (in_plane) return ExponentialInPlane(a);
  constexpr int kTerms = 11; // rounding
  const Sym3 square = Square(a);
  const double half = 0.5 * Trace(square), determinant = kThird * Contract(square, a);
  PowerOf power = {0, 1, 0};
  double c0 = 1, c1 = 1, c2 = 0, factor = 1;
#pragma GCC unroll 11
  for (int k = 2; k <= kTerms; ++k) {
    power = power.Next(half, determinant);
    factor /= k;
    c0 += factor * power.c0, c1 += factor * power.c1, c2 += factor * power.c2;
  }
  return Sphere(c0) + c1 * a + c2 * square;
}

/// The same two by principal values, for any b and a.
inline LogStrain LogarithmicStrainOfLarge(const Sym3 &b)
{
  const Spectrum spectrum = Decompose(b);
  const Vec3 e = {0.5 * Log(spectrum.value[0]), 0.5 * Log(spectrum.value[1]), 0.5 * Log(spectrum.value[2])};
  const double mean = (e[0] + e[1] + e[2]) / 3;
  return {spectrum.Compose(e - Vec3{mean, mean, mean}), HUGE_VAL};
}
inline Sym3 ExponentialOfLarge(const Sym3 &a)
{
  const Spectrum spectrum = Decompose(a);
  return spectrum.Compose({std::exp(spectrum.value[0]), std::exp(spectrum.value[1]), std::exp(spectrum.value[2])});
}

} // namespace mlgimp
