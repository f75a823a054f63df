// Materials by their properties: energy, objectivity, yield, the same law in all geometries.
#include "physics/material.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace mlgimp;

namespace
{

/// Of the random numbers of each law, which so do not depend on the laws before it.
constexpr unsigned kSeed = 20240607;
RandomNumbers Random(kSeed);

constexpr double kE = 70e9, kNu = 0.33, kRho = 2700, kYield = 200e6, kHardening = 2e9;
constexpr double kMu = kE / (2 * (1 + kNu)), kLambda = kE * kNu / ((1 + kNu) * (1 - 2 * kNu)), kBulk = kLambda + 2 * kMu / 3;
constexpr int kHistory = 16; // at least what any law here keeps

/// F or L by rows; stress as xx, yy, zz, xy, yz, xz.
using Matrix = std::array<double, 9>;
using Stress = std::array<double, 6>;
constexpr Matrix kUnit = {1, 0, 0, 0, 1, 0, 0, 0, 1};

std::unique_ptr<Material> Create(const std::string &law, double yield = kYield, GeometryKind geometry = GeometryKind::kSpatial)
{
  return CreateMaterial(law, {kE, kNu, kRho, yield, kHardening}, geometry);
}

using mlgimp::operator*;
Matrix operator*(const Matrix &a, const Matrix &b)
{
  Matrix product{};
  for (int k = 0; k < 27; ++k) product[k / 3] += a[3 * (k / 9) + k % 3] * b[3 * (k % 3) + k / 3 % 3];
  return product;
}
Matrix Transpose(const Matrix &a) { return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]}; }
Matrix Full(const double *s) { return {s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]}; }
Matrix Diagonal(double xx, double yy, double zz) { return {xx, 0, 0, 0, yy, 0, 0, 0, zz}; }
double Difference(const Matrix &a, const Matrix &b)
{
  double largest = 0;
  for (int k = 0; k < 9; ++k) largest = Largest({largest, std::abs(a[k] - b[k])});
  return largest;
}

/// A rotation by any angle about any axis, exact to round-off: 2 (n n^T) - I is a half turn, and two of them any turn.
Matrix RandomRotation()
{
  const auto half_turn = [] {
    Vec3 n = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    n = (1 / Norm(n)) * n;
    Matrix turn;
    for (int k = 0; k < 9; ++k) turn[k] = 2 * n[k / 3] * n[k % 3] - kUnit[k];
    return turn;
  };
  return half_turn() * half_turn();
}
Matrix RandomF()
{
  Matrix F = kUnit;
  for (double &component : F) component += Random(-0.2, 0.2);
  return F;
}

/// A point of a material in space, and its state.
struct Sample {
  explicit Sample(const Material &law) : material(law) { material.InitialHistory(history); }
  /// Advances by I + `dt` L.
  void Advance(const Matrix &L, double dt = 1)
  {
    Row L_rows[9], F_rows[9];
    LoadRows<9>(L.data(), 1, L_rows), LoadRows<9>(F.data(), 1, F_rows);
    AdvanceDeformation<Spatial>(1, dt, L_rows, F_rows);
    material.UpdateStress({1, dt, 1, L_rows, F_rows, nullptr, nullptr, stress, history, kHistory}, &dissipated);
    StoreRows<9>(F_rows, 1, F.data());
  }
  /// Advances to principal stretches along the axes, from such stretches.
  void StretchTo(double x, double y, double z) { Advance(Diagonal(x / F[0] - 1, y / F[4] - 1, z / F[8] - 1)); }
  double Energy() const
  {
    double energy;
    material.StoredEnergy(1, F.data(), nullptr, stress, history, kHistory, &energy);
    return energy;
  }
  double Jacobian() const { return Determinant(LoadGradient<Spatial>(F.data(), 1)); }
  /// Of Cauchy's stress, Pa.
  double Mises() const
  {
    const Sym3 sigma = LoadStress<Spatial>(stress), deviator = sigma - Sphere(Trace(sigma) / 3);
    return std::sqrt(1.5 * Contract(deviator, deviator));
  }
  double PlasticStrain() const { return history[material.PlaceOf(kPlasticStrain)]; }

