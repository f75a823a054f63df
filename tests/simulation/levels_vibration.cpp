// A free block that vibrates across the border of a finer level, in the plane and in space: energy and momentum over many
// periods.
//
// Without arguments: the tests. With "table": all borders, ratios, updates and laws; with "table -N" in space, N periods.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>

using namespace mlgimp;

namespace
{

const MaterialConstants kMaterial = {1e7, 0.3, 1000, NAN, NAN};
const Box kDomain = {{-0.5, -0.5}, {1.5, 1.5}}, kHalf = {{0.5, -0.5}, {1.5, 1.5}}, kCentred = {{0.25, 0.25}, {0.75, 0.75}};

struct Case {
  const char *name;
  std::vector<Box> boxes; ///< of the finer levels; none for one level
  int ratio = 2;
  double across = 0; ///< in space: half of the block's size along y and z, which are sides of symmetry
};

const Case kOne = {"one level", {}}, kAcross = {"half", {kHalf}}, kInside = {"centred box", {kCentred}},
           kSpace = {"block in space, one level", {}, 2, 0.25},
           kSpaceAcross = {"block in space, half", {{{0.5, 0, 0}, {1.5, 0.5, 0.5}}}, 2, 0.25},
           kCube = {"cube, one level", {}, 2, 0.5},
           kCubeInside = {"cube, box inside", {{{0.25, 0, 0}, {0.75, 0.25, 0.25}}}, 2, 0.5},
           kThree = {"three levels, half", {{{-0.25, -0.5}, {1.5, 1.5}}, {{0.5, -0.5}, {1.5, 1.5}}}};

/// After 20 and 80 periods. Momenta are relative to sqrt(2 E m): mean of the period, largest value up to then, and largest
/// value less the stagger. (Velocities belong to the half steps of their level, so that their sum swings with the force
/// between the levels, by (dt_c - dt_f)/2 times that force; the mean is what drifts.)
struct Result {
  double energy[2] = {NAN, NAN}, drift[2] = {NAN, NAN}, swing[2] = {NAN, NAN}, rest[2] = {NAN, NAN};
};

/// A block of side 1 on cells x cells coarse cells, or its upper half on a roller for speed, with v_x = 0.02 c sin(pi (x - 1/2)).
/// Energies are means of a period, relative to the first period's.
PetscErrorCode Vibrate(const Case &levels, const Scheme &scheme, const std::string &law, int cells, int periods, Result *result,
                       bool upper_half = false)
{
  constexpr double kStrain = 0.02;
  constexpr int kCheck = 7; // steps between looks at the momentum
  LevelsRun run;
  Budgets budgets;
  PetscFunctionBeginUser;
  run.SetScheme(scheme);
  Box body = {{0, upper_half ? 0.5 : 0}, {1, 1}}, domain = kDomain;
  if (levels.across > 0) {
    run.model.geometry.kind = GeometryKind::kSpatial;
    run.model.sides[kYLower] = run.model.sides[kZLower] = BoundaryKind::kSymmetry;
    for (int d : {1, 2}) body.upper[d] = levels.across, domain.lower[d] = 0, domain.upper[d] = levels.across + 0.25;
  }
  AddBody(run.model, CreateBoxRegion(body), law, kMaterial);
  const double c = run.model.materials[0]->SpeedOfSound();
  std::vector<Box> boxes = levels.boxes;
  if (upper_half) {
    run.model.sides[kYLower] = BoundaryKind::kSymmetry;
    domain.lower[1] = 0.5;
    for (Box &box : boxes) box.lower[1] = 0.5;
  }
  PetscCall(run.Create(NestedLevels(run.model, domain, 1.0 / cells, levels.ratio, boxes)));
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    a.velocity[a.dim * p] = kStrain * c * std::sin(M_PI * (a.position[a.dim * p] - 0.5));
  }));
  PetscCall(run.hierarchy.ReduceBudgets(&budgets));
  const double start = budgets.momentum[0];
  const double scale = std::sqrt(2 * (budgets.kinetic_energy + budgets.strain_energy) * budgets.mass);
  const int steps = static_cast<int>(std::ceil(2 * cells / 0.36)); // in a period 2 L/c
  run.dt = 2 / c / steps;
  double first = 0, sum = 0, swing = 0, rest = 0, mean = 0;
  for (int step = 0; step < periods * steps && !run.Failed(); ++step) {
    const int period = step / steps;
    const bool counts = period == 0 || period == 19 || period == 79;
    PetscCall(run.Advance());
    if (counts || step % kCheck == 0) {
      PetscCall(run.hierarchy.ReduceBudgets(&budgets));
      const double change = (budgets.momentum[0] - start) / scale;
      swing = Largest({swing, std::abs(change)});
      rest = Largest({rest, std::abs(change - budgets.stagger_impulse[0] / scale)});
      if (counts) mean += change / steps;
    }
    if (!counts) continue;
    (period == 0 ? first : sum) += budgets.kinetic_energy + budgets.strain_energy;
    if ((step + 1) % steps != 0) continue;
    const int k = period == 79;
    result->energy[k] = sum / first, result->drift[k] = std::abs(mean), result->swing[k] = swing, result->rest[k] = rest;
    sum = mean = 0;
  }
  if (run.Failed()) *result = {};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TableRow(const Case &levels, const Scheme &scheme, const std::string &law, int cells, int periods)
{
  Result r;
  PetscFunctionBeginUser;
  PetscCall(Vibrate(levels, scheme, law, cells, periods, &r));
  std::printf("| %s | %d | %d | %s | %s | %.4f | %.4f | %.1e | %.1e | %.1e | %.0e |\n", levels.name, levels.ratio, cells,
              scheme.name, law.c_str(), r.energy[0], r.energy[1], r.drift[0], r.drift[1], r.swing[periods >= 80],
              periods < 80 ? r.rest[0] : r.rest[1]);
  std::fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Table(int periods)
{
  PetscFunctionBeginUser;
  std::printf(
      "| levels | ratio | cells | scheme | law | E/E0, 20 periods | 80 periods | momentum, 20 | 80 | swing | less stagger |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  if (periods < 0) {
    for (const Case &levels : {kSpace, kSpaceAcross, kCube, kCubeInside})
      for (int cells : {24, 32}) PetscCall(TableRow(levels, kDefaultScheme, "neo_hookean", cells, -periods));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (const Scheme &scheme : {kMusl, kDefaultScheme})
    for (const Case &levels : {kOne, kAcross, kInside, kThree}) PetscCall(TableRow(levels, scheme, "neo_hookean", 24, periods));
  for (const Scheme &scheme : {kUsl, kXpic2})
    for (const Case &levels : {kOne, kAcross}) PetscCall(TableRow(levels, scheme, "neo_hookean", 24, periods));
  for (const Case &levels : {kOne, kAcross}) PetscCall(TableRow(levels, kDefaultScheme, "hypoelastic", 24, periods));
  for (int cells : {16, 32})
    for (const Case &levels : {kOne, kAcross}) PetscCall(TableRow(levels, kMusl, "neo_hookean", cells, std::min(periods, 20)));
  PetscCall(TableRow(kOne, kMusl, "neo_hookean", 48, periods)); // the finer level's cells everywhere
  for (int ratio : {3, 4})
    for (const Scheme &scheme : {kMusl, kDefaultScheme})
      PetscCall(TableRow({"half", {kHalf}, ratio}, scheme, "neo_hookean", 24, std::min(periods, 20)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestVibration(const Scheme &scheme)
{
  constexpr int kCells = 24;
  PetscFunctionBeginUser;
  const bool absolute = !scheme.viscosity.On(); // the energy itself, not that against one level
  const int longest = absolute ? 20 : 80;       // where drifts would show: the defaults
  Result one;
  if (!absolute) PetscCall(Vibrate(kOne, scheme, "neo_hookean", kCells, 80, &one));
  for (const Case &levels : {kAcross, kInside}) {
    const bool across = levels.name == kAcross.name;
    const std::string name = std::string("vibrating block, ") + levels.name + ", " + scheme.name;
    Result r;
    PetscCall(Vibrate(levels, scheme, "neo_hookean", kCells, across ? longest : 20, &r));
    for (int k = 0; k < (across && longest > 20 ? 2 : 1); ++k) {
      const std::string when = k ? ", 80 periods" : ", 20 periods";
      if (absolute) {
        ExpectAtLeast(name + ": E/E0" + when, r.energy[k], 0.97);
        ExpectAtMost(name + ": E/E0" + when, r.energy[k], 1.02);
      } else
        ExpectAtMost(name + ": energy against one level" + when, std::abs(r.energy[k] / one.energy[k] - 1), 0.03);
      ExpectAtMost(name + ": mean momentum of a period, of sqrt(2 E m)" + when, r.drift[k], 2e-3);
      ExpectAtMost(name + ": momentum less the stagger" + when, r.rest[k], 1e-9);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsVibration, Musl) { EXPECT_EQ(TestVibration(kMusl), PETSC_SUCCESS); }

TEST(LevelsVibration, Default) { EXPECT_EQ(TestVibration(kDefaultScheme), PETSC_SUCCESS); }

} // namespace

int main(int argc, char **argv)
{
  return RunProgram(argc, argv, [](int periods) { return Table(periods ? periods : 80); });
}
