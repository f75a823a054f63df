// The nodes that contact pushes: their masses and velocities, what sides leave of a push, and the push itself.
#pragma once

#include "contact/border_nodes.hpp"
#include "contact/contact.hpp"
#include "contact/group.hpp"
#include "grid/light_nodes.hpp"
#include "grid/nodes.hpp"

namespace mlgimp
{

/// A level's nodes in a step, after sides were applied. The state must be final on owned nodes; of ghosts nothing is known.
class NodeMotion
{
public:
  /// mass_cutoff: nodes with less are empty, kg. border: to the next coarser level, or null. shared: by place, nodes that also
  /// move the next finer level's, or null.
  NodeMotion(const Grid &grid, const BoundaryConditions &sides, const LightNodes &light, double mass_cutoff,
             const ContactGroup &group, BorderNodes *border, SharedNode *shared)
      : grid_(grid), sides_(sides), light_(light), mass_cutoff_(mass_cutoff), group_(group), border_(border), shared_(shared)
  {
  }

  const Grid &Mesh() const { return grid_; }
  const BoundaryConditions &Sides() const { return sides_; }
  const LightNodes &Light() const { return light_; }
  const ContactGroup &Group() const { return group_; }
  BorderNodes *Border() const { return border_; }
  /// The rank in the group, or -1 outside of it.
  PetscMPIInt OwnerOf(Index node) const { return group_.RankOf(grid_.Nodes().BlockOf(node)); }
  bool IsEmpty(double mass) const { return mass <= mass_cutoff_; }
  /// Mass of the points of this level, and of the next finer one where there are both, kg.
  double MassOf(Index node) const;
  /// Of the motion that points will be moved by, m/s.
  Vec3 VelocityOf(Index node) const;
  /// The part of a change of velocity that the sides leave.
  Vec3 FreePart(Index node, Vec3 change) const;
  /// Adds an impulse on an owned node, N s: the change of (v, dv) that the sides leave of it, and both impulses.
  void Push(Index node, Vec3 impulse, ContactReport *report) const;

private:
  const Grid &grid_;
  const BoundaryConditions &sides_;
  const LightNodes &light_;
  double mass_cutoff_;
  const ContactGroup &group_;
  BorderNodes *border_;
  SharedNode *shared_;
};

} // namespace mlgimp
