// What is near the indenter, and impulses on nodes.
#include "contact/body.hpp"

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

bool FarFromIndenter(const ContactView &view, Vec3 x)
{
  const double range = kPointRange * view.grid.Geometry().spacing;
  const int up = view.geometry.Dim() - 1;
  return view.tip.end[up] - x[up] > range || view.indenter.Gap(x, view.tip.end).distance > range; // no surface is below the tip
}

double MassOf(const ContactView &view, Index node)
{
  const std::ptrdiff_t place = view.grid.Place(node);
  return view.grid.Sums()[place].mass + (view.shared ? view.shared[place].finer_mass : 0);
}

Vec3 VelocityOf(const ContactView &view, Index node)
{
  const NodeVelocity at = view.grid.Velocity(view.grid.Place(node));
  Vec3 velocity{};
  for (int d = 0; d < view.geometry.Dim(); ++d)
    velocity[d] = view.sides.Constrains(node, d) ? view.sides.HeldVelocity(node, d) : at.velocity[d];
  return velocity;
}

Vec3 FreePart(const ContactView &view, Index node, Vec3 change)
{
  for (int d = 0; d < view.geometry.Dim(); ++d)
    if (view.sides.Constrains(node, d)) change[d] = 0;
  return change;
}

void PushNode(const ContactView &view, Index node, Vec3 impulse, ContactReport *report)
{
  const std::ptrdiff_t place = view.grid.Place(node);
  const double mass = MassOf(view, node);
  const Vec3 taken = FreePart(view, node, impulse), by = (1 / mass) * taken;
  const auto [velocity, change] = view.grid.Velocity(place);
  for (int d = 0; d < view.geometry.Dim(); ++d) {
    velocity[d] += by[d];
    change[d] += by[d];
  }
  if (view.shared) view.shared[place].impulse = view.shared[place].impulse + taken;
  report->pushed.push_back({place, by});
  report->impulse = report->impulse + impulse;
  report->side_impulse = report->side_impulse + taken - impulse;
}

} // namespace mlgimp
