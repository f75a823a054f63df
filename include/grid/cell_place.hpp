// Places in the cells of a grid, hats about their corners, and columns: lines of nodes along the last axis.
#pragma once

#include "grid/grid_geometry.hpp"

#include <array>
#include <cstdint>

namespace mlgimp
{

/// Where a place lies in the grid.
struct CellPlace {
  Index cell; ///< the first corner of its cell
  Vec3 part;  ///< from 0 to 1 along each axis
};
CellPlace Locate(const GridGeometry &grid, Vec3 x);

/// Corner c of a cell: bit a of c chooses the upper node along axis a.
inline Index Corner(Index cell, int c) { return {cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1)}; }
/// Hats of the grid about the corners of a cell, [2^axes] for the first axes.
std::array<double, 8> Hats(Vec3 part, int axes);

/// A number for a column of the grid, a line of nodes along the last axis, named by its horizontal node.
inline std::int64_t ColumnKey(const GridGeometry &grid, Index column)
{
  return column[0] + grid.padding + std::int64_t(grid.Nodes(0)) * (column[1] + grid.Padding(1));
}
/// Calls work(key, column, hat) for the columns at the corners of a cell.
template <class Work> void ForEachColumn(const GridGeometry &grid, const CellPlace &place, Work work)
{
  const int up = grid.dim - 1;
  const std::array<double, 8> hats = Hats(place.part, up);
  for (int c = 0; c < 1 << up; ++c) {
    Index at = Corner(place.cell, c);
    at[up] = 0;
    work(ColumnKey(grid, at), at, hats[c]);
  }
}

} // namespace mlgimp
