// Which rank owns which nodes: ranges of columns and rows of about equal numbers of points.
#pragma once

#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// Splits the nodes of a level among `ranks` ranks, or fewer: each rank gets at least `least_points` points and
/// kHaloWidth nodes along each axis. Columns and rows of blocks follow the points per node column and row; the split
/// with the shortest inner borders is taken. The first ranks get the blocks.
void MakeLayout(int ranks, double least_points, const std::vector<double> &columns, const std::vector<double> &rows,
                GridLayout *layout);

/// The layout that suits the points of a level now, on the same ranks; `changed` tells whether it differs from that in
/// use. Collective on `world`.
PetscErrorCode ProposeLayout(MPI_Comm world, Level &level, GridLayout *layout, bool *changed);

} // namespace mlgimp
