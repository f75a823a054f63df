// The pointwise layer by its properties: weights, materials, indenters, histories and tilings at random places.
#include "check.hpp"

#include "pointwise/indenter.hpp"
#include "pointwise/material.hpp"
#include "pointwise/region.hpp"
#include "pointwise/shape.hpp"

#include <cmath>
#include <random>

using namespace mlgimp;

namespace
{

std::mt19937 generator(20240607);
double Random(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(generator); }

// ---- Shape functions --------------------------------------------------------------------------------------------

/// The mean over [d - l, d + l] of the hat function of `node`, exactly: trapezia between its kinks. l = 0: its value.
double MeanHat(int node, double d, double l)
{
  const auto hat = [&](double x) { return std::max(1 - std::abs(x - node), 0.0); };
  if (l == 0) return hat(d);
  double sum = 0, from = d - l;
  for (double knot : {node - 1.0, static_cast<double>(node), node + 1.0, d + l}) {
    const double to = std::min(std::max(knot, from), d + l);
    sum += 0.5 * (hat(from) + hat(to)) * (to - from);
    from = to;
  }
  return sum / (2 * l);
}

/// Largest errors of the weights along an axis over many random offsets; half sizes are drawn from `sizes`.
template <class Shape> void CheckAxisWeights(const std::string &name, const std::vector<double> &sizes)
{
  double unity = 0, slopes = 0, linear = 0, outside = 0, mean = 0, derivative = 0, mirror = 0;
  for (double l : sizes)
    for (int n = 0; n < 400; ++n) {
      const double d = Random(-0.4999, 0.4999), step = 1e-5 * (l > 0 ? l : 1);
      const AxisWeights at = Shape::Evaluate(d, l), back = Shape::Evaluate(-d, l);
      const AxisWeights above = Shape::Evaluate(d + step, l), below = Shape::Evaluate(d - step, l);
      unity = std::max(unity, std::abs(at.w[0] + at.w[1] + at.w[2] - 1));
      slopes = std::max(slopes, std::abs(at.g[0] + at.g[1] + at.g[2]));
      linear = std::max(linear, std::abs(at.w[2] - at.w[0] - d) + std::abs(at.g[2] - at.g[0] - 1));
      for (int k = 0; k < 3; ++k) {
        outside = std::max({outside, -at.w[k], at.w[k] - 1});
        mean = std::max(mean, std::abs(at.w[k] - MeanHat(k - 1, d, l)));
        mirror = std::max({mirror, std::abs(at.w[k] - back.w[2 - k]), std::abs(at.g[k] + back.g[2 - k])});
        if (l > 0 || std::abs(d) > step)
          derivative = std::max(derivative, std::abs((above.w[k] - below.w[k]) / (2 * step) - at.g[k]));
      }
    }
  // Round-off grows as 1/l, down to l = 1e-3. A difference across a kink of the slope, which is 1/(2 l) steep, is off by
  // up to step/(4 l).
  CheckAtMost(name + ": weights add up to one", unity, 1e-15);
  CheckAtMost(name + ": slopes add up to zero", slopes, 1e-12);
  CheckAtMost(name + ": linear functions and their slope are reproduced", linear, 1e-12);
  CheckAtMost(name + ": weights leave [0, 1] by", outside, 1e-15);
  CheckAtMost(name + ": weights are means of the hat function", mean, 1e-12);
  CheckAtMost(name + ": slopes are derivatives of the weights", derivative, 1e-5);
  CheckAtMost(name + ": a reflection exchanges weights", mirror, 1e-15);
}

/// Stencils of a block of points in 2D against products of means of hat functions over the points' current extent.
template <class Shape> void CheckStencil(const std::string &name)
{
  constexpr double kH = 0.37;
  const Lattice<2> lattice = {{-1.3, 2.1}, 1 / kH, {-2, 3}, {1, 40}};
  double x[2 * kBlock], half[2 * kBlock], F[4 * kBlock], largest = 0;
  int clamped = 0;
  Stencil<2> stencil;
  for (int p = 0; p < kBlock; ++p) {
    for (int a = 0; a < 2; ++a) {
      x[2 * p + a] = lattice.origin[a] + kH * Random(5, 15);
      half[2 * p + a] = kH * (p % 8 == a ? 0.5 : p % 8 == 2 + a ? 0.7 : p % 8 == 4 + a ? 1e-4 : Random(0.05, 0.3));
    }
    for (int c = 0; c < 4; ++c) F[4 * p + c] = (c % 3 == 0) + (p % 8 < 6 ? 0 : Random(-0.3, 0.3));
  }
  const int counted = ComputeStencil<Shape>(lattice, kBlock, x, half, F, stencil);
  for (int p = 0; p < kBlock; ++p) {
    double l[2], sum = 0;
    for (int a = 0; a < 2; ++a) {
      const double *f = F + 4 * p + 2 * a, *size = half + 2 * p;
      l[a] = (Shape::kUsesDeformation ? std::hypot(f[0] * size[0], f[1] * size[1]) : size[a]) / kH;
      clamped += l[a] > 0.5 + 1e-9 || l[a] < 1e-3;
      l[a] = std::is_same_v<Shape, Linear> ? 0 : std::min(std::max(l[a], 1e-3), 0.5);
    }
    for (int k = 0; k < 9; ++k) {
      const int index = stencil.node[p] + stencil.offset[k] + 40 * 3 - 2; // global node i + 40 j
      const double dx = (x[2 * p] - lattice.origin[0]) / kH - index % 40, dy = (x[2 * p + 1] - lattice.origin[1]) / kH - index / 40;
      largest = std::max(largest, std::abs(stencil.S[k][p] - MeanHat(0, dx, l[0]) * MeanHat(0, dy, l[1])));
      sum += stencil.S[k][p];
    }
    double gradient[2][2] = {};
    for (int k = 0; k < 9; ++k) {
      const int index = stencil.node[p] + stencil.offset[k] + 40 * 3 - 2;
      for (int a = 0; a < 2; ++a) {
        gradient[a][0] += stencil.dS[a][k][p] * kH * (index % 40);
        gradient[a][1] += stencil.dS[a][k][p] * kH * (index / 40);
      }
    }
    largest = std::max({largest, std::abs(sum - 1), 1e-2 * std::abs(gradient[0][0] - 1), 1e-2 * std::abs(gradient[1][1] - 1),
                        1e-2 * std::abs(gradient[0][1]), 1e-2 * std::abs(gradient[1][0])});
  }
  CheckAtMost(name + ": weights of points in the plane, gradients of linear functions", largest, 1e-12);
  Check(name + ": clamped sizes are counted", counted == clamped, std::to_string(counted) + " of " + std::to_string(clamped));
}

void ShapeFunctionTests()
{
  CheckAxisWeights<Linear>("linear", {0});
  CheckAxisWeights<UniformGimp>("GIMP", {0.5, 0.25, 0.125, 0.01, Random(0.02, 0.5), Random(0.02, 0.5), Random(0.02, 0.5)});
  double mean = 0;
  for (int n = 0; n < 400; ++n)
    for (int k = 0; k < 3; ++k) {
      const double d = Random(-0.5, 0.5);
      mean = std::max(mean, std::abs(UniformGimp::Evaluate(d, kMinHalfSize).w[k] - MeanHat(k - 1, d, kMinHalfSize)));
    }
  CheckAtMost("GIMP: least half size", mean, 1e-12);
  CheckStencil<Linear>("linear");
  CheckStencil<UniformGimp>("uGIMP");
  CheckStencil<ContiguousGimp>("cpGIMP");
}

// ---- Materials --------------------------------------------------------------------------------------------------

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
    double rate[4][kBlock], increment[4][kBlock];
    for (int k = 0; k < 4; ++k) rate[k][0] = L[k];
    AdvanceDeformation(1, dt, rate, increment, F);
    MaterialBatch batch{1, dt, {}, {}, F, stress, history, material.HistorySize()};
    for (int k = 0; k < 4; ++k) batch.L[k] = rate[k], batch.increment[k] = increment[k];
    material.UpdateStress(batch, &dissipated);
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

std::array<double, 4> RandomF()
{
  return {1 + Random(-0.2, 0.2), Random(-0.2, 0.2), Random(-0.2, 0.2), 1 + Random(-0.2, 0.2)};
}

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
  CheckAtMost(law + ": stress less derivative of the energy, of E", largest / kE, 1e-8);
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
  CheckAtMost(law + ": a rotation turns the stress, of E", largest / kE, 1e-14);
}

