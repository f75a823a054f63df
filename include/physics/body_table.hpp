// Which material the points of each body have.
#pragma once

#include "base/rows.hpp"
#include "physics/material.hpp"
#include "physics/point_fields.hpp"

#include <algorithm>
#include <vector>

namespace mlgimp
{

/// Bodies as the sweeps see them: the material of each, and which of the materials that average their volume it is, or -1.
struct BodyTable {
  std::vector<const Material *> material;
  std::vector<int> average;
  bool one_material = false; ///< all bodies have the same

  /// A body of the material of a point. With one material memory is left alone: no sweep needs the bodies otherwise.
  int BodyFor(const PointArrays &points, int p) const { return one_material ? 0 : points.body[p]; }
  const Material &Of(const PointArrays &points, int p) const { return *material[BodyFor(points, p)]; }
  /// End of the block that begins at a point: at most kBlock points of one material.
  int BlockEnd(const PointArrays &points, int start) const
  {
    const int limit = std::min(start + kBlock, points.count);
    if (one_material) return limit;
    int end = start + 1;
    while (end < limit && material[points.body[end]] == material[points.body[start]]) ++end;
    return end;
  }
};

} // namespace mlgimp
