// What contact asks of nodes, and impulses on them.
#include "contact/node_motion.hpp"

namespace mlgimp
{

double NodeMotion::MassOf(Index node) const
{
  const std::ptrdiff_t place = grid_.Place(node);
  return grid_.Sums()[place].mass + (shared_ ? shared_[place].finer_mass : 0);
}

Vec3 NodeMotion::VelocityOf(Index node) const
{
  const NodeVelocity at = grid_.Velocity(grid_.Place(node));
  Vec3 velocity{};
  for (int d = 0; d < grid_.Geometry().dim; ++d)
    velocity[d] = sides_.Constrains(node, d) ? sides_.HeldVelocity(node, d) : at.velocity[d];
  return velocity;
}

Vec3 NodeMotion::FreePart(Index node, Vec3 change) const
{
  for (int d = 0; d < grid_.Geometry().dim; ++d)
    if (sides_.Constrains(node, d)) change[d] = 0;
  return change;
}

void NodeMotion::Push(Index node, Vec3 impulse, ContactReport *report) const
{
  const std::ptrdiff_t place = grid_.Place(node);
  const Vec3 taken = FreePart(node, impulse), by = (1 / MassOf(node)) * taken;
  const auto [velocity, change] = grid_.Velocity(place);
  for (int d = 0; d < grid_.Geometry().dim; ++d) {
    velocity[d] += by[d];
    change[d] += by[d];
  }
  if (shared_) shared_[place].impulse = shared_[place].impulse + taken;
  report->contact_nodes.push_back({place, by});
  report->impulse = report->impulse + impulse;
  report->side_impulse = report->side_impulse + taken - impulse;
}

} // namespace mlgimp
