// Axisymmetry against exact solutions: a stretched patch, radial motion, vibrations and a manufactured solution.
//
// Without arguments: the tests. With "table": the modes and the manufactured solution over the size of cells.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <random>
#include <unordered_map>

using namespace mlgimp;

namespace
{

const MaterialConstants kMaterial = {1, 0.3, 1, NAN, NAN};
constexpr double kTwoPi = 2 * M_PI;

void SetUp(Model &model, const Scheme &scheme)
{
  model.geometry.kind = GeometryKind::kAxisymmetric;
  model.sides.fill(BoundaryKind::kSymmetry);
  model.stress_update = scheme.update;
  model.short_wave = scheme.viscosity;
}

/// Gives point p, which lies where it does without stress, the radius r and the radial stretch, with the stress of the law.
void Displace(const PointArrays &a, int p, const Material &material, double r, double stretch)
{
  const double R = a.initial_radius[p], hoop = r / R, J = stretch * hoop;
  const double pressure = material.Elastic().lambda * std::log(J) / J, mu = material.Elastic().mu / J;
  a.position[2 * p] = r;
  a.F[4 * p] = stretch;
  a.stress[4 * p] = mu * (stretch * stretch - 1) + pressure;
  a.stress[4 * p + 1] = pressure;
  a.stress[4 * p + 2] = mu * (hoop * hoop - 1) + pressure;
}

// ---- patch ----

struct Forces {
  double radial = 0, axial = 0; ///< largest on a node, of |sigma| 2 pi r h
};

/// A cylinder stretched by `stretch` across and along, under the stress (s, s, t) and the pressures that balance it.
PetscErrorCode PatchForces(int points_per_cell, Vec3 stretch, double offset, Forces *forces)
{
  constexpr double kRadius = 6.3, kHeight = 5.6, kAcross = -0.7, kAlong = 0.4;
  LevelsRun run;
  PetscFunctionBeginUser;
  SetUp(run.model, kDefaultScheme);
  run.model.sides = {BoundaryKind::kSymmetry};
  AddBody(run.model, CreateBoxRegion({{0, 0}, {kRadius, kHeight}}), "neo_hookean", kMaterial, {}, points_per_cell);
  for (Side side : {kXUpper, kYLower, kYUpper})
    run.model.loads.push_back({0, side, {{-HUGE_VAL, HUGE_VAL}}, PiecewiseLinear({0}, {side == kXUpper ? -kAcross : -kAlong})});
  PetscCall(run.Create(OneLevel(run.model, {{0, -8 - offset}, {20, 24 - offset}}, 1)));
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    for (int d = 0; d < 2; ++d) {
      a.position[2 * p + d] *= stretch[d];
      a.F[4 * p + 3 * d] = stretch[d];
    }
    a.stress[4 * p] = a.stress[4 * p + 2] = kAcross;
    a.stress[4 * p + 1] = kAlong;
  }));
  PetscCall(run.hierarchy.Advance({0, 1e-15}));
  const Grid &nodes = run.hierarchy.At(0).Mesh();
  *forces = {};
  ForEach(nodes.Owned(), [&](Index node) {
    const NodeSums &sums = nodes.Sums()[nodes.Place(node)];
    const double scale = kTwoPi * kRadius * stretch[0] * std::abs(kAcross);
    if (node[0] > 0) forces->radial = Largest({forces->radial, std::abs(sums.force[0]) / scale}); // the axis is held
    forces->axial = Largest({forces->axial, std::abs(sums.force[1]) / scale});
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Radial, Patch)
{
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> offset(0, 1);
  const Vec3 stretches[] = {{1, 1}, {1.07, 1}, {1.17, 0.8}, {0.8, 1.2}, {1.3, 0.9}};
  for (int points = 1; points <= 3; ++points) {
    double radial = 0, axial = 0;
    for (const Vec3 &stretch : stretches) {
      if (points == 1 && LargestComponent(stretch) > 1) continue; // a point may not become wider than a cell
      Forces forces;
      ASSERT_EQ(PatchForces(points, stretch, offset(generator), &forces), PETSC_SUCCESS);
      radial = Largest({radial, forces.radial}), axial = Largest({axial, forces.axial});
    }
    const std::string name = "axisymmetric patch, " + std::to_string(points) + " points a cell: nodal force along ";
    ExpectAtMost(name + "r, of |sigma| 2 pi r h", radial, 1e-12);
    ExpectAtMost(name + "z, of |sigma| 2 pi r h", axial, 1e-12);
  }
}

// ---- prescribed motion ----

/// Nodes move with v = c r to the stretch 1.3: places, F and stresses are exact.
PetscErrorCode Stretch(StressUpdate update)
{
  constexpr double kRate = 1e-3, kStretch = 1.3;
  LevelsRun run;
  PetscFunctionBeginUser;
  SetUp(run.model, {"", update, {0, 0}, 0});
  run.model.sides[kXUpper] = BoundaryKind::kFree;
  AddBody(run.model, CreateBoxRegion({{0, 0}, {8, 4}}), "neo_hookean", kMaterial);
  const Material &material = *run.model.materials[0];
  PetscCall(run.Create(OneLevel(run.model, {{0, 0}, {12, 4}}, 1)));
  Level &level = run.hierarchy.At(0);
  const double dt = 1;
  double stretch = 1;
  while (stretch < kStretch) {
    PetscCall(level.GatherForces({0, dt}));
    PetscCall(level.UpdateNodes(dt));
    PetscCall(level.FinishNodes({0, dt}, {}));
    const Grid &nodes = level.Mesh();
    ForEach(nodes.Owned(), [&](Index node) {
      double *v = nodes.Arrays().VelocityArray() + 4 * nodes.Place(node);
      v[0] = kRate * nodes.Geometry().Coordinate(0, node[0]);
      v[1] = v[2] = v[3] = 0;
    });
    PetscCall(level.AdvancePoints(dt));
    PetscCall(level.EndStep());
    stretch *= 1 + kRate * dt;
  }
  double place = 0, F = 0, stress = 0, volume = 0;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const double R = a.initial_radius[p], J = stretch * stretch,
                 expected = material.Elastic().mu / J * (J - 1) + material.Elastic().lambda * std::log(J) / J;
    place = Largest({place, std::abs(a.position[2 * p] / (stretch * R) - 1)});
    F = Largest({F, std::abs(a.F[4 * p] / stretch - 1)});
    for (int k : {0, 2}) stress = Largest({stress, std::abs(a.stress[4 * p + k] / expected - 1)});
    const double area = 4 * a.half_size[2 * p] * a.half_size[2 * p + 1] * stretch; // J m/rho = 2 pi r A
    volume = Largest({volume, std::abs(J * a.mass[p] / kMaterial.density / (kTwoPi * a.position[2 * p] * area) - 1)});
  }));
  const std::string name = std::string("v = c r to the stretch 1.3: error of ");
  ExpectAtMost(name + "r", place, 1e-12);
  ExpectAtMost(name + "F", F, 1e-12);
  ExpectAtMost(name + "the stresses along r and around", stress, 1e-12);
  ExpectAtMost(name + "the volume against 2 pi r A", volume, 1e-12);
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Radial, StretchUsl) { EXPECT_EQ(Stretch(StressUpdate::kUsl), PETSC_SUCCESS); }

