// Boxes, disks and polygons, and their tiling.
#include "pointwise/region.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

class BoxRegion : public Region
{
public:
  explicit BoxRegion(const Box &box) : box_(box) {}
  bool Contains(Vec2 x) const override { return box_.Contains(x); }
  Box Bounds() const override { return box_; }

private:
  Box box_;
};

class DiskRegion : public Region
{
public:
  DiskRegion(Vec2 center, double radius) : center_(center), radius_(radius) {}
  bool Contains(Vec2 x) const override { return Norm(x - center_) < radius_; }
  Box Bounds() const override
  {
    const Vec2 r = {radius_, radius_};
    return {center_ - r, center_ + r};
  }

private:
  Vec2 center_;
  double radius_;
};

class PolygonRegion : public Region
{
public:
  explicit PolygonRegion(std::vector<Vec2> vertices) : vertices_(std::move(vertices)) {}

  /// Counts the edges that a ray to the right crosses.
  bool Contains(Vec2 x) const override
  {
    bool inside = false;
    for (std::size_t k = 0, last = vertices_.size() - 1; k < vertices_.size(); last = k++) {
      const Vec2 a = vertices_[k], b = vertices_[last];
      if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
  }

  Box Bounds() const override
  {
    Box box{vertices_.front(), vertices_.front()};
    for (const Vec2 &v : vertices_)
      for (int d = 0; d < 2; ++d) {
        box.lower[d] = std::min(box.lower[d], v[d]);
        box.upper[d] = std::max(box.upper[d], v[d]);
      }
    return box;
  }

private:
  std::vector<Vec2> vertices_;
};

constexpr double kSliver = 1e-6; ///< pieces thinner than this part of a cell are rounding errors

} // namespace

std::unique_ptr<Region> CreateBoxRegion(const Box &box) { return std::make_unique<BoxRegion>(box); }
std::unique_ptr<Region> CreateDiskRegion(Vec2 center, double radius) { return std::make_unique<DiskRegion>(center, radius); }
std::unique_ptr<Region> CreatePolygonRegion(std::vector<Vec2> vertices)
{
  return std::make_unique<PolygonRegion>(std::move(vertices));
}

Tiling::Cut Tiling::CutAxis(int axis, int cell) const
{
  const double start = std::max(origin_[axis] + cell * cell_size_, bounds_.lower[axis]);
  const double end = std::min(origin_[axis] + (cell + 1) * cell_size_, bounds_.upper[axis]);
  if (end - start < kSliver * cell_size_) return {};
  const int count = std::max(1, static_cast<int>(std::lround(per_cell_ * (end - start) / cell_size_)));
  return {start, (end - start) / count, count};
}

std::vector<Tile> Tiling::InCell(int i, int j) const
{
  const Cut x = CutAxis(0, i), y = CutAxis(1, j);
  std::vector<Tile> tiles;
  for (int b = 0; b < y.count; ++b)
    for (int a = 0; a < x.count; ++a)
      tiles.push_back({{x.start + (a + 0.5) * x.width, y.start + (b + 0.5) * y.width}, {0.5 * x.width, 0.5 * y.width}});
  return tiles;
}

bool Tiling::At(Vec2 x, Tile &tile) const
{
  for (int axis = 0; axis < 2; ++axis) {
    const int cell = static_cast<int>(std::floor((x[axis] - origin_[axis]) / cell_size_));
    const Cut cut = CutAxis(axis, cell);
    const double place = cut.count ? std::floor((x[axis] - cut.start) / cut.width) : -1;
    if (place < 0 || place >= cut.count) return false;
    tile.center[axis] = cut.start + (place + 0.5) * cut.width;
    tile.half_size[axis] = 0.5 * cut.width;
  }
  return true;
}

} // namespace mlgimp
