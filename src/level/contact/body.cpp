// Pieces of faces, and impulses on nodes.
#include "level/contact/body.hpp"

#include "level/face.hpp"

#include <algorithm>

namespace mlgimp
{

void AddPointSegments(const PointArrays &points, int p, const Geometry &geometry, std::vector<SurfaceSegment> *segments)
{
  const int dim = geometry.Dim();
  for (const Side side : SidesOf{dim}) {
    if (!(points.faces[p] & OuterFaceBit(side))) continue;
    const Face face = PointFace(points, p, side);
    const double area = Norm(face.area_normal);
    int count = 1;
    for (int e = 1; e < dim; ++e) count *= kSegmentsPerEdge;
    for (int k = 0; k < count; ++k) {
      Vec3 x = face.center;
      for (int e = 0, place = k; e < dim - 1; ++e, place /= kSegmentsPerEdge)
        x = x + ((2 * (place % kSegmentsPerEdge) + 1.0) / kSegmentsPerEdge - 1) * face.half_edge[e];
      segments->push_back({x, (1 / area) * face.area_normal, area * geometry.OutOfPlane(face.center[0]) / count,
                           Norm(face.half_edge[0]) / kSegmentsPerEdge});
    }
  }
}

bool FarFromIndenter(const ContactView &view, const PointArrays &points, int p)
{
  const double h = view.grid.Geometry().spacing;
  return view.indenter.Gap(points.Position(p), view.tip.end).distance > kPointRange * h;
}

double MassOf(const ContactView &view, Index node)
{
  const std::ptrdiff_t place = view.grid.Place(node);
  const double own = view.grid.Sums()[place].mass;
  return own > view.mass_cutoff && view.shared ? own + view.shared[place].finer_mass : own;
}

/// One of the two arrays' mass of a node, kg.
static double LeastMassOf(const ContactView &view, const double *masses, Index node)
{
  return masses ? masses[view.grid.Place(node)] : 0;
}

double MovedMassOf(const ContactView &view, Index node)
{
  return std::max(MassOf(view, node), LeastMassOf(view, view.least_masses, node));
}

Vec3 VelocityOf(const ContactView &view, Index node)
{
  const NodeVelocity at = view.grid.Velocity(view.grid.Place(node));
  const double lack = LackOf(LeastMassOf(view, view.later_masses, node), MassOf(view, node));
  const NodalSettings settings = lack > 0 && view.nodal ? *view.nodal : NodalSettings();
  Vec3 velocity{};
  for (int d = 0; d < view.geometry.Dim(); ++d)
    velocity[d] = view.sides.Constrains(node, d)
                      ? view.sides.HeldVelocity(node, d)
                      : at.velocity[d] - Lacking(settings, view.dt, lack, d, at.change[d], at.velocity[d] - at.change[d]);
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
  const double mass = MassOf(view, node), lacks_later = LackOf(LeastMassOf(view, view.later_masses, node), mass),
               lacks = LackOf(LeastMassOf(view, view.least_masses, node), mass);
  const Vec3 taken = FreePart(view, node, impulse), by = (1 / mass) * taken;
  const auto [velocity, change] = view.grid.Velocity(place);
  for (int d = 0; d < view.geometry.Dim(); ++d) {
    velocity[d] += (1 - lacks + lacks_later) * by[d];
    change[d] += by[d];
  }
  if (view.shared) view.shared[place].impulse = view.shared[place].impulse + taken;
  report->pushed.push_back({place, by});
  report->impulse = report->impulse + impulse;
  report->side_impulse = report->side_impulse + taken - impulse;
}

} // namespace mlgimp
