// Logarithms and exponentials that loops over points can vectorise.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace mlgimp
{

/// ln 2 in two parts, the first of which is exact times a whole number.
inline constexpr double kLn2Upper = 6.93147180369123816490e-01, kLn2Lower = 1.90821492927058770002e-10; // exact

/// 1/n!
inline constexpr std::array<double, 14> kInverseFactorial = [] {
  std::array<double, 14> all = {1};
  for (int n = 1; n < 14; ++n) all[n] = all[n - 1] / n;
  return all;
}();

/// ln x of a positive normal x, to round-off: without branches or calls.
/// x = 2^k m with m between sqrt(1/2) and sqrt(2); ln m from the odd series in s = (m - 1)/(m + 1), with the
/// coefficients of the C library of Sun Microsystems (1993).
[[gnu::always_inline]] inline double Log(double x)
{
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcd, kBias = 1024, kTwoTo52 = 0x4330000000000000; // exact
  std::uint64_t bits;
  std::memcpy(&bits, &x, 8);
  const std::uint64_t biased = (bits - kRootHalf + (kBias << 52)) >> 52, k_bits = kTwoTo52 | biased;
  const std::uint64_t m_bits = bits - ((biased - kBias) << 52);
  double k, m;
  std::memcpy(&k, &k_bits, 8);
  std::memcpy(&m, &m_bits, 8);
  k -= 4503599627370496.0 + kBias;
  const double f = m - 1, s = f / (2 + f), z = s * s, zz = z * z;
  const double odd = z * (6.666666666666735130e-01 +
                          zz * (2.857142874366239149e-01 + zz * (1.818357216161805012e-01 + zz * 1.479819860511658591e-01)));
  const double even = zz * (3.999999999940941908e-01 + zz * (2.222219843214978396e-01 + zz * 1.531383769920937332e-01));
  return k * kLn2Upper - ((s * (f - (odd + even)) - k * kLn2Lower) - f);
}

/// ln(1 + x), to round-off: x less what 1 + x has of it, over 1 + x, is the missing part of the logarithm.
[[gnu::always_inline]] inline double Log1p(double x)
{
  const double sum = 1 + x;
  return Log(sum) + (x - (sum - 1)) / sum;
}

/// exp x, to round-off for |x| <= 690; beyond that as at 690.
/// x = k ln 2 + r with |r| <= (ln 2)/2; exp r by its series.
[[gnu::always_inline]] inline double Exp(double x)
{
  constexpr double kMaxExponent = 690, kInverseLn2 = 1.44269504088896338700, kRounding = 6755399441055744.0; // exact: 1.5 2^52
  constexpr std::uint64_t kBias = 1023;                                                                      // exact
  const double limited = std::min(std::max(x, -kMaxExponent), kMaxExponent), shifted = limited * kInverseLn2 + kRounding;
  const double k = shifted - kRounding, r = limited - k * kLn2Upper - k * kLn2Lower;
  double sum = kInverseFactorial[13];
#pragma GCC unroll 13
  for (int n = 12; n >= 0; --n) sum = sum * r + kInverseFactorial[n];
  std::uint64_t bits;
  std::memcpy(&bits, &shifted, 8);
  bits = (bits + kBias) << 52;
  double power;
  std::memcpy(&power, &bits, 8);
  return sum * power;
}

/// x^y for x >= 0, y >= 0; less than 1e-299 for 0 where y is above 1e-297.
[[gnu::always_inline]] inline double Pow(double x, double y)
{
  constexpr double kLogZero = -1e300; // exact
  return Exp(y * (x > 0 ? Log(x) : kLogZero));
}

/// atanh(s)/s by as many terms of its series: with eight to round-off for s^2 <= 0.01, with four for s^2 <= 2e-4.
template <int terms = 8> [[gnu::always_inline]] inline double AtanhRatio(double s2)
{
  double sum = 1.0 / (2 * terms - 1);
#pragma GCC unroll 7
  for (int k = 2 * terms - 3; k > 0; k -= 2) sum = sum * s2 + 1.0 / k;
  return sum;
}

/// exp(x) - 1, to round-off for |x| < 0.003.
[[gnu::always_inline]] inline double SmallGrowth(double x)
{
  double sum = kInverseFactorial[5];
#pragma GCC unroll 4
  for (int n = 4; n > 0; --n) sum = sum * x + kInverseFactorial[n];
  return x * sum;
}

} // namespace mlgimp
