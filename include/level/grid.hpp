// The background grid of one level: a DMDA as index space, ghosted nodal arrays, and their halo by a PetscSF.
//
// The grid reaches `padding` nodes beyond its box on every side, so that a point at a side finds all its nodes.
#pragma once

#include "base/handle.hpp"
#include "base/tensor.hpp"
#include "pointwise/point_fields.hpp"
#include "pointwise/shape.hpp"

#include <vector>

namespace mlgimp
{

/// Where a grid lies and what bounds it.
struct GridGeometry {
  Vec3 lower;     ///< position of node (0, 0) of the box, m
  double spacing; ///< h, m
  int cells[2];   ///< of the box
  int padding;    ///< layers of nodes beyond the box
  int Nodes(int axis) const { return cells[axis] + 1 + 2 * padding; }
};

/// How a grid is divided: number of nodes of every column and row of blocks, along x and y, and the rank that holds
/// each block, row by row. Ranks without a block take no part in the level's steps.
struct GridLayout {
  std::array<std::vector<PetscInt>, 2> widths;
  std::vector<PetscMPIInt> ranks; ///< of the communicator of all levels
  int Blocks() const { return static_cast<int>(widths[0].size() * widths[1].size()); }
};

/// Nodal arrays on the ghosted index space; the components of a node lie together.
struct NodeArrays {
  /// Sums over points: mass, momentum (2), mass of owned points (no copies), force (2), power-giving external force (2).
  static constexpr int kSums = 8;
  /// New velocity (2) and its change in the step (2).
  static constexpr int kVelocity = 4;
  /// Momentum or velocity of the second extrapolation (2), of the projection for XPIC (2), strain rate xx, yy, xy, -.
  static constexpr int kRates = 8;
  double *sums, *velocity, *rates;
};

/// Memory of nodal arrays: with 64-byte alignment no node lies across two cache lines, which PETSc's 16 bytes allow.
struct alignas(64) CacheLine {
  double values[8];
};

/// A nodal array and the local vector that shows it to PETSc.
struct NodalField {
  std::vector<CacheLine> memory;
  VecHandle vector;
};

class Grid
{
public:
  Grid() = default;
  Grid(const Grid &) = delete;
  Grid &operator=(const Grid &) = delete;
  ~Grid();

  /// Collective on `world`. On ranks without a block the grid knows where it lies, but has no nodes.
  PetscErrorCode Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout);

  const GridGeometry &Geometry() const { return geometry_; }
  const GridLayout &Layout() const { return layout_; }
  const Lattice<2> &IndexSpace() const { return lattice_; }
  const NodeArrays &Arrays() const { return arrays_; }
  /// The ranks with a block, ordered by block; null on others.
  MPI_Comm Comm() const { return comm_; }
  bool Participates() const { return comm_ != MPI_COMM_NULL; }

  /// Owned nodes as half-open ranges of box indices (the padding is negative or beyond the cells).
  int OwnedLower(int axis) const { return owned_lower_[axis]; }
  int OwnedUpper(int axis) const { return owned_upper_[axis]; }
  /// Place of the node with box indices (i, j) in the ghosted arrays; it must be owned or a ghost.
  int Index(int i, int j) const { return (j - ghost_lower_[1]) * ghost_size_[0] + i - ghost_lower_[0]; }
  bool IsLocal(int i, int j) const
  {
    return i >= ghost_lower_[0] && i < ghost_lower_[0] + ghost_size_[0] && j >= ghost_lower_[1] &&
           j < ghost_lower_[1] + ghost_size_[1];
  }
  bool Owns(int i, int j) const { return i >= OwnedLower(0) && i < OwnedUpper(0) && j >= OwnedLower(1) && j < OwnedUpper(1); }
  /// False where one rank has the whole grid.
  bool HasGhosts() const { return layout_.Blocks() > 1; }
  int OwnedNodes() const { return (OwnedUpper(0) - OwnedLower(0)) * (OwnedUpper(1) - OwnedLower(1)); }
  int GhostedNodes() const { return ghost_size_[0] * ghost_size_[1]; }
  int GhostLower(int axis) const { return ghost_lower_[axis]; }
  int GhostSize(int axis) const { return ghost_size_[axis]; }
  double Coordinate(int axis, int index) const { return geometry_.lower[axis] + index * geometry_.spacing; }
  /// Box index of the node nearest to x along an axis.
  int Nearest(int axis, double x) const
  {
    return static_cast<int>(std::floor((x - geometry_.lower[axis]) / geometry_.spacing + 0.5));
  }
  /// The block that holds node (i, j), which is also its owner's rank in Comm(); -1 outside the grid.
  int BlockOfNode(int i, int j) const;
  /// The owner's rank among all ranks; -1 outside the grid.
  PetscMPIInt OwnerOfNode(int i, int j) const;
  /// Place of node (i, j) in the ghosted arrays of the owner of `block`.
  int IndexInBlock(int block, int i, int j) const;

  /// Adds the ghosts' values to their owners (kSums or kRates components a node).
  PetscErrorCode ReduceToOwners(double *array);
  /// Copies the owners' values to the ghosts.
  PetscErrorCode Broadcast(double *array, int components);

  /// The values of a node: kVelocity or kSums components.
  MPI_Datatype Unit(int components) const { return components == NodeArrays::kVelocity ? unit4_ : unit8_; }

private:
  PetscErrorCode CreateArrays();
  PetscErrorCode CreateField(DM nodes, int components, NodalField *field, double **array);
  PetscErrorCode CreateHalo();

  MPI_Comm comm_ = MPI_COMM_NULL;
  GridGeometry geometry_{};
  GridLayout layout_;
  Lattice<2> lattice_{};
  NodeArrays arrays_{};
  DMHandle nodes8_, nodes4_;
  NodalField sums_, velocity_, rates_;
  SFHandle halo_;
  MPI_Datatype unit4_ = MPI_DATATYPE_NULL, unit8_ = MPI_DATATYPE_NULL;
  int owned_lower_[2]{}, owned_upper_[2]{}, ghost_lower_[2]{}, ghost_size_[2]{};
  std::vector<int> starts_[2]; ///< first node of each column and row of blocks, then the end, as box indices
};

/// Divides `count` nodes into `parts` ranges of about equal total weight, each at least `minimum` nodes wide.
/// weights [count]: points per node column. Needs count >= parts * minimum.
std::vector<PetscInt> DivideByWeight(const std::vector<double> &weights, int parts, int minimum);

/// Ghost nodes a step needs: the stencil's reach of one, a point's drift of less than one cell between migrations, and
/// one for a face, which lies up to half a cell from its point.
inline constexpr int kHaloWidth = 3;

} // namespace mlgimp
