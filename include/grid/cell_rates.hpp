// Strain rates and growth of volume of cells by the velocities of their corners, and smooth strain rates of nodes.
#pragma once

#include "grid/grid.hpp"

namespace mlgimp
{

/// From the new velocities v of the nodes, which must be known on ghosts: the gradient in the middle of each cell,
/// L_ij = sum_corners (+-1)_j v_i/(2^(dim-1) h), in axisymmetry with the mean radial velocity over the radius there. Leaves the
/// growth of volume det(I + dt L) - 1 of cells where materials keep sums at cells; HUGE_VAL where a corner has no more than
/// mass_cutoff. Leaves on nodes, in `rates`, the mean strain rate of the cells around them, by the least mass of their corners:
/// it is that of any linear motion, also at a surface.
void FindCellRates(Grid &grid, bool has_hoop, double mass_cutoff, double dt);

} // namespace mlgimp
