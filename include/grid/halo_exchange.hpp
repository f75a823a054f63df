// The messages between ranks that have nodes in common: sums of what each has added there, copies of the owners' values, and
// lists of numbers.
#pragma once

#include "grid/node_partition.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace mlgimp
{

/// An array of nodes, and the components of it that ranks send each other.
struct NodalField {
  double *values;          ///< [nodes][size]
  std::ptrdiff_t size;     ///< doubles of a node
  std::vector<int> chosen; ///< places of components among them
};

/// All calls are collective on the grid's ranks, and do nothing where one rank has the whole grid.
class HaloExchange
{
public:
  HaloExchange() = default;
  HaloExchange(const HaloExchange &) = delete;
  HaloExchange &operator=(const HaloExchange &) = delete;
  ~HaloExchange();

  /// Between this rank and NodePartition::Neighbours.
  PetscErrorCode Create(const NodePartition &nodes);

  /// Leaves the sums over all ranks in the chosen components. One message to and from each rank brings them to all ranks that
  /// have a node, its owner and others alike, so no second message is needed. Contributions are added in the order of the
  /// ranks: the sums are the same on all.
  PetscErrorCode Sum(const std::vector<NodalField> &fields);
  /// Copies the owners' values to the ghosts. values: a unit for each local node, by place.
  PetscErrorCode Broadcast(MPI_Datatype unit, void *values);
  /// Sends numbers to each neighbour, as many as there are, and receives theirs.
  PetscErrorCode Send(const std::vector<std::vector<double>> &outgoing, std::vector<std::vector<double>> *incoming);
  std::size_t Neighbours() const { return with_.size(); }
  /// Those of lower rank, which are the first.
  std::size_t LowerNeighbours() const { return lower_; }

private:
  PetscErrorCode CreateBroadcast(const NodePartition &nodes);
  PetscErrorCode Exchange(int numbers);

  MPI_Comm comm_ = MPI_COMM_NULL; ///< PETSc's own beside the grid's, with a tag that no other library uses
  PetscMPIInt tag_ = 0;
  /// The neighbours by rank, with the places of the nodes in common, in an order that both have.
  std::vector<std::pair<PetscMPIInt, std::vector<std::ptrdiff_t>>> with_;
  std::size_t lower_ = 0;
  std::vector<std::ptrdiff_t> all_; ///< nodes that some other rank has too
  std::vector<double> own_, outgoing_, incoming_;
  std::vector<MPI_Request> requests_;
  SFHandle ghosts_; ///< owned nodes to ghosts on other ranks
};

} // namespace mlgimp