// ---- vibrations ----

struct Vibration {
  double energy = NAN; ///< mean of the 20th period over that of the first
  double phase = NAN;  ///< lag after 20 periods, rad
};

/// Runs `periods` of `steps` steps; ratio: mean energy of the last over that of the first, NaN where the run fails.
PetscErrorCode EnergyRatio(LevelsRun &run, int periods, int steps, double *ratio)
{
  Budgets budgets;
  double first = 0, last = 0;
  PetscFunctionBeginUser;
  for (int step = 0; step < periods * steps && !run.Failed(); ++step) {
    PetscCall(run.Advance());
    if (step >= steps && step < (periods - 1) * steps) continue;
    PetscCall(run.hierarchy.ReduceBudgets(&budgets));
    (step < steps ? first : last) += budgets.kinetic_energy + budgets.strain_energy;
  }
  *ratio = run.Failed() ? NAN : last / first;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// u = A J1(k r) cos(w t) between the axis and a wall at r = 1, n cells, which starts from the displacement.
PetscErrorCode BesselMode(int n, const std::vector<Box> &boxes, Vibration *result)
{
  constexpr double k = 3.8317059702, kStrain = 0.003;
  constexpr int kPeriods = 20, kHeight = 4;
  LevelsRun run;
  PetscFunctionBeginUser;
  SetUp(run.model, kDefaultScheme);
  const Box strip = {{0, 0}, {1, double(kHeight) / n}};
  AddBody(run.model, CreateBoxRegion(strip), "neo_hookean", kMaterial);
  std::vector<Box> levels = boxes;
  for (Box &box : levels) box.upper[1] = strip.upper[1];
  PetscCall(run.Create(NestedLevels(run.model, strip, 1.0 / n, 2, levels)));
  const Material &material = *run.model.materials[0];
  const double c = material.SpeedOfSound(), w = k * c, A = kStrain / k;
  const int steps = static_cast<int>(std::ceil(kTwoPi / w * n * c / 0.4)); // in a period
  run.dt = kTwoPi / w / steps;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int l) {
    const double R = a.initial_radius[p], mode = A * j1(k * R), slope = A * k * (j0(k * R) - j1(k * R) / (k * R));
    Displace(a, p, material, R + mode, 1 + slope);
    a.velocity[2 * p] = w * mode * std::sin(0.5 * w * run.dt / (l + 1)); // velocities are half a step older
  }));
  *result = {};
  PetscCall(EnergyRatio(run, kPeriods, steps, &result->energy));
  double displacement = 0, velocity = 0;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const double R = a.initial_radius[p], weight = a.mass[p] * j1(k * R);
    displacement += weight * (a.position[2 * p] - R);
    velocity += weight * a.velocity[2 * p];
  }));
  if (run.Failed()) PetscFunctionReturn(PETSC_SUCCESS);
  result->phase = std::atan2(velocity / w, displacement) - 0.5 * w * run.dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const std::vector<Box> kAtAxis = {{{0, 0}, {0.5, 1}}}, kOutside = {{{0.5, 0}, {1, 1}}};