  const Material &material;
  Matrix F = kUnit;
  double stress[6] = {}, history[kHistory] = {}, dissipated = 0;
};

/// The state after one increment from the undeformed body to F.
Sample At(const Material &material, const Matrix &F)
{
  Sample sample(material);
  Matrix L = F;
  for (int k = 0; k < 9; ++k) L[k] -= kUnit[k];
  sample.Advance(L);
  return sample;
}

/// J sigma = (dW/dF) F^T by central differences in all components; the small-strain law has sigma = dW/dF.
void StressIsDerivativeOfEnergy(const std::string &law)
{
  const auto material = Create(law, 1e3 * kE);
  double largest = 0;
  Random.seed(kSeed);
  for (int n = 0; n < 50; ++n) {
    const Matrix F = RandomF();
    const Sample sample = At(*material, F);
    Matrix P;
    for (int k = 0; k < 9; ++k) {
      constexpr double kStep = 1e-5;
      Matrix above = F, below = F;
      above[k] += kStep, below[k] -= kStep;
      P[k] = (At(*material, above).Energy() - At(*material, below).Energy()) / (2 * kStep);
    }
    Matrix kirchhoff = law == "linear" ? P : P * Transpose(F);
    for (double &component : kirchhoff) component /= law == "linear" ? 1 : sample.Jacobian();
    largest = Largest({largest, Difference(Full(sample.stress), kirchhoff)});
  }
  EXPECT_LE(largest / kE, 1e-8) << law + ": stress less derivative of the energy, of E";
}

void Objectivity(const std::string &law)
{
  const auto material = Create(law, 1e3 * kE);
  double largest = 0;
  Random.seed(kSeed);
  for (int n = 0; n < 50; ++n) {
    const Matrix F = RandomF(), Q = RandomRotation();
    const Sample turned = At(*material, Q * F);
    largest = Largest({largest, Difference(Full(turned.stress), Q * Full(At(*material, F).stress) * Transpose(Q))});
  }
  EXPECT_LE(largest / kE, 2e-14) << law + ": a rotation turns the stress, of E";
}

/// Hooke's law at strain e leaves an error of order e^2, and 1 + e one of 1e-16.
void SmallStrains(const std::string &law, double strain)
{
  const double tolerance = 20 * strain + 1e-15 / strain;
  const auto material = Create(law);
  double largest = 0, energy = 0;
  Random.seed(kSeed);
  for (int n = 0; n < 50; ++n) {
    Matrix gradient, F = kUnit, hooke;
    for (int k = 0; k < 9; ++k) F[k] += gradient[k] = Random(-1, 1) * strain;
    const double trace = gradient[0] + gradient[4] + gradient[8];
    double work = 0;
    for (int k = 0; k < 9; ++k) {
      hooke[k] = kLambda * trace * kUnit[k] + kMu * (gradient[k] + Transpose(gradient)[k]);
      work += 0.5 * hooke[k] * gradient[k];
    }
    const Sample sample = At(*material, F);
    largest = Largest({largest, Difference(Full(sample.stress), hooke)});
    energy = Largest({energy, std::abs(sample.Energy() - work)});
  }
  EXPECT_LE(largest / (kE * strain), tolerance) << law + ": Hooke's law for small strains, relative";
  EXPECT_LE(energy / (kE * strain * strain), tolerance) << law + ": energy for small strains, relative";
  double speed2;
  material->WaveSpeedSquared(1, kUnit.data(), nullptr, &speed2);
  EXPECT_LE(std::abs(speed2 * kRho / (kLambda + 2 * kMu) - 1), 1e-14) << law + ": wave speed of the undeformed body";
}

