// Elasticity of crystals: how constants turn, speeds of waves, indentation modulus, and the law in axes of its own.
#include "physics/material.hpp"
#include "program/input/read_case.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include "base/spectral.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

const Stiffness kSilicon = StiffnessOf({165.7, 63.9, 79.6}), kCopper = StiffnessOf({168.4, 121.4, 75.4}),
                kZinc = StiffnessOf({163.7, 36.4, 53, 63.5, 38.8}), kQuartz = StiffnessOf({86.8, 7.0, 11.9, 105.8, 58.2, -18.0});

Vec3 Unit(Vec3 v) { return (1 / Norm(v)) * v; }
/// Axes of a run whose third one is along a direction and whose first one along another, across it.
Mat3 Axes(Vec3 up, Vec3 x)
{
  const Vec3 z = Unit(up), first = Unit(x), second = Cross(z, first);
  return {first[0], first[1], first[2], second[0], second[1], second[2], z[0], z[1], z[2]};
}
Vec3 RandomUnit() { return Unit({Random(-1, 1), Random(-1, 1), Random(-1, 1)}); }
Mat3 RandomAxes()
{
  const Vec3 up = RandomUnit();
  return Axes(up, Cross(up, RandomUnit()));
}
Mat3 Product(const Mat3 &a, const Mat3 &b)
{
  return {
      a.xx * b.xx + a.xy * b.yx + a.xz * b.zx, a.xx * b.xy + a.xy * b.yy + a.xz * b.zy, a.xx * b.xz + a.xy * b.yz + a.xz * b.zz,
      a.yx * b.xx + a.yy * b.yx + a.yz * b.zx, a.yx * b.xy + a.yy * b.yy + a.yz * b.zy, a.yx * b.xz + a.yy * b.yz + a.yz * b.zz,
      a.zx * b.xx + a.zy * b.yx + a.zz * b.zx, a.zx * b.xy + a.zy * b.yy + a.zz * b.zy, a.zx * b.xz + a.zy * b.yz + a.zz * b.zz};
}
double Size(const Sym3 &s) { return std::sqrt(Contract(s, s)); }

/// Any stable one: A A^T + I.
Stiffness RandomStiffness()
{
  double a[6][6];
  Stiffness C;
  for (auto &row : a)
    for (double &x : row) x = Random(-1, 1);
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) {
      C.At(i, j) = i == j;
      for (int k = 0; k < 6; ++k) C.At(i, j) += a[i][k] * a[j][k];
    }
  return C;
}

Anisotropic LawOf(const Stiffness &C)
{
  MaterialConstants constants;
  constants.density = 1;
  constants.crystal = {C, 2};
  return Anisotropic(constants);
}

Sym3 StressAt(const Anisotropic &law, const Mat3 &F)
{
  LawPoint point{F, {}, {}};
  return law.Stress(point);
}

Mat3 RandomF()
{
  const auto r = [] { return Random(-0.2, 0.2); };
  return {1 + r(), r(), r(), r(), 1 + r(), r(), r(), r(), 1 + r()};
}

/// The law and its energy in turned axes are those of turned strains: C in the axes of rows a has a S a^T at a F.
TEST(Crystals, TurnedWithTheBody)
{
  double stress = 0, energy = 0;
  for (int n = 0; n < 50; ++n) {
    const Stiffness C = RandomStiffness();
    const Mat3 a = RandomAxes(), F = RandomF(), there = Product(Product(a, F), Transposed(a));
    const Anisotropic here_law = LawOf(C), there_law = LawOf(Turned(C, a));
    const Sym3 here = StressAt(here_law, F);
    stress = Largest({stress, Size(StressAt(there_law, there) - Push(a, here)) / Size(here)});
    energy = Largest({energy, std::abs(there_law.Energy({there, {}, {}}) / here_law.Energy({F, {}, {}}) - 1)});
    EXPECT_LE(std::abs(there_law.fastest / here_law.fastest - 1), 1e-12) << "fastest wave in other axes";
    EXPECT_LE(std::abs(LeastEigenvalue(there_law.stiffness) / LeastEigenvalue(C) - 1), 1e-10) << "least eigenvalue in other axes";
  }
  EXPECT_LE(stress, 1e-13);
  EXPECT_LE(energy, 1e-13);
}

