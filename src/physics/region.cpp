// Boxes, balls, cylinders and polygons, and their tiling.
#include "physics/region.hpp"

#include <algorithm>
#include <cfloat>

namespace mlgimp
{

namespace
{

/// The place at a distance from a centre on the way to another one.
Vec3 AtRadius(Vec3 x, Vec3 center, double radius)
{
  const double distance = Norm(x - center);
  return distance > 0 ? center + (radius / distance) * (x - center) : x;
}

class BoxRegion : public Region
{
public:
  explicit BoxRegion(const Box &box) : box_(box) {}
  bool Contains(Vec3 x, double tolerance) const override
  {
    const Vec3 margin = {tolerance, tolerance, box_.upper[2] > box_.lower[2] ? tolerance : 0};
    return Box{box_.lower - margin, box_.upper + margin}.Contains(x);
  }
  Box Bounds() const override { return box_; }
  bool IsBox() const override { return true; }
  double Distance(Vec3 /*x*/) const override { return -HUGE_VAL; }
  Vec3 OnOutline(Vec3 x, int, bool) const override { return x; } // tiles fill it

private:
  Box box_;
};

class BallRegion : public Region
{
public:
  BallRegion(GeometryKind geometry, Vec3 center, double radius) : bounds_{center, center}, center_(center), radius_(radius)
  {
    for (int axis = 0; axis <= UpAxis(geometry); ++axis) bounds_.lower[axis] -= radius, bounds_.upper[axis] += radius;
    if (geometry == GeometryKind::kAxisymmetric && center[0] == 0) bounds_.lower[0] = 0;
  }
  bool Contains(Vec3 x, double tolerance) const override { return Norm(x - center_) < radius_ + tolerance; }
  Box Bounds() const override { return bounds_; }
  double Distance(Vec3 x) const override { return Norm(x - center_) - radius_; }
  Vec3 OnOutline(Vec3 x, int, bool) const override { return AtRadius(x, center_, radius_); }

private:
  Box bounds_;
  Vec3 center_;
  double radius_;
};

class CylinderRegion : public Region
{
public:
  CylinderRegion(Vec3 bottom_center, double radius, double height)
      : bounds_{bottom_center - Vec3{radius, radius, 0}, bottom_center + Vec3{radius, radius, height}}, center_(bottom_center),
        radius_(radius)
  {
  }
  bool Contains(Vec3 x, double tolerance) const override
  {
    return std::hypot(x[0] - center_[0], x[1] - center_[1]) < radius_ + tolerance && x[2] >= bounds_.lower[2] - tolerance &&
           x[2] < bounds_.upper[2] + tolerance;
  }
  Box Bounds() const override { return bounds_; }
  double Distance(Vec3 x) const override { return std::hypot(x[0] - center_[0], x[1] - center_[1]) - radius_; }
  Vec3 OnOutline(Vec3 x, int axis, bool at_edge) const override // tiles end at its bottom and its top
  {
    const Vec3 middle{center_[0], center_[1], x[2]};
    return axis < 2 || at_edge || Norm(x - middle) > radius_ ? AtRadius(x, middle, radius_) : x;
  }

private:
  Box bounds_;
  Vec3 center_;
  double radius_;
};

class PartOfRegion : public Region
{
public:
  PartOfRegion(std::unique_ptr<Region> whole, const Box &box) : whole_(std::move(whole)), bounds_(whole_->Bounds())
  {
    for (int axis = 0; axis < 3; ++axis)
      bounds_.lower[axis] = std::max(bounds_.lower[axis], box.lower[axis]),
      bounds_.upper[axis] = std::min(bounds_.upper[axis], box.upper[axis]);
  }
  bool Contains(Vec3 x, double tolerance) const override
  {
    const Vec3 margin = {tolerance, tolerance, bounds_.upper[2] > bounds_.lower[2] ? tolerance : 0};
    return Box{bounds_.lower - margin, bounds_.upper + margin}.Contains(x) && whole_->Contains(x, tolerance);
  }
  Box Bounds() const override { return bounds_; }
  double Distance(Vec3 x) const override { return whole_->Distance(x); }
  Vec3 OnOutline(Vec3 x, int axis, bool at_edge) const override { return whole_->OnOutline(x, axis, at_edge); }

private:
  std::unique_ptr<Region> whole_;
  Box bounds_;
};

class PolygonRegion : public Region
{
public:
  explicit PolygonRegion(std::vector<Vec3> vertices) : vertices_(std::move(vertices)) {}

