// Loops over the owned nodes of a grid.
#include "level/nodes.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

/// Calls work(index) with the place in the ghosted arrays of every owned node.
template <class Work> void ForEachOwned(const Grid &grid, Work work)
{
  for (int j = grid.OwnedLower(1); j < grid.OwnedUpper(1); ++j) {
    const int row = grid.Index(0, j);
    for (int i = grid.OwnedLower(0); i < grid.OwnedUpper(0); ++i) work(row + i);
  }
}

/// Calls work(index, side) for every owned node at or beyond each bound side.
template <class Work> void ForEachConstrained(const Grid &grid, const BoundaryConditions &sides, Work work)
{
  for (int s = 0; s < kSides; ++s) {
    const Side side = static_cast<Side>(s);
    if (sides.kind[s] == BoundaryKind::kFree) continue;
    int lower[2] = {grid.OwnedLower(0), grid.OwnedLower(1)}, upper[2] = {grid.OwnedUpper(0), grid.OwnedUpper(1)};
    const int axis = AxisOf(side);
    if (SignOf(side) < 0)
      upper[axis] = std::min(upper[axis], sides.node[s] + 1);
    else
      lower[axis] = std::max(lower[axis], sides.node[s]);
    for (int j = lower[1]; j < upper[1]; ++j)
      for (int i = lower[0]; i < upper[0]; ++i) work(grid.Index(i, j), side);
  }
}

/// Share of a node's mass that points of this level have; the rest are copies, whose budgets their owners keep.
double OwnedShare(const double *sums) { return sums[0] > 0 ? sums[3] / sums[0] : 0; }

} // namespace

void AddBodyForces(const Grid &grid, const NodalSettings &settings, double dt, NodalTotals &totals)
{
  Vec3 gravity_impulse{}, damping_impulse{};
  ForEachOwned(grid, [&](int index) {
    double *sums = grid.Arrays().sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    const double owned = dt * OwnedShare(sums);
    for (int axis = 0; axis < 2; ++axis) {
      const double gravity = sums[0] * settings.gravity[axis], damping = -settings.damping * sums[1 + axis];
      sums[4 + axis] += gravity + damping;
      gravity_impulse[axis] += owned * gravity;
      damping_impulse[axis] += owned * damping;
    }
  });
  totals.gravity_impulse = totals.gravity_impulse + gravity_impulse;
  totals.damping_impulse = totals.damping_impulse + damping_impulse;
}

void UpdateVelocities(const Grid &grid, const NodalSettings &settings, double dt, NodalTotals &totals)
{
  const NodeArrays &nodes = grid.Arrays();
  Vec3 load_impulse{};
  ForEachOwned(grid, [&](int index) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    double *velocity = nodes.velocity + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(index);
    const bool empty = sums[0] <= settings.mass_cutoff;
    const double inverse_mass = empty ? 0 : 1 / sums[0];
    for (int axis = 0; axis < 2; ++axis) {
      velocity[2 + axis] = dt * sums[4 + axis] * inverse_mass;
      velocity[axis] = sums[1 + axis] * inverse_mass + velocity[2 + axis];
      load_impulse[axis] += empty ? 0 : dt * sums[6 + axis];
    }
  });
  totals.load_impulse = totals.load_impulse + load_impulse;
}

void ApplyBoundaryConditions(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings,
                             NodalTotals &totals)
{
  const NodeArrays &nodes = grid.Arrays();
  ForEachConstrained(grid, sides, [&](int index, Side side) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    double *velocity = nodes.velocity + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(index);
    if (sums[0] <= settings.mass_cutoff) return;
    for (int axis = 0; axis < 2; ++axis) {
      if (!sides.Constrains(side, axis)) continue;
      totals.support_impulse[axis] -= sums[3] * velocity[axis];
      velocity[2 + axis] -= velocity[axis];
      velocity[axis] = 0;
    }
  });
}

void AddWork(const Grid &grid, const NodalSettings &settings, double dt, NodalTotals &totals)
{
  const NodeArrays &nodes = grid.Arrays();
  double work = 0, damped = 0;
  ForEachOwned(grid, [&](int index) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    const double *velocity = nodes.velocity + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(index);
    for (int axis = 0; axis < 2; ++axis) {
      const double mean = velocity[axis] - 0.5 * velocity[2 + axis], old = velocity[axis] - velocity[2 + axis];
      work += mean * (sums[6 + axis] + sums[3] * settings.gravity[axis]);
      damped += sums[3] * old * mean;
    }
  });
  totals.external_work += dt * work;
  totals.damping_dissipation += dt * settings.damping * damped;
}