/// Hooke's law at strain e leaves an error of order e^2.
void SmallStrains(const std::string &law)
{
  constexpr double kStrain = 1e-6;
  const auto material = Create(law);
  double largest = 0, energy = 0;
  for (int n = 0; n < 50; ++n) {
    const double xx = Random(-1, 1) * kStrain, yy = Random(-1, 1) * kStrain, xy = Random(-1, 1) * kStrain, yx = Random(-1, 1) * kStrain;
    const Sample sample = At(*material, {1 + xx, xy, yx, 1 + yy});
    const double sphere = kLambda * (xx + yy), shear = kMu * (xy + yx);
    const double stress[4] = {sphere + 2 * kMu * xx, sphere + 2 * kMu * yy, sphere, shear};
    largest = std::max(largest, Difference(sample.stress, {stress[0], stress[1], stress[2], stress[3]}));
    energy = std::max(energy, std::abs(sample.Energy() - 0.5 * (stress[0] * xx + stress[1] * yy + shear * (xy + yx))));
  }
  CheckAtMost(law + ": Hooke's law for small strains, relative", largest / (kE * kStrain), 20 * kStrain);
  CheckAtMost(law + ": energy for small strains, relative", energy / (kE * kStrain * kStrain), 2e-4); // 1 + e loses 1e-16/e
  double speed2;
  material->WaveSpeedSquared(1, Sample(*material).F, &speed2);
  CheckAtMost(law + ": wave speed of the undeformed body", std::abs(speed2 * kRho / (kLambda + 2 * kMu) - 1), 1e-14);
}

