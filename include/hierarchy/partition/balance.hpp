// Which rank owns which nodes: ranges of columns and rows of about equal numbers of points.
#pragma once

#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// Divides `count` nodes into `parts` ranges of about equal total weight, each at least `minimum` nodes wide.
/// weights [count]: points per layer of nodes. Needs count >= parts * minimum.
std::vector<PetscInt> DivideByWeight(const std::vector<double> &weights, int parts, int minimum);

/// Splits the nodes of a level among `ranks` ranks, or fewer: each rank gets at least `least_points` points on average
/// and kHaloWidth nodes along each axis. Of all splits by planes normal to the axes, which follow the points per layer of nodes,
/// the one with the least work on the busiest rank, points and halo nodes, is taken. The first ranks get the blocks. nodes:
/// nearest to this rank's points, counted from the first of the padding. Collective on `world`.
PetscErrorCode FirstLayout(MPI_Comm world, int ranks, double least_points, const std::vector<Index> &nodes,
                           const GridGeometry &grid, GridLayout *layout);

/// True where a level with so many points should be on another number of ranks: where they have less than half or more
/// than twice `least_points` each, and there are others to take.
bool NeedsOtherRanks(double points, int blocks, int ranks, double least_points);

/// The layout that suits the points of a level now: on the same ranks, or, where NeedsOtherRanks, on as many as suit them,
/// the first ones. `changed`: whether it is better than that in use. Collective on `world`.
PetscErrorCode BetterLayout(MPI_Comm world, Level &level, double least_points, GridLayout *layout, bool *changed);

/// The first layout for points of any rank on a grid. Collective on `world`.
PetscErrorCode LayoutFor(MPI_Comm world, Points &points, const GridGeometry &grid, double least_points, GridLayout *layout);

} // namespace mlgimp
