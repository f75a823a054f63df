// Bodies of nodes, point by point.
#include "grid/node_bodies.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

void NodeBodies::SetGroups(std::vector<int> groups)
{
  groups_ = std::move(groups);
  const bool one = std::all_of(groups_.begin(), groups_.end(), [&](int group) { return group == groups_.front(); });
  if (one) groups_.clear(), bits_.clear();
}

/// The nodes within a cell and half the point's size.
void NodeBodies::Mark(const NodePartition &nodes, const PointArrays &points, int p)
{
  constexpr int kBits = 32; // size
  IndexBox around{{}, {1, 1, 1}};
  for (int axis = 0; axis < points.dim; ++axis) {
    const double h = nodes.Geometry().spacing, place = (points.Position(p)[axis] - nodes.Geometry().lower[axis]) / h,
                 reach = 1 + std::min(CurrentHalfSize(points, p, axis) / h, kMaxHalfSize);
    if (!std::isfinite(place)) return; // a point that has failed
    around.lower[axis] = static_cast<int>(std::floor(place - reach)) + 1;
    around.upper[axis] = static_cast<int>(std::ceil(place + reach));
  }
  const std::uint32_t bit = std::uint32_t(1) << groups_[points.body[p]] % kBits;
  ForEach(Intersection(around, nodes.Ghosted()), [&](Index node) { bits_[nodes.Place(node)] |= bit; });
}

PetscErrorCode NodeBodies::Find(Grid &grid, const std::vector<PointArrays> &stores)
{
  std::vector<std::vector<double>> outgoing(grid.Halo().Neighbours()), incoming;
  PetscFunctionBeginUser;
  if (groups_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  bits_.assign(grid.Ghosted().Count(), 0);
  for (const PointArrays &points : stores)
    for (int p = 0; p < points.count; ++p) Mark(grid.Nodes(), points, p);
  ForEach(grid.Ghosted(), [&](Index node) {
    const std::uint32_t bits = bits_[grid.Place(node)];
    if (bits == 0) return;
    grid.Nodes().ForEachCopy(node, [&](std::size_t rank, std::ptrdiff_t place) {
      outgoing[rank].insert(outgoing[rank].end(), {static_cast<double>(place), static_cast<double>(bits)});
    });
  });
  PetscCall(grid.Halo().Send(outgoing, &incoming));
  for (const std::vector<double> &message : incoming)
    for (std::size_t k = 0; k < message.size(); k += 2)
      bits_[static_cast<std::size_t>(message[k])] |= static_cast<std::uint32_t>(message[k + 1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
