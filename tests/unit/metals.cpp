// Hardening laws and the return to them; logarithm and exponential by series; a steady state of simple shear.
#include "physics/log_strain.hpp"
#include "physics/material.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace mlgimp;

namespace
{

constexpr unsigned kSeed = 20261122;
RandomNumbers Random(kSeed);

MaterialConstants Constants(const std::string &hardening)
{
  MaterialConstants c;
  c.youngs_modulus = 70e9, c.poissons_ratio = 0.33, c.density = 2700;
  c.yield_stress = 200e6, c.hardening_modulus = hardening == "linear" ? 2e9 : 3e8;
  c.hardening = hardening;
  c.hardening_exponent = 0.25, c.hardening_strain = 0.01;
  c.saturation_stress = 320e6, c.saturation_strain = 0.1;
  c.plastic_strains = {0, 0.02, 0.3}, c.flow_stresses = {200e6, 260e6, 300e6};
  c.rate_sensitivity = 0.02, c.reference_rate = 1, c.thermal_exponent = 1, c.melting_temperature = 900, c.heat_capacity = 900;
  c.adiabatic = true;
  return c;
}

/// Points of a block in many states, every fifth of them below yield; the same ones for each law, wherever it stands in the list.
template <class Law> void ReturnsToFlow(const std::string &name)
{
  const Law law(Constants(name));
  double off = 0;
  Random.seed(kSeed);
  for (int block = 0; block < 40; ++block) {
    double q[kBlock], strain[kBlock], temperature[kBlock], three_mu[kBlock];
    const double rate = std::pow(10, Random(0, 12));
    for (int p = 0; p < kBlock; ++p) {
      strain[p] = std::pow(10, Random(-9, 0.5)) * (p % 7 ? 1 : 0), temperature[p] = Random(293, 850);
      three_mu[p] = 3 * 26e9 / (0.9 + 0.002 * p);
      const double excess = p % 5 ? std::pow(10, Random(-10, 1)) : -0.001;
      q[p] = law.At(strain[p], 0, temperature[p]).stress * (1 + excess);
    }
    PlasticStep step;
    FlowOf(law, {kBlock - block % 3, q, strain, Law::kThermal ? temperature : nullptr, nullptr, three_mu, rate}, step);
    for (int p = 0; p < kBlock - block % 3; ++p) {
      const double d = step.strain[p];
      const double flow = law.At(strain[p] + d, rate * d, temperature[p]).stress;
      if (p % 5) {
        EXPECT_GT(d, 0) << name;
        const double start = law.At(strain[p], rate * d, temperature[p]).stress;
        off = Largest({off, std::abs(q[p] - three_mu[p] * d - flow) / q[p]});
        EXPECT_NEAR(step.work[p], 0.5 * d * (start + flow), 1e-9 * d * flow) << name + ": work by the trapezoidal rule";
      } else {
        EXPECT_EQ(d, 0) << name + ": elastic below yield";
        EXPECT_EQ(step.work[p], 0) << name + ": elastic below yield";
      }
    }
  }
  EXPECT_LE(off, 1e-12) << name + ": stress less flow stress after the return, of the trial stress";
}

TEST(Metals, EveryLawIsReturnedTo)
{
  ReturnsToFlow<LinearHardening>("linear");
  ReturnsToFlow<SwiftHardening>("swift");
  ReturnsToFlow<VoceHardening>("voce");
  ReturnsToFlow<LudwikHardening>("ludwik");
  ReturnsToFlow<TableHardening>("table");
  ReturnsToFlow<JohnsonCookHardening>("johnson_cook");
}

/// States in which metals begin to flow in an impact: Newton's method in d and in ln d went round in a circle in one of 2000.
TEST(Metals, FirstYieldAtHighRates)
{
  const JohnsonCookHardening law(Constants("johnson_cook"));
  const double modulus = 3 * 26e9;
  double off = 0, three_mu[kBlock];
  std::fill_n(three_mu, kBlock, modulus);
  for (int block = 0; block < 2000; ++block) {
    double q[kBlock], strain[kBlock], temperature[kBlock];
    const double rate = block ? std::pow(10, Random(8, 11)) : 683203161.96912241;
    for (int p = 0; p < kBlock; ++p) {
      strain[p] = block ? std::pow(10, Random(-7, -5)) : 7.359372975412517e-06;
      temperature[p] = block ? 293 : 293.82777066478286;
      q[p] = block ? law.At(strain[p], 0, 293).stress + modulus * std::pow(10, Random(-4.5, -2)) : 272871338.41610235;
    }
    PlasticStep step;
    FlowOf(law, {kBlock, q, strain, temperature, nullptr, three_mu, rate}, step);
    for (int p = 0; p < kBlock; ++p) {
      const double d = step.strain[p], flow = law.At(strain[p] + d, rate * d, temperature[p]).stress;
      off = Largest({off, std::abs(q[p] - modulus * d - flow) / q[p]});
    }
  }
  EXPECT_LE(off, 1e-9) << "stress less flow stress after the return, of the trial stress";
}

/// Johnson & Cook's law, counting its evaluations.
struct CountedLaw : JohnsonCookHardening {
  using JohnsonCookHardening::JohnsonCookHardening;
  FlowPoint At(double a, double rate, double temperature) const
  {
    ++evaluations;
    return JohnsonCookHardening::At(a, rate, temperature);
  }
  mutable int evaluations = 0;
};

/// Newton's method in the strain overshoots where flow rises with the logarithm of its rate, and halving took 20.
TEST(Metals, LawsOfTheRateAreReturnedToInFewSteps)
{
  for (const double rate : {1e-1, 1e3, 1e6, 1e9}) {
    const CountedLaw law(Constants("johnson_cook"));
    constexpr double kStrain = 1e-5;
    constexpr int kPoints = 500;
    for (int n = 0; n < kPoints; ++n) {
      const double strain = std::pow(10, Random(-4, 0)), temperature = 300, three_mu = 3 * 26e9;
      const double flow = law.JohnsonCookHardening::At(strain, rate, temperature).stress;
      const double trial = flow + three_mu * kStrain * Random(0.1, 2);
      PlasticStep step;
      FlowOf(law, {1, &trial, &strain, &temperature, nullptr, &three_mu, rate / kStrain}, step);
    }
    EXPECT_LE(law.evaluations, 8 * kPoints) << rate << " 1/s: evaluations of the law in " << kPoints << " steps";
  }
}

/// Against the C library's, over all that laws may ask for.
TEST(Metals, ExponentialsAndPowers)
{
  double off = 0, off_power = 0;
  for (int n = 0; n < 20000; ++n) {
    const double x = Random(-600, 600), base = std::pow(10, Random(-20, 3)), exponent = Random(0, 3);
    off = Largest({off, std::abs(Exp(x) / std::exp(x) - 1)});
    const double power = std::pow(base, exponent), size = 1 + std::abs(std::log(power)); // its error is that of its logarithm
    off_power = Largest({off_power, std::abs(Pow(base, exponent) / power - 1) / size});
  }
  EXPECT_LE(off, 1e-15) << "exponential";
  EXPECT_LE(off_power, 1e-15) << "power";
  EXPECT_EQ(Exp(0), 1);
  EXPECT_LE(Pow(0, 0.3), 1e-299);
  EXPECT_EQ(Pow(0, 0), 1);
}

/// The formulas, at places where they are easy.
TEST(Metals, FlowStresses)
{
  MaterialConstants c = Constants("power");
  c.hardening_strain = NAN;
  const double strain = 15 * c.yield_stress / c.youngs_modulus; // 1 + E a/sy = 16
  EXPECT_NEAR(SwiftHardening(c).At(strain, 0, 0).stress / c.yield_stress, 2, 1e-14) << "power";
  EXPECT_NEAR(SwiftHardening(Constants("swift")).At(0.15, 0, 0).stress / 200e6, 2, 1e-14) << "swift";
  EXPECT_NEAR(VoceHardening(Constants("voce")).At(0.1, 0, 0).stress / (320e6 - 120e6 / std::exp(1)), 1, 1e-14) << "voce";
  EXPECT_NEAR(LudwikHardening(Constants("ludwik")).At(0.0016, 0, 0).stress / (200e6 + 3e8 * 0.2), 1, 1e-14) << "ludwik";
  EXPECT_NEAR(TableHardening(Constants("table")).At(0.01, 0, 0).stress / 230e6, 1, 1e-14) << "table, half way";
  EXPECT_EQ(TableHardening(Constants("table")).At(5, 0, 0).stress, 300e6) << "table, beyond";
  const JohnsonCookHardening law(Constants("johnson_cook"));
  const double half_soft = 0.5 * (293 + 900);
  EXPECT_NEAR(law.At(0, std::exp(5), half_soft).stress / (200e6 * 1.1 * 0.5), 1, 1e-13) << "johnson_cook: rate and temperature";
  EXPECT_EQ(law.At(0, 0.5, 293).stress, 200e6) << "johnson_cook: no softening below the reference rate";
  EXPECT_EQ(law.At(0, 0.5, 2000).stress, 0) << "johnson_cook: molten";
  MaterialConstants hot = Constants("johnson_cook");
  hot.initial_temperature = half_soft;
  EXPECT_EQ(JohnsonCookHardening(hot).At(0, 0.5, half_soft).stress, 200e6) << "johnson_cook: T0 is the temperature at the start";
  hot.reference_temperature = 293;
  EXPECT_NEAR(JohnsonCookHardening(hot).At(0, 0.5, half_soft).stress / 100e6, 1, 1e-13) << "johnson_cook: hot at the start";
}

/// Largest differences of the series from principal values: logarithm, and exponential of it.
template <bool in_plane> std::array<double, 2> SeriesOff()
{
  std::array<double, 2> off{};
  for (int n = 0; n < 2000; ++n) {
    const double size = std::pow(10, Random(-12, -1.2)), volume = Random(0.5, 2);
    Sym3 b = {Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    if (in_plane) b.yz = b.xz = 0;
    b = volume * (Sphere(1) + size / 3 * b);
    const LogStrain series = LogarithmicStrain<in_plane>(b), exact = LogarithmicStrainOfLarge(b);
    if (series.norm2 > kLargestNorm2) continue;
    const Sym3 less = series.deviator - exact.deviator;
    off[0] = Largest({off[0], std::sqrt(Contract(less, less))});
    const Sym3 back = std::cbrt(Determinant(b)) * Exponential<in_plane>(2 * series.deviator) - b;
    off[1] = Largest({off[1], std::sqrt(Contract(back, back)) / volume});
  }
  return off;
}

TEST(Metals, LogarithmAndExponentialBySeries)
{
  const auto plane = SeriesOff<true>(), space = SeriesOff<false>();
  EXPECT_LE(plane[0], 2e-15) << "logarithm in the plane, series less principal values";
  EXPECT_LE(plane[1], 2e-15) << "exp of the logarithm less the tensor, in the plane";
  EXPECT_LE(space[0], 2e-15) << "logarithm, series less principal values";
  EXPECT_LE(space[1], 2e-15) << "exp of the logarithm less the tensor";
}

/// Points of a metal in simple shear in small steps; returns stress xx, yy, zz, xy.
std::array<double, 4> Shear(const Material &metal, double strain, int steps, double *plastic_strain)
{
  Row F[4] = {{1}, {0}, {0}, {1}}, L[4] = {};
  double stress[4] = {}, history[2], dissipated = 0;
  metal.InitialHistory(history);
  L[1][0] = strain / steps;
  for (int k = 0; k < steps; ++k) {
    AdvanceDeformation<PlaneStrain>(1, 1, L, F);
    metal.UpdateStress({1, 1, 1, L, F, nullptr, nullptr, stress, history, 2}, &dissipated);
  }
  *plastic_strain = history[metal.PlaceOf(kPlasticStrain)];
  return {stress[0], stress[1], stress[2], stress[3]};
}

/// Pressed in one direction to .9 of the volume: Cauchy's stresses differ by the flow stress, as in CalculiX and Abaqus.
/// Kirchhoff's would make it 1/.9 times as much. The plastic work is that of the flow stress on the shrinking volume.
TEST(Metals, FlowStressBoundsCauchyStress)
{
  for (const double modulus : {0.0, 2e9}) {
    MaterialConstants c = Constants("linear");
    c.yield_stress = c.youngs_modulus / 100, c.hardening_modulus = modulus;
    const auto metal = CreateMaterial("j2", c, GeometryKind::kPlaneStrain);
    constexpr int kSteps = 20000;
    Row F[4] = {{1}, {0}, {0}, {1}}, L[4] = {};
    double stress[4] = {}, history[1] = {}, dissipated = 0, work = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double before = F[3][0], after = 1 - 0.1 * (k + 1) / kSteps, plastic = history[0];
      L[3][0] = after / before - 1;
      AdvanceDeformation<PlaneStrain>(1, 1, L, F);
      metal->UpdateStress({1, 1, 1, L, F, nullptr, nullptr, stress, history, 1}, &dissipated);
      const double flow = c.yield_stress + modulus * 0.5 * (plastic + history[0]);
      work += after * flow * (history[0] - plastic);
    }
    const double flow = c.yield_stress + modulus * history[0], bulk = metal->Elastic().Bulk();
    EXPECT_NEAR((stress[0] - stress[1]) / flow, 1, 1e-10) << "difference of normal stresses, of the flow stress";
    EXPECT_NEAR((stress[0] + stress[1] + stress[2]) / (3 * bulk * std::log(0.9) / 0.9), 1, 1e-10) << "pressure";
    EXPECT_NEAR(dissipated / work, 1, 1e-12) << "plastic work";
  }
}

/// Perfect plasticity in steady simple shear: tau = k/cosh(k/mu), sxx - syy = 2 k tanh(k/mu).
TEST(Metals, SteadyShear)
{
  MaterialConstants c = Constants("linear");
  c.hardening_modulus = 0, c.yield_stress = c.youngs_modulus / 100;
  const auto metal = CreateMaterial("j2", c, GeometryKind::kPlaneStrain);
  const double k = c.yield_stress / std::sqrt(3), mu = metal->Elastic().mu;
  double plastic;
  const auto stress = Shear(*metal, 3, 20000, &plastic);
  EXPECT_NEAR(stress[3] / k, 1 / std::cosh(k / mu), 2e-6) << "shear stress, of k";
  EXPECT_NEAR((stress[0] - stress[1]) / k, 2 * std::tanh(k / mu), 2 * 3.0 / 20000) << "difference of normal stresses, of k";
  EXPECT_NEAR((stress[0] + stress[1] + stress[2]) / k, 0, 1e-9) << "pressure, of k";
}

} // namespace
