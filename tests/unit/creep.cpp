// Laws in time at one point: creep and relaxation against the integration of one equation, the order in the step, dissipation.
#include "physics/material.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

using namespace mlgimp;

namespace
{

MaterialConstants Constants(const std::string &rate_law, double exponent)
{
  MaterialConstants c;
  c.youngs_modulus = 50e9, c.poissons_ratio = 0.3, c.density = 7000;
  c.yield_stress = 40e6, c.hardening_modulus = 1e9, c.hardening = "linear";
  c.rate_law = rate_law, c.creep_stress = 60e6, c.creep_rate = 2e-3, c.creep_exponent = exponent;
  c.activation_energy = rate_law == "garofalo" ? 2000 : 0;
  return c;
}

/// A point in space that is pressed from all sides to a part of its volume, without a shear stress, and then drawn out along x
/// without a change of volume, strain(t) in the logarithm.
struct Pulled {
  Pulled(const Material &material, double scale, double volume = 1) : material(material), scale(scale)
  {
    material.InitialHistory(history);
    const double side = std::cbrt(volume);
    if (volume != 1) Grow(1, {side, side, side});
  }

  void Step(double dt, double from, double to)
  {
    const double along = std::exp(to - from), across = 1 / std::sqrt(along);
    Grow(dt, {along, across, across});
  }
  void Grow(double dt, std::array<double, 3> growth)
  {
    Row L[9] = {}, F[9] = {};
    for (int d = 0; d < 3; ++d) {
      L[4 * d][0] = (growth[d] - 1) / dt;
      stretch[d] *= growth[d];
      F[4 * d][0] = stretch[d];
    }
    material.UpdateStress({1, dt, scale, L, F, nullptr, nullptr, stress, history, 40}, &dissipated);
  }
  double Mises() const { return stress[0] - stress[1]; }
  double Energy() const
  {
    const double F[9] = {stretch[0], 0, 0, 0, stretch[1], 0, 0, 0, stretch[2]};
    double energy;
    material.StoredEnergy(1, F, nullptr, stress, history, 40, &energy);
    return energy;
  }

