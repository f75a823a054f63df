// The nodes that couple two levels: which rank advances each, which others know it, and how their values travel.
#pragma once

#include "base/handle.hpp"
#include "grid/nodes.hpp"
#include "hierarchy/coupling/border_geometry.hpp"
#include "hierarchy/partition/mapping.hpp"

#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// A fine node with beta < 1 and the interface nodes it hangs on.
struct BlendNode {
  std::ptrdiff_t node; ///< place in the fine level's ghosted arrays
  double beta;
  int count;        ///< of interface nodes with a weight
  int interface[8]; ///< their numbers
  double weight[8]; ///< N_I(x_i)
};

/// Nodes of this rank that the border acts on.
struct CoupledOfBorder {
  std::vector<std::ptrdiff_t> coarse;      ///< interface nodes that it owns on the coarse level
  std::vector<std::ptrdiff_t> held_coarse; ///< interface nodes with ghosts, whose velocity the border makes
  std::vector<std::ptrdiff_t> fine;        ///< of the band, in its order
  CoupledPlaces fine_places;
};

/// Each rank of the finer level numbers the interface nodes that it advances, its owned ones, then others that it knows as its
/// band or light nodes hang on them.
class InterfaceNodes
{
public:
  /// All are kept by reference. coarse_sides: of the domain, on the coarse grid. Collective on `world`.
  PetscErrorCode Create(MPI_Comm world, const BorderGeometry &border, const NodePartition &coarse,
                        const BoundaryConditions &coarse_sides, const NodePartition &fine);

  int Owned() const { return owned_; }
  int Known() const { return static_cast<int>(known_.size()); }
  /// Of a known one: its index on the coarse grid.
  Index At(int k) const { return known_[k].at; }
  /// Its number, -1 where this rank does not know it.
  int Find(Index at) const
  {
    const auto found = place_.find(at);
    return found == place_.end() ? -1 : found->second;
  }
  /// Whether a side of the domain holds a component of an owned one's velocity.
  bool IsHeld(int k, int axis) const { return held_axes_[k] >> axis & 1; }
  /// The block of the finer level that advances the node at an index of the coarse grid.
  int BlockOf(Index coarse) const { return fine_->BlockOf(border_->FineNodeAt(coarse)); }
  /// Owned fine nodes with beta < 1.
  const std::vector<BlendNode> &Band() const { return band_; }
  const CoupledOfBorder &Coupled() const { return coupled_; }

  /// Values of the coarse grid's nodes, by place, to owned interface nodes. Collective on all.
  PetscErrorCode ToInterface(MPI_Datatype unit, const void *coarse, void *interface) const;
  /// Values of owned interface nodes to those of the coarse grid's owners, by place. Collective on all.
  PetscErrorCode ToCoarse(MPI_Datatype unit, const void *interface, void *coarse) const;
  /// Values of owned ones, [known], to the other ranks that know them. Collective on the finer level's ranks.
  PetscErrorCode Broadcast(MPI_Datatype unit, void *values) const;
  /// Adds what other ranks have in their known ones to the owners' values. Collective on the finer level's ranks.
  PetscErrorCode AddUp(MPI_Datatype unit, void *values) const;
  /// Adds what the blocks of the two levels exchange in a coarse step, times a factor; `level` is that of the coarser one. The
  /// same on all ranks. Collective on all.
  PetscErrorCode AddTraffic(int level, double factor, std::vector<BlockTraffic> *traffic) const;

private:
  /// An interface node by its index on the coarse grid, the fine block that advances it and its number there.
  struct Node {
    Index at;
    int block, place;
  };

  void ListOwned();
  void ListBand();
  void ListBesideLight();
  void ListHeldAxes(const BoundaryConditions &coarse_sides);
  BlendNode Blend(Index node);
  int Know(Index at);
  PetscErrorCode FindPlaces();
  PetscErrorCode CreateCopies();
  PetscErrorCode CreateTransfer();

  MPI_Comm world_ = MPI_COMM_NULL;
  const BorderGeometry *border_ = nullptr;
  const NodePartition *coarse_ = nullptr, *fine_ = nullptr;
  std::vector<Node> known_; ///< the owned ones first
  int owned_ = 0;
  std::unordered_map<Index, int, IndexHash> place_; ///< in known_
  std::vector<BlendNode> band_;
  std::vector<unsigned char> held_axes_; ///< [owned] bit per axis
  CoupledOfBorder coupled_;
  SFHandle copies_;   ///< owned ones to other ranks that know them
  SFHandle transfer_; ///< coarse nodes to owned ones
};

} // namespace mlgimp