/// A quarter turn in many increments exchanges sigma_xx and sigma_yy.
void HypoelasticRotation()
{
  constexpr int kSteps = 1000;
  const auto material = Create("hypoelastic");
  Sample sample(*material);
  const double before[4] = {3e8, -1e8, 5e7, 2e8}, w = 2 * std::tan(M_PI / 4 / kSteps);
  std::copy(before, before + 4, sample.stress);
  for (int n = 0; n < kSteps; ++n) sample.Advance({0, -w, w, 0});
  CheckAtMost("hypoelastic: stress after a quarter turn, relative",
              Difference(sample.stress, {before[1], before[0], before[2], -before[3]}) / before[0], 1e-12);
  const auto norm = [](const double *s) { return s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2 * s[3] * s[3]; };
  CheckAtMost("hypoelastic: norm of the stress after a quarter turn, relative", std::abs(norm(sample.stress) / norm(before) - 1), 1e-12);
}

/// Uniaxial strain: the von Mises stress of tau is 2 mu e until it meets the yield stress; then alpha follows from e.
void UniaxialYield()
{
  constexpr int kSteps = 1000;
  const auto material = Create("j2");
  Sample sample(*material);
  const double yield_strain = kYield / (2 * kMu), largest_strain = 5.13 * yield_strain, growth = std::exp(largest_strain / kSteps) - 1;
  double work = 0, first_yield = 0, off_surface = 0, off_alpha = 0, tau_before = 0;
  for (int n = 1; n <= kSteps; ++n) {
    sample.Advance({growth, 0, 0, 0});
    const double J = sample.Jacobian(), *s = sample.stress, strain = n * largest_strain / kSteps, tau = J * s[0];
    work += 0.5 * (tau + tau_before) * largest_strain / kSteps;
    tau_before = tau;
    if (sample.dissipated == 0) continue;
    if (first_yield == 0) first_yield = strain;
    const double mises = J * std::sqrt(0.5 * (std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2)) + 3 * s[3] * s[3]);
    const double alpha = (2 * kMu * strain - kYield) / (3 * kMu + kHardening);
    off_surface = std::max(off_surface, std::abs(mises / (kYield + kHardening * sample.history[4]) - 1));
    off_alpha = std::max(off_alpha, std::abs(sample.history[4] - alpha) / yield_strain);
  }
  const double alpha = sample.history[4], plastic_work = kYield * alpha + 0.5 * kHardening * alpha * alpha;
  CheckAtMost("j2: first yield is within the increment of the exact strain",
              std::abs((first_yield - yield_strain) / (largest_strain / kSteps) - 0.5), 0.5);
  CheckAtMost("j2: von Mises stress less yield stress, relative", off_surface, 1e-10);
  CheckAtMost("j2: plastic strain against the exact one", off_alpha, 1e-10);
  CheckAtMost("j2: plastic work, relative", std::abs(sample.dissipated / plastic_work - 1), 1e-10);
  CheckAtMost("j2: stored energy and plastic work are the work done", std::abs((sample.Energy() + sample.dissipated) / work - 1), 1e-5);
  const double tau = sample.Jacobian() * sample.stress[0], dissipated = sample.dissipated, back = 0.5 * yield_strain;
  sample.Advance({std::exp(-back) - 1, 0, 0, 0});
  const double drop = tau - sample.Jacobian() * sample.stress[0];
  CheckAtMost("j2: stiffness of unloading", std::abs(drop / ((kLambda + 2 * kMu) * back) - 1), 1e-10);
  Check("j2: unloading dissipates nothing", sample.dissipated == dissipated && sample.history[4] == alpha);
}