/// A quarter turn in many increments, about any axis, turns the stress: Hughes & Winget's rotation for a constant spin of
/// 2 tan(angle/2) is the rotation by that angle.
TEST(Materials, HypoelasticRotation)
{
  constexpr int kSteps = 1000;
  const auto material = Create("hypoelastic");
  Sample sample(*material);
  const Stress before = {3e8, -1e8, 5e7, 2e8, -4e7, 7e7};
  const Matrix axes = RandomRotation(), quarter = axes * Matrix{0, -1, 0, 1, 0, 0, 0, 0, 1} * Transpose(axes);
  const double w = 2 * std::tan(M_PI / 4 / kSteps);
  std::copy(before.begin(), before.end(), sample.stress);
  for (int n = 0; n < kSteps; ++n) sample.Advance(axes * Matrix{0, -w, 0, w, 0, 0, 0, 0, 0} * Transpose(axes));
  EXPECT_LE(Difference(Full(sample.stress), quarter * Full(before.data()) * Transpose(quarter)) / before[0], 1e-12)
      << "hypoelastic: stress after a quarter turn, relative";
}

/// Uniaxial strain e: the von Mises stress of tau = J sigma is 2 mu e until it meets J times the yield stress, J = exp(e); then
/// alpha follows from 2 mu e - 3 mu alpha = J (sy + H alpha).
TEST(Materials, UniaxialYield)
{
  constexpr int kSteps = 1000;
  const auto material = Create("j2");
  Sample sample(*material);
  const double yield_strain = kYield / (2 * kMu), largest_strain = 5.13 * yield_strain;
  double work = 0, plastic_work = 0, first_yield = 0, off_surface = 0, off_alpha = 0, tau_before = 0, alpha = 0;
  for (int n = 1; n <= kSteps; ++n) {
    const double strain = n * largest_strain / kSteps, J = std::exp(strain), before = alpha;
    sample.StretchTo(J, 1, 1);
    const double tau = J * sample.stress[0];
    work += 0.5 * (tau + tau_before) * largest_strain / kSteps;
    tau_before = tau;
    alpha = std::max(0.0, (2 * kMu * strain - J * kYield) / (3 * kMu + J * kHardening));
    plastic_work += J * (kYield + 0.5 * kHardening * (alpha + before)) * (alpha - before);
    if (sample.dissipated == 0) continue;
    if (first_yield == 0) first_yield = strain;
    off_surface = Largest({off_surface, std::abs(sample.Mises() / (kYield + kHardening * sample.PlasticStrain()) - 1)});
    off_alpha = Largest({off_alpha, std::abs(sample.PlasticStrain() - alpha) / yield_strain});
  }
  double exact_yield = yield_strain;
  for (int k = 0; k < 50; ++k) exact_yield = yield_strain * std::exp(exact_yield);
  EXPECT_LE(std::abs((first_yield - exact_yield) / (largest_strain / kSteps) - 0.5), 0.5)
      << "j2: first yield is within the increment of the exact strain";
  EXPECT_LE(off_surface, 1e-10) << "j2: von Mises stress less yield stress, relative";
  EXPECT_LE(off_alpha, 1e-10) << "j2: plastic strain against the exact one";
  EXPECT_LE(std::abs(sample.dissipated / plastic_work - 1), 1e-10) << "j2: plastic work, relative";
  EXPECT_LE(std::abs((sample.Energy() + sample.dissipated) / work - 1), 1e-5)
      << "j2: stored energy and plastic work are the work done";
  const double tau = sample.Jacobian() * sample.stress[0], dissipated = sample.dissipated, back = 0.5 * yield_strain;
  alpha = sample.PlasticStrain();
  sample.Advance(Diagonal(std::exp(-back) - 1, 0, 0));
  const double drop = tau - sample.Jacobian() * sample.stress[0];
  EXPECT_LE(std::abs(drop / ((kLambda + 2 * kMu) * back) - 1), 1e-10) << "j2: stiffness of unloading";
  EXPECT_EQ(sample.dissipated, dissipated) << "j2: unloading dissipates nothing";
  EXPECT_EQ(sample.PlasticStrain(), alpha);
}

/// tau = J sigma along a bar at its strain e and the plastic strain alpha: E e up to the yield stress; then E (e - alpha), where
/// sigma is sy + H alpha and ln J the elastic strain's (1 - 2 nu) tau/E.
double StressAlongBar(double e, double *alpha)
{
  double tau = kE * e;
  const auto volume_ratio = [&tau] { return std::exp((1 - 2 * kNu) * tau / kE); };
  *alpha = 0;
  if (tau <= volume_ratio() * kYield) return tau;
  for (int k = 0; k < 100; ++k) {
    tau = volume_ratio() * (kYield + kHardening * *alpha);
    *alpha = e - tau / kE;
  }
  return tau;
}

