// What is done to the velocities of nodes.
#include "grid/nodes.hpp"
#include "grid/light_nodes.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

using namespace mlgimp;

namespace
{

constexpr double kFull = 2; // kg

RandomNumbers Random(20240607);

/// A grid of 10 x 10 (x 10) cells whose nodes have random masses up to a height, a layer of light ones there and nothing above,
/// on all ranks of a communicator in layers of blocks.
struct LightSurface {
  Grid grid;
  BoundaryConditions sides;
  NodalSettings settings;
  LightNodes light;
  int top;

  PetscErrorCode Create(MPI_Comm comm, int dim, bool hoop = false)
  {
    const int ranks = RanksOf(comm);
    const GridGeometry shape = {{0, 0, 0}, 0.5, {10, 10, dim == 3 ? 10 : 1}, 1, dim};
    GridLayout layout;
    PetscFunctionBeginUser;
    top = dim == 3 ? 6 : 5;
    for (int axis = 0; axis < 3; ++axis) layout.widths[axis] = {shape.Nodes(axis)};
    layout.widths[0].clear();
    for (int rank = 0; rank < ranks; ++rank) {
      layout.widths[0].push_back(shape.Nodes(0) * (rank + 1) / ranks - shape.Nodes(0) * rank / ranks);
      layout.ranks.push_back(rank);
    }
    sides.kind[0] = BoundaryKind::kSymmetry;
    settings.full_mass = kFull, settings.mass_cutoff = kEmptyNode * kFull;
    PetscCall(grid.Create(comm, shape, layout));
    light.Create(grid, sides, settings, hoop, std::vector<double>(grid.Ghosted().Count(), 1.0));
    ForEach(grid.Ghosted(), [&](Index node) {
      const int up = node[dim - 1];
      const double wave = 0.5 + 0.5 * std::sin(node[0] + 3.0 * node[1] + 5.0 * node[2]);
      grid.Sums()[grid.Place(node)].mass = kFull * (up > top ? 0 : up == top ? 0.04 * wave : 0.5 + 0.5 * wave);
    });
    light.Find(grid, {});
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /// A linear field of two components, or a wavy one.
  std::vector<double> Field(bool linear) const
  {
    std::vector<double> field(2 * grid.Ghosted().Count());
    ForEach(grid.Ghosted(), [&](Index n) {
      double *const at = &field[2 * grid.Place(n)];
      at[0] = linear ? 3 + n[0] - 2 * n[1] + 0.5 * n[2] : std::sin(7 * n[0] + 3 * n[1] + n[2]);
      at[1] = linear ? -1 : std::cos(n[0] * n[1] - n[2]);
    });
    return field;
  }
  double Product(const std::vector<double> &a, const std::vector<double> &b) const
  {
    double sum = 0;
    ForEach(grid.Owned(), [&](Index n) {
      for (int c = 0; c < 2; ++c) sum += a[2 * grid.Place(n) + c] * b[2 * grid.Place(n) + c];
    });
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, grid.Nodes().Comm());
    return sum;
  }
};

/// What is linear stays so, also along the side of symmetry, where light nodes hang on others there.
TEST(LightNodes, KeepLinearMotions)
{
  for (int dim : {2, 3}) {
    LightSurface body;
    ASSERT_EQ(body.Create(PETSC_COMM_SELF, dim), PETSC_SUCCESS);
    const std::vector<double> linear = body.Field(true);
    std::vector<double> field = linear;
    int light = 0;
    ForEach(body.grid.Owned(), [&](Index node) {
      const std::ptrdiff_t place = body.grid.Place(node);
      ASSERT_TRUE(node[0] <= 0 || node[0] >= 10 || body.light.IsLight(place) == (node[dim - 1] == body.top));
      if (body.light.IsLight(place)) ++light, field[2 * place] = 1e3 * Random(-1, 1);
    });
    EXPECT_GE(light, 10);
    std::vector<double> as_was = field;
    ASSERT_EQ(body.light.Prolong(body.grid.Halo(), field.data(), 2), PETSC_SUCCESS);
    ForEach(body.grid.Owned(), [&](Index node) {
      const std::ptrdiff_t place = body.grid.Place(node);
      double own = 1;
      body.light.ForEachDonor(place, [&](std::ptrdiff_t on, double weight) { own = on == place ? weight : own; });
      const double expected = own * as_was[2 * place] + (1 - own) * linear[2 * place];
      const bool at_side = node[0] <= 0 && body.light.IsLight(place); // no neighbours across it
      EXPECT_NEAR(field[2 * place], at_side ? field[2 * place] : expected, 1e-12);
      EXPECT_NEAR(field[2 * place + 1], -1, 1e-12);
    });
  }
}

/// Sums are restricted by the transpose, and none is lost; on ranks as on one, also on ghosts.
TEST(LightNodesOnRanks, RestrictByTheTranspose)
{
  for (int dim : {2, 3}) {
    LightSurface body, alone;
    ASSERT_EQ(body.Create(PETSC_COMM_WORLD, dim), PETSC_SUCCESS);
    ASSERT_EQ(alone.Create(PETSC_COMM_SELF, dim), PETSC_SUCCESS);
    std::vector<double> x = body.Field(false), y = body.Field(true), Px = x, Ry = y, P1 = alone.Field(false),
                        R1 = alone.Field(true), ones(x.size(), 1.0);
    const double sum = body.Product(y, ones);
    ASSERT_EQ(body.light.Prolong(body.grid.Halo(), Px.data(), 2), PETSC_SUCCESS);
    ASSERT_EQ(body.light.Restrict(body.grid.Halo(), Ry.data(), 2), PETSC_SUCCESS);
    ASSERT_EQ(alone.light.Prolong(alone.grid.Halo(), P1.data(), 2), PETSC_SUCCESS);
    ASSERT_EQ(alone.light.Restrict(alone.grid.Halo(), R1.data(), 2), PETSC_SUCCESS);
    EXPECT_NEAR(body.Product(Ry, x), body.Product(y, Px), 1e-10 * std::abs(body.Product(y, Px)) + 1e-9);
    EXPECT_NEAR(body.Product(Ry, ones), sum, 1e-12 * std::abs(sum)) << "mass and momentum are kept";
    ForEach(body.grid.Ghosted(), [&](Index node) {
      for (int c = 0; c < 2; ++c) {
        EXPECT_NEAR(Px[2 * body.grid.Place(node) + c], P1[2 * alone.grid.Place(node) + c], 1e-12);
        EXPECT_NEAR(Ry[2 * body.grid.Place(node) + c], R1[2 * alone.grid.Place(node) + c], 1e-11);
      }
    });
  }
}

/// A node at the axis is not light for its small volume.
TEST(LightNodes, AreLightForTheirRadius)
{
  LightSurface body;
  ASSERT_EQ(body.Create(PETSC_COMM_SELF, 2, true), PETSC_SUCCESS);
  const auto is_light = [&](double mass, Index node) {
    body.grid.Sums()[body.grid.Place(node)].mass = mass;
    body.light.Find(body.grid, {});
    return body.light.IsLight(body.grid.Place(node));
  };
  const double limit = LightNodes::kLight * kFull;
  EXPECT_TRUE(is_light(2.9 * limit, {3, 2, 0}));
  EXPECT_FALSE(is_light(3.1 * limit, {3, 2, 0}));
  EXPECT_TRUE(is_light(0.9 * limit / 6, {0, 2, 0}));
  EXPECT_FALSE(is_light(1.1 * limit / 6, {0, 2, 0}));
}

/// What steps of XPIC leave of a velocity that the projection has nothing of.
double LeftOfNoise(const XpicSchedule &xpic, int steps)
{
  double left = 1;
  for (long step = 0; step < steps; ++step) left *= 1 - xpic.InStep(step);
  return left;
}

TEST(Xpic, OfSeveralStepsTakesWhatItWouldStepByStep)
{
  constexpr int kSteps = 24;
  for (const double fraction : {0.0, 0.001, 0.02, 0.03, 0.05, 0.5})
    for (const double steps : {1.0, 2.0, 25.0})
      EXPECT_NEAR(LeftOfNoise({fraction, steps}, kSteps), std::pow(1 - fraction / steps, kSteps), 1e-13) << fraction;
  for (const auto &[fraction, interval] : {std::pair{0.02, 4}, {0.001, 4}, {0.021, 3}, {0.04, 2}, {0.05, 1}, {1.0, 1}}) {
    const XpicSchedule xpic(fraction, 2);
    for (int step = 0; step < kSteps; ++step)
      EXPECT_EQ(xpic.InStep(step) > 0, step % interval == interval - 1) << fraction << " in step " << step;
  }
}

} // namespace
