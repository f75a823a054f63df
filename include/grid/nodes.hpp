// What happens at the nodes of a level: the update of velocities, the sides of the domain, and the budgets of both.
#pragma once

#include "base/tensor.hpp"
#include "grid/budgets.hpp"
#include "grid/grid.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

namespace mlgimp
{

class LightNodes;

enum class BoundaryKind { kFree, kSymmetry, kFixed };

/// The sides of the domain as a level's grid sees them.
struct BoundaryConditions {
  std::array<BoundaryKind, kSides> kind{};
  std::array<int, kSides> node{}; ///< box index of the side's nodes; nodes beyond it are bound as well

  bool Reaches(Side side, Index at) const
  {
    const int index = at[AxisOf(side)];
    return SignOf(side) < 0 ? index <= node[side] : index >= node[side];
  }
  bool Constrains(Side side, int axis) const
  {
    return kind[side] == BoundaryKind::kFixed || (kind[side] == BoundaryKind::kSymmetry && AxisOf(side) == axis);
  }
  /// True where the velocity component `axis` of a node is held.
  bool Constrains(Index at, int axis) const
  {
    for (const Side side : kAllSides)
      if (Reaches(side, at) && Constrains(side, axis)) return true;
    return false;
  }
  /// What a side holds a component at that it constrains, m/s. All that holds nodes asks here, so that a side that moves needs no
  /// other place.
  double HeldVelocity(Side, int) const { return 0; }
  /// The same at a node; of the sides that hold it there the last one counts, as in loops over sides.
  double HeldVelocity(Index at, int axis) const
  {
    double held = 0;
    for (const Side side : kAllSides)
      if (Reaches(side, at) && Constrains(side, axis)) held = HeldVelocity(side, axis);
    return held;
  }
};

/// Of the mass of a full cell of the lightest material: nodes with less are empty, and the forces on them are lost.
inline constexpr double kEmptyNode = 1e-24;
/// Settings of the nodal update.
struct NodalSettings {
  Vec3 gravity{};         ///< m/s2
  double damping = 0;     ///< 1/s
  double full_mass = 0;   ///< of a cell of the lightest material, in axisymmetry one cell from the axis, kg
  double mass_cutoff = 0; ///< nodes with less are skipped, kg
  double xpic_fraction = 0;
  int xpic_order = 2;
  bool HasBodyForces() const { return damping > 0 || Norm(gravity) > 0; }
};

/// XPIC of up to four steps at once where its share in them stays below 0.08: noise decays as it would step by step, for a
/// quarter of the work (Nairn's codes have it at such intervals too).
class XpicSchedule
{
public:
  XpicSchedule() = default;
  /// fraction: of a step of level 0, in which the level makes so many steps.
  XpicSchedule(double fraction, double steps)
  {
    constexpr double kMaxShare = 0.08;
    constexpr int kMaxSteps = 4;
    while (interval_ < kMaxSteps && (interval_ + 1) * fraction <= kMaxShare * (1 + 1e-9)) ++interval_;
    share_ = 1 - std::pow(1 - fraction / steps, interval_);
  }
  /// The share of XPIC in the velocity update of a step of the level; the first is step 0.
  double InStep(long step) const { return (step + 1) % interval_ == 0 ? share_ : 0; }

private:
  double share_ = 0;
  int interval_ = 1;
};

/// Nodes of a level, with ghosts, whose velocities a neighbouring level has a part in.
struct CoupledPlaces {
  std::vector<std::ptrdiff_t> held;      ///< places of those whose velocity another level alone makes
  std::vector<std::ptrdiff_t> interface; ///< those among them that move with nodes of the next finer level
  std::vector<Index> blended;            ///< those that both make
  double reach = 0;                      ///< of contact: these follow the motion where the indenter is no farther, m
};

/// An owned node and a part of the change of its velocity in the step, m/s.
struct NodeChange {
  std::ptrdiff_t node; ///< place in the ghosted arrays
  Vec3 change;
  bool has_traction = false; ///< tractions of friction are a part of it
};

/// The second velocity of nodes that contact pushes is ahead of what points have got of dv by this part of dv: contact asks how
/// faces move with the new velocity, and points strained by that of points alone lag behind, so that noise of a bar under a punch
/// doubled every 10 crossings. More costs energy; where friction acts, 0.2 leaves noise, as columns let go in turns.
/// Nodes that hang on others have none: a flat surface on a line of nodes else splits its last two layers of points.
inline constexpr double kContactLead = 0.1, kTractionLead = 0.3;
/// Adds these parts to what points have spread into `rates`, before it is summed up; returns the nodes, each once, with the
/// parts.
std::map<std::ptrdiff_t, double> AdvanceContactNodes(const Grid &grid, const std::vector<NodeChange> &contact_nodes,
                                                     const LightNodes &light);

/// The momentum that points have on a node after the step, kg m/s: p + sum m S dv_p where they have spread their change, into
/// `rates`; else p + m dv, as if nodes had their mass to themselves.
Vec3 MomentumAfter(const Grid &grid, std::ptrdiff_t place, bool spread);

/// Kinetic energy that the points get from parts of the changes of nodal velocities, J: exactly dv . (p + P)/2 with their momenta
/// on the node before and after the step (P: MomentumAfter). Blows on nodes with little mass, which points hardly see, do not
/// count as work. ahead: what AdvanceContactNodes has put into `rates`.
double WorkOnPoints(const Grid &grid, const std::vector<NodeChange> &contact_nodes, const std::map<std::ptrdiff_t, double> &ahead,
                    bool spread);

// What follows is done to owned nodes and ghosts, of which all ranks have the same sums; budgets count owned nodes.

/// Of owned nodes at the start of the step, the part that points of this level have in them, J.
double KineticEnergy(const Grid &grid, const NodalSettings &settings);

/// Adds gravity and damping, m g - damping p, to the nodal forces f; v = p/m + dt f/m; velocity := (v, dv).
void UpdateVelocities(const Grid &grid, const NodalSettings &settings, double dt);

/// Holds the velocities of nodes at the sides, adding up the impulse on the body and its work, force times speed. held: by how
/// much the velocities of owned nodes change.
void ApplyBoundaryConditions(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, Budgets &budgets);

/// Adds up the impulses of gravity and damping, and their work with the mean velocity of the step, after sides and contact.
void AddBodyWork(const Grid &grid, const NodalSettings &settings, double dt, Budgets &budgets);

/// rates := p/m from `sums`, for a strain update before the forces (USF).
void VelocitiesFromSums(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings);

/// What the second velocities of a level's nodes take beside sums.
struct SecondVelocityPlan {
  const std::vector<std::ptrdiff_t> &held;      ///< places where the second velocity is the new one
  const std::vector<std::ptrdiff_t> &following; ///< where it is the new one and what the second extrapolation would change of it
  double xpic;                                  ///< share of XPIC in the step
};

/// Makes velocities of what points have spread into `rates`: the second one, MomentumAfter over the mass, and for XPIC the mean
/// of the points' velocities; at sides those that these hold. Adds up the impulse of sides on the velocities that XPIC projects.
void DivideRates(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, const SecondVelocityPlan &plan,
                 Budgets &budgets);

/// Makes of the means, on all nodes with those that hang on others, the projected velocity (2 v - mean for XPIC of order 2, v for
/// order 1). The second velocity takes part in XPIC as the points' velocities do.
void FinishRates(const Grid &grid, const NodalSettings &settings, const SecondVelocityPlan &plan);

} // namespace mlgimp