void ExpectMode(const std::string &name, int n, const std::vector<Box> &boxes, double energy, double phase)
{
  Vibration mode;
  ASSERT_EQ(BesselMode(n, boxes, &mode), PETSC_SUCCESS);
  const std::string title = "radial mode, " + name + ", n = " + std::to_string(n) + ": ";
  ExpectAtMost(title + "|E/E0 - 1| after 20 periods", std::abs(mode.energy - 1), energy);
  ExpectAtMost(title + "|phase| after 20 periods, rad", std::abs(mode.phase), phase);
}

TEST(Radial, Mode)
{
  ExpectMode("one level", 16, {}, 0.03, 1);
  ExpectMode("one level", 32, {}, 0.015, 0.25);
}

TEST(Radial, ModeOnLevels)
{
  ExpectMode("finer at the axis", 32, kAtAxis, 0.03, 0.25);
  ExpectMode("finer outside", 32, kOutside, 0.03, 0.25);
}

/// A free cylinder of 24 x 24 cells with v_z = strain c sin(pi z/L): its energy after 20 periods.
PetscErrorCode FreeCylinder(double strain, double *ratio)
{
  constexpr int kCells = 24, kPeriods = 20;
  LevelsRun run;
  PetscFunctionBeginUser;
  SetUp(run.model, kDefaultScheme);
  run.model.sides = {BoundaryKind::kSymmetry};
  AddBody(run.model, CreateBoxRegion({{0, 0}, {1, 1}}), "neo_hookean", kMaterial);
  PetscCall(run.Create(OneLevel(run.model, {{0, -0.5}, {1.5, 1.5}}, 1.0 / kCells)));
  const double c = run.model.materials[0]->SpeedOfSound();
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    a.velocity[2 * p + 1] = strain * c * std::sin(M_PI * (a.position[2 * p + 1] - 0.5));
  }));
  const int steps = static_cast<int>(std::ceil(2 * kCells / 0.36)); // in a period 2 L/c
  run.dt = 2 / c / steps;
  PetscCall(EnergyRatio(run, kPeriods, steps, ratio));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Radial, FreeCylinder)
{
  double ratio;
  ASSERT_EQ(FreeCylinder(0.005, &ratio), PETSC_SUCCESS);
  ExpectAtMost("free cylinder, strain 0.5 %: |E/E0 - 1| after 20 periods", std::abs(ratio - 1), 0.01);
  ASSERT_EQ(FreeCylinder(0.05, &ratio), PETSC_SUCCESS);
  ExpectAtMost("free cylinder, strain 5 %: |E/E0 - 1| after 20 periods", std::abs(ratio - 1), 0.05);
}

// ---- manufactured solution ----

constexpr double kA = 0.05, kOmega = M_PI; // r = R + A sin(w t) sin(pi R), one period

