// Nodes that several ranks have in their arrays, and the sums there of what each of them has added.
#pragma once

#include "base/petsc.hpp"

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

/// One message to and from each rank with nodes in common brings the sums to all ranks that have a node, its owner and others
/// alike, so no second message is needed. Contributions are added in the order of the ranks: the sums are the same on all.
class SharedNodes
{
public:
  /// The places of the nodes that this rank has in common with another, in an order that both have.
  using Common = std::pair<PetscMPIInt, std::vector<std::ptrdiff_t>>;

  SharedNodes() = default;
  SharedNodes(const SharedNodes &) = delete;
  SharedNodes &operator=(const SharedNodes &) = delete;
  ~SharedNodes();

  /// with: ordered by rank. Collective.
  PetscErrorCode Create(MPI_Comm comm, std::vector<Common> with);
  /// Leaves the sums over all ranks in the chosen components. Collective.
  PetscErrorCode Sum(const std::vector<NodalField> &fields);
  /// The ranks with nodes in common, in their order.
  std::vector<PetscMPIInt> Ranks() const;
  /// Sends numbers to each of these ranks, as many as there are, and receives theirs. Collective.
  PetscErrorCode Send(const std::vector<std::vector<double>> &outgoing, std::vector<std::vector<double>> *incoming);

private:
  PetscErrorCode Exchange(int numbers);

  MPI_Comm comm_ = MPI_COMM_NULL; ///< PETSc's own beside the one given, with a tag that no other library uses
  PetscMPIInt tag_ = 0, rank_ = 0;
  std::vector<Common> with_;
  std::vector<std::ptrdiff_t> all_; ///< nodes that some other rank has too
  std::vector<double> own_, outgoing_, incoming_;
  std::vector<MPI_Request> requests_;
};

} // namespace mlgimp