void Deformation()
{
  double L[4][kBlock], increment[4][kBlock], F[4 * kBlock], before[4 * kBlock], largest = 0, row = 0;
  constexpr double kDt = 0.02;
  for (int p = 0; p < kBlock; ++p)
    for (int k = 0; k < 4; ++k) L[k][p] = Random(-3, 3), before[4 * p + k] = F[4 * p + k] = Random(-2, 2);
  const double returned = AdvanceDeformation(kBlock, kDt, L, increment, F);
  for (int p = 0; p < kBlock; ++p)
    for (int i = 0; i < 2; ++i) {
      row = std::max(row, kDt * (std::abs(L[2 * i][p]) + std::abs(L[2 * i + 1][p])));
      for (int j = 0; j < 2; ++j) {
        double product = before[4 * p + 2 * i + j];
        for (int k = 0; k < 2; ++k) product += kDt * L[2 * i + k][p] * before[4 * p + 2 * k + j];
        largest = std::max({largest, std::abs(F[4 * p + 2 * i + j] - product),
                            std::abs(increment[2 * i + j][p] - (i == j) - kDt * L[2 * i + j][p])});
      }
    }
  CheckAtMost("F <- (I + dt L) F", largest, 1e-15);
  CheckAtMost("largest increment of strain", std::abs(returned - row), 1e-15);
}

void MaterialTests()
{
  Deformation();
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "linear", "j2"}) StressIsDerivativeOfEnergy(law);
  for (const char *law : {"neo_hookean", "st_venant_kirchhoff", "j2"}) Objectivity(law);
  for (const std::string &law : MaterialModels()) SmallStrains(law);
  HypoelasticRotation();
  UniaxialYield();
}

// ---- Indenters, histories, tilings ------------------------------------------------------------------------------

/// Height of a surface at x, by bisection of the gap along the vertical.
double Height(const IndenterSurface &surface, double x, double upper)
{
  double below = -1e-3, above = upper;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (below + above);
    (surface.Gap({x, middle}).distance > 0 ? below : above) = middle;
  }
  return 0.5 * (below + above);
}

