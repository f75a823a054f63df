// The nodes that contact pushes, brought to the group's first rank, and the impulses on their way back.
#pragma once

#include "contact/node_motion.hpp"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// A number for a node of a level or of the next coarser one, rising with its place.
inline std::uint64_t NodeKey(Index node, bool coarser)
{
  constexpr std::uint64_t kMiddle = 1 << 20; // size: indices have 21 bits
  std::uint64_t key = 0;
  for (int a = 2; a >= 0; --a) key = key << 21 | (static_cast<std::uint64_t>(node[a]) + kMiddle);
  return key << 1 | (coarser ? 1 : 0);
}

/// What contact knows of a node, by its owner.
struct NodeState {
  Index at;
  int coarser;         ///< 1 for a node of the next coarser level
  PetscMPIInt rank;    ///< of the group, that owns it
  double mass;         ///< that an impulse moves; 0 where it has no motion of its own, kg
  double own;          ///< of its motion that does not hang on other nodes of its level, see LightNodes
  bool moves;          ///< has points
  double share;        ///< of its motion that is its own, beta of border_nodes.hpp
  Vec3 free, velocity; ///< 1 along axes that no side holds; before contact, m/s
};

/// A part of a light node's motion that hangs on another of its level.
struct NodeLink {
  Index node, on;
  int coarser; ///< 1 of nodes of the next coarser level
  double weight;
};

/// The nodes that some segments or points push, on one rank. Light ones hang on fuller ones, and those near a border on nodes of
/// the coarser level.
class ContactNodes
{
public:
  /// Brings the states of some nodes of each rank, and of those that they hang on, to the first rank of the group; empty on
  /// others. Collective on the group.
  PetscErrorCode Gather(const NodeMotion &motion, const std::vector<Index> &nodes);

  int Size() const { return static_cast<int>(states_.size()); }
  const NodeState &At(int number) const { return states_[number]; }
  /// The number of a node of this level; -1 of one that no rank of the group has.
  int NumberOf(Index node) const
  {
    const auto found = number_.find(NodeKey(node, false));
    return found == number_.end() ? -1 : found->second;
  }

  /// Impulses, or forces, in place of which comes what they move, u_i <- dt^2 J_i/m_i along free axes, also of nodes that hang on
  /// others.
  void Move(double dt, std::vector<Vec3> *u) const;
  /// About what a unit force on each node moves itself by, m/N.
  std::vector<Vec3> Mobility(double dt) const;
  /// Gives the nodes that others hang on their parts of impulses, and leaves these their own.
  void Restrict(std::vector<Vec3> *u) const;
  /// Whether some nodes hang on others.
  bool AreAtBorder() const { return !at_border_.empty(); }

  /// Sends impulses, of which tractions have given a part, to the ranks that own the nodes, which change velocities by them. On
  /// the first rank [nodes] N s, after Restrict. Collective on the group.
  PetscErrorCode Push(const NodeMotion &motion, const std::vector<Vec3> &impulses, const std::vector<Vec3> &of_friction,
                      ContactReport *report) const;

private:
  struct Hanging {
    int node, on;
    double weight;
  };
  PetscErrorCode GatherStates(const NodeMotion &motion, const std::vector<Index> &nodes, std::vector<NodeLink> *links);
  std::vector<NodeState> states_;
  std::unordered_map<std::uint64_t, int> number_;
  void RestrictLight(const std::vector<Hanging> &light, int coarser, std::vector<Vec3> *u) const;
  void ProlongLight(const std::vector<Hanging> &light, int coarser, std::vector<Vec3> *u) const;
  std::vector<Hanging> light_, light_coarser_, at_border_;
};

} // namespace mlgimp
