// A block that flies obliquely into, through and out of finer levels, in the plane and in space: points, mass and momentum; the
// energy of one that vibrates as it flies. With "table": that energy for all levels and schemes.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <set>

using namespace mlgimp;

namespace
{

const MaterialConstants kMaterial = {4e6, 0.3, 1000, NAN, NAN};
constexpr double kSpeed = 0.1;                                                // of the wave speed, along x
const Box kDomain = {{0, 0}, {37, 28}}, kRagged = {{2.13, 2.71}, {8.4, 8.1}}, // m
    kWhole = {{1, 2}, {9, 8}};                                                // cut into whole tiles
const Box kSpace = {{0, 0, 0}, {34, 25, 16}}, kBlock = {{2.13, 2.71, 1.9}, {6.4, 6.1, 5.3}};

struct Case {
  const char *name;
  std::vector<Box> boxes;
  int ratio = 2;
  bool merge = false;
  int dim = 2;
};

const std::vector<Box> kBox = {{{13, 6}, {23, 20}}}, kBoxes = {{{11, 4}, {25, 22}}, {{16, 9}, {20, 17}}},
                       kSpaceBox = {{{11, 5, 2}, {20, 20, 13}}};

struct Flight {
  double stress = 0;            ///< largest, of Young's modulus
  double mass = 0, arrived = 0; ///< error of the mass; share of the points beyond the finer levels
  double split = 0, left = 0, merged = 0, transfer_error = 0;
  double energy = 0, vibration = 0; ///< mean of the last tenth; that without the flight's own, of the start's
  bool numbers = true;              ///< unique, and as many as the budgets say
};

double Vibration(const Budgets &b)
{
  const Vec3 momentum = {b.momentum[0], b.momentum[1], b.momentum[2]};
  return b.kinetic_energy + b.strain_energy - 0.5 * Dot(momentum, momentum) / b.mass;
}

/// From the lower left corner to the upper right one; amplitude: of the vibration's strain.
PetscErrorCode Fly(const Case &levels, const Scheme &scheme, double amplitude, Flight *f)
{
  LevelsRun run;
  Budgets first, budgets;
  PetscFunctionBeginUser;
  run.SetScheme(scheme);
  const bool space = levels.dim == 3;
  if (space) run.model.geometry.kind = GeometryKind::kSpatial;
  const double c = CreateMaterial("neo_hookean", kMaterial, run.model.geometry.kind)->SpeedOfSound();
  const Vec3 velocity = {kSpeed * c, 0.68 * kSpeed * c, space ? 0.3 * kSpeed * c : 0};
  const double h = amplitude == 0 ? 1 : 0.5; // m; the vibration needs the finer one
  const Box body = space ? kBlock : amplitude == 0 ? kRagged : kWhole;
  AddBody(run.model, CreateBoxRegion(body), "neo_hookean", kMaterial, velocity);
  HierarchySettings settings = NestedLevels(run.model, space ? kSpace : kDomain, h, levels.ratio, levels.boxes);
  settings.merge_siblings = levels.merge;
  PetscCall(run.Create(settings));
  const Vec3 middle = 0.5 * (body.lower + body.upper), size = body.upper - body.lower;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    a.velocity[a.dim * p] += amplitude * c * std::sin(M_PI * (a.position[a.dim * p] - middle[0]) / size[0]);
  }));
  PetscCall(run.hierarchy.ReduceBudgets(&first));
  run.dt = 0.4 * h / (run.model.materials[0]->SpeedOfSound() * (1 + kSpeed));
  const int steps = static_cast<int>(24.5 / (velocity[0] * run.dt));
  *f = {};
  int samples = 0;
  for (int step = 0; step < steps && !run.Failed(); ++step) {
    PetscCall(run.Advance());
    if (amplitude == 0)
      PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
        for (int k = a.stress_components * p; k < a.stress_components * (p + 1); ++k)
          if (!(std::abs(a.stress[k]) <= f->stress * kMaterial.youngs_modulus))
            f->stress = std::abs(a.stress[k]) / kMaterial.youngs_modulus;
      }));
    else if (step > 0.9 * steps) {
      PetscCall(run.hierarchy.ReduceBudgets(&budgets));
      f->energy += budgets.kinetic_energy + budgets.strain_energy;
      f->vibration += Vibration(budgets) / Vibration(first);
      ++samples;
    }
  }
  PetscCall(run.hierarchy.ReduceBudgets(&budgets));
  std::set<std::int64_t> ids;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int l) {
    ids.insert(a.id[p]);
    f->arrived += (l == 0 && a.position[a.dim * p] > (levels.boxes.empty() ? 23 : levels.boxes[0].upper[0])) / budgets.points;
  }));
  const int children = levels.ratio * levels.ratio * (space ? levels.ratio : 1);
  f->energy /= std::max(samples, 1), f->vibration /= std::max(samples, 1);
  f->mass = std::abs(budgets.mass / first.mass - 1);
  f->split = budgets.points_split, f->left = budgets.points_left, f->merged = budgets.points_merged;
  f->transfer_error = budgets.transfer_mass_error / first.mass + budgets.transfer_momentum_error / (first.mass * Norm(velocity));
  f->numbers = static_cast<double>(ids.size()) == budgets.points && !run.Failed() &&
               budgets.points == first.points + (children - 1) * (budgets.points_split - budgets.points_merged);
  if (run.Failed()) f->energy = f->stress = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestFlight(const Case &levels, const Scheme &scheme)
{
  const std::string name = std::string("flight, ") + levels.name + ", " + scheme.name;
  Flight f;
  PetscFunctionBeginUser;
  PetscCall(Fly(levels, scheme, 0, &f));
  ExpectAtMost(name + ": stress, of E", f.stress, 1e-10);
  ExpectAtMost(name + ": error of the mass", f.mass, 1e-14);
  ExpectAtMost(name + ": error of mass and momentum, added up by the transfer", f.transfer_error, 1e-12);
  ExpectTrue(name + ": all points arrive", f.arrived > 1 - 1e-9);
  char detail[80];
  std::snprintf(detail, sizeof detail, "%.0f split, %.0f left, %.0f merged", f.split, f.left, f.merged);
  ExpectTrue(name + ": numbers are unique and as many as the budgets say", f.numbers && f.split > 0 && f.left > 0, detail);
  if (levels.merge) ExpectTrue(name + ": points are merged", f.merged > 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A strained and turned crystal that is too soft to move itself flies through a finer level: every point, split, merged and sent
/// to others, keeps the stress of its law.
PetscErrorCode TestStrainedFlight(bool merge)
{
  LevelsRun run;
  MaterialConstants soft = kMaterial;
  PetscFunctionBeginUser;
  run.model.geometry.kind = GeometryKind::kSpatial;
  soft.crystal.stiffness = StiffnessOf({86.8e-20, 7.0e-20, 11.9e-20, 105.8e-20, 58.2e-20, -18.0e-20}); // quartz
  AddBody(run.model, CreateBoxRegion(kBlock), "anisotropic", soft, {3, 2, 1});
  HierarchySettings settings = NestedLevels(run.model, kSpace, 1, 2, kSpaceBox);
  settings.merge_siblings = merge;
  PetscCall(run.Create(settings));
  const double c = std::cos(0.7), s = std::sin(0.7);
  LawPoint turned{{1.05 * c, -0.95 * s, 0.02, 1.05 * s, 0.95 * c, 0.03, 0.01, 0, 1.02}, {}, {}};
  const double F[9] = {turned.F.xx, turned.F.xy, turned.F.xz, turned.F.yx, turned.F.yy,
                       turned.F.yz, turned.F.zx, turned.F.zy, turned.F.zz};
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) { std::copy_n(F, 9, a.F + 9 * p); }));
  const Sym3 exact = Anisotropic(soft).Stress(turned);
  const double wanted[6] = {exact.xx, exact.yy, exact.zz, exact.xy, exact.yz, exact.xz};
  double error = 0;
  run.dt = 0.1;
  for (int step = 0; step < 75; ++step) {
    PetscCall(run.Advance());
    PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
      for (int k = 0; k < 6; ++k)
        error = Largest({error, std::abs(a.stress[6 * p + k] - wanted[k]) / soft.crystal.stiffness.At(2, 2)});
    }));
  }
  Budgets budgets;
  PetscCall(run.hierarchy.ReduceBudgets(&budgets));
  const std::string name = merge ? "strained crystal in flight, merging: " : "strained crystal in flight: ";
  ExpectAtMost(name + "stress, of C33", error, 1e-11); // 1e-12 seen, as that of velocities at nodes is rounded
  ExpectTrue(name + "points are split" + (merge ? " and merged" : ""),
             budgets.points_split > 0 && (!merge || budgets.points_merged > 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Children get the velocity of their own place: v = V + G (x - V t) in a body that moves into the finer level.
PetscErrorCode TestSplitVelocity(int ratio)
{
  LevelsRun run;
  PetscFunctionBeginUser;
  AddBody(run.model, CreateBoxRegion({{2, 1}, {20, 23}}), "neo_hookean", kMaterial);
  PetscCall(run.Create(NestedLevels(run.model, {{0, 0}, {24, 24}}, 1, ratio, {{{11, 0}, {24, 24}}})));
  const double c = run.model.materials[0]->SpeedOfSound(), g = 1e-4 * c;
  const Vec3 V = {0.1 * c, 0};
  const double G[4] = {0.5 * g, -g, g, 0.3 * g};
  const auto exact = [&](Vec3 x) { return V + Multiply(G, x - run.time * V - Vec3{11, 12}); };
  std::set<std::int64_t> known;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const Vec3 v = exact({a.position[2 * p], a.position[2 * p + 1]});
    std::copy(v.begin(), v.end(), a.velocity + 2 * p);
    known.insert(a.id[p]);
  }));
  run.dt = 0.4 / (1.1 * c);
  double error = 0;
  int children = 0;
  for (int step = 0; step < 14; ++step) {
    PetscCall(run.Advance());
    PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
      const Vec3 x = {a.position[2 * p], a.position[2 * p + 1]};
      if (!known.insert(a.id[p]).second || std::abs(x[1] - 12) > 1.5) return; // near the free sides there are waves
      error = Largest({error, Norm(Vec3{a.velocity[2 * p], a.velocity[2 * p + 1]} - exact(x)) / g});
      ++children;
    }));
  }
  const std::string name = "splitting, ratio " + std::to_string(ratio) + ": ";
  ExpectTrue(name + "there are children", children >= 6 * ratio * ratio);
  ExpectAtMost(name + "velocity of children in a linear field, of its change over a coarse cell", error,
               0.15); // 0.24 without L dx
  PetscFunctionReturn(PETSC_SUCCESS);
}