void NoteCoupling(const Grid &grid, const NodalSettings &settings, double dt, std::vector<CoupledNode> &nodes)
{
  for (CoupledNode &coupled : nodes) {
    const double *sums = grid.Arrays().sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(coupled.node);
    const double *velocity = grid.Arrays().velocity + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(coupled.node);
    for (int axis = 0; axis < 2; ++axis)
      coupled.change[axis] = sums[0] > settings.mass_cutoff ? velocity[2 + axis] - dt * sums[4 + axis] / sums[0] : 0;
  }
}

void AddExchange(const Grid &grid, const NodalSettings &settings, double dt, const std::vector<CoupledNode> &coupled,
                 NodalTotals &totals)
{
  const NodeArrays &nodes = grid.Arrays();
  double work = 0;
  ForEachOwned(grid, [&](int index) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    const double *after = nodes.rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(index);
    if (sums[0] <= settings.mass_cutoff) return;
    for (int axis = 0; axis < 2; ++axis) {
      const double outside = sums[6 + axis] + sums[0] * settings.gravity[axis] - settings.damping * sums[1 + axis];
      work += 0.5 * dt * (sums[4 + axis] - outside) / sums[0] * (sums[1 + axis] + after[axis]);
    }
  });
  for (const CoupledNode &node : coupled) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(node.node);
    const double *after = nodes.rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(node.node);
    for (int axis = 0; axis < 2; ++axis) work += 0.5 * node.change[axis] * (sums[1 + axis] + after[axis]);
  }
  totals.exchange_work += work;
}

/// Zero normal velocities of the second extrapolation at the sides; returns the impulse on the projected velocities.
static Vec3 ConstrainRates(const Grid &grid, const BoundaryConditions &sides)
{
  Vec3 impulse{};
  ForEachConstrained(grid, sides, [&](int index, Side side) {
    const double *sums = grid.Arrays().sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    double *rates = grid.Arrays().rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(index);
    for (int axis = 0; axis < 2; ++axis) {
      if (!sides.Constrains(side, axis)) continue;
      impulse[axis] -= sums[3] * rates[2 + axis];
      rates[axis] = rates[2 + axis] = 0;
    }
  });
  return impulse;
}

void VelocitiesFromSums(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings)
{
  const NodeArrays &nodes = grid.Arrays();
  ForEachOwned(grid, [&](int index) {
    const double *sums = nodes.sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
    double *rates = nodes.rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(index);
    std::fill_n(rates, NodeArrays::kRates, 0.0);
    if (sums[0] <= settings.mass_cutoff) return;
    rates[0] = sums[1] / sums[0];
    rates[1] = sums[2] / sums[0];
  });
  ConstrainRates(grid, sides);
}

void UpdateRates(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings,
                 const std::vector<CoupledNode> &coupled, NodalTotals &totals)
{
  const NodeArrays &nodes = grid.Arrays();
  ForEachOwned(grid, [&](int index) {
    const double mass = nodes.sums[NodeArrays::kSums * static_cast<std::ptrdiff_t>(index)];
    const double *velocity = nodes.velocity + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(index);
    double *rates = nodes.rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(index);
    if (mass <= settings.mass_cutoff) {
      std::fill_n(rates, NodeArrays::kRates, 0.0);
      return;
    }
    const double inverse_mass = 1 / mass;
    for (int k = 0; k < NodeArrays::kRates; ++k) rates[k] *= inverse_mass;
    for (int axis = 0; axis < 2; ++axis) {
      rates[2 + axis] = settings.xpic_order == 1 ? velocity[axis] : 2 * velocity[axis] - rates[2 + axis];
      if (settings.second_extrapolation)
        rates[axis] += settings.xpic_fraction * (rates[2 + axis] - rates[axis]);
      else
        rates[axis] = velocity[axis];
    }
  });
  for (const CoupledNode &node : coupled)
    for (int axis = 0; node.held && axis < 2; ++axis) {
      double *rates = nodes.rates + NodeArrays::kRates * static_cast<std::ptrdiff_t>(node.node);
      rates[axis] = nodes.velocity[NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(node.node) + axis];
    }
  totals.xpic_side_impulse = totals.xpic_side_impulse + settings.xpic_fraction * ConstrainRates(grid, sides);
}

} // namespace mlgimp
