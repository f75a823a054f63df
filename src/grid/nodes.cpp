// Loops over the owned nodes of a grid.
#include "grid/nodes.hpp"

#include "grid/light_nodes.hpp"

#include <algorithm>
#include <type_traits>

namespace mlgimp
{

namespace
{

/// Calls work(place, dim, owned) with the place in the arrays of every node of a box, the dimension as a constant, and whether
/// the node is owned, which is a constant too.
template <class Work> void ForEachNode(const Grid &grid, const IndexBox &box, Work work)
{
  const IndexBox &owned = grid.Owned();
  const auto rows = [&](auto dim) {
    const auto part = [&](std::ptrdiff_t first, std::ptrdiff_t end, auto is_owned) {
      for (std::ptrdiff_t place = first; place < end; ++place) work(place, dim, is_owned);
    };
    for (int k = box.lower[2]; k < box.upper[2]; ++k)
      for (int j = box.lower[1]; j < box.upper[1]; ++j) {
        const std::ptrdiff_t first = grid.Place({box.lower[0], j, k}), end = first + box.Size(0);
        const std::ptrdiff_t first_owned = first + owned.lower[0] - box.lower[0],
                             end_owned = first_owned + (owned.Contains({owned.lower[0], j, k}) ? owned.Size(0) : 0);
        part(first, first_owned, std::false_type());
        part(first_owned, end_owned, std::true_type());
        part(end_owned, end, std::false_type());
      }
  };
  if (grid.Geometry().dim == 2)
    rows(std::integral_constant<int, 2>());
  else
    rows(std::integral_constant<int, 3>());
}

/// Of owned nodes, which budgets count; and with the ghosts, of which each rank has the sums.
template <class Work> void ForEachOwned(const Grid &grid, Work work) { ForEachNode(grid, grid.Owned(), work); }
template <class Work> void ForEachLocal(const Grid &grid, Work work) { ForEachNode(grid, grid.Ghosted(), work); }

/// Calls work(place, side, owned) for every local node at or beyond each side that is not free.
template <class Work> void ForEachConstrained(const Grid &grid, const BoundaryConditions &sides, Work work)
{
  for (const Side side : kAllSides) {
    if (sides.kind[side] == BoundaryKind::kFree) continue;
    IndexBox nodes = grid.Ghosted();
    const int axis = AxisOf(side);
    if (SignOf(side) < 0)
      nodes.upper[axis] = std::min(nodes.upper[axis], sides.node[side] + 1);
    else
      nodes.lower[axis] = std::max(nodes.lower[axis], sides.node[side]);
    ForEach(nodes, [&](Index node) { work(grid.Place(node), side, grid.Owned().Contains(node)); });
  }
}

} // namespace

double KineticEnergy(const Grid &grid, const NodalSettings &settings)
{
  double energy = 0;
  ForEachOwned(grid, [&](std::ptrdiff_t place, auto dim, auto) {
    const NodeSums &node = grid.Sums()[place];
    if (node.mass <= settings.mass_cutoff) return;
    for (int axis = 0; axis < dim; ++axis)
      energy += 0.5 * node.owned_mass / (node.mass * node.mass) * node.momentum[axis] * node.momentum[axis];
  });
  return energy;
}

void UpdateVelocities(const Grid &grid, const NodalSettings &settings, double dt)
{
  const Vec3 gravity = settings.gravity;
  const double damping = settings.damping, cutoff = settings.mass_cutoff;
  ForEachLocal(grid, [=, sums = grid.Sums(), velocities = grid.Arrays().VelocityArray()](std::ptrdiff_t place, auto dim, auto) {
    NodeSums &node = sums[place];
    double *const velocity = velocities + NodeLayout::Velocity(dim) * place;
    double v[dim], dv[dim], force[dim]; // all before any is stored, as the compiler makes vectors then
    const double mass = node.mass, inverse_mass = mass <= cutoff ? 0 : 1 / mass;
    for (int axis = 0; axis < dim; ++axis) {
      const double momentum = node.momentum[axis];
      force[axis] = node.force[axis] + (mass * gravity[axis] - damping * momentum);
      dv[axis] = dt * force[axis] * inverse_mass;
      v[axis] = momentum * inverse_mass + dv[axis];
    }
    for (int axis = 0; axis < dim; ++axis) {
      node.force[axis] = force[axis];
      velocity[axis] = v[axis], velocity[NodeLayout::Velocity(dim) / 2 + axis] = dv[axis];
    }
  });
}

void ApplyBoundaryConditions(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, Budgets &budgets)
{
  const int dim = grid.Geometry().dim;
  ForEachConstrained(grid, sides, [&](std::ptrdiff_t place, Side side, bool owned) {
    const NodeSums &node = grid.Sums()[place];
    const auto [velocity, change] = grid.Velocity(place);
    if (node.mass <= settings.mass_cutoff) return;
    for (int axis = 0; axis < dim; ++axis) {
      if (!sides.Constrains(side, axis)) continue;
      const double held = sides.HeldVelocity(side, axis), correction = held - velocity[axis];
      if (owned) budgets.support_impulse[axis] += node.owned_mass * correction;
      if (owned) budgets.external_work += held * correction * node.owned_mass;
      change[axis] += correction;
      velocity[axis] = held;
    }
  });
}

void AddBodyWork(const Grid &grid, const NodalSettings &settings, double dt, Budgets &budgets)
{
  Vec3 way{}, momentum{}; // of the mass, by the step; at its start
  double mass = 0, damped = 0;
  ForEachOwned(grid, [&](std::ptrdiff_t place, auto dim, auto) {
    const NodeSums &node = grid.Sums()[place];
    const auto [velocity, change] = grid.Velocity(place);
    if (node.mass == 0) return;
    const double owned = node.owned_mass / node.mass;
    mass += node.owned_mass;
    for (int axis = 0; axis < dim; ++axis) {
      const double mean = velocity[axis] - 0.5 * change[axis];
      way[axis] += node.owned_mass * mean;
      momentum[axis] += owned * node.momentum[axis];
      damped += node.owned_mass * (velocity[axis] - change[axis]) * mean;
    }
  });
  budgets.gravity_impulse += dt * mass * settings.gravity;
  budgets.external_work += dt * Dot(way, settings.gravity);
  budgets.damping_impulse += -dt * settings.damping * momentum;
  budgets.damping_work += dt * settings.damping * damped;
}

std::map<std::ptrdiff_t, double> AdvanceContactNodes(const Grid &grid, const std::vector<NodeChange> &contact_nodes,
                                                     const LightNodes &light)
{
  std::map<std::ptrdiff_t, double> ahead;
  for (const NodeChange &one : contact_nodes) {
    double &part = ahead[one.node];
    if (!light.IsLight(one.node)) part = std::max(part, one.has_traction ? kTractionLead : kContactLead);
  }
  for (const auto &[node, part] : ahead)
    for (int axis = 0; axis < grid.Geometry().dim; ++axis)
      grid.Rates(node)[axis] += part * grid.Sums()[node].mass * grid.Velocity(node).change[axis];
  return ahead;
}

Vec3 MomentumAfter(const Grid &grid, std::ptrdiff_t place, bool spread)
{
  const NodeSums &node = grid.Sums()[place];
  const double *const added = grid.Rates(place), *const change = grid.Velocity(place).change;
  Vec3 after{};
  for (int axis = 0; axis < grid.Geometry().dim; ++axis)
    after[axis] = node.momentum[axis] + (spread ? added[axis] : node.mass * change[axis]);
  return after;
}

double WorkOnPoints(const Grid &grid, const std::vector<NodeChange> &contact_nodes, const std::map<std::ptrdiff_t, double> &ahead,
                    bool spread)
{
  const int dim = grid.Geometry().dim;
  double work = 0;
  for (const NodeChange &one : contact_nodes) {
    const NodeSums &node = grid.Sums()[one.node];
    const double *const change = grid.Velocity(one.node).change;
    const Vec3 after = MomentumAfter(grid, one.node, spread);
    const auto pushed = ahead.find(one.node);
    for (int axis = 0; axis < dim; ++axis) {
      const double lead = pushed == ahead.end() ? 0 : pushed->second * node.mass * change[axis];
      work += 0.5 * one.change[axis] * (node.momentum[axis] + after[axis] - lead);
    }
  }
  return work;
}

/// Holds at the sides the velocities of the second extrapolation and the means that XPIC takes off; returns the impulse on the
/// latter, N s.
static Vec3 ConstrainRates(const Grid &grid, const BoundaryConditions &sides)
{
  const int dim = grid.Geometry().dim;
  Vec3 impulse{};
  ForEachConstrained(grid, sides, [&](std::ptrdiff_t place, Side side, bool owned) {
    double *const velocity = grid.Rates(place), *const mean = velocity + NodeLayout::Projected(dim);
    for (int axis = 0; axis < dim; ++axis) {
      if (!sides.Constrains(side, axis)) continue;
      const double held = sides.HeldVelocity(side, axis);
      if (owned) impulse[axis] += grid.Sums()[place].owned_mass * (mean[axis] - held);
      velocity[axis] = mean[axis] = held;
    }
  });
  return impulse;
}

void VelocitiesFromSums(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings)
{
  ForEachLocal(grid, [&](std::ptrdiff_t place, auto dim, auto) {
    const NodeSums &node = grid.Sums()[place];
    double *const rates = grid.Rates(place);
    std::fill_n(rates, NodeLayout::Rates(dim), 0.0);
    for (int axis = 0; node.mass > settings.mass_cutoff && axis < dim; ++axis) rates[axis] = node.momentum[axis] / node.mass;
  });
  ConstrainRates(grid, sides);
}

/// The second velocity of a node that moves with those of another level: that motion, and what the second extrapolation would
/// change of it. Points there carry velocities p/m that may differ from the motion for good; strained by these, they would not be
/// as the surface that contact sees.
static void FollowMotion(const Grid &grid, const NodalSettings &settings, std::ptrdiff_t node)
{
  const NodeSums &sums = grid.Sums()[node];
  const auto [motion, change] = grid.Velocity(node);
  double *const velocity = grid.Rates(node);
  const bool smooths = sums.mass > settings.mass_cutoff;
  for (int axis = 0; axis < grid.Geometry().dim; ++axis)
    velocity[axis] = motion[axis] + (smooths ? velocity[axis] - sums.momentum[axis] / sums.mass - change[axis] : 0);
}

/// The new velocity in place of the second one.
static void HoldRates(const Grid &grid, const SecondVelocityPlan &plan)
{
  for (const std::ptrdiff_t node : plan.held) std::copy_n(grid.Velocity(node).velocity, grid.Geometry().dim, grid.Rates(node));
}

void DivideRates(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, const SecondVelocityPlan &plan,
                 Budgets &budgets)
{
  const double cutoff = settings.mass_cutoff, share = plan.xpic;
  ForEachLocal(grid, [=, sums = grid.Sums(), rates = grid.Arrays().RatesArray()](std::ptrdiff_t place, auto dim, auto) {
    const NodeSums &node = sums[place];
    double *const velocity = rates + NodeLayout::Rates(dim) * place, *const mean = velocity + NodeLayout::Projected(dim);
    const double inverse_mass = node.mass <= cutoff ? 0 : 1 / node.mass;
    for (int axis = 0; axis < dim; ++axis) velocity[axis] = inverse_mass * (node.momentum[axis] + velocity[axis]);
    for (int axis = 0; share > 0 && axis < dim; ++axis) mean[axis] *= inverse_mass;
  });
  HoldRates(grid, plan);
  for (const std::ptrdiff_t node : plan.following) FollowMotion(grid, settings, node);
  const Vec3 impulse = ConstrainRates(grid, sides);
  if (settings.xpic_order == 2) budgets.xpic_side_impulse += plan.xpic * impulse;
}

void FinishRates(const Grid &grid, const NodalSettings &settings, const SecondVelocityPlan &plan)
{
  const double mean = settings.xpic_order == 1 ? 0 : 1;
  if (plan.xpic > 0)
    ForEachLocal(grid, [&](std::ptrdiff_t place, auto dim, auto) {
      const double *const updated = grid.Velocity(place).velocity;
      double *const velocity = grid.Rates(place), *const projected = velocity + NodeLayout::Projected(dim);
      for (int axis = 0; axis < dim; ++axis) {
        projected[axis] = updated[axis] + mean * (updated[axis] - projected[axis]);
        velocity[axis] += plan.xpic * (projected[axis] - velocity[axis]);
      }
    });
  HoldRates(grid, plan);
}

} // namespace mlgimp
