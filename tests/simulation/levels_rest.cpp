// A block under uniform stress between rollers stays at rest, also where points of several levels meet; in the plane and in
// space.
#include "simulation/setup.hpp"

#include <cmath>

using namespace mlgimp;

namespace
{

/// The largest speed after 200 steps, in space 60, relative to the wave speed times the strain. stretch: in space with a third
/// component.
PetscErrorCode Deactivate(const std::vector<Box> &boxes, int ratio, const Scheme &scheme, const Vec3 stretch, double *speed)
{
  const bool space = stretch[2] > 0;
  const int dim = space ? 3 : 2, cells = space ? 8 : 12;
  const Box whole = {{}, {1, 1, space ? 1.0 : 0}};
  LevelsRun run;
  PetscFunctionBeginUser;
  if (space) run.model.geometry.kind = GeometryKind::kSpatial;
  run.model.sides.fill(BoundaryKind::kSymmetry);
  run.SetScheme(scheme);
  AddBody(run.model, CreateBoxRegion(whole), "neo_hookean", {1e7, 0.3, 1000, NAN, NAN});
  const Material &material = *run.model.materials[0];
  PetscCall(run.Create(NestedLevels(run.model, whole, 1.0 / cells, ratio, boxes)));
  const double J = stretch[0] * stretch[1] * (space ? stretch[2] : 1), volumetric = material.Elastic().lambda * std::log(J) / J;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    // The points' rectangles tile the square as they are: they were smaller before.
    a.mass[p] /= J;
    if (!space) a.stress[4 * p + 2] = volumetric;
    for (int d = 0; d < dim; ++d) {
      a.half_size[dim * p + d] /= stretch[d];
      a.F[dim * dim * p + (dim + 1) * d] = stretch[d];
      a.stress[a.stress_components * p + d] = material.Elastic().mu / J * (stretch[d] * stretch[d] - 1) + volumetric;
    }
  }));
  run.dt = 0.4 / cells / material.SpeedOfSound();
  for (int step = 0; step < (space ? 60 : 200); ++step) PetscCall(run.Advance());
  *speed = run.Failed() ? NAN : 0;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const double v = Norm(a.Velocity(p)) / (material.SpeedOfSound() * std::abs(stretch[0] - 1));
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
      PetscCall(Deactivate({half}, ratio, scheme, {0.99, 1.01}, &speed));
      ExpectAtMost(name + ", border across: v/(c strain)", speed, 1e-12);
      PetscCall(Deactivate({inside}, ratio, scheme, {1.01, 0.98}, &speed));
      ExpectAtMost(name + ", box inside: v/(c strain)", speed, 1e-12);
      if (ratio > 2) continue;
      PetscCall(Deactivate(nested, ratio, scheme, {0.99, 1.005}, &speed));
      ExpectAtMost(name + ", three levels: v/(c strain)", speed, 1e-12);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsRest, UnderStress) { EXPECT_EQ(TestRest(), PETSC_SUCCESS); }

TEST(LevelsRest, UnderStressInSpace)
{
  const std::vector<Box> half = {{{0.5, 0, 0}, {1, 1, 1}}}, inside = {{{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}}},
                         nested = {{{0.125, 0, 0}, {1, 1, 1}}, {{0.75, 0, 0.625}, {1, 1, 1}}};
  double speed;
  ASSERT_EQ(Deactivate(half, 2, kDefaultScheme, {0.99, 1.01, 1.005}, &speed), PETSC_SUCCESS);
  ExpectAtMost("at rest under stress in space, border across: v/(c strain)", speed, 1e-12);
  ASSERT_EQ(Deactivate(inside, 2, kUsl, {1.01, 0.98, 0.99}, &speed), PETSC_SUCCESS);
  ExpectAtMost("at rest under stress in space, box inside: v/(c strain)", speed, 1e-12);
  ASSERT_EQ(Deactivate(nested, 2, kDefaultScheme, {0.99, 1.005, 1.01}, &speed), PETSC_SUCCESS);
  ExpectAtMost("at rest under stress in space, three levels: v/(c strain)", speed, 1e-12);
}

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv); }
