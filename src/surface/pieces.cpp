// Pieces of patches, and what is near the indenter.
#include "surface/pieces.hpp"

#include <algorithm>
#include <cfloat>

namespace mlgimp
{

SurfaceSegment SegmentOf(const SurfacePatch &patch, double s, double t, const Geometry &geometry)
{
  const Vec3 *const x = patch.corner;
  const int dim = geometry.Dim();
  const std::array<double, 4> part = CornerWeights(s, t, dim);
  Vec3 center{}, along = x[1] - x[0], across = {0, 0, 1};
  for (int c = 0; c < 1 << (dim - 1); ++c) center = center + part[c] * x[c];
  if (dim == 3) along = (1 - t) * along + t * (x[2] - x[3]), across = (1 - s) * (x[3] - x[0]) + s * (x[2] - x[1]);
  const Vec3 normal = Cross(along, across);
  const double area = std::max(Norm(normal), DBL_MIN);
  return {center, (1 / area) * normal, area * geometry.OutOfPlane(center[0]), 0.5 * Norm(along)};
}

bool FarFromIndenter(const SurfaceInputs &surface, Vec3 tip, Vec3 x)
{
  const double range = kPointRange * surface.grid.Geometry().spacing;
  const int up = surface.geometry.Dim() - 1;
  return tip[up] - x[up] > range || surface.indenter.Gap(x, tip).distance > range; // no surface is below the tip
}

} // namespace mlgimp
