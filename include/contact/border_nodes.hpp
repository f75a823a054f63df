// What contact asks of a border, where nodes of a level move with those of the next coarser one.
//
// Node i of the finer level has the velocity beta_i u_i + (1 - beta_i) sum_I N_I(x_i) v_I, so an impulse J on it acts on the mass
// of its own in proportion to beta_i, and on the coarser nodes I in proportion to (1 - beta_i) N_I(x_i).
#pragma once

#include "base/index.hpp"
#include "grid/nodes.hpp"

#include <functional>
#include <vector>

namespace mlgimp
{

/// What a node of the finer level hangs on.
struct NodeBlend {
  double beta = 1;  ///< the part that is its own
  int count = 0;    ///< of coarser nodes with a weight
  Index node[8];    ///< on the coarser grid
  double weight[8]; ///< N_I(x_i)
};

/// A node of the coarser level that also moves nodes of the finer one. Doubles throughout.
struct SharedNode {
  double finer_mass = 0;       ///< of the finer level's points on it, kg
  Vec3 finer_contact_change{}; ///< change of its velocity by contact on the finer level in the step, m/s
  Vec3 impulse{};              ///< of contact on its own level, N s: that of the step before, then that of the step
};

/// The border of a level to the next coarser one, as its contact sees it.
class BorderNodes
{
public:
  virtual ~BorderNodes() = default;
  /// Of any node of the finer grid; it depends on its place alone.
  virtual NodeBlend BlendOf(Index node) const = 0;
  /// The rank of the finer level that advances a coarser node.
  virtual int BlockOf(Index coarse) const = 0;

  /// Calls work(node, weight) for the coarser nodes that the motion of one of them hangs on where it is light, itself among them.
  /// Of those that this rank's nodes hang on.
  using DonorWork = std::function<void(Index, double)>;
  virtual void ForEachDonor(Index coarse, const DonorWork &work) const = 0;

  // Of coarser nodes that this rank advances.
  virtual double MassOf(Index coarse) const = 0;                ///< of the points of both levels, kg; 0 beyond the grid
  virtual Vec3 FreePart(Index coarse, Vec3 change) const = 0;   ///< what sides leave of a change of velocity
  virtual void Push(Index coarse, Vec3 change_of_velocity) = 0; ///< takes effect in Spread
  /// Applies the pushes to the coarser nodes and to the finer nodes that hang on them, and adds the latter's changes to `pushed`.
  /// Collective on the finer level's ranks.
  virtual PetscErrorCode Spread(std::vector<NodeChange> *pushed) = 0;
};

} // namespace mlgimp
