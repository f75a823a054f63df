// A block under uniform stress between rollers stays at rest, also where points of several levels meet.
#include "simulation/setup.hpp"

#include <cmath>

using namespace mlgimp;

namespace
{

constexpr int kCells = 12;
const Box kSquare = {{0, 0}, {1, 1}};

/// The largest speed after 200 steps, relative to the wave speed times the strain.
PetscErrorCode Rest(const std::vector<Box> &boxes, int ratio, const Scheme &scheme, const Vec3 stretch, double *speed)
{
  LevelsRun run;
  PetscFunctionBeginUser;
  run.model.sides.fill(BoundaryKind::kSymmetry);
  run.SetScheme(scheme);
  AddBody(run.model, CreateBoxRegion(kSquare), "neo_hookean", {1e7, 0.3, 1000, NAN, NAN});
  const Material &material = *run.model.materials[0];
  PetscCall(run.Create(NestedLevels(run.model, kSquare, 1.0 / kCells, ratio, boxes)));
  const double J = stretch[0] * stretch[1], volumetric = material.Lambda() * std::log(J) / J;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    // The points' rectangles tile the square as they are: they were smaller before.
    a.mass[p] /= J;
    for (int d = 0; d < 2; ++d) {
      a.half_size[2 * p + d] /= stretch[d];
      a.F[4 * p + 3 * d] = stretch[d];
      a.stress[4 * p + d] = material.Mu() / J * (stretch[d] * stretch[d] - 1) + volumetric;
    }
    a.stress[4 * p + 2] = volumetric;
  }));
  run.dt = 0.4 / kCells / material.SpeedOfSound();
  for (int step = 0; step < 200; ++step) PetscCall(run.Advance());
  *speed = run.Failed() ? NAN : 0;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const double v = std::hypot(a.velocity[2 * p], a.velocity[2 * p + 1]) / (material.SpeedOfSound() * std::abs(stretch[0] - 1));
    if (!(v <= *speed)) *speed = v;
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestRest()
{
  const Box half = {{0.5, 0}, {1, 1}}, inside = {{0.25, 0.25}, {0.75, 0.75}};
  const std::vector<Box> nested = {{{0.25, 0}, {1, 1}}, {{8.0 / 12, 0}, {1, 1}}};
  double speed;
  PetscFunctionBeginUser;
  for (const Scheme &scheme : {kDefaultScheme, kUsl})
    for (int ratio : {2, 3}) {
      const std::string name = std::string("at rest under stress, ratio ") + std::to_string(ratio) + ", " + scheme.name;
      PetscCall(Rest({half}, ratio, scheme, {0.99, 1.01}, &speed));
      ExpectAtMost(name + ", border across: v/(c strain)", speed, 1e-12);
      PetscCall(Rest({inside}, ratio, scheme, {1.01, 0.98}, &speed));
      ExpectAtMost(name + ", box inside: v/(c strain)", speed, 1e-12);
      if (ratio > 2) continue;
      PetscCall(Rest(nested, ratio, scheme, {0.99, 1.005}, &speed));
      ExpectAtMost(name + ", three levels: v/(c strain)", speed, 1e-12);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsRest, UnderStress) { EXPECT_EQ(TestRest(), PETSC_SUCCESS); }

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv); }
