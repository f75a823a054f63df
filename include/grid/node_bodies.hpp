// Which bodies a node has points of: where bodies can part, no light node hangs on nodes of another one.
#pragma once

#include "grid/grid.hpp"
#include "physics/point_fields.hpp"

#include <cstdint>
#include <vector>

namespace mlgimp
{

class NodeBodies
{
public:
  /// groups: of each body, the number of those that touch at the start, which the grid holds together for good.
  void SetGroups(std::vector<int> groups);
  /// Finds those of all local nodes, for whose points each of `stores` is. Does nothing where all bodies are one group.
  /// Collective on the grid's ranks.
  PetscErrorCode Find(Grid &grid, const std::vector<PointArrays> &stores);
  /// False where two nodes have points of different bodies alone; places as in the grid.
  bool MayShare(std::ptrdiff_t a, std::ptrdiff_t b) const
  {
    return bits_.empty() || bits_[a] == 0 || bits_[b] == 0 || (bits_[a] & bits_[b]) != 0;
  }

private:
  void Mark(const NodePartition &nodes, const PointArrays &points, int p);

  std::vector<int> groups_;
  std::vector<std::uint32_t> bits_; ///< by place: one for each group, which those beyond the 32nd share; empty for one group
};

} // namespace mlgimp
