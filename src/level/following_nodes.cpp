// Blended nodes near the indenter.
#include "level/following_nodes.hpp"

#include <cmath>

namespace mlgimp
{

void FollowingNodes::Find(const NodePartition &nodes, const CoupledPlaces &coupled, const LightNodes &light,
                          const Indenter &indenter, Vec3 tip)
{
  const GridGeometry &grid = nodes.Geometry();
  const double moved = Norm(tip - tip_);
  tip_ = tip;
  off_.resize(coupled.blended.size(), -HUGE_VAL);
  places_.clear();
  for (std::size_t k = 0; k < off_.size(); ++k) {
    const Index node = coupled.blended[k];
    if ((off_[k] -= moved) > coupled.reach) continue;
    const Vec3 x{grid.Coordinate(0, node[0]), grid.Coordinate(1, node[1]), grid.Coordinate(2, node[2])};
    const std::ptrdiff_t place = nodes.Place(node);
    off_[k] = indenter.Gap(x, tip).distance;
    if (!light.IsLight(place) && off_[k] < coupled.reach) places_.push_back(place);
  }
}

} // namespace mlgimp
