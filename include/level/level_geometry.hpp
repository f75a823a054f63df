// Where a level lies in the domain.
#pragma once

#include "grid/nodes.hpp"
#include "level/model.hpp"

namespace mlgimp
{

/// Where a level lies.
struct LevelGeometry {
  GridGeometry grid;
  BoundaryConditions sides;
  std::array<bool, kSides> border{}; ///< sides that lie within the next coarser level, not on the domain's side
  /// Nearest nodes that points of this level may have: beyond a border points may stray until they move.
  IndexBox PointNodes() const
  {
    IndexBox nodes{{}, {1, 1, 1}};
    for (int axis = 0; axis < grid.dim; ++axis) {
      nodes.lower[axis] = border[2 * axis] ? 1 - grid.padding : 0;
      nodes.upper[axis] = grid.cells[axis] + (border[2 * axis + 1] ? grid.padding : 1);
    }
    return nodes;
  }
};

/// Places the domain's sides on a level's grid; the level is free at its borders.
void PlaceSides(const Model &model, LevelGeometry *level);

} // namespace mlgimp
