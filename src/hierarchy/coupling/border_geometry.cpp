// Depths, weights and boxes of nodes at the border of two levels.
#include "hierarchy/coupling/border_geometry.hpp"

#include <algorithm>
#include <climits>
#include <cmath>

namespace mlgimp
{

static constexpr double kOuterBeta = 0.3; ///< beta just inside the box

static int FloorDivide(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/// Depth of a fine node inside the box, in fine cells; sides of the domain do not count.
int BorderGeometry::Depth(Index node) const
{
  int depth = INT_MAX;
  for (int s = 0; s < 2 * Dim(); ++s) {
    const int axis = s / 2;
    if (fine_.border[s]) depth = std::min(depth, s % 2 ? fine_.grid.cells[axis] - node[axis] : node[axis]);
  }
  return depth;
}

double BorderGeometry::Beta(Index node) const
{
  const double depth = Depth(node), width = blend_width_ * ratio_;
  return depth <= 0 ? 0 : depth >= width ? 1 : kOuterBeta + (1 - kOuterBeta) * depth / width;
}

NodeBlend BorderGeometry::BlendOf(Index node) const
{
  NodeBlend blend{Beta(node), 0, {}, {}};
  if (blend.beta == 1) return blend;
  const Index offset = Offset();
  ForEach({{}, {2, 2, Dim() == 3 ? 2 : 1}}, [&](Index corner) {
    Index coarse{};
    double weight = 1;
    for (int axis = 0; axis < Dim(); ++axis) {
      const int below = FloorDivide(node[axis], ratio_);
      const double x = static_cast<double>(node[axis] - below * ratio_) / ratio_;
      coarse[axis] = below + corner[axis] + offset[axis];
      weight *= corner[axis] ? x : 1 - x;
    }
    if (weight == 0) return;
    blend.node[blend.count] = coarse;
    blend.weight[blend.count++] = weight;
  });
  return blend;
}

IndexBox BorderGeometry::MassNodes() const
{
  IndexBox nodes = fine_.grid.NodeBox();
  for (int axis = 0; axis < Dim(); ++axis) {
    if (!fine_.border[2 * axis]) nodes.lower[axis] = -1;
    if (!fine_.border[2 * axis + 1]) nodes.upper[axis] = fine_.grid.cells[axis] + 2;
  }
  return nodes;
}

Index BorderGeometry::Offset() const
{
  Index offset{};
  for (int axis = 0; axis < Dim(); ++axis)
    offset[axis] = static_cast<int>(std::lround((fine_.grid.lower[axis] - coarse_.lower[axis]) / coarse_.spacing));
  return offset;
}

Index BorderGeometry::FineNodeAt(Index coarse) const
{
  const IndexBox all = fine_.grid.NodeBox();
  const Index offset = Offset();
  Index at{};
  for (int axis = 0; axis < Dim(); ++axis)
    at[axis] = std::clamp((coarse[axis] - offset[axis]) * ratio_, all.lower[axis], all.upper[axis] - 1);
  return at;
}

bool BorderGeometry::IsInterface(Index node) const
{
  const Index from = node - Offset();
  IndexBox hat{{}, {1, 1, 1}};
  for (int axis = 0; axis < Dim(); ++axis)
    hat.lower[axis] = (from[axis] - 1) * ratio_ + 1, hat.upper[axis] = (from[axis] + 1) * ratio_;
  hat = Intersection(hat, MassNodes());
  if (hat.Empty()) return false;
  const int depth = std::min(Depth(hat.lower), Depth(hat.upper - Index{1, 1, 1})); // of a box, at its corners
  return depth < blend_width_ * ratio_;
}

IndexBox BorderGeometry::Around() const
{
  const Index offset = Offset();
  const int reach = (fine_.grid.padding + ratio_ - 1) / ratio_;
  IndexBox around{{}, {1, 1, 1}};
  for (int axis = 0; axis < Dim(); ++axis) {
    around.lower[axis] = offset[axis] - reach;
    around.upper[axis] = offset[axis] + fine_.grid.cells[axis] / ratio_ + reach + 1;
  }
  return Intersection(around, coarse_.NodeBox());
}

std::size_t BorderGeometry::Count() const
{
  std::size_t count = 0;
  ForEachInterface(Around(), [&](Index) { ++count; });
  return count;
}

} // namespace mlgimp
