// Where a level's grid lies: its cells and nodes, whichever ranks hold them.
//
// The grid reaches `padding` nodes beyond its box on every side, so that a point at a side finds all its nodes.
#pragma once

#include "base/index.hpp"
#include "base/tensor.hpp"

#include <cmath>

namespace mlgimp
{

/// Where a grid lies and what bounds it. In two dimensions there is one layer of nodes, without cells, along the third axis.
struct GridGeometry {
  Vec3 lower;     ///< position of node (0, 0, 0) of the box, m
  double spacing; ///< h, m
  Index cells;    ///< of the box
  int padding;    ///< layers of nodes beyond the box, along the axes of its dimension
  int dim = 2;

  /// Box index of the node nearest to x.
  int Nearest(int axis, double x) const { return static_cast<int>(std::floor((x - lower[axis]) / spacing + 0.5)); }
  Index Nearest(Vec3 x) const { return {Nearest(0, x[0]), Nearest(1, x[1]), dim == 3 ? Nearest(2, x[2]) : 0}; }
  double Coordinate(int axis, int index) const { return lower[axis] + index * spacing; }
  int Padding(int axis) const { return axis < dim ? padding : 0; }
  int Nodes(int axis) const { return axis < dim ? cells[axis] + 1 + 2 * padding : 1; }
  /// All nodes, by their box indices.
  IndexBox NodeBox() const
  {
    const Index first{-Padding(0), -Padding(1), -Padding(2)};
    return {first, first + Index{Nodes(0), Nodes(1), Nodes(2)}};
  }
};

} // namespace mlgimp