/// width: of the part of the surface that is looked at, whose height is below `height`.
void CheckSurface(const std::string &name, const IndenterSurface &surface, double width, double height)
{
  double unit = 0, gradient = 0, lowest = HUGE_VAL;
  bool signs = true;
  for (int n = 0; n < 200; ++n) {
    constexpr double kStep = 1e-6;
    const double x = Random(-width, width), y = Height(surface, x, height);
    const Vec2 normal = surface.Gap({x, y}).normal;
    unit = std::max(unit, std::abs(Norm(normal) - 1));
    for (int a = 0; a < 2 && std::abs(x) > 1e-4; ++a) {
      Vec2 above = {x, y}, below = {x, y};
      above[a] += kStep, below[a] -= kStep;
      const double slope = (surface.Gap(above).distance - surface.Gap(below).distance) / (2 * kStep);
      gradient = std::max(gradient, std::abs(slope - normal[a]));
    }
    signs &= surface.Gap(Vec2{x, y} + 1e-3 * normal).distance > 0 && surface.Gap(Vec2{x, y} + -1e-3 * normal).distance < 0;
    lowest = std::min(lowest, y);
  }
  CheckAtMost(name + ": length of the normal less one", unit, 1e-14);
  CheckAtMost(name + ": normal less gradient of the gap, on the surface", gradient, 1e-6);
  Check(name + ": gap is positive outside and negative inside", signs);
  Check(name + ": nothing lies below the tip", lowest > -1e-12);
  CheckAtMost(name + ": gap at the tip", std::abs(surface.Gap({0, 0}).distance), 1e-15);
  CheckAtMost(name + ": gap below the tip", std::abs(surface.Gap({0, -0.01}).distance - 0.01), 0.01 * 0.07); // 1 - cos 19.7
}

void IndenterTests()
{
  constexpr double kHalfAngle = 70.3, kTipRadius = 0.2;
  const double slope = 1 / std::tan(kHalfAngle * M_PI / 180);
  CheckSurface("wedge", *CreateWedge(kHalfAngle, 0), 1, 1);
  const auto rounded = CreateWedge(kHalfAngle, kTipRadius);
  CheckSurface("rounded wedge", *rounded, 1, 1);
  CheckSurface("cylinder", *CreateCylinder(2), 1.5, 2);
  CheckSurface("flat punch", *CreateFlatPunch(2), 0.99, 1);
  CheckSurface("polygon", *CreatePolygonIndenter({{3, 7}, {5, 7.6}, {5, 10}, {1, 10}, {1, 7.5}}), 1.9, 1);
  const double x = 1e-3 * kTipRadius, height = Height(*rounded, x, 1);
  CheckAtMost("rounded wedge: radius of curvature at the tip", std::abs(x * x / (2 * height) / kTipRadius - 1), 1e-5);
  CheckAtMost("rounded wedge: slope far from the tip", std::abs((Height(*rounded, 1001, 1000) - Height(*rounded, 1000, 1000)) / slope - 1), 1e-6);
  CheckAtMost("wedge: slope", std::abs(Height(*CreateWedge(kHalfAngle, 0), 1, 1) / slope - 1), 1e-12);
  CheckAtMost("cylinder: height", std::abs(Height(*CreateCylinder(2), 1, 2) - (2 - std::sqrt(3))), 1e-12);
  CheckAtMost("cylinder: gap at a distance", std::abs(CreateCylinder(2)->Gap({3, -2}).distance - 3), 1e-14);
  Check("IsConvex", IsConvex({{0, 0}, {1, 0}, {0, 1}}) && IsConvex({{0, 1}, {1, 0}, {0, 0}}) &&
                        !IsConvex({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}));
}

