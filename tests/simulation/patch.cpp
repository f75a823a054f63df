// Patch test: points of several sizes that tile a stretched body under uniform stress leave no force on the nodes within
// it, wherever the grid lies; with the matching pressures on its sides, on no node at all.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <cmath>

using namespace mlgimp;

namespace
{

constexpr double kH = 0.25, kThickness = 0.7, kWidth = 5, kHeight = 3; // m
constexpr double kStress[4] = {-3e5, 2e5, 4e4, 1e5};                   // Pa: xx, yy, zz, xy
const double kScale = 3e5 * kH * kThickness;                           // |sigma| h t, N

RandomNumbers Random(71);

/// Two boxes side by side, kWidth x kHeight together, each with its own points per cell.
struct Patch {
  int left, right;      ///< points per cell and direction
  double F[4];          ///< xx, xy, yx, yy
  double stress[4];     ///< Pa
  bool pressed = false; ///< pressures on the outer sides balance the stress
};

struct Forces {
  double inside = 0; ///< largest nodal force where no node at the rim hangs on the node, of |sigma| h t
  double all = 0;    ///< largest nodal force
  int nodes = 0;     ///< that lie inside
};

/// True where all within three cells of a node was in the body before it was mapped by F and shifted: light nodes at the rim give
/// their forces to nodes within two.
bool Inside(const Patch &patch, Vec3 node, Vec3 shift)
{
  const double *F = patch.F, J = F[0] * F[3] - F[1] * F[2];
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 x = node + 3 * kH * Vec3{corner % 2 ? 1.0 : -1.0, corner / 2 ? 1.0 : -1.0} - shift;
    const Vec3 X = {(F[3] * x[0] - F[1] * x[1]) / J, (F[0] * x[1] - F[2] * x[0]) / J};
    if (X[0] < 0 || X[0] > kWidth || X[1] < 0 || X[1] > kHeight) return false;
  }
  return true;
}

void AddPressures(Model &model, const Patch &patch)
{
  const auto add = [&](int body, Side side) {
    model.loads.push_back({body, side, {{-HUGE_VAL, HUGE_VAL}}, PiecewiseLinear({0}, {-patch.stress[AxisOf(side)]})});
  };
  add(0, kXLower);
  add(1, kXUpper);
  for (int body = 0; body < 2; ++body)
    for (Side side : {kYLower, kYUpper}) add(body, side);
}

