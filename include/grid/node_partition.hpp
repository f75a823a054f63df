// Which rank holds which nodes of a grid, and where a rank has them in its arrays.
#pragma once

#include "base/handle.hpp"
#include "grid/grid_geometry.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace mlgimp
{

/// How a grid is divided: number of nodes of every layer of blocks along each axis, and the rank that holds each block, the
/// first axis fastest. Ranks without a block take no part in the level's steps.
struct GridLayout {
  std::array<std::vector<PetscInt>, 3> widths{{{}, {}, {1}}};
  std::vector<PetscMPIInt> ranks; ///< of the communicator of all levels
  int Blocks() const { return static_cast<int>(widths[0].size() * widths[1].size() * widths[2].size()); }
};

/// Ghost nodes a step needs: the stencil's reach of one, a point's drift of less than one cell between migrations, and
/// one for a face, which lies up to half a cell from its point.
inline constexpr int kHaloWidth = 3; // size

/// The nodes of a grid in blocks, one on each rank that takes part. Nodes go by their box indices: the padding is negative or
/// beyond the cells.
class NodePartition
{
public:
  /// Another block that has nodes of this rank too.
  struct Neighbour {
    int block;
    IndexBox nodes; ///< that it has, with its ghosts
  };

  /// Collective on `world`. Ranks without a block know where the grid lies and who has its nodes, but have none.
  PetscErrorCode Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout);

  const GridGeometry &Geometry() const { return geometry_; }
  const GridLayout &Layout() const { return layout_; }
  /// The ranks with a block, ordered by block; null on others.
  MPI_Comm Comm() const { return comm_; }
  bool Participates() const { return comm_ != MPI_COMM_NULL; }
  /// Where the level's points live: points that change levels lie for a moment on ranks without a part of the grid, too.
  MPI_Comm PointsComm() const { return Participates() ? Comm() : PETSC_COMM_SELF; }
  /// The same nodes for PETSc, with room for what its viewers show of each; null on ranks without a block.
  DM DistributedArray() const { return array_; }

  /// The nodes of this rank, and with its ghosts.
  const IndexBox &Owned() const { return owned_; }
  const IndexBox &Ghosted() const { return ghosted_; }
  /// The nodes that the owner of a block has, with its ghosts, in the order of its arrays.
  IndexBox GhostedOf(int block) const;
  /// False where one rank has the whole grid.
  bool HasGhosts() const { return layout_.Blocks() > 1; }
  /// Place of a local node in the arrays.
  std::ptrdiff_t Place(Index node) const { return ghosted_.Place(node); }

  /// The block that holds a node, which is also its owner's rank in Comm(); -1 outside the grid.
  int BlockOf(Index node) const;
  /// The blocks that hold nodes of a box, or lie nearest to it, in their order.
  std::vector<int> BlocksIn(const IndexBox &box) const;
  /// The owner's rank among all ranks; -1 outside the grid.
  PetscMPIInt OwnerOf(Index node) const;

  /// Ordered by block.
  const std::vector<Neighbour> &Neighbours() const { return neighbours_; }
  /// Calls work(k, place) for each neighbour that has a local node too: its number among the neighbours, and the node's place in
  /// its arrays.
  template <class Work> void ForEachCopy(Index node, Work work) const
  {
    for (std::size_t k = 0; k < neighbours_.size(); ++k)
      if (neighbours_[k].nodes.Contains(node)) work(k, neighbours_[k].nodes.Place(node));
  }

private:
  PetscErrorCode CreateArray();
  void FindNeighbours();

  CommHandle comm_;
  GridGeometry geometry_{};
  GridLayout layout_;
  std::array<std::vector<int>, 3> starts_; ///< first node of each layer of blocks, then the end, as box indices
  DMHandle array_;
  IndexBox owned_, ghosted_;
  std::vector<Neighbour> neighbours_;
};

} // namespace mlgimp