/// Uniaxial stress along each axis: e = tau/E + alpha along it and -nu tau/E - alpha/2 across, and no stress across.
TEST(Materials, UniaxialStress)
{
  constexpr double kLargest = 0.2;
  constexpr int kSteps = 50;
  const auto material = Create("j2");
  double along = 0, across = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Sample sample(*material);
    for (int n = 1; n <= kSteps; ++n) {
      double alpha, stretch[3];
      const double e = kLargest * n / kSteps, tau = StressAlongBar(e, &alpha);
      for (int d = 0; d < 3; ++d) stretch[d] = std::exp(d == axis ? e : -kNu * tau / kE - 0.5 * alpha);
      sample.StretchTo(stretch[0], stretch[1], stretch[2]);
      for (int c = 0; c < 6; ++c) {
        const double off = std::abs(sample.Jacobian() * sample.stress[c] - (c == axis ? tau : 0));
        (c == axis ? along : across) = Largest({c == axis ? along : across, off});
      }
    }
  }
  EXPECT_LE(along / kYield, 1e-11) << "j2: stress along the bar, of the yield stress";
  EXPECT_LE(across / kYield, 1e-11) << "j2: stress across the bar, of the yield stress";
}

/// Whatever the path, stress is on the yield surface after a plastic step, and the pressure that of J: plastic flow keeps the
/// volume.
TEST(Materials, RadialReturn)
{
  const auto material = Create("j2");
  double off_surface = 0, off_pressure = 0;
  for (int path = 0; path < 20; ++path) {
    Sample sample(*material);
    for (int n = 0; n < 50; ++n) {
      const double dissipated = sample.dissipated;
      Matrix L;
      for (double &component : L) component = Random(-1, 1) * 0.02;
      sample.Advance(L);
      EXPECT_LE(sample.Mises(), (kYield + kHardening * sample.PlasticStrain()) * (1 + 1e-10)) << "j2: beyond yield";
      if (sample.dissipated > dissipated)
        off_surface = Largest({off_surface, std::abs(sample.Mises() / (kYield + kHardening * sample.PlasticStrain()) - 1)});
      const double J = sample.Jacobian(), tau = J * Trace(LoadStress<Spatial>(sample.stress)) / 3;
      off_pressure = Largest({off_pressure, std::abs(tau / kBulk - std::log(J))});
    }
  }
  EXPECT_LE(off_surface, 1e-10) << "j2: von Mises stress less yield stress, relative";
  EXPECT_LE(off_pressure, 1e-12) << "j2: pressure less that of J, of the bulk modulus";
}