constexpr double kAmplitude = 0.005;

PetscErrorCode Table(int)
{
  const Case cases[] = {{"two levels", kBox},     {"two levels, merging", kBox, 2, true},
                        {"three levels", kBoxes}, {"three levels, merging", kBoxes, 2, true},
                        {"ratio 3", kBox, 3},     {"ratio 3, merging", kBox, 3, true}};
  PetscFunctionBeginUser;
  std::printf("| scheme | levels | energy after the flight, of one level's, -1 | vibration alone, of the start's | points split "
              "| merged | stress without vibration, of E |\n| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const Scheme &scheme : {kMusl, kDefaultScheme, kUsl}) {
    Flight one, other, still;
    PetscCall(Fly({"one level", {}}, scheme, kAmplitude, &one));
    std::printf("| %s | one level | | %.3f |\n", scheme.name, one.vibration);
    for (const Case &levels : cases) {
      PetscCall(Fly(levels, scheme, kAmplitude, &other));
      PetscCall(Fly(levels, scheme, 0, &still));
      std::printf("| %s | %s | %+.2e | %.3f | %.0f | %.0f | %.1e |\n", scheme.name, levels.name, other.energy / one.energy - 1,
                  other.vibration, other.split, other.merged, still.stress);
      std::fflush(stdout);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsCrossing, TwoLevels)
{
  EXPECT_EQ(TestFlight({"two levels", kBox}, kDefaultScheme), PETSC_SUCCESS);
  EXPECT_EQ(TestFlight({"two levels, merging", kBox, 2, true}, kDefaultScheme), PETSC_SUCCESS);
}

TEST(LevelsCrossing, ThreeLevels)
{
  EXPECT_EQ(TestFlight({"three levels", kBoxes}, kMusl), PETSC_SUCCESS);
  EXPECT_EQ(TestFlight({"three levels, merging", kBoxes, 2, true}, kMusl), PETSC_SUCCESS);
}

TEST(LevelsCrossing, RatioThree) { EXPECT_EQ(TestFlight({"ratio 3", kBox, 3}, kUsl), PETSC_SUCCESS); }

TEST(LevelsCrossing, Space)
{
  EXPECT_EQ(TestFlight({"space", kSpaceBox, 2, false, 3}, kDefaultScheme), PETSC_SUCCESS);
  EXPECT_EQ(TestFlight({"space, merging", kSpaceBox, 2, true, 3}, kDefaultScheme), PETSC_SUCCESS);
}

TEST(LevelsCrossing, StrainedCrystal)
{
  for (bool merge : {false, true}) EXPECT_EQ(TestStrainedFlight(merge), PETSC_SUCCESS);
}

TEST(LevelsCrossing, VelocityOfChildren)
{
  for (int ratio : {2, 3}) EXPECT_EQ(TestSplitVelocity(ratio), PETSC_SUCCESS);
}

TEST(LevelsCrossing, EnergyOfVibration)
{
  Flight one, other;
  ASSERT_EQ(Fly({"one level", {}}, kDefaultScheme, kAmplitude, &one), PETSC_SUCCESS);
  for (bool merge : {false, true}) {
    ASSERT_EQ(Fly({"two levels", kBox, 2, merge}, kDefaultScheme, kAmplitude, &other), PETSC_SUCCESS);
    ExpectAtMost(std::string("vibrating block in flight") + (merge ? ", merging" : "") + ": energy against one level",
                 std::abs(other.energy / one.energy - 1), 1e-3);
  }
}

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv, Table); }
