// Materials by their properties: energy, objectivity, yield, deformation.
#include "pointwise/material.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

using namespace mlgimp;

namespace
{

std::mt19937 generator(20240607);
double Random(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(generator); }

constexpr double kE = 70e9, kNu = 0.33, kRho = 2700, kYield = 200e6, kHardening = 2e9;
const double kMu = kE / (2 * (1 + kNu)), kLambda = kE * kNu / ((1 + kNu) * (1 - 2 * kNu));

std::unique_ptr<Material> Create(const std::string &law, double yield = kYield)
{
  return CreateMaterial(law, {kE, kNu, kRho, yield, kHardening});
}

/// A point of a material and its state.
struct Sample {
  explicit Sample(const Material &law) : material(law) { material.InitialHistory(history); }
  /// Advances by I + `dt` L; L as xx, xy, yx, yy.
  void Advance(const std::array<double, 4> &L, double dt = 1)
  {
    const double rate[1][4] = {{L[0], L[1], L[2], L[3]}};
    double increment[1][4];
    AdvanceDeformation(1, dt, rate, increment, F);
    material.UpdateStress({1, dt, rate, increment, F, stress, history, material.HistorySize()}, &dissipated);
  }
  double Energy() const
  {
    double energy;
    material.StoredEnergy(1, F, stress, history, material.HistorySize(), &energy);
    return energy;
  }
  double Jacobian() const { return F[0] * F[3] - F[1] * F[2]; }