double BodyForce(double R, double g, const Material &material)
{
  const double lambda = material.Elastic().lambda, mu = material.Elastic().mu, rho = material.Density();
  const double s = std::sin(M_PI * R), c = std::cos(M_PI * R), f = 1 + g * M_PI * c, t = 1 + g * s / R;
  const double df = -g * M_PI * M_PI * s, dt = g * (M_PI * R * c - s) / (R * R), logarithm = lambda * std::log(f * t);
  const double radial = mu * (f - 1 / f) + logarithm / f, hoop = mu * (t - 1 / t) + logarithm / t; // first Piola-Kirchhoff
  const double slope = mu * df * (1 + 1 / (f * f)) + lambda * (df / f + dt / t) / f - logarithm * df / (f * f);
  return -kOmega * kOmega * g * s - (slope + (radial - hoop) / R) / rho;
}

struct Errors {
  double largest = 0, rms = 0; ///< of r, the worst of all steps
  double first_cell = 0;       ///< of F_rr at R < h, of its amplitude
};

PetscErrorCode Manufactured(int n, Errors *errors)
{
  LevelsRun run;
  std::unordered_map<std::int64_t, double> radius;
  PetscFunctionBeginUser;
  SetUp(run.model, kDefaultScheme);
  const Box strip = {{0, 0}, {1, 1.0 / n}};
  AddBody(run.model, CreateBoxRegion(strip), "neo_hookean", kMaterial);
  const Material &material = *run.model.materials[0];
  run.model.acceleration = [&](double time, int count, const std::int64_t *id, const double *, double *a) {
    for (int p = 0; p < count; ++p)
      a[2 * p] = BodyForce(radius.at(id[p]), kA * std::sin(kOmega * time), material), a[2 * p + 1] = 0;
  };
  PetscCall(run.Create(OneLevel(run.model, strip, 1.0 / n)));
  const double period = kTwoPi / kOmega;
  const int steps = static_cast<int>(std::ceil(period * n * material.SpeedOfSound() * 1.2 / 0.4));
  run.dt = period / steps;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const double R = radius[a.id[p]] = a.initial_radius[p];
    a.velocity[2 * p] = kA * kOmega * std::cos(0.5 * kOmega * run.dt) * std::sin(M_PI * R);
  }));
  *errors = {};
  for (int step = 0; step < steps && !run.Failed(); ++step) {
    PetscCall(run.Advance());
    const double g = kA * std::sin(kOmega * run.time);
    double sum = 0;
    int count = 0;
    PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
      const double R = a.initial_radius[p], error = std::abs(a.position[2 * p] - R - g * std::sin(M_PI * R));
      errors->largest = Largest({errors->largest, error});
      sum += error * error;
      ++count;
      const double slope = std::abs(a.F[4 * p] - 1 - g * M_PI * std::cos(M_PI * R)) / (kA * M_PI);
      if (R * n < 1) errors->first_cell = Largest({errors->first_cell, slope});
    }));
    errors->rms = Largest({errors->rms, std::sqrt(sum / count)});
  }
  if (run.Failed()) *errors = {NAN, NAN, NAN};
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Radial, Manufactured)
{
  Errors coarse, fine;
  ASSERT_EQ(Manufactured(16, &coarse), PETSC_SUCCESS);
  ASSERT_EQ(Manufactured(64, &fine), PETSC_SUCCESS);
  ExpectAtLeast("radial manufactured solution: order of the rms error, n = 16..64", 0.5 * std::log2(coarse.rms / fine.rms), 1.8);
  ExpectAtLeast("radial manufactured solution: order of the max error, n = 16..64",
                0.5 * std::log2(coarse.largest / fine.largest), 1.8);
  ExpectAtMost("radial manufactured solution: rms error at n = 64", fine.rms, 8e-5);
  ExpectAtMost("radial manufactured solution: F_rr in the first cell at n = 64, of its amplitude", fine.first_cell, 0.012);
}

PetscErrorCode Table(int largest_n)
{
  PetscFunctionBeginUser;
  std::printf(
      "| n | manufactured: max | rms | F_rr, first cell | mode: E/E0, one level | phase | finer at the axis | phase | finer "
      "outside | phase |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (int n = 16; n <= std::max(64, largest_n); n *= 2) {
    Errors errors;
    Vibration mode;
    PetscCall(Manufactured(n, &errors));
    std::printf("| %d | %.2e | %.2e | %.4f |", n, errors.largest, errors.rms, errors.first_cell);
    for (const std::vector<Box> &boxes : {std::vector<Box>{}, kAtAxis, kOutside}) {
      PetscCall(BesselMode(n, boxes, &mode));
      std::printf(" %.4f | %.3f |", mode.energy, mode.phase);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv, Table); }
