// Plastic strains of points at the surface, by columns of the grid.
#include "contact/strain_under.hpp"

#include "contact/segments.hpp"
#include "surface/pieces.hpp"

namespace mlgimp
{

void StrainUnder::Begin(const SurfaceInputs &surface, Vec3 tip)
{
  const PointArrays points = surface.points.Arrays();
  const GridGeometry &grid = surface.grid.Geometry();
  Clear();
  for (const int p : surface.points.SurfacePoints()) {
    if (FarFromIndenter(surface, tip, points.Position(p)) || !surface.bodies.Of(points, p).Traits().flows) continue;
    before_.push_back({p, points.history[PointArrays::At(p, points.history_components)]});
    ForEachColumn(grid, Locate(grid, points.Position(p)), [&](std::int64_t key, Index, double hat) {
      columns_.push_back({key, 0, hat * points.mass[p]});
    });
  }
}

const std::vector<ColumnStrain> &StrainUnder::End(const PointArrays &points)
{
  const std::size_t of_each = before_.empty() ? 0 : columns_.size() / before_.size();
  for (std::size_t k = 0; k < before_.size(); ++k) {
    const double by = points.history[PointArrays::At(before_[k].first, points.history_components)] - before_[k].second;
    for (std::size_t c = k * of_each; c < (k + 1) * of_each; ++c) columns_[c].strain = by * columns_[c].weight;
  }
  return columns_;
}

} // namespace mlgimp
