// A body without stress that flies obliquely through the grid: nothing happens to it but the motion.
#include "level/samples.hpp"
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <map>

using namespace mlgimp;

namespace
{

constexpr double kH = 0.5;          // m
constexpr int kCells[2] = {30, 22}; // of the domain
const Vec3 kVelocity = {7.3, 4.1};  // m/s: 0.1 of the wave speed
const MaterialConstants kMaterial = {4e6, 0.3, 1000, 1e4, 1e5};

struct Variant {
  std::string shape, update;
  StressUpdate stress_update;
  ShortWaveViscosity viscosity;
  double xpic;
};

struct State {
  std::map<std::int64_t, Vec3> position;
  int count = 0;
  double mass = 0;
};

PetscErrorCode Take(Hierarchy &hierarchy, State *state)
{
  PetscFunctionBeginUser;
  const PointArrays a = hierarchy.At(0).PointStore().Arrays();
  *state = {};
  state->count = a.count;
  for (int p = 0; p < a.count; ++p) {
    state->position[a.id[p]] = {a.position[2 * p], a.position[2 * p + 1]};
    state->mass += a.mass[p];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What has changed that should not have; all relative.
struct Errors {
  double stress = 0, position = 0, velocity = 0, momentum = 0, mass = 0;
  bool same_points = true;
};

/// Flies over 20 x 11 cells, about 0.03 of a cell a step.
PetscErrorCode Fly(const Variant &variant, const std::string &law, bool disk, Errors *errors)
{
  Model model;
  Hierarchy hierarchy;
  LogEvents events;
  State before, after;
  Budgets point_sums;
  PetscFunctionBeginUser;
  model.shape_function = variant.shape;
  model.stress_update = variant.stress_update;
  model.short_wave = variant.viscosity;
  model.nodal.xpic_fraction = variant.xpic;
  const Vec3 lower = {2.13 * kH, 2.71 * kH}, upper = {6.6 * kH, 7.1 * kH};
  AddBody(model,
          disk ? CreateBallRegion(GeometryKind::kPlaneStrain, 0.5 * (lower + upper), 2.2 * kH) : CreateBoxRegion({lower, upper}),
          law, kMaterial, kVelocity);
  const double dt = 0.4 * kH / model.materials[0]->SpeedOfSound();
  PetscCall(RegisterLogEvents(&events));
  PetscCall(
      hierarchy.Create(PETSC_COMM_WORLD, model, OneLevel(model, {{0, 0}, {kCells[0] * kH, kCells[1] * kH}}, kH), events, true));
  PetscCall(Take(hierarchy, &before));
  const int steps = static_cast<int>(20 * kH / (kVelocity[0] * dt));
  *errors = {};
  for (int step = 0; step < steps; ++step) {
    PetscCall(hierarchy.Advance({step * dt, dt}));
    const PointArrays a = hierarchy.At(0).PointStore().Arrays();
    for (int k = 0; k < 4 * a.count; ++k)
      errors->stress = Largest({errors->stress, std::abs(a.stress[k]) / kMaterial.youngs_modulus});
    for (int p = 0; p < a.count; ++p)
      for (int d = 0; d < 2; ++d)
        errors->velocity = Largest({errors->velocity, std::abs(a.velocity[2 * p + d] / kVelocity[d] - 1)});
  }
  PetscCall(Take(hierarchy, &after));
  SumPoints(hierarchy.At(0), &point_sums);
  errors->same_points = after.count == before.count && after.position.size() == before.position.size() &&
                        static_cast<int>(after.position.size()) == after.count &&
                        hierarchy.At(0).Step().failure.kind == LevelFailure::kNone;
  errors->mass = std::abs(after.mass / before.mass - 1);
  errors->momentum = Norm(point_sums.momentum - before.mass * kVelocity) / (before.mass * Norm(kVelocity));
  for (const auto &[id, X] : before.position) {
    const auto found = after.position.find(id);
    errors->same_points &= found != after.position.end();
    if (found == after.position.end()) continue;
    errors->position = Largest({errors->position, Norm(found->second - X - steps * dt * kVelocity) / Norm(found->second)});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestFlights(const std::string &shape)
{
  const Variant updates[] = {
      {"", "USL", StressUpdate::kUsl, {0, 0}, 0},
      {"", "USF", StressUpdate::kUsf, {0, 0}, 0},
      {"", "MUSL", StressUpdate::kMusl, {0, 0}, 0},
      {"", "MUSL, short-wave viscosity", StressUpdate::kMusl, {0.001, 8}, 0},
      {"", "MUSL, XPIC(2)", StressUpdate::kMusl, {0, 0}, 0.1},
  };
  PetscFunctionBeginUser;
  for (Variant variant : updates)
    for (bool disk : {false, true}) {
      Errors e;
      variant.shape = shape;
      PetscCall(Fly(variant, disk ? "hypoelastic" : "neo_hookean", disk, &e));
      const std::string name = shape + ", " + variant.update + (disk ? ", disk" : ", box");
      // A point that has just reached a node with the linear hat divides round-off by its distance from the last one:
      // with USL that feeds itself, the reason why MUSL was invented. Only the budgets are exact there.
      if (shape != "linear" || variant.stress_update != StressUpdate::kUsl) {
        ExpectAtMost(name + ": stress, of E", e.stress, 1e-12);
        ExpectAtMost(name + ": place after 20 cells, relative", e.position, 1e-12);
        ExpectAtMost(name + ": velocity of points, relative", e.velocity, 1e-12);
      }
      ExpectAtMost(name + ": momentum and mass, relative", e.momentum + e.mass, 1e-13);
      ExpectTrue(name + ": no point lost or doubled", e.same_points);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

class Translation : public testing::TestWithParam<std::string>
{
};

TEST_P(Translation, ChangesNothingElse) { EXPECT_EQ(TestFlights(GetParam()), PETSC_SUCCESS); }

INSTANTIATE_TEST_SUITE_P(Shapes, Translation, testing::ValuesIn(ShapeFunctions()), [](const auto &shape) { return shape.param; });

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv); }
