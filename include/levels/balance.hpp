// Which rank owns which nodes: ranges of columns and rows of about equal numbers of points.
#pragma once

#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// Splits the ranks into columns and rows and the nodes among them by points per node column and row; takes the split
/// with the shortest inner borders. False where there are too few nodes for the ranks.
bool MakeLayout(int ranks, const std::vector<double> &columns, const std::vector<double> &rows, GridLayout *layout);

/// The layout that suits the points of a level now; `changed` tells whether it differs from that in use. Collective.
PetscErrorCode ProposeLayout(Level &level, GridLayout *layout, bool *changed);

} // namespace mlgimp