/// J sigma = (dW/dF) F^T by central differences.
TEST(Crystals, StressIsDerivativeOfEnergy)
{
  double largest = 0;
  for (int n = 0; n < 50; ++n) {
    constexpr double kStep = 1e-5;
    const Anisotropic law = LawOf(RandomStiffness());
    const Mat3 F = RandomF();
    Mat3 P;
    for (double Mat3::*at : {&Mat3::xx, &Mat3::xy, &Mat3::xz, &Mat3::yx, &Mat3::yy, &Mat3::yz, &Mat3::zx, &Mat3::zy, &Mat3::zz}) {
      Mat3 above = F, below = F;
      above.*at += kStep, below.*at -= kStep;
      P.*at = (law.Energy({above, {}, {}}) - law.Energy({below, {}, {}})) / (2 * kStep);
    }
    const Sym3 tau = SymmetricPart(Product(P, Transposed(F)));
    largest = Largest({largest, Size((1 / Determinant(F)) * tau - StressAt(law, F)) / law.fastest});
  }
  EXPECT_LE(largest, 1e-8);
}

/// Stress of a point of a geometry at F, in which only zz has z.
template <class G> Sym3 StressOf(const Stiffness &C, const Mat3 &F)
{
  constexpr int n = G::kDim;
  MaterialConstants constants;
  constants.density = 1;
  constants.crystal = {C, 1};
  const double f[9] = {F.xx, F.xy, F.xz, F.yx, F.yy, F.yz, F.zx, F.zy, F.zz}, one = 1, zero[9] = {};
  double stored[n * n], stress[G::kStress] = {}, dissipated = 0;
  Row L_rows[n * n], F_rows[n * n];
  for (int k = 0; k < n * n; ++k) stored[k] = f[3 * (k / n) + k % n];
  LoadRows<n * n>(stored, 1, F_rows), LoadRows<n * n>(zero, 1, L_rows);
  CreateMaterial("anisotropic", constants, G::kKind)
      ->UpdateStress({1, 1, 1, L_rows, F_rows, G::kHoop ? &F.zz : nullptr, G::kHoop ? &one : nullptr, stress, nullptr, 0},
                     &dissipated);
  return LoadStress<G>(stress);
}

/// Crystals that a geometry may have have the stress there that they have in space.
TEST(Crystals, SameInAllGeometries)
{
  const Stiffness zinc = Turned(kZinc, {1, 0, 0, 0, 0, 1, 0, -1, 0});
  const Mat3 above = Axes({1, 1, 1}, {1, 1, -2});
  const Stiffness silicon =
      Turned(kSilicon, {above.xx, above.xy, above.xz, above.zx, above.zy, above.zz, -above.yx, -above.yy, -above.yz});
  for (int n = 0; n < 20; ++n) {
    const auto r = [] { return Random(-0.1, 0.1); };
    const Mat3 F = {1 + r(), r(), 0, r(), 1 + r(), 0, 0, 0, 1 + r()}, plane = {F.xx, F.xy, 0, F.yx, F.yy, 0, 0, 0, 1};
    EXPECT_LE(Size(StressOf<Axisymmetric>(zinc, F) - StressOf<Spatial>(zinc, F)), 1e-12);
    EXPECT_LE(Size(StressOf<PlaneStrain>(silicon, plane) - StressOf<Spatial>(silicon, plane)), 1e-12);
  }
}

/// A strained point that is turned ten times about, by 10 degrees each: the stress in its own frame stays.
TEST(Crystals, Objectivity)
{
  const Anisotropic law = LawOf(Turned(kQuartz, RandomAxes()));
  const Mat3 start = RandomF(), axes = RandomAxes();
  const double c = std::cos(M_PI / 18), s = std::sin(M_PI / 18);
  const Mat3 turn = Product(Product(axes, {c, -s, 0, s, c, 0, 0, 0, 1}), Transposed(axes));
  const Sym3 before = StressAt(law, start);
  Mat3 Q = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double largest = 0;
  for (int n = 0; n < 360; ++n) {
    Q = Product(turn, Q);
    largest = Largest({largest, Size(Push(Transposed(Q), StressAt(law, Product(Q, start))) - before) / Size(before)});
  }
  EXPECT_LE(largest, 1e-12);
}