  const Material &material;
  double scale, dissipated = 0, stretch[3] = {1, 1, 1}, stress[6] = {}, history[40] = {};
};

/// Strain of a cycle with a hold: up, held, down through zero; over 6 s.
double Strain(double t) { return 4e-3 * (t < 1 ? t : t < 3 ? 1 : 1 - 1.5 * (t - 3)); }

/// q at the end of t by the classical Runge-Kutta method for q' = 3 mu (e' - rate(|q|, a) sign q), a' = rate.
double Integrate(double three_mu, double end, const std::function<double(double, double)> &rate)
{
  constexpr int kSteps = 400000;
  double q = 0, a = 0;
  const double dt = end / kSteps;
  const auto slope = [&](double t, double q_now, double a_now) {
    const double e = t < 1 ? 4e-3 : t < 3 ? 0 : -6e-3, r = rate(std::abs(q_now), a_now);
    return std::pair(three_mu * (e - std::copysign(r, q_now)), r);
  };
  for (int k = 0; k < kSteps; ++k) {
    const double middle = (k + 0.5) * dt; // never on a kink of the strain
    const auto [q1, a1] = slope(middle, q, a);
    const auto [q2, a2] = slope(middle, q + 0.5 * dt * q1, a + 0.5 * dt * a1);
    const auto [q3, a3] = slope(middle, q + 0.5 * dt * q2, a + 0.5 * dt * a2);
    const auto [q4, a4] = slope(middle, q + dt * q3, a + dt * a3);
    q += dt / 6 * (q1 + 2 * q2 + 2 * q3 + q4), a += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return q;
}

/// The law's q at the end in so many steps, the simulated time being `scale` times the test's.
double StressAt(const Material &material, double end, int steps, double scale = 1, double volume = 1)
{
  Pulled point(material, scale, volume);
  for (int k = 0; k < steps; ++k) point.Step(scale * end / steps, Strain(end * k / steps), Strain(end * (k + 1) / steps));
  return point.Mises();
}

} // namespace

TEST(Creep, FollowsItsEquationWithSecondOrder)
{
  const double three_mu = 3 * 50e9 / 2.6;
  const auto norton = [](double n) { return [=](double q, double) { return 2e-3 * std::pow(q / 60e6, n); }; };
  struct Case {
    const char *law;
    double exponent;
    std::function<double(double, double)> rate;
  };
  const double garofalo = 2e-3 * std::exp(-2000 / (8.31446261815324 * 293));
  const std::vector<Case> cases = {
      {"norton", 1, norton(1)},
      {"norton", 5, norton(5)},
      {"norton", 10, norton(10)},
      {"eyring", 1, [](double q, double) { return 2e-3 * std::sinh(q / 60e6); }},
      {"garofalo", 3, [=](double q, double) { return garofalo * std::pow(std::sinh(q / 60e6), 3); }},
      {"perzyna", 2, [](double q, double a) { return 2e-3 * std::pow(std::max(q - 40e6 - 1e9 * a, 0.0) / 60e6, 2); }},
  };
  for (const Case &one : cases)
    for (const double end : {2.5, 4.5}) { // in the hold, and after the stress has changed its sign, within a step
      const auto material = CreateMaterial("j2", Constants(one.law, one.exponent), GeometryKind::kSpatial);
      const double exact = std::abs(Integrate(three_mu, end, one.rate));
      const auto off = [&](int steps) { return std::abs(std::abs(StressAt(*material, end, steps)) / exact - 1); };
      const double coarse = off(900), fine = off(9000);
      EXPECT_LT(fine, 1e-6) << one.law << " " << one.exponent << " at " << end << " s";
      if (end == 2.5) { EXPECT_LT(fine, coarse / 30) << one.law << " " << one.exponent << ": order"; }
    }
}

/// The rate follows from the Cauchy stress: in a body pressed to 0.8 of its volume that has the modulus mu/J, as the elastic
/// strain says J times it.
TEST(Creep, FollowsFromTheCauchyStress)
{
  constexpr double kVolume = 0.8, kEnd = 2.5;
  for (const double n : {1.0, 5.0}) {
    const auto material = CreateMaterial("j2", Constants("norton", n), GeometryKind::kSpatial);
    const double exact =
        Integrate(3 * 50e9 / 2.6 / kVolume, kEnd, [=](double q, double) { return 2e-3 * std::pow(q / 60e6, n); });
    const auto off = [&](int steps) { return std::abs(StressAt(*material, kEnd, steps, 1, kVolume) / exact - 1); };
    const double coarse = off(900), fine = off(9000);
    EXPECT_LT(fine, 1e-6) << n;
    EXPECT_LT(fine, coarse / 30) << n << ": order";
  }
}

TEST(Creep, TimeOfTheTestAndRatesScaleExactly)
{
  for (const char *law : {"norton", "garofalo", "perzyna"}) {
    MaterialConstants c = Constants(law, 3);
    const auto slow = CreateMaterial("j2", c, GeometryKind::kSpatial);
    c.creep_rate *= 2;
    const auto fast = CreateMaterial("j2", c, GeometryKind::kSpatial);
    Pulled one(*slow, 0.25), two(*fast, 0.5);
    for (int k = 0; k < 100; ++k) one.Step(1, k * 1e-4, (k + 1) * 1e-4), two.Step(1, k * 1e-4, (k + 1) * 1e-4);
    EXPECT_EQ(one.stress[0], two.stress[0]) << law;
  }
}

/// Steps in which all relaxes many times over, and none in which time rests.
TEST(Creep, AnyStepIsStable)
{
  for (const char *law : {"norton", "eyring", "perzyna"})
    for (const double exponent : {1.0, 5.0, 20.0}) {
      const auto material =
          CreateMaterial("j2", Constants(law, law == std::string("eyring") ? 1 : exponent), GeometryKind::kSpatial);
      const double least = law == std::string("perzyna") ? 40e6 : 0;
      Pulled point(*material, 1e30);
      point.Step(1, 0, 4e-3);
      const double elastic = 3 * 50e9 / 2.6 * 4e-3;
      EXPECT_NEAR(point.Mises() / elastic, 1, law == std::string("perzyna") ? 0.3 : 1e-12) << law << exponent << ": time rests";
      double last = point.Mises();
      for (const double step : {1e-6, 1e-3, 1.0, 1e3, 1e9, 1e15}) {
        point.scale = 1 / step;
        point.Step(1, 0, 0);
        EXPECT_LE(point.Mises(), last * (1 + 1e-10)) << law << exponent; // rounding of 1 + e, of e = 2e-5
        EXPECT_GE(point.Mises(), 0.99 * least) << law << exponent;
        last = point.Mises();
      }
    }
}

TEST(Viscoelastic, RelaxesByItsTerms)
{
  MaterialConstants c;
  c.youngs_modulus = 3e9, c.poissons_ratio = 0.3, c.density = 1200;
  c.relaxation_times = {0.7, 5}, c.relaxation_shares = {0.25, 0.4}, c.relaxation_bulk_shares = {0, 0.3};
  const auto material = CreateMaterial("viscoelastic", c, GeometryKind::kSpatial);
  constexpr double kStrain = 1e-7; // so small that the law is linear
  Pulled point(*material, 1e-3);   // a simulated millisecond is a second
  for (int k = 0; k < 1000; ++k) point.Step(1e-6, k * 1e-3 * kStrain, (k + 1) * 1e-3 * kStrain);
  const double mu3 = 3 * 3e9 / 2.6;
  const auto exact = [&](double t) { // a ramp of 1 s and a hold
    double share = 0.35;
    for (int k = 0; k < 2; ++k)
      share += c.relaxation_shares[k] * c.relaxation_times[k] *
               (std::exp(-std::max(t - 1, 0.0) / c.relaxation_times[k]) - std::exp(-t / c.relaxation_times[k]));
    return mu3 * kStrain * share;
  };
  EXPECT_NEAR(point.Mises() / exact(1), 1, 1e-6);
  for (int k = 0; k < 3; ++k) point.Step(2e-3, kStrain, kStrain); // exact for any step
  EXPECT_NEAR(point.Mises() / exact(7), 1, 1e-6);
  point.Step(1e6, kStrain, kStrain);
  EXPECT_NEAR(point.Mises() / (0.35 * mu3 * kStrain), 1, 1e-6);
}

/// Work of the stress, what is stored and what is dissipated, in a cycle with a hold; all of it at small strain, where the law is
/// the linear one.
TEST(Viscoelastic, DissipatesWhatItLoses)
{
  MaterialConstants c;
  c.youngs_modulus = 3e9, c.poissons_ratio = 0.3, c.density = 1200;
  c.relaxation_times = {0.7, 5}, c.relaxation_shares = {0.25, 0.4}, c.relaxation_bulk_shares = {0.2, 0.3};
  const auto material = CreateMaterial("viscoelastic", c, GeometryKind::kSpatial);
  constexpr double kScale = 1e-4;
  constexpr int kSteps = 20000;
  Pulled point(*material, 1);
  double work = 0, last = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double from = kScale * Strain(4.5 * k / kSteps), to = kScale * Strain(4.5 * (k + 1) / kSteps);
    point.Step(4.5 / kSteps, from, to);
    work += 0.5 * (last + point.Mises()) * (to - from);
    last = point.Mises();
  }
  EXPECT_GT(point.dissipated, 0.1 * work);
  EXPECT_NEAR((point.Energy() + point.dissipated) / work, 1, 1e-6);
}
