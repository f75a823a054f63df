// Nodes in the band of a border beside the indenter, at which strain follows the motion of the nodes.
#pragma once

#include "grid/light_nodes.hpp"
#include "grid/nodes.hpp"
#include "physics/indenter.hpp"

#include <vector>

namespace mlgimp
{

class FollowingNodes
{
public:
  /// The blended nodes nearer to the indenter than CoupledPlaces::reach, with its tip there. Their places alone decide, so that
  /// ranks, and runs that go on, find the same ones.
  void Find(const NodePartition &nodes, const CoupledPlaces &coupled, const LightNodes &light, const Indenter &indenter,
            Vec3 tip);
  /// Forgets them: other nodes are coupled from now on.
  void Clear() { off_.clear(), places_.clear(); }
  const std::vector<std::ptrdiff_t> &Places() const { return places_; }

private:
  std::vector<double> off_; ///< that blended nodes are at least off the indenter with its tip there, m
  Vec3 tip_{};
  std::vector<std::ptrdiff_t> places_;
};

} // namespace mlgimp
