// The undeformed shapes of bodies, and how a shape is cut into material points.
#pragma once

#include "base/tensor.hpp"
#include "pointwise/point_fields.hpp"

#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// An axis-aligned box.
struct Box {
  Vec2 lower{}, upper{};
  /// Place of a side along its axis.
  double At(Side side) const { return SignOf(side) < 0 ? lower[AxisOf(side)] : upper[AxisOf(side)]; }
  /// Half-open, so that boxes side by side share no point.
  bool Contains(Vec2 x) const { return x[0] >= lower[0] && x[0] < upper[0] && x[1] >= lower[1] && x[1] < upper[1]; }
};

/// The shape of a body before it deforms.
class Region
{
public:
  virtual ~Region() = default;
  virtual bool Contains(Vec2 x) const = 0;
  virtual Box Bounds() const = 0;
};

std::unique_ptr<Region> CreateBoxRegion(const Box &box);
std::unique_ptr<Region> CreateDiskRegion(Vec2 center, double radius);
/// Vertices in order, either way round; may be concave.
std::unique_ptr<Region> CreatePolygonRegion(std::vector<Vec2> vertices);

/// A piece of a body that one material point stands for.
struct Tile {
  Vec2 center{}, half_size{};
};

/// Cuts the bounding box of a region along the cells of a grid and each piece into equal tiles, about
/// `per_cell` x `per_cell` in a whole cell, so that a box is filled exactly wherever its sides lie.
class Tiling
{
public:
  Tiling(const Box &bounds, Vec2 origin, double cell_size, int per_cell)
      : bounds_(bounds), origin_(origin), cell_size_(cell_size), per_cell_(per_cell)
  {
  }
  /// Tiles in the cell with this index; empty where the cell does not meet the box.
  std::vector<Tile> InCell(int i, int j) const;
  /// The tile that contains x; false outside the box.
  bool At(Vec2 x, Tile &tile) const;

private:
  struct Cut {
    double start = 0, width = 0; ///< the part of the cell inside the box, and the width of its tiles
    int count = 0;
  };
  Cut CutAxis(int axis, int cell) const;

  Box bounds_;
  Vec2 origin_;
  double cell_size_;
  int per_cell_;
};

} // namespace mlgimp
