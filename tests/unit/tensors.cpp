// The small numerics of base: logarithm, products of tensors, principal values.
#include "base/log.hpp"
#include "base/spectral.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

Mat3 RandomTensor()
{
  const auto r = [] { return Random(-1, 1); };
  return {r(), r(), r(), r(), r(), r(), r(), r(), r()};
}
double Size(const Sym3 &a) { return std::sqrt(Contract(a, a)); }

TEST(Tensors, Logarithm)
{
  const double special[] = {std::sqrt(0.5), std::sqrt(2), 1, 1 + 1e-15, 1 - 1e-15, 1 + 1e-9, 2, 0.5, 1e-300, 1e300};
  for (int n = 0; n < 20000; ++n) {
    const double x = n < 10 ? special[n] : std::exp(n % 2 ? Random(-1, 1) : Random(-700, 700));
    EXPECT_LE(std::abs(Log(x) - std::log(x)), 5e-16 * std::abs(std::log(x))) << "x " << x;
    EXPECT_LE(std::abs(Log1p(x) - std::log1p(x)), 5e-16 * std::abs(std::log1p(x))) << "1 + x of x " << x;
  }
}

/// To round-off in the ranges that they state.
TEST(Tensors, SeriesOfSmallArguments)
{
  for (int n = 0; n < 20000; ++n) {
    const double s = Random(-0.1, 0.1), least = s * std::sqrt(2e-2), x = 0.03 * s;
    EXPECT_LE(std::abs(s * AtanhRatio(s * s) - std::atanh(s)), 1e-15 * std::abs(s)) << "s " << s;
    EXPECT_LE(std::abs(least * AtanhRatio<4>(least * least) - std::atanh(least)), 1e-15 * std::abs(least)) << "s " << least;
    EXPECT_LE(std::abs(SmallGrowth(x) - std::expm1(x)), 1e-15 * std::abs(x)) << "x " << x;
  }
}

TEST(Tensors, Products)
{
  double push = 0, determinant = 0;
  for (int n = 0; n < 100; ++n) {
    const Mat3 a = RandomTensor();
    const Sym3 s = SymmetricPart(RandomTensor()), B = SymmetricProduct(a, a);
    // det is that of the product of columns; a s a^T : I = s : a^T a
    const Vec3 x = {a.xx, a.yx, a.zx}, y = {a.xy, a.yy, a.zy}, z = {a.xz, a.yz, a.zz};
    const Vec3 cross = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
    determinant = Largest({determinant, std::abs(Determinant(a) - Dot(cross, z))});
    push = Largest({push, std::abs(Trace(Push(a, s)) - Contract(s, SymmetricProduct(Transposed(a), Transposed(a))))});
    push = Largest({push, Size(Push(a, Sphere(2)) - 2 * B)});
  }
  EXPECT_LE(determinant, 1e-15);
  EXPECT_LE(push, 1e-14);
}

/// Also with double and triple principal values, axes that lie along the coordinates, and values far apart.
TEST(Tensors, PrincipalValues)
{
  double composed = 0, rotation = 0, values = 0;
  for (int n = 0; n < 2000; ++n) {
    const double spread = std::pow(10.0, -(n % 17)), first = Random(0.5, 2);
    const Vec3 exact = {first, first + spread * Random(-0.4, 0.4), n % 3 ? first : first + Random(-0.4, 0.4)};
    const Mat3 axes = n % 5 ? Decompose(SymmetricPart(RandomTensor())).directions : Mat3{1, 0, 0, 0, 1, 0, 0, 0, 1};
    const Sym3 a = Spectrum{exact, axes}.Compose(exact);
    const Spectrum found = Decompose(a);
    Vec3 value = found.value, sorted = exact;
    std::sort(value.begin(), value.end());
    std::sort(sorted.begin(), sorted.end());
    for (int k = 0; k < 3; ++k) values = Largest({values, std::abs(value[k] - sorted[k])});
    composed = Largest({composed, Size(found.Compose(found.value) - a)});
    rotation = Largest({rotation, Size(SymmetricProduct(found.directions, found.directions) - Sphere(1))});
    EXPECT_LE(std::abs(Determinant(found.directions) - 1), 1e-14);
  }
  EXPECT_LE(values, 1e-14) << "principal values";
  EXPECT_LE(composed, 1e-14) << "the tensor of its principal values and directions";
  EXPECT_LE(rotation, 1e-14) << "directions are orthonormal";
}

} // namespace