/// What Hooke's law says of a stress is what it says of the strain that has it.
TEST(Materials, StrainOfAStress)
{
  const Elasticity law({kE, kNu, kRho, kYield, kHardening});
  double energy = 0, square = 0;
  for (int n = 0; n < 50; ++n) {
    const Sym3 e = {Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    energy = Largest({energy, std::abs(law.EnergyOf(law.Hooke(e)) / law.HookeEnergy(e) - 1)});
    square = Largest({square, std::abs(law.StrainSquared(law.Hooke(e)) / Contract(e, e) - 1)});
  }
  EXPECT_LE(energy, 1e-13) << "energy of a stress, of that of its strain";
  EXPECT_LE(square, 1e-13) << "square of the strain of a stress";
}

/// The state of a point of a geometry after one step, and what the law says of it.
struct Outcome {
  Stress stress{};
  double energy, speed2, dissipated = 0, plastic_strain = 0;
};

/// Two steps of a point with F_zz = `zz` and its growth, in a geometry that has no xz and yz.
template <class G> Outcome Follow(const std::string &law, const Matrix &first, const Matrix &second)
{
  const auto material = Create(law, kYield, G::kKind);
  constexpr int n = G::kDim;
  double F[9], L[9], stress[6] = {}, history[kHistory];
  Row F_rows[9], L_rows[9];
  Matrix now = kUnit;
  Outcome outcome;
  material->InitialHistory(history);
  for (const Matrix &growth : {first, second}) {
    now = growth * now;
    for (int k = 0; k < n * n; ++k) {
      const int from = 3 * (k / n) + k % n;
      F[k] = now[from], L[k] = growth[from] - kUnit[from];
    }
    if (n == 3 && law != "j2") L[8] = std::log(growth[8]); // as the hoop's rate
    LoadRows<n * n>(F, 1, F_rows), LoadRows<n * n>(L, 1, L_rows);
    const double hoop = now[8], ratio = growth[8];
    const double *const hoops = G::kHoop ? &hoop : nullptr, *const ratios = G::kHoop ? &ratio : nullptr;
    material->UpdateStress({1, 1, 1, L_rows, F_rows, hoops, ratios, stress, history, kHistory}, &outcome.dissipated);
    material->StoredEnergy(1, F, hoops, stress, history, kHistory, &outcome.energy);
    material->WaveSpeedSquared(1, F, hoops, &outcome.speed2);
  }
  std::copy(stress, stress + G::kStress, outcome.stress.begin());
  if (law == "j2") outcome.plastic_strain = history[0];
  return outcome;
}

/// Largest difference of two outcomes but for the wave speed, energies and stress as parts of E.
double Difference(const Outcome &a, const Outcome &b)
{
  double largest = std::abs(a.plastic_strain - b.plastic_strain);
  largest += (std::abs(a.energy - b.energy) + std::abs(a.dissipated - b.dissipated)) / kE;
  for (int k = 0; k < 6; ++k) largest = Largest({largest, std::abs(a.stress[k] - b.stress[k]) / kE});
  return largest;
}

TEST(Materials, SameInAllGeometries)
{
  for (const std::string &law : MaterialModels()) {
    double plane = 0, hoop = 0;
    Random.seed(kSeed);
    for (int n = 0; n < 50; ++n) {
      Matrix growth[2];
      for (Matrix &G : growth)
        G = {1 + Random(-0.1, 0.1), Random(-0.1, 0.1), 0, Random(-0.1, 0.1), 1 + Random(-0.1, 0.1), 0, 0, 0, 1};
      const Outcome in_plane = Follow<PlaneStrain>(law, growth[0], growth[1]),
                    in_space = Follow<Spatial>(law, growth[0], growth[1]);
      plane = Largest({plane, Difference(in_plane, in_space)});
      EXPECT_LE(in_plane.speed2, in_space.speed2 * (1 + 1e-14)) << law + ": no waves along z in plane strain";
      growth[0][8] += Random(-0.1, 0.1), growth[1][8] += Random(-0.1, 0.1);
      const Outcome round = Follow<Axisymmetric>(law, growth[0], growth[1]), solid = Follow<Spatial>(law, growth[0], growth[1]);
      hoop = Largest({hoop, Difference(round, solid) + std::abs(round.speed2 / solid.speed2 - 1)});
    }
    EXPECT_LE(plane, 1e-14) << law + ": plane strain is space with F_zz = 1";
    EXPECT_LE(hoop, 1e-14) << law + ": axisymmetry is space with F_zz = r/R";
  }
}

/// A law whose constant is missing gives nothing else.
TEST(Materials, NoLimitHoldsForWhatIsNoNumber)
{
  for (int at : {0, 4, 8}) {
    Matrix broken = kUnit;
    broken[at] = NAN;
    EXPECT_FALSE(Difference(kUnit, broken) <= HUGE_VAL) << "component " << at;
  }
}

TEST(Materials, StressIsDerivativeOfEnergy)
{
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "linear", "j2", "anisotropic"}) StressIsDerivativeOfEnergy(law);
}

TEST(Materials, SmallStrains)
{
  for (const double strain : {1e-6, 1e-9})
    for (const std::string &law : MaterialModels()) SmallStrains(law, strain);
}

TEST(Materials, Objectivity)
{
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "j2", "anisotropic"}) Objectivity(law);
}

} // namespace
