// Patches of the surface lie on the rank that owns the node nearest to them, also after nodes have got other owners.
#include "physics/tips/profiles.hpp"
#include "simulation/setup.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

/// Patches of all ranks, and those of them that lie on a rank which does not own their node.
PetscErrorCode CountPatches(Level &level, int counts[2])
{
  const Grid &grid = level.Mesh();
  PetscFunctionBeginUser;
  counts[0] = counts[1] = 0;
  for (const SurfacePatch &patch : level.Contact().Patches().Patches()) {
    ++counts[0];
    counts[1] += grid.Nodes().OwnerOf(grid.Geometry().Nearest(patch.Center(2))) != RankIn(PETSC_COMM_WORLD);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT, MPI_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

TEST(PatchesOnRanks, FollowTheOwnersOfNodes)
{
  LevelsRun run;
  int before[2], after[2];
  AddBody(run.model, CreateBoxRegion({{2, 0}, {30, 8}}), "neo_hookean", {1e7, 0.3, 1000, NAN, NAN});
  run.model.indenter = Indenter{CreateSphere(run.model.geometry.kind, 2), {PiecewiseLinear{{0}, {1}}}, {16, 12}, 8};
  HierarchySettings settings = OneLevel(run.model, {{0, 0}, {32, 16}}, 1);
  settings.points_per_rank = 1;
  ASSERT_EQ(run.Create(settings), PETSC_SUCCESS);
  run.dt = 1e-3;
  Level &level = run.hierarchy.At(0);
  level.Stores().BoundDrift(0, run.dt); // so that patches are not looked at for their motion
  ASSERT_EQ(run.Advance(), PETSC_SUCCESS);
  ASSERT_EQ(CountPatches(level, before), PETSC_SUCCESS);
  EXPECT_GE(before[0], 28) << "one for each cell of the upper side";
  EXPECT_EQ(before[1], 0);
  GridLayout layout = level.Mesh().Nodes().Layout();
  EXPECT_EQ(layout.Blocks(), RanksOf(PETSC_COMM_WORLD));
  std::reverse(layout.ranks.begin(), layout.ranks.end());
  ASSERT_EQ(level.Repartition(layout), PETSC_SUCCESS);
  ASSERT_EQ(run.hierarchy.Connected().Reconnect(true), PETSC_SUCCESS);
  ASSERT_EQ(run.Advance(), PETSC_SUCCESS);
  ASSERT_EQ(CountPatches(level, after), PETSC_SUCCESS);
  EXPECT_EQ(after[0], before[0]);
  EXPECT_EQ(after[1], 0);
}
