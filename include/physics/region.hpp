// The undeformed shapes of bodies, and how a shape is cut into material points.
#pragma once

#include "base/index.hpp"
#include "base/tensor.hpp"
#include "physics/geometry.hpp"
#include "physics/point_fields.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// An axis-aligned box; in two dimensions without extent along the third axis.
struct Box {
  Vec3 lower{}, upper{};
  /// Place of a side along its axis.
  double At(Side side) const { return SignOf(side) < 0 ? lower[AxisOf(side)] : upper[AxisOf(side)]; }
  /// Half-open, so that boxes side by side share no point.
  bool Contains(Vec3 x) const
  {
    const bool inside_third = upper[2] == lower[2] || (x[2] >= lower[2] && x[2] < upper[2]);
    return x[0] >= lower[0] && x[0] < upper[0] && x[1] >= lower[1] && x[1] < upper[1] && inside_third;
  }
};

/// The whole space.
inline constexpr Box kEverywhere{{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL, HUGE_VAL}};

/// The shape of a body before it deforms.
class Region
{
public:
  virtual ~Region() = default;
  /// tolerance: places less than this far outside count as well, m; where it is negative, places near the outline do not.
  virtual bool Contains(Vec3 x, double tolerance = 0) const = 0;
  virtual Box Bounds() const = 0;
  virtual bool IsBox() const { return false; }
  /// How far a place within the bounds is outside, m; negative inside.
  virtual double Distance(Vec3 x) const = 0;
  /// The place of the outline for one near it, a corner of a tile's outer face across an axis. at_edge: whether outer faces
  /// across other axes end there too.
  virtual Vec3 OnOutline(Vec3 x, int axis, bool at_edge) const = 0;
  /// Sharp vertices of the outline between two of its places, from the first on. Of the plane.
  virtual std::vector<Vec3> Between(Vec3 /*first*/, Vec3 /*last*/) const { return {}; }
};

std::unique_ptr<Region> CreateBoxRegion(const Box &box);
/// A disk in two dimensions; in axisymmetry the half at x > 0 of one whose center is on the axis.
std::unique_ptr<Region> CreateBallRegion(GeometryKind geometry, Vec3 center, double radius);
/// Of space, with its axis along z.
std::unique_ptr<Region> CreateCylinderRegion(Vec3 bottom_center, double radius, double height);
/// The part of a region in a box.
std::unique_ptr<Region> CreatePartOf(std::unique_ptr<Region> whole, const Box &box);
/// Of the plane. Vertices in order, either way round; may be concave.
std::unique_ptr<Region> CreatePolygonRegion(std::vector<Vec3> vertices);

/// A piece of a body that one material point stands for.
struct Tile {
  Vec3 center{}, half_size{};
};

/// What of a tile lies in a region: its share of the tile's volume, and the sums of places from an origin and of their squares
/// over it, each place by its own share.
struct PartOfTile {
  double share = 0;
  Vec3 sum{}, squares{};
  void Add(const PartOfTile &other, double times)
  {
    share += times * other.share;
    sum = sum + times * other.sum, squares = squares + times * other.squares;
  }
};
PartOfTile WholeOf(const Tile &tile, Vec3 origin, int dim);
PartOfTile PartInside(const Region &region, const Tile &tile, Vec3 origin, int dim);
/// A tile of the part's volume with its centre and the proportions of its second moments; `tile` is whole, its centre the origin.
Tile TileOf(const PartOfTile &part, const Tile &tile, int dim);

/// The edge of the cells of the level that a place belongs to, m.
using CellSizeAt = std::function<double(Vec3)>;

/// What is the same but for rounding, of the length in question.
inline constexpr double kRounding = 1e-6; // rounding
/// A piece of a box at a cell line that is thinner than this part of a cell belongs to the cell on the other side: alone with
/// the nodes beyond, its points would be unstable (docs/decisions.md). At borders of levels it is at most one cell of
/// the finer one.
inline constexpr double kSliver = 0.25 + kRounding;
inline constexpr double kThinnestPoint = 0.1 + kRounding; ///< part of a whole point; of other shapes what is thinner is a sliver

/// Cuts the bounding box of a region along the cells of a grid and each piece into equal tiles, about
/// `per_cell` along each axis of a whole cell, so that a box is filled exactly wherever its sides lie. How many tiles there
/// are and where does not depend on rounding.
class Tiling
{
public:
  /// is_box: the region is its bounding box. cell_size_at: of all levels, empty for one: where a body's side lies in the first
  /// cell beyond a border of levels, the cells there decide if that is a sliver.
  Tiling(const Box &bounds, bool is_box, Vec3 origin, double cell_size, int per_cell, CellSizeAt cell_size_at = {})
      : bounds_(bounds), sliver_(is_box ? kSliver : kThinnestPoint / per_cell), dim_(bounds.upper[2] > bounds.lower[2] ? 3 : 2),
        origin_(origin), cell_size_(cell_size), per_cell_(per_cell), cell_size_at_(std::move(cell_size_at))
  {
  }
  Vec3 CellCenter(Index at) const { return origin_ + cell_size_ * Vec3{at[0] + 0.5, at[1] + 0.5, dim_ == 3 ? at[2] + 0.5 : 0}; }
  /// Most tiles of a cell along an axis, with slivers of a neighbouring level's cells on both sides.
  static int MostTiles(int per_cell, int ratio);
  /// Tiles in the cell with this index; empty where the cell does not meet the box.
  std::vector<Tile> InCell(Index at) const;
  /// The tile that contains x; false outside the box.
  bool At(Vec3 x, Tile &tile) const;

private:
  struct Cut {
    double start = 0, width = 0; ///< the part of the cell inside the box, and the width of its tiles
    int count = 0;
  };
  double CellSizeThere(Vec3 x) const { return cell_size_at_ ? cell_size_at_(x) : cell_size_; }
  double Line(int axis, int line) const { return origin_[axis] + line * cell_size_; }
  bool IsCut(int axis, int line, Vec3 cell_center) const;
  /// cell_center: of the cell, or of one beside it along the axis.
  Cut CutAxis(int axis, int cell, Vec3 cell_center) const;

  Box bounds_;
  double sliver_; ///< cells
  int dim_;
  Vec3 origin_;
  double cell_size_;
  int per_cell_;
  CellSizeAt cell_size_at_;
};

/// Height of a body under or above x along an axis; false where there is none.
bool SurfaceAbove(const Region &region, Vec3 x, int up, double *height);

} // namespace mlgimp