/// rho c^2 of plane waves in a strained body, u Q u + n sigma n over rho, is below the bound; without strain it comes near.
TEST(Crystals, NoWaveIsFaster)
{
  for (int n = 0; n < 10; ++n) {
    const Anisotropic law = LawOf(RandomStiffness());
    double still = 0, strained = 0;
    const Mat3 F = RandomF();
    const Sym3 B = SymmetricProduct(F, F);
    const double stretch2 = std::max(
        {B.xx + std::abs(B.xy) + std::abs(B.xz), B.yy + std::abs(B.xy) + std::abs(B.yz), B.zz + std::abs(B.xz) + std::abs(B.yz)});
    const auto fastest = [&law](const Mat3 &f, const Vec3 &v) { // of the direction v, per initial density
      const Vec3 N = {f.xx * v[0] + f.yx * v[1] + f.zx * v[2], f.xy * v[0] + f.yy * v[1] + f.zy * v[2],
                      f.xz * v[0] + f.yz * v[1] + f.zz * v[2]};
      Mat3 Q;
      const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      const auto row = [&](const Vec3 &e) { // C : (e N), times N
        const Sym3 s = law.stiffness * SymmetricPart({e[0] * N[0], e[0] * N[1], e[0] * N[2], e[1] * N[0], e[1] * N[1],
                                                      e[1] * N[2], e[2] * N[0], e[2] * N[1], e[2] * N[2]});
        return Vec3{s.xx * N[0] + s.xy * N[1] + s.xz * N[2], s.xy * N[0] + s.yy * N[1] + s.yz * N[2],
                    s.xz * N[0] + s.yz * N[1] + s.zz * N[2]};
      };
      const Vec3 x = row(axes[0]), y = row(axes[1]), z = row(axes[2]);
      Q = {x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]};
      const Vec3 value = Decompose(Push(f, SymmetricPart(Q))).value;
      const Sym3 S = law.stiffness * StVenantKirchhoff::GreenStrain(f);
      const Vec3 SN = {S.xx * N[0] + S.xy * N[1] + S.xz * N[2], S.xy * N[0] + S.yy * N[1] + S.yz * N[2],
                       S.xz * N[0] + S.yz * N[1] + S.zz * N[2]};
      return std::max({value[0], value[1], value[2]}) + Dot(SN, N);
    };
    for (int k = 0; k < 4000; ++k) {
      const Vec3 v = RandomUnit();
      still = Largest({still, fastest({1, 0, 0, 0, 1, 0, 0, 0, 1}, v)});
      strained = Largest({strained, fastest(F, v)});
    }
    EXPECT_LE(still / law.fastest, 1 + 1e-12);
    EXPECT_GE(still / law.fastest, 0.98);
    EXPECT_LE(strained / law.WaveSpeedSquared(F, stretch2), 1 + 1e-12);
  }
}

/// The fastest wave in silicon is longitudinal along [111]: rho c^2 = (C11 + 2 C12 + 4 C44)/3, in zinc C11.
TEST(Crystals, KnownWaves)
{
  EXPECT_NEAR(FastestModulus(Turned(kSilicon, RandomAxes())), (165.7 + 2 * 63.9 + 4 * 79.6) / 3, 1e-10);
  EXPECT_NEAR(FastestModulus(kZinc), 163.7, 1e-10);
}

