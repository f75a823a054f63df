// Smooth strain rates of nodes, from those of the cells around them.
#pragma once

#include "grid/grid.hpp"

namespace mlgimp
{

/// From the new velocities v of the nodes, which must be known on ghosts: the gradient in the middle of each cell that points lie
/// in, L_ij = sum_corners (+-1)_j v_i/(2^(dim-1) h), in axisymmetry with the mean radial velocity over the radius there. Leaves
/// on nodes, in `rates`, the mean strain rate of the cells around them, weighted by the least mass of a corner: in a linear
/// motion it is the same everywhere, also at a surface.
void FindStrainRates(Grid &grid, bool has_hoop);

} // namespace mlgimp