/// Nodal forces at the start of a step of the patch, mapped by F and shifted against the grid by a random distance.
PetscErrorCode NodalForces(const Patch &patch, Forces *forces)
{
  Model model;
  Hierarchy hierarchy;
  LogEvents events;
  PetscFunctionBeginUser;
  const double middle = Random(2, 3); // the bodies meet within a cell
  const MaterialConstants constants = {1e7, 0.3, 1000, NAN, NAN};
  model.geometry.thickness = kThickness;
  AddBody(model, CreateBoxRegion({{0, 0}, {middle, kHeight}}), "neo_hookean", constants, {0, 0}, patch.left);
  AddBody(model, CreateBoxRegion({{middle, 0}, {kWidth, kHeight}}), "neo_hookean", constants, {0, 0}, patch.right);
  if (patch.pressed) AddPressures(model, patch);
  // The body starts where the grid's cells cut it unevenly, so that its tiles have many sizes.
  const Box domain = {{-8 * kH - Random(0, kH), -8 * kH - Random(0, kH)}, {}};
  const Box grid = {domain.lower, domain.lower + Vec3{40 * kH, 32 * kH}};
  PetscCall(RegisterLogEvents(&events));
  PetscCall(hierarchy.Create(PETSC_COMM_WORLD, model, OneLevel(model, grid, kH), events, true));
  const PointArrays a = hierarchy.At(0).PointStore().Arrays();
  const Vec3 shift = {Random(0, 3 * kH), Random(0, 3 * kH)};
  for (int p = 0; p < a.count; ++p) {
    const Vec3 x = Multiply(patch.F, {a.position[2 * p], a.position[2 * p + 1]}) + shift;
    std::copy_n(x.begin(), 2, a.position + 2 * p);
    std::copy(patch.F, patch.F + 4, a.F + 4 * p);
    std::copy(patch.stress, patch.stress + 4, a.stress + 4 * p);
  }
  PetscCall(hierarchy.Advance({0, 1e-15}));
  const Grid &nodes = hierarchy.At(0).Mesh();
  *forces = {};
  ForEach(nodes.Owned(), [&](Index node) {
    const NodeSums &sums = nodes.Sums()[nodes.Place(node)];
    const double force = std::hypot(sums.force[0], sums.force[1]) / kScale;
    forces->all = Largest({forces->all, force});
    if (!Inside(patch, {nodes.Geometry().Coordinate(0, node[0]), nodes.Geometry().Coordinate(1, node[1])}, shift)) return;
    forces->inside = Largest({forces->inside, force});
    ++forces->nodes;
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The largest forces over several places of the grid.
PetscErrorCode Worst(const Patch &patch, Forces *worst)
{
  PetscFunctionBeginUser;
  *worst = {0, 0, 1 << 20};
  for (int n = 0; n < 10; ++n) {
    Forces forces;
    PetscCall(NodalForces(patch, &forces));
    worst->inside = Largest({worst->inside, forces.inside});
    worst->all = Largest({worst->all, forces.all});
    worst->nodes = std::min(worst->nodes, forces.nodes);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string Sizes(const Patch &patch)
{
  return std::to_string(patch.left) + " and " + std::to_string(patch.right) + " points a cell";
}

TEST(Patch, Stretched)
{
  Forces forces;
  const double *s = kStress;
  // A point may not become wider than a cell: one point a cell can only be pressed together.
  const Patch patches[] = {
      {2, 4, {1.25, 0, 0, 0.8}, {s[0], s[1], s[2], s[3]}},
      {4, 2, {0.7, 0, 0, 1.3}, {s[0], s[1], s[2], s[3]}},
      {1, 2, {0.9, 0, 0, 0.75}, {s[0], s[1], s[2], s[3]}},
      {3, 3, {1, 0, 0, 1}, {s[0], s[1], s[2], s[3]}},
  };
  for (Patch patch : patches) {
    ASSERT_EQ(Worst(patch, &forces), PETSC_SUCCESS);
    ExpectAtMost("patch, " + Sizes(patch) + ": nodal force inside, of |sigma| h t", forces.inside, 1e-12);
    ExpectTrue("patch, " + Sizes(patch) + ": there are nodes inside, and forces at its rim",
               forces.nodes >= 30 && forces.all > 0.5);
    patch.pressed = true;
    patch.stress[3] = 0; // a pressure has no shear
    ASSERT_EQ(Worst(patch, &forces), PETSC_SUCCESS);
    ExpectAtMost("patch under pressure, " + Sizes(patch) + ": nodal force anywhere, of p h t", forces.all, 1e-10);
  }
}

TEST(Patch, ShearedAndTurned)
{
  Forces forces;
  const double *s = kStress, angle = 20 * M_PI / 180, c = std::cos(angle), si = std::sin(angle);
  const Patch sheared = {2, 2, {1, 0.1, 0, 1}, {s[0], s[1], s[2], s[3]}},
              turned = {2, 2, {c, -si, si, c}, {s[0], s[1], s[2], s[3]}};
  ASSERT_EQ(Worst(sheared, &forces), PETSC_SUCCESS);
  ExpectAtMost("patch, shear 0.1: nodal force inside, of |sigma| h t", forces.inside, 0.01);
  ASSERT_EQ(Worst(turned, &forces), PETSC_SUCCESS);
  ExpectAtMost("patch, rotation by 20 degrees (a limit of cpGIMP): nodal force inside, of |sigma| h t", forces.inside, 0.05);
}

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv); }
