// The background grid of one level: its nodes on this rank and others, what they hold, and their halo.
#pragma once

#include "grid/halo_exchange.hpp"
#include "grid/nodal_arrays.hpp"
#include "grid/node_partition.hpp"
#include "physics/point_fields.hpp"
#include "physics/shape.hpp"

#include <string>

namespace mlgimp
{

/// A level's grid as a rank has it: its parts, and of these what most callers ask for.
class Grid
{
public:
  /// Collective on `world`. On ranks without a block the grid knows where it lies, but has no nodes. volume_averages: number of
  /// materials that keep sums at the cells; marks_cells: those that points lie in get a mark.
  PetscErrorCode Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout, int volume_averages = 0,
                        bool marks_cells = true);

  /// Gives points of a smaller half size, in cells, the weights of points of this one.
  void WidenThinPoints(double half_size) { lattice_.least_half_size = half_size; }
  /// Makes points end at a side of symmetry, whose nodes have this box index.
  void EndPointsAt(Side side, int node)
  {
    lattice_.end[AxisOf(side)][SignOf(side) > 0] = node;
    lattice_.has_ends = true;
  }

  const NodePartition &Nodes() const { return nodes_; }
  const NodalArrays &Arrays() const { return arrays_; }
  NodalArrays &Arrays() { return arrays_; }
  HaloExchange &Halo() { return halo_; }
  /// What the weights of points go by.
  const Lattice &IndexSpace() const { return lattice_; }

  // Of the nodes and their arrays.
  const GridGeometry &Geometry() const { return nodes_.Geometry(); }
  bool Participates() const { return nodes_.Participates(); }
  const IndexBox &Owned() const { return nodes_.Owned(); }
  const IndexBox &Ghosted() const { return nodes_.Ghosted(); }
  std::ptrdiff_t Place(Index node) const { return nodes_.Place(node); }
  NodeSums *Sums() const { return arrays_.Sums(); }
  NodeVelocity Velocity(std::ptrdiff_t place) const { return arrays_.Velocity(place); }
  double *Rates(std::ptrdiff_t place) const { return arrays_.Rates(place); }

  // Collective on the grid's ranks.

  /// Adds up what all ranks have added to the nodes, and marked, their own and ghosts alike: afterwards all know the sums there.
  PetscErrorCode ShareSums();
  /// The same of so many rates, from the first on, and of the sums of cells.
  PetscErrorCode ShareRates(int count);
  /// Copies the owners' velocities to the ghosts, where more than shared sums has made them.
  PetscErrorCode BroadcastVelocity() { return halo_.Broadcast(arrays_.VelocityUnit(), arrays_.VelocityArray()); }
  /// Shows the grid to the viewer that the option -PREFIXdm_view names, and mass, momentum, velocity p/m and force of the nodes,
  /// as they are in `sums`, to that of -PREFIXnodes_view. Nodes with less mass than mass_cutoff have no velocity.
  PetscErrorCode View(const std::string &prefix, double mass_cutoff) const;

private:
  NodePartition nodes_;
  NodalArrays arrays_;
  HaloExchange halo_;
  Lattice lattice_{};
};

} // namespace mlgimp
