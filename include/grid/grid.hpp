// The background grid of one level: a DMDA as index space, ghosted nodal arrays, and their halo by a PetscSF.
//
// The grid reaches `padding` nodes beyond its box on every side, so that a point at a side finds all its nodes.
#pragma once

#include "base/handle.hpp"
#include "base/index.hpp"
#include "base/tensor.hpp"
#include "grid/shared_nodes.hpp"
#include "physics/point_fields.hpp"
#include "physics/shape.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace mlgimp
{

/// Where a grid lies and what bounds it. In two dimensions there is one layer of nodes, without cells, along the third axis.
struct GridGeometry {
  Vec3 lower;     ///< position of node (0, 0, 0) of the box, m
  double spacing; ///< h, m
  Index cells;    ///< of the box
  int padding;    ///< layers of nodes beyond the box, along the axes of its dimension
  int dim = 2;

  /// Box index of the node nearest to x.
  int Nearest(int axis, double x) const { return static_cast<int>(std::floor((x - lower[axis]) / spacing + 0.5)); }
  Index Nearest(Vec3 x) const { return {Nearest(0, x[0]), Nearest(1, x[1]), dim == 3 ? Nearest(2, x[2]) : 0}; }
  double Coordinate(int axis, int index) const { return lower[axis] + index * spacing; }
  int Padding(int axis) const { return axis < dim ? padding : 0; }
  int Nodes(int axis) const { return axis < dim ? cells[axis] + 1 + 2 * padding : 1; }
  /// All nodes, by their box indices.
  IndexBox NodeBox() const
  {
    const Index first{-Padding(0), -Padding(1), -Padding(2)};
    return {first, first + Index{Nodes(0), Nodes(1), Nodes(2)}};
  }
};

/// How a grid is divided: number of nodes of every layer of blocks along each axis, and the rank that holds each block, the
/// first axis fastest. Ranks without a block take no part in the level's steps.
struct GridLayout {
  std::array<std::vector<PetscInt>, 3> widths{{{}, {}, {1}}};
  std::vector<PetscMPIInt> ranks; ///< of the communicator of all levels
  int Blocks() const { return static_cast<int>(widths[0].size() * widths[1].size() * widths[2].size()); }
};

/// What a node holds of the points around it: one cache line in every geometry.
struct alignas(64) NodeSums {
  double mass;        ///< kg
  double owned_mass;  ///< of points that this level owns; the others are copies, kg
  double momentum[3]; ///< kg m/s
  double force[3];    ///< internal, of loads and of bodies, N
};
static_assert(sizeof(NodeSums) == 64, "nodal sums travel and load as eight doubles");

/// The new velocity of a node and its change in the step, m/s.
struct NodeVelocity {
  double *velocity, *change; ///< [dim] each
};

/// What a cell holds of the points of a material in it, kg: sums of mass, and of what else is named times mass.
struct CellSums {
  double mass;
  double growth;          ///< of volume, in the step
  double relative_volume; ///< J, at the step's start
};

/// Components of the nodal arrays by dimension. Velocities: as many for the new one as for its change. Rates: momentum or
/// velocity of the second extrapolation, strain rate (xx, yy, xy in the plane, xx, yy, zz, xy in axisymmetry, xx, yy, zz, xy, yz,
/// xz in space), momentum or velocity of the projection for XPIC.
struct NodeLayout {
  static constexpr int kSums = sizeof(NodeSums) / sizeof(double);
  static constexpr int Viewed(int dim) { return 1 + 3 * dim; } ///< of the vector that PETSc's viewers show
  static constexpr int Velocity(int dim) { return dim == 2 ? 4 : 8; }
  static constexpr int Rates(int dim) { return dim == 2 ? 8 : 16; }
  static constexpr int StrainRate(int dim) { return dim; }             ///< place of the strain rate among the rates
  static constexpr int Projected(int dim) { return dim == 2 ? 6 : 9; } ///< place of the projection among them
};

/// Memory of nodal arrays: with 64-byte alignment no node lies across two cache lines.
struct alignas(64) CacheLine {
  double values[8];
};

class Grid
{
public:
  Grid() = default;
  Grid(const Grid &) = delete;
  Grid &operator=(const Grid &) = delete;
  ~Grid();

  /// Collective on `world`. On ranks without a block the grid knows where it lies, but has no nodes. volume_averages: number of
  /// materials that keep sums at the cells.
  PetscErrorCode Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout, int volume_averages = 0);

  /// Gives points of a smaller half size, in cells, the weights of points of this one.
  void WidenThinPoints(double half_size) { lattice_.least_half_size = half_size; }
  /// Makes points end at a side of symmetry, whose nodes have this box index.
  void EndPointsAt(Side side, int node)
  {
    lattice_.end[AxisOf(side)][SignOf(side) > 0] = node;
    lattice_.has_ends = true;
  }

  const GridGeometry &Geometry() const { return geometry_; }
  const GridLayout &Layout() const { return layout_; }
  const Lattice &IndexSpace() const { return lattice_; }
  /// The ranks with a block, ordered by block; null on others.
  MPI_Comm Comm() const { return comm_; }
  bool Participates() const { return comm_ != MPI_COMM_NULL; }
  /// Where the level's points live: points that change levels lie for a moment on ranks without a part of the grid, too.
  MPI_Comm PointsComm() const { return Participates() ? comm_ : PETSC_COMM_SELF; }

  /// Nodes by their box indices (the padding is negative or beyond the cells): those of this rank, and with its ghosts.
  const IndexBox &Owned() const { return owned_; }
  const IndexBox &Ghosted() const { return ghosted_; }
  bool Owns(Index node) const { return owned_.Contains(node); }
  /// False where one rank has the whole grid.
  bool HasGhosts() const { return layout_.Blocks() > 1; }
  std::size_t GhostedNodes() const { return static_cast<std::size_t>(ghosted_.Count()); }

  /// Place of a local node in the arrays.
  std::ptrdiff_t Place(Index node) const
  {
    const Index at = node - ghosted_.lower;
    return at[0] + lattice_.stride[1] * static_cast<std::ptrdiff_t>(at[1]) +
           lattice_.stride[2] * static_cast<std::ptrdiff_t>(at[2]);
  }
  /// The local node at a place.
  Index NodeAt(std::ptrdiff_t place) const
  {
    const int x = ghosted_.Size(0), y = ghosted_.Size(1);
    return ghosted_.lower + Index{static_cast<int>(place % x), static_cast<int>(place / x % y), static_cast<int>(place / x / y)};
  }
  double Coordinate(int axis, int index) const { return geometry_.Coordinate(axis, index); }
  Index Nearest(Vec3 x) const { return geometry_.Nearest(x); }
  /// The block that holds a node, which is also its owner's rank in Comm(); -1 outside the grid.
  int BlockOfNode(Index node) const;
  /// The blocks that hold nodes of a box, or lie nearest to it, in their order.
  std::vector<int> BlocksIn(const IndexBox &box) const;
  /// The owner's rank among all ranks; -1 outside the grid.
  PetscMPIInt OwnerOfNode(Index node) const;
  /// Place of a node in the arrays of the owner of `block`.
  PetscInt PlaceInBlock(int block, Index node) const;

  /// Nodal arrays on the ghosted nodes; see NodeLayout.
  NodeSums *Sums() const { return sums_; }
  double *VelocityArray() const { return velocity_; }
  double *RatesArray() const { return rates_; }
  NodeVelocity Velocity(std::ptrdiff_t place) const
  {
    double *const first = velocity_ + velocity_size_ * place;
    return {first, first + velocity_size_ / 2};
  }
  double *Rates(std::ptrdiff_t place) const { return rates_ + rates_size_ * place; }
  /// Sums of a material over the points of cells: those of the cell above a node, along every axis, lie CellStride() times the
  /// node's place from the first.
  CellSums *Cells(int average) const { return cells_ + average; }
  int CellStride() const { return cell_size_; }
  void ClearSums() const;
  /// Rates, and the sums of cells.
  void ClearRates() const;

  /// Adds up what all ranks have added to the nodes, their own and ghosts alike: afterwards all know the sums there.
  PetscErrorCode ShareSums();
  /// The same of rates, with or without the projection and the strain rate, and of cells, which get their means.
  PetscErrorCode ShareRates(bool projection, bool strain_rate);
  /// Copies the owners' velocities to the ghosts, where more than shared sums has made them.
  PetscErrorCode BroadcastVelocity();
  /// The same of a number for each node, by place. Collective on the grid's ranks.
  PetscErrorCode BroadcastNumbers(double *numbers);

  /// Calls work(k, place) for each other rank that has a local node too: the k-th of those with nodes in common, in the order
  /// of ranks, and the node's place in its arrays.
  template <class Work> void ForEachCopy(Index node, Work work) const
  {
    for (std::size_t k = 0; k < neighbours_.size(); ++k)
      if (neighbours_[k].second.Contains(node)) work(k, PlaceInBlock(neighbours_[k].first, node));
  }
  std::size_t Neighbours() const { return neighbours_.size(); }
  /// Those of lower rank.
  std::size_t LowerNeighbours() const { return lower_neighbours_; }
  /// Numbers for each of them, and theirs. Collective on the grid's ranks.
  PetscErrorCode SendToNeighbours(const std::vector<std::vector<double>> &outgoing, std::vector<std::vector<double>> *incoming)
  {
    return shared_.Send(outgoing, incoming);
  }

  /// The values of a node as one unit of communication.
  MPI_Datatype SumsUnit() const { return sums_unit_; }
  MPI_Datatype VelocityUnit() const { return velocity_unit_; }

  /// Shows the grid to the viewer that the option -PREFIXdm_view names, and mass, momentum, velocity p/m and force of the nodes,
  /// as they are in `sums`, to that of -PREFIXnodes_view. Nodes with less mass than mass_cutoff have no velocity. Collective on
  /// the grid's ranks.
  PetscErrorCode View(const std::string &prefix, double mass_cutoff) const;

private:
  PetscErrorCode CreateNodes();
  PetscErrorCode CreateHalo();
  PetscErrorCode CreateSharedNodes();
  IndexBox GhostedOf(int block) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  GridGeometry geometry_{};
  GridLayout layout_;
  Lattice lattice_{};
  DMHandle nodes_;
  IndexBox owned_, ghosted_;
  std::vector<CacheLine> memory_[3];
  NodeSums *sums_ = nullptr;
  double *velocity_ = nullptr, *rates_ = nullptr;
  std::ptrdiff_t velocity_size_ = 0, rates_size_ = 0; ///< doubles of a node
  std::vector<CellSums> cell_memory_;
  CellSums *cells_ = nullptr;
  int cell_size_ = 0; ///< materials that a cell has sums of
  SFHandle halo_;
  SharedNodes shared_;
  std::vector<std::pair<int, IndexBox>> neighbours_; ///< blocks with nodes in common, and their nodes with ghosts
  std::size_t lower_neighbours_ = 0;
  UnitHandle sums_unit_, velocity_unit_;
  std::vector<int> starts_[3]; ///< first node of each layer of blocks, then the end, as box indices
};

/// Ghost nodes a step needs: the stencil's reach of one, a point's drift of less than one cell between migrations, and
/// one for a face, which lies up to half a cell from its point.
inline constexpr int kHaloWidth = 3; // size

} // namespace mlgimp
