// Blocks of nodes by the layers that they lie in.
#include "grid/node_partition.hpp"

#include "grid/nodal_arrays.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode NodePartition::Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout)
{
  PetscFunctionBeginUser;
  geometry_ = geometry;
  layout_ = layout;
  for (int axis = 0; axis < 3; ++axis) {
    starts_[axis] = {-geometry.Padding(axis)};
    for (PetscInt width : layout.widths[axis]) starts_[axis].push_back(starts_[axis].back() + width);
  }
  const auto place = std::find(layout.ranks.begin(), layout.ranks.end(), RankIn(world));
  const bool participates = place != layout.ranks.end();
  PetscCallMPI(
      MPI_Comm_split(world, participates ? 0 : MPI_UNDEFINED, static_cast<int>(place - layout.ranks.begin()), comm_.Out()));
  if (!participates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateArray());
  FindNeighbours();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NodePartition::CreateArray()
{
  const auto &widths = layout_.widths;
  PetscInt start[3], size[3];
  PetscFunctionBeginUser;
  PetscCall(DMDACreate(comm_, array_.Out()));
  PetscCall(DMSetDimension(array_, geometry_.dim));
  PetscCall(DMDASetSizes(array_, geometry_.Nodes(0), geometry_.Nodes(1), geometry_.Nodes(2)));
  PetscCall(DMDASetNumProcs(array_, static_cast<PetscInt>(widths[0].size()), static_cast<PetscInt>(widths[1].size()),
                            static_cast<PetscInt>(widths[2].size())));
  PetscCall(DMDASetOwnershipRanges(array_, widths[0].data(), widths[1].data(), widths[2].data()));
  PetscCall(DMDASetDof(array_, NodeLayout::Viewed(geometry_.dim)));
  PetscCall(DMDASetStencilType(array_, DMDA_STENCIL_BOX));
  PetscCall(DMDASetStencilWidth(array_, kHaloWidth));
  PetscCall(DMSetUp(array_));
  const auto to_box = [&](const PetscInt *first, const PetscInt *count) {
    IndexBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = axis < geometry_.dim ? first[axis] - geometry_.padding : 0;
      box.upper[axis] = axis < geometry_.dim ? box.lower[axis] + count[axis] : 1;
    }
    return box;
  };
  PetscCall(DMDAGetCorners(array_, &start[0], &start[1], &start[2], &size[0], &size[1], &size[2]));
  owned_ = to_box(start, size);
  PetscCall(DMDAGetGhostCorners(array_, &start[0], &start[1], &start[2], &size[0], &size[1], &size[2]));
  ghosted_ = to_box(start, size);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void NodePartition::FindNeighbours()
{
  IndexBox near = ghosted_; // with what reaches into it
  for (int axis = 0; axis < geometry_.dim; ++axis) near.lower[axis] -= kHaloWidth, near.upper[axis] += kHaloWidth;
  for (const int block : BlocksIn(near))
    if (block != RankIn(comm_) && !Intersection(ghosted_, GhostedOf(block)).Empty())
      neighbours_.push_back({block, GhostedOf(block)});
}

IndexBox NodePartition::GhostedOf(int block) const
{
  IndexBox nodes;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int> &starts = starts_[axis];
    const int layers = static_cast<int>(starts.size() - 1), layer = block % layers, halo = axis < geometry_.dim ? kHaloWidth : 0;
    block /= layers;
    nodes.lower[axis] = std::max(starts[layer] - halo, starts.front());
    nodes.upper[axis] = std::min(starts[layer + 1] + halo, starts.back());
  }
  return nodes;
}

/// The layer of blocks that a node lies in.
static int LayerOf(const std::vector<int> &starts, int node)
{
  return static_cast<int>(std::upper_bound(starts.begin(), starts.end(), node) - starts.begin()) - 1;
}

int NodePartition::BlockOf(Index node) const
{
  int block = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const std::vector<int> &starts = starts_[axis];
    if (node[axis] < starts.front() || node[axis] >= starts.back()) return -1;
    block = block * static_cast<int>(starts.size() - 1) + LayerOf(starts, node[axis]);
  }
  return block;
}

std::vector<int> NodePartition::BlocksIn(const IndexBox &box) const
{
  std::vector<int> blocks;
  IndexBox layers;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = starts_[axis].front(), last = starts_[axis].back() - 1;
    layers.lower[axis] = LayerOf(starts_[axis], std::clamp(box.lower[axis], first, last));
    layers.upper[axis] = LayerOf(starts_[axis], std::clamp(box.upper[axis] - 1, first, last)) + 1;
  }
  const int rows = static_cast<int>(starts_[1].size()) - 1, columns = static_cast<int>(starts_[0].size()) - 1;
  ForEach(layers, [&](Index at) { blocks.push_back(at[0] + columns * (at[1] + rows * at[2])); });
  return blocks;
}

PetscMPIInt NodePartition::OwnerOf(Index node) const
{
  const int block = BlockOf(node);
  return block < 0 ? -1 : layout_.ranks[block];
}

} // namespace mlgimp