/// Published constants give published moduli, isotropic ones E/(1 - nu^2).
TEST(Crystals, IndentationModulus)
{
  struct Row {
    Stiffness C;
    Vec3 up, x;
    double modulus;
  };
  const Row rows[] = {{kSilicon, {0, 0, 1}, {1, 0, 0}, 164.81},  {kSilicon, {0, 1, 1}, {1, 0, 0}, 172.81},
                      {kSilicon, {1, 1, 1}, {1, -1, 0}, 175.30}, {kCopper, {0, 0, 1}, {1, 0, 0}, 134.01},
                      {kCopper, {0, 1, 1}, {1, 0, 0}, 147.39},   {kCopper, {1, 1, 1}, {1, -1, 0}, 151.58},
                      {kZinc, {0, 0, 1}, {1, 0, 0}, 69.226},     {kZinc, {1, 0, 0}, {0, 1, 0}, 131.44}};
  for (const Row &row : rows)
    EXPECT_NEAR(IndentationModulus({Turned(row.C, Axes(row.up, row.x)), 2}) / row.modulus, 1, 5e-5) << row.modulus;
  const double lambda = 60, mu = 26;
  for (const int up : {1, 2})
    EXPECT_NEAR(IndentationModulus({IsotropicStiffness(lambda, mu), up}) / (4 * mu * (lambda + mu) / (lambda + 2 * mu)), 1,
                1e-12);
  const Mat3 y_up = {1, 0, 0, 0, 0, 1, 0, -1, 0};
  EXPECT_NEAR(IndentationModulus({Turned(kZinc, y_up), 1}) / 69.226, 1, 1e-5) << "c axis along y";
}

/// Each class keeps its constants under its turns, and more constants say the same of one with fewer.
TEST(Crystals, Classes)
{
  const auto expect_same = [](const Stiffness &a, const Stiffness &b, const char *name) {
    for (int k = 0; k < 21; ++k) EXPECT_NEAR(a.c[k], b.c[k], 1e-12) << name << " " << k;
  };
  const double c = -0.5, s = std::sqrt(0.75);
  const Mat3 third = {c, s, 0, -s, c, 0, 0, 0, 1}, quarter = {0, 1, 0, -1, 0, 0, 0, 0, 1}, diagonal = {0, 1, 0, 0, 0, 1, 1, 0, 0},
             half = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  expect_same(Turned(kQuartz, third), kQuartz, "trigonal, a third about c");
  expect_same(Turned(kQuartz, half), kQuartz, "trigonal, a half about a");
  expect_same(Turned(kSilicon, quarter), kSilicon, "cubic, a quarter");
  expect_same(Turned(kSilicon, diagonal), kSilicon, "cubic, about [111]");
  expect_same(StiffnessOf({165.7, 165.7, 165.7, 63.9, 63.9, 63.9, 79.6, 79.6, 79.6}), kSilicon, "orthotropic");
  expect_same(StiffnessOf({std::begin(kQuartz.c), std::end(kQuartz.c)}), kQuartz, "all");
  expect_same(StiffnessOf({163.7, 36.4, 53, 63.5, 38.8, 0}), kZinc, "trigonal without C14");
  EXPECT_NEAR(kZinc.At(5, 5), 63.65, 1e-12);
  EXPECT_FALSE(StiffnessOf({1, 2}).Given());
}

/// A round axis, mirrors, and what has none.
TEST(Crystals, Mirrors)
{
  const auto skew = [](const Stiffness &C) { return LawOf(C).Traits().skew_axes; };
  EXPECT_EQ(skew(Turned(kSilicon, Axes({0, 1, 1}, {1, 0, 0}))), 0) << "(011) has two mirrors";
  EXPECT_EQ(skew(Turned(kSilicon, Axes({1, 1, 1}, {1, -1, 0}))), 6) << "(111) has one, across [1-10]";
  EXPECT_EQ(skew(kQuartz), 6);
  EXPECT_EQ(skew(Turned(kZinc, RandomAxes())), 7);
  const double c = std::cos(1.0), s = std::sin(1.0);
  const Stiffness around = Turned(kZinc, {c, s, 0, -s, c, 0, 0, 0, 1});
  for (int k = 0; k < 21; ++k) EXPECT_NEAR(around.c[k], kZinc.c[k], 1e-12) << "zinc is alike all around its c axis";
}

} // namespace