void HistoryTests()
{
  const PiecewiseLinear speed({0.5, 1, 3, 4}, {0, 2, 2, -1});
  Check("history: values", speed.Value(0) == 0 && speed.Value(0.75) == 1 && speed.Value(2) == 2 && speed.Value(3.5) == 0.5 && speed.Value(9) == -1);
  double worst = 0, sum = 0;
  constexpr int kParts = 5000;
  for (int n = 0; n < kParts; ++n) { // knots fall on ends of parts, where the trapezium rule is exact
    const double t = 5.0 * n / kParts, next = 5.0 * (n + 1) / kParts;
    sum += 0.5 * (speed.Value(t) + speed.Value(next)) * (next - t);
    worst = std::max(worst, std::abs(speed.Integral(next) - sum));
  }
  CheckAtMost("history: integral", worst, 1e-12);
  CheckAtMost("history: constant one", std::abs(PiecewiseLinear({2}, {3}).Integral(1.5) - 4.5), 1e-15);
  // The integral grows to 0.5 + 4 + 2/3 at t = 3 + 2/3 and falls again.
  worst = 0;
  for (double target : {1e-9, 0.1, 0.5, 2.0, 4.5, 5.0, 5.16})
    worst = std::max(worst, std::abs(speed.Integral(speed.TimeOfIntegral(target, 10)) - target) + (speed.TimeOfIntegral(target, 10) < 3.667 ? 0 : 1));
  CheckAtMost("history: first time of an integral", worst, 1e-12);
  Check("history: integrals never reached", std::isinf(speed.TimeOfIntegral(5.17, 10)) && std::isinf(speed.TimeOfIntegral(2, 1.5)));

  const Indenter indenter = {CreateCylinder(1), {speed, 2, 0.5}, {3, 7}, 6};
  CheckAtMost("motion: depth before turning", std::abs(indenter.Depth(1.5) - (0.5 + 1 - 1)), 1e-14);
  CheckAtMost("motion: depth after turning", std::abs(indenter.Depth(3) - (2.5 - 0.5 - 1)), 1e-14);
  Check("motion: velocity", indenter.Velocity(1.5)[1] == -2 && indenter.Velocity(3)[1] == 0.5 && indenter.Velocity(3)[0] == 0);
  CheckAtMost("motion: gap moves with the tip", std::abs(indenter.Gap(indenter.Tip(1.7), 1.7).distance), 1e-14);
}

void TilingTests()
{
  double area = 0, outside = 0, other = 0, miss = 0;
  for (int n = 0; n < 200; ++n) {
    const double h = Random(0.1, 2);
    const Vec2 origin = {Random(-3, 3), Random(-3, 3)};
    Box box = {{origin[0] + Random(0, 3), origin[1] + Random(0, 3)}, {}};
    box.upper = {box.lower[0] + Random(0.05, 6), box.lower[1] + Random(0.05, 6)};
    if (n % 4 == 0) box.lower[0] = origin[0] + h, box.upper[0] = origin[0] + h + (0.1 + 0.2) / 0.1 * h; // sides on nodes but for round-off
    const Tiling tiling(box, origin, h, 1 + n % 4);
    double sum = 0;
    const int last[2] = {static_cast<int>((box.upper[0] - origin[0]) / h) + 1, static_cast<int>((box.upper[1] - origin[1]) / h) + 1};
    for (int j = -1; j <= last[1]; ++j)
      for (int i = -1; i <= last[0]; ++i)
        for (const Tile &tile : tiling.InCell(i, j)) {
          Tile found;
          other = std::max(other, tiling.At(tile.center, found) ? Norm(found.center - tile.center) : HUGE_VAL);
          for (int a = 0; a < 2; ++a)
            outside = std::max({outside, box.lower[a] - tile.center[a] + tile.half_size[a], tile.center[a] + tile.half_size[a] - box.upper[a]});
          sum += 4 * tile.half_size[0] * tile.half_size[1];
        }
    area = std::max(area, std::abs(sum / ((box.upper[0] - box.lower[0]) * (box.upper[1] - box.lower[1])) - 1));
    for (int k = 0; k < 20; ++k) {
      const Vec2 x = {Random(box.lower[0], box.upper[0]), Random(box.lower[1], box.upper[1])};
      Tile tile;
      const bool found = tiling.At(x, tile);
      for (int a = 0; a < 2; ++a) miss = std::max(miss, found ? std::abs(x[a] - tile.center[a]) - tile.half_size[a] : HUGE_VAL);
    }
  }
  CheckAtMost("tiling: area less the box's, relative", area, 1e-12);
  CheckAtMost("tiling: tiles beyond the box by", outside, 1e-12);
  CheckAtMost("tiling: the tile at a tile's centre is another by", other, 1e-12);
  CheckAtMost("tiling: places outside the tile found for them by", miss, 1e-12);
}

} // namespace

int main()
{
  ShapeFunctionTests();
  MaterialTests();
  IndenterTests();
  HistoryTests();
  TilingTests();
  return 0;
}