  /// Counts the edges that a ray to the right crosses; near an edge the tolerance decides.
  bool Contains(Vec3 x, double tolerance) const override
  {
    bool inside = false;
    for (std::size_t k = 0, last = vertices_.size() - 1; k < vertices_.size(); last = k++) {
      const Vec3 a = vertices_[k], b = vertices_[last];
      if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
    }
    const bool near = tolerance != 0 && Nearest(x).distance <= std::abs(tolerance);
    return near ? tolerance > 0 : inside;
  }
  double Distance(Vec3 x) const override { return (Contains(x, 0) ? -1 : 1) * Nearest(x).distance; }
  Vec3 OnOutline(Vec3 x, int, bool) const override { return Nearest(x).at; }
  std::vector<Vec3> Between(Vec3 first, Vec3 last) const override
  {
    const std::size_t count = vertices_.size();
    const Place from = Nearest(first), to = Nearest(last);
    std::vector<Vec3> on, back;
    if (from.edge == to.edge) return {};
    for (std::size_t k = from.edge; k != to.edge; k = (k + 1) % count) on.push_back(vertices_[(k + 1) % count]);
    for (std::size_t k = from.edge; k != to.edge; k = (k + count - 1) % count) back.push_back(vertices_[k]);
    return Length(first, on, last) < Length(first, back, last) ? on : back;
  }
  Box Bounds() const override
  {
    Box box{vertices_.front(), vertices_.front()};
    for (const Vec3 &v : vertices_)
      for (int d = 0; d < 2; ++d) {
        box.lower[d] = std::min(box.lower[d], v[d]);
        box.upper[d] = std::max(box.upper[d], v[d]);
      }
    return box;
  }

private:
  /// The nearest place of the outline; edge k goes from vertex k to the next.
  struct Place {
    std::size_t edge;
    Vec3 at;
    double distance;
  };
  Place Nearest(Vec3 x) const
  {
    Place nearest{0, {}, HUGE_VAL};
    for (std::size_t k = 0; k < vertices_.size(); ++k) {
      const Vec3 a = vertices_[k], edge = vertices_[(k + 1) % vertices_.size()] - a;
      const double part = std::clamp(Dot(x - a, edge) / std::max(Dot(edge, edge), DBL_MIN), 0.0, 1.0);
      const Vec3 at = a + part * edge;
      if (Norm(x - at) < nearest.distance) nearest = {k, at, Norm(x - at)};
    }
    return nearest;
  }
  static double Length(Vec3 first, const std::vector<Vec3> &between, Vec3 last)
  {
    double length = 0;
    for (const Vec3 &x : between) length += Norm(x - first), first = x;
    return length + Norm(last - first);
  }
  std::vector<Vec3> vertices_;
};

} // namespace

std::unique_ptr<Region> CreateBoxRegion(const Box &box) { return std::make_unique<BoxRegion>(box); }
std::unique_ptr<Region> CreateBallRegion(GeometryKind geometry, Vec3 center, double radius)
{
  return std::make_unique<BallRegion>(geometry, center, radius);
}
std::unique_ptr<Region> CreateCylinderRegion(Vec3 bottom_center, double radius, double height)
{
  return std::make_unique<CylinderRegion>(bottom_center, radius, height);
}
std::unique_ptr<Region> CreatePartOf(std::unique_ptr<Region> whole, const Box &box)
{
  return std::make_unique<PartOfRegion>(std::move(whole), box);
}
std::unique_ptr<Region> CreatePolygonRegion(std::vector<Vec3> vertices)
{
  return std::make_unique<PolygonRegion>(std::move(vertices));
}

PartOfTile WholeOf(const Tile &tile, Vec3 origin, int dim)
{
  PartOfTile part{1, tile.center - origin, {}};
  for (int a = 0; a < dim; ++a) part.squares[a] = part.sum[a] * part.sum[a] + tile.half_size[a] * tile.half_size[a] / 3;
  return part;
}

PartOfTile PartInside(const Region &region, const Tile &tile, Vec3 origin, int dim)
{
  constexpr int kPlacesInPlane = 16, kPlacesInSpace = 6; // along an axis
  const bool cut = std::abs(region.Distance(tile.center)) <= Norm(tile.half_size);
  const int along = !cut ? 1 : dim == 3 ? kPlacesInSpace : kPlacesInPlane;
  const double width = 2 * *std::max_element(tile.half_size.begin(), tile.half_size.end()) / along;
  PartOfTile part;
  ForEach({{0, 0, 0}, {along, along, dim == 3 ? along : 1}}, [&](Index k) {
    Tile place{tile.center, (1.0 / along) * tile.half_size};
    for (int a = 0; a < dim; ++a) place.center[a] += (2 * k[a] + 1 - along) * place.half_size[a];
    const double inside = std::clamp(0.5 - region.Distance(place.center) / width, 0.0, 1.0);
    part.Add(WholeOf(place, origin, dim), inside / std::pow(along, dim));
  });
  return part;
}

Tile TileOf(const PartOfTile &part, const Tile &tile, int dim)
{
  Tile same = tile;
  double scale = part.share;
  for (int a = 0; a < dim; ++a) {
    const double off = part.sum[a] / part.share;
    same.center[a] += off;
    same.half_size[a] = std::sqrt(3 * std::max(part.squares[a] / part.share - off * off, 0.0));
    scale *= tile.half_size[a] / same.half_size[a];
  }
  for (int a = 0; a < dim; ++a) same.half_size[a] *= std::pow(scale, 1.0 / dim);
  return same;
}

/// Tiles of a piece of a body with a length in cells: none is longer than a cell by more than a tenth.
static int CountTiles(int per_cell, double length)
{
  const double fitting = std::floor(per_cell * length + 0.5 + kRounding);
  return static_cast<int>(std::max({1.0, fitting, std::ceil(length - kThinnestPoint)}));
}

/// True where a cell line divides the body: not where one of its sides is beyond the line by less than a sliver.
bool Tiling::IsCut(int axis, int line, Vec3 cell_center) const
{
  constexpr double kMinDistance = 2; // size: cells; slivers are at most 1 wide
  const double place = Line(axis, line);
  if (place - bounds_.lower[axis] > kMinDistance * cell_size_ && bounds_.upper[axis] - place > kMinDistance * cell_size_)
    return true;
  Vec3 below = cell_center, above = cell_center;
  below[axis] = place - 0.5 * cell_size_;
  above[axis] = place + 0.5 * cell_size_;
  const double size_below = CellSizeThere(below), size_above = CellSizeThere(above);
  const double most = std::min({size_below, size_above, cell_size_}); // or it would be no neighbour's
  const double sliver_below = std::min(sliver_ * size_below, most), sliver_above = std::min(sliver_ * size_above, most);
  return place - bounds_.lower[axis] > sliver_below && bounds_.upper[axis] - place > sliver_above;
}

Tiling::Cut Tiling::CutAxis(int axis, int cell, Vec3 cell_center) const
{
  const double rounding = kRounding * cell_size_;
  if (bounds_.upper[axis] < Line(axis, cell) - rounding || bounds_.lower[axis] > Line(axis, cell + 1) + rounding) return {};
  const double start = IsCut(axis, cell, cell_center) ? Line(axis, cell) : bounds_.lower[axis];
  const double end = IsCut(axis, cell + 1, cell_center) ? Line(axis, cell + 1) : bounds_.upper[axis];
  const double middle = 0.5 * (start + end) + rounding;
  if (middle < Line(axis, cell) || middle >= Line(axis, cell + 1)) return {};             // a neighbour's
  if (end - start < (kThinnestPoint - 2 * kRounding) * cell_size_ / per_cell_) return {}; // of a body that is nothing but that
  const int count = CountTiles(per_cell_, (end - start) / cell_size_);
  return {start, (end - start) / count, count};
}

int Tiling::MostTiles(int per_cell, int ratio) { return CountTiles(per_cell, 1 + 2 * std::min(kSliver * ratio, 1 + kRounding)); }

std::vector<Tile> Tiling::InCell(Index at) const
{
  const Vec3 center = CellCenter(at);
  Cut cuts[3];
  IndexBox all{{0, 0, 0}, {1, 1, 1}}; // in two dimensions one layer without thickness
  std::vector<Tile> tiles;
  for (int axis = 0; axis < dim_; ++axis) {
    cuts[axis] = CutAxis(axis, at[axis], center);
    if (cuts[axis].count == 0) return tiles;
    all.upper[axis] = cuts[axis].count;
  }
  ForEach(all, [&](Index k) {
    Tile tile;
    for (int axis = 0; axis < dim_; ++axis) tile.center[axis] = cuts[axis].start + (k[axis] + 0.5) * cuts[axis].width;
    for (int axis = 0; axis < dim_; ++axis) tile.half_size[axis] = 0.5 * cuts[axis].width;
    tiles.push_back(tile);
  });
  return tiles;
}

bool Tiling::At(Vec3 x, Tile &tile) const
{
  Index cell{};
  for (int axis = 0; axis < dim_; ++axis) cell[axis] = static_cast<int>(std::floor((x[axis] - origin_[axis]) / cell_size_));
  const Vec3 center = CellCenter(cell);
  for (int axis = 0; axis < dim_; ++axis) {
    bool found = false;
    for (int neighbour : {0, -1, 1}) { // a sliver is a neighbour's
      const Cut cut = CutAxis(axis, cell[axis] + neighbour, center);
      const double place = cut.count ? std::floor((x[axis] - cut.start) / cut.width) : -1;
      if (found || place < 0 || place >= cut.count) continue;
      found = true;
      tile.center[axis] = cut.start + (place + 0.5) * cut.width;
      tile.half_size[axis] = 0.5 * cut.width;
    }
    if (!found) return false;
  }
  return true;
}

bool SurfaceAbove(const Region &region, Vec3 x, int up, double *height)
{
  constexpr int kLattice = 4096; // size
  const double lower = region.Bounds().lower[up], upper = region.Bounds().upper[up], step = (upper - lower) / kLattice;
  for (int k = 0; k < kLattice; ++k) {
    double inside = upper - (k + 0.5) * step, outside = inside + step;
    x[up] = inside;
    if (!region.Contains(x)) continue;
    for (int halving = 0; halving < 40; ++halving) {
      x[up] = 0.5 * (inside + outside);
      (region.Contains(x) ? inside : outside) = x[up];
    }
    *height = std::abs(inside - upper) < 1e-9 * (upper - lower) ? upper : inside;
    return true;
  }
  return false;
}

} // namespace mlgimp
