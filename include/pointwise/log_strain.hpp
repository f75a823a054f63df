// Logarithmic strain of metals: the logarithm and the exponential of tensors, in loops that vectorise.
//
// A function of a tensor y without trace is c0 I + c1 y + c2 y^2, as y^3 = (y:y/2) y + det(y) I: the powers of a series need
// no tensors. Elastic strains of metals are small, and some fifteen terms give all digits; large ones go by principal values.
#pragma once

#include "base/log.hpp"
#include "base/spectral.hpp"
#include "base/tensor.hpp"

#include <cmath>

namespace mlgimp
{

/// (ln b)/2 of a symmetric positive tensor b.
struct LogStrain {
  Sym3 deviator; ///< e'
  double mean;   ///< tr/3
  double scale;  ///< exp(2 mean)
  double norm2;  ///< y:y of y = b/(tr b/3) - I: where it is above kLargestNorm2, LogarithmicStrain is not to be used
};
inline constexpr double kLargestNorm2 = 0.01;

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

/// From the series of ln(1 + y).
[[gnu::always_inline]] inline LogStrain LogarithmicStrain(const Sym3 &b)
{
  constexpr int kTerms = 14;
  const double third = Trace(b) / 3;
  const Sym3 y = (1 / third) * b - Sphere(1), square = Square(y);
  const double norm2 = Trace(square), determinant = (Contract(square, y)) / 3;
  PowerOf power = {0, 1, 0};
  double c0 = 0, c1 = 1, c2 = 0;
#pragma GCC unroll 14
  for (int k = 2; k <= kTerms; ++k) {
    power = power.Next(0.5 * norm2, determinant);
    const double factor = (k % 2 ? 1.0 : -1.0) / k;
    c0 += factor * power.c0, c1 += factor * power.c1, c2 += factor * power.c2;
  }
  const double rest = c0 + c2 * norm2 / 3; // of order y^2
  const double grown = 1 + rest * (1 + rest / 2 * (1 + rest / 3 * (1 + rest / 4 * (1 + rest / 5))));
  return {0.5 * (c1 * y + c2 * (square - Sphere(norm2 / 3))), 0.5 * (Log(third) + rest), third * grown, norm2};
}

/// exp(a) of a tensor without trace, a:a at most kLargestNorm2 or little more.
[[gnu::always_inline]] inline Sym3 Exponential(const Sym3 &a)
{
  constexpr int kTerms = 11;
  const Sym3 square = Square(a);
  const double half = 0.5 * Trace(square), determinant = Contract(square, a) / 3;
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
inline LogStrain LogarithmicStrainOfLarge(const Sym3 &b, double norm2)
{
  const Spectrum spectrum = Decompose(b);
  const Vec3 e = {0.5 * Log(spectrum.value[0]), 0.5 * Log(spectrum.value[1]), 0.5 * Log(spectrum.value[2])};
  const double mean = (e[0] + e[1] + e[2]) / 3;
  return {spectrum.Compose(e - Vec3{mean, mean, mean}), mean, std::exp(2 * mean), norm2};
}
inline Sym3 ExponentialOfLarge(const Sym3 &a)
{
  const Spectrum spectrum = Decompose(a);
  return spectrum.Compose({std::exp(spectrum.value[0]), std::exp(spectrum.value[1]), std::exp(spectrum.value[2])});
}

} // namespace mlgimp