  const Material &material;
  double F[4] = {1, 0, 0, 1}, stress[4] = {}, history[5] = {}, dissipated = 0;
};

/// The state after one increment from the undeformed body to F.
Sample At(const Material &material, const std::array<double, 4> &F)
{
  Sample sample(material);
  sample.Advance({F[0] - 1, F[1], F[2], F[3] - 1});
  return sample;
}

std::array<double, 4> RandomF() { return {1 + Random(-0.2, 0.2), Random(-0.2, 0.2), Random(-0.2, 0.2), 1 + Random(-0.2, 0.2)}; }

/// Q t Q^T for t as xx, yy, zz, xy; c, s: cosine and sine of the angle.
std::array<double, 4> Rotated(const double t[4], double c, double s)
{
  return {c * c * t[0] - 2 * c * s * t[3] + s * s * t[1], s * s * t[0] + 2 * c * s * t[3] + c * c * t[1], t[2],
          c * s * (t[0] - t[1]) + (c * c - s * s) * t[3]};
}

double Difference(const double a[4], const std::array<double, 4> &b)
{
  double largest = 0;
  for (int k = 0; k < 4; ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

/// J sigma = (dW/dF) F^T by central differences; the small-strain law has sigma = dW/dF.
void StressIsDerivativeOfEnergy(const std::string &law)
{
  const auto material = Create(law, 1e3 * kE);
  double largest = 0;
  for (int n = 0; n < 50; ++n) {
    const std::array<double, 4> F = RandomF();
    const Sample sample = At(*material, F);
    double P[4];
    for (int k = 0; k < 4; ++k) {
      constexpr double kStep = 1e-5;
      std::array<double, 4> above = F, below = F;
      above[k] += kStep, below[k] -= kStep;
      P[k] = (At(*material, above).Energy() - At(*material, below).Energy()) / (2 * kStep);
    }
    const bool small = law == "linear";
    const double f[4] = {small ? 1 : F[0], small ? 0 : F[1], small ? 0 : F[2], small ? 1 : F[3]};
    const double J = small ? 1 : sample.Jacobian();
    const double xx = P[0] * f[0] + P[1] * f[1], yy = P[2] * f[2] + P[3] * f[3];
    const double xy = P[0] * f[2] + P[1] * f[3], yx = P[2] * f[0] + P[3] * f[1];
    largest = std::max(largest, Difference(sample.stress, {xx / J, yy / J, sample.stress[2], xy / J}) + std::abs(xy - yx));
  }
  EXPECT_LE(largest / kE, 1e-8) << law + ": stress less derivative of the energy, of E";
}

void Objectivity(const std::string &law)
{
  const auto material = Create(law, 1e3 * kE);
  double largest = 0;
  for (int n = 0; n < 50; ++n) {
    const std::array<double, 4> F = RandomF();
    const double angle = Random(-3, 3), c = std::cos(angle), s = std::sin(angle);
    const Sample turned = At(*material, {c * F[0] - s * F[2], c * F[1] - s * F[3], s * F[0] + c * F[2], s * F[1] + c * F[3]});
    largest = std::max(largest, Difference(turned.stress, Rotated(At(*material, F).stress, c, s)));
  }
  EXPECT_LE(largest / kE, 1e-14) << law + ": a rotation turns the stress, of E";
}

/// Hooke's law at strain e leaves an error of order e^2.
void SmallStrains(const std::string &law)
{
  constexpr double kStrain = 1e-6;
  const auto material = Create(law);
  double largest = 0, energy = 0;
  for (int n = 0; n < 50; ++n) {
    const double xx = Random(-1, 1) * kStrain, yy = Random(-1, 1) * kStrain, xy = Random(-1, 1) * kStrain,
                 yx = Random(-1, 1) * kStrain;
    const Sample sample = At(*material, {1 + xx, xy, yx, 1 + yy});
    const double sphere = kLambda * (xx + yy), shear = kMu * (xy + yx);
    const double stress[4] = {sphere + 2 * kMu * xx, sphere + 2 * kMu * yy, sphere, shear};
    largest = std::max(largest, Difference(sample.stress, {stress[0], stress[1], stress[2], stress[3]}));
    energy = std::max(energy, std::abs(sample.Energy() - 0.5 * (stress[0] * xx + stress[1] * yy + shear * (xy + yx))));
  }
  EXPECT_LE(largest / (kE * kStrain), 20 * kStrain) << law + ": Hooke's law for small strains, relative";
  EXPECT_LE(energy / (kE * kStrain * kStrain), 2e-4) << law + ": energy for small strains, relative"; // 1 + e loses 1e-16/e
  double speed2;
  material->WaveSpeedSquared(1, Sample(*material).F, &speed2);
  EXPECT_LE(std::abs(speed2 * kRho / (kLambda + 2 * kMu) - 1), 1e-14) << law + ": wave speed of the undeformed body";
}

/// A quarter turn in many increments exchanges sigma_xx and sigma_yy.
TEST(Materials, HypoelasticRotation)
{
  constexpr int kSteps = 1000;
  const auto material = Create("hypoelastic");
  Sample sample(*material);
  const double before[4] = {3e8, -1e8, 5e7, 2e8}, w = 2 * std::tan(M_PI / 4 / kSteps);
  std::copy(before, before + 4, sample.stress);
  for (int n = 0; n < kSteps; ++n) sample.Advance({0, -w, w, 0});
  EXPECT_LE(Difference(sample.stress, {before[1], before[0], before[2], -before[3]}) / before[0], 1e-12)
      << "hypoelastic: stress after a quarter turn, relative";
  const auto norm = [](const double *s) { return s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2 * s[3] * s[3]; };
  EXPECT_LE(std::abs(norm(sample.stress) / norm(before) - 1), 1e-12)
      << "hypoelastic: norm of the stress after a quarter turn, relative";
}

/// Uniaxial strain: the von Mises stress of tau is 2 mu e until it meets the yield stress; then alpha follows from e.
TEST(Materials, UniaxialYield)
{
  constexpr int kSteps = 1000;
  const auto material = Create("j2");
  Sample sample(*material);
  const double yield_strain = kYield / (2 * kMu), largest_strain = 5.13 * yield_strain,
               growth = std::exp(largest_strain / kSteps) - 1;
  double work = 0, first_yield = 0, off_surface = 0, off_alpha = 0, tau_before = 0;
  for (int n = 1; n <= kSteps; ++n) {
    sample.Advance({growth, 0, 0, 0});
    const double J = sample.Jacobian(), *s = sample.stress, strain = n * largest_strain / kSteps, tau = J * s[0];
    work += 0.5 * (tau + tau_before) * largest_strain / kSteps;
    tau_before = tau;
    if (sample.dissipated == 0) continue;
    if (first_yield == 0) first_yield = strain;
    const double mises =
        J * std::sqrt(0.5 * (std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2)) + 3 * s[3] * s[3]);
    const double alpha = (2 * kMu * strain - kYield) / (3 * kMu + kHardening);
    off_surface = std::max(off_surface, std::abs(mises / (kYield + kHardening * sample.history[4]) - 1));
    off_alpha = std::max(off_alpha, std::abs(sample.history[4] - alpha) / yield_strain);
  }
  const double alpha = sample.history[4], plastic_work = kYield * alpha + 0.5 * kHardening * alpha * alpha;
  EXPECT_LE(std::abs((first_yield - yield_strain) / (largest_strain / kSteps) - 0.5), 0.5)
      << "j2: first yield is within the increment of the exact strain";
  EXPECT_LE(off_surface, 1e-10) << "j2: von Mises stress less yield stress, relative";
  EXPECT_LE(off_alpha, 1e-10) << "j2: plastic strain against the exact one";
  EXPECT_LE(std::abs(sample.dissipated / plastic_work - 1), 1e-10) << "j2: plastic work, relative";
  EXPECT_LE(std::abs((sample.Energy() + sample.dissipated) / work - 1), 1e-5)
      << "j2: stored energy and plastic work are the work done";
  const double tau = sample.Jacobian() * sample.stress[0], dissipated = sample.dissipated, back = 0.5 * yield_strain;
  sample.Advance({std::exp(-back) - 1, 0, 0, 0});
  const double drop = tau - sample.Jacobian() * sample.stress[0];
  EXPECT_LE(std::abs(drop / ((kLambda + 2 * kMu) * back) - 1), 1e-10) << "j2: stiffness of unloading";
  EXPECT_EQ(sample.dissipated, dissipated) << "j2: unloading dissipates nothing";
  EXPECT_EQ(sample.history[4], alpha);
}

TEST(Materials, Deformation)
{
  double L[kBlock][4], increment[kBlock][4], F[4 * kBlock], before[4 * kBlock], largest = 0, row = 0;
  constexpr double kDt = 0.02;
  for (int p = 0; p < kBlock; ++p)
    for (int k = 0; k < 4; ++k) L[p][k] = Random(-3, 3), before[4 * p + k] = F[4 * p + k] = Random(-2, 2);
  const double returned = AdvanceDeformation(kBlock, kDt, L, increment, F);
  for (int p = 0; p < kBlock; ++p)
    for (int i = 0; i < 2; ++i) {
      row = std::max(row, kDt * (std::abs(L[p][2 * i]) + std::abs(L[p][2 * i + 1])));
      for (int j = 0; j < 2; ++j) {
        double product = before[4 * p + 2 * i + j];
        for (int k = 0; k < 2; ++k) product += kDt * L[p][2 * i + k] * before[4 * p + 2 * k + j];
        largest = std::max({largest, std::abs(F[4 * p + 2 * i + j] - product),
                            std::abs(increment[p][2 * i + j] - (i == j) - kDt * L[p][2 * i + j])});
      }
    }
  EXPECT_LE(largest, 1e-15) << "F <- (I + dt L) F";
  EXPECT_LE(std::abs(returned - row), 1e-15) << "largest increment of strain";
}

TEST(Materials, StressIsDerivativeOfEnergy)
{
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "linear", "j2"}) StressIsDerivativeOfEnergy(law);
}

TEST(Materials, SmallStrains)
{
  for (const std::string &law : MaterialModels()) SmallStrains(law);
}

/// The neo-Hookean sigma_zz is lambda ln J/J: the logarithm that vectorises against that of the library.
TEST(Materials, Logarithm)
{
  const auto material = Create("neo_hookean");
  const double powers[] = {std::sqrt(0.5), std::sqrt(2), 1, 1 + 1e-15, 1 - 1e-15, 1 + 1e-9, 2, 0.5, 1e-30, 1e30};
  for (int n = 0; n < 20000; ++n) {
    const double J = n < 10 ? powers[n] : std::exp(n % 2 ? Random(-1, 1) : Random(-60, 60));
    const double rate[1][4] = {}, increment[1][4] = {{1, 0, 0, 1}}, F[4] = {J, 0, 0, 1};
    double stress[4] = {}, dissipated = 0;
    material->UpdateStress({1, 1, rate, increment, F, stress, nullptr, 0}, &dissipated);
    EXPECT_LE(std::abs(stress[2] - kLambda * std::log(J) / J), 1e-15 * std::abs(stress[2])) << "J " << J;
  }
}

TEST(Materials, Objectivity)
{
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "j2"}) Objectivity(law);
}

} // namespace
