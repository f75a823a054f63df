// What is near the indenter, and impulses on nodes.
#include "level/contact/body.hpp"

#include <algorithm>

namespace mlgimp
{

bool FarFromIndenter(const ContactView &view, const PointArrays &points, int p)
{
  const double range = kPointRange * view.grid.Geometry().spacing;
  const Vec3 x = points.Position(p);
  const int up = view.geometry.Dim() - 1;
  return view.tip.end[up] - x[up] > range || view.indenter.Gap(x, view.tip.end).distance > range; // no surface is below the tip
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
