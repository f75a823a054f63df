// Messages between neighbouring ranks.
#include "grid/halo_exchange.hpp"

#include <algorithm>

namespace mlgimp
{

/// Calls work(value) for the chosen components of nodes, node by node.
template <class Work>
static void ForEachValue(const std::vector<NodalField> &fields, const std::vector<std::ptrdiff_t> &nodes, Work work)
{
  for (const std::ptrdiff_t node : nodes)
    for (const NodalField &field : fields)
      for (const int component : field.chosen) work(field.values[field.size * node + component]);
}

HaloExchange::~HaloExchange()
{
  PetscFunctionBegin;
  if (comm_ != MPI_COMM_NULL) PetscCallVoid(PetscCommDestroy(&comm_));
  PetscFunctionReturnVoid();
}

PetscErrorCode HaloExchange::Create(const NodePartition &nodes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCommDuplicate(nodes.Comm(), &comm_, &tag_));
  for (const NodePartition::Neighbour &neighbour : nodes.Neighbours()) {
    std::vector<std::ptrdiff_t> common;
    ForEach(Intersection(nodes.Ghosted(), neighbour.nodes), [&](Index node) { common.push_back(nodes.Place(node)); });
    all_.insert(all_.end(), common.begin(), common.end());
    with_.push_back({neighbour.block, std::move(common)});
    lower_ += neighbour.block < RankIn(comm_);
  }
  std::sort(all_.begin(), all_.end());
  all_.erase(std::unique(all_.begin(), all_.end()), all_.end());
  PetscCall(CreateBroadcast(nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Roots are owned nodes and leaves ghost nodes, both as places in the ghosted arrays, so that the exchange is in place.
PetscErrorCode HaloExchange::CreateBroadcast(const NodePartition &nodes)
{
  const PetscMPIInt own = RankIn(comm_);
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  ForEach(nodes.Ghosted(), [&](Index node) {
    const int block = nodes.BlockOf(node);
    if (block == own) return;
    leaves.push_back(static_cast<PetscInt>(nodes.Place(node)));
    roots.push_back({block, static_cast<PetscInt>(nodes.GhostedOf(block).Place(node))});
  });
  PetscCall(PetscSFCreate(nodes.Comm(), ghosts_.Out()));
  PetscCall(PetscSFSetGraph(ghosts_, static_cast<PetscInt>(nodes.Ghosted().Count()), static_cast<PetscInt>(leaves.size()),
                            leaves.data(), PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(ghosts_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends and receives as many numbers of each node.
PetscErrorCode HaloExchange::Exchange(int numbers)
{
  const double *from = outgoing_.data();
  PetscFunctionBeginUser;
  incoming_.resize(outgoing_.size()); // as others have as many nodes in common with this rank
  requests_.clear();
  double *to = incoming_.data();
  for (const auto &[rank, nodes] : with_) {
    const int count = numbers * static_cast<int>(nodes.size());
    PetscCallMPI(MPI_Irecv(to, count, MPI_DOUBLE, rank, tag_, comm_, &requests_.emplace_back()));
    PetscCallMPI(MPI_Isend(from, count, MPI_DOUBLE, rank, tag_, comm_, &requests_.emplace_back()));
    to += count, from += count;
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HaloExchange::Sum(const std::vector<NodalField> &fields)
{
  int numbers = 0;
  PetscFunctionBeginUser;
  if (with_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const NodalField &field : fields) numbers += static_cast<int>(field.chosen.size());
  outgoing_.clear(), own_.clear();
  for (const auto &[rank, nodes] : with_) ForEachValue(fields, nodes, [&](double value) { outgoing_.push_back(value); });
  ForEachValue(fields, all_, [&](double &value) { own_.push_back(value), value = 0; });
  PetscCall(Exchange(numbers));
  const auto add = [&](const std::vector<std::ptrdiff_t> &nodes, const double *from) {
    ForEachValue(fields, nodes, [&](double &value) { value += *from++; });
    return from;
  };
  const double *next = incoming_.data();
  for (std::size_t k = 0; k < lower_; ++k) next = add(with_[k].second, next);
  add(all_, own_.data());
  for (std::size_t k = lower_; k < with_.size(); ++k) next = add(with_[k].second, next);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HaloExchange::Broadcast(MPI_Datatype unit, void *values)
{
  PetscFunctionBeginUser;
  if (with_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(ghosts_, unit, values, values, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(ghosts_, unit, values, values, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HaloExchange::Send(const std::vector<std::vector<double>> &outgoing, std::vector<std::vector<double>> *incoming)
{
  PetscFunctionBeginUser;
  requests_.clear();
  incoming->resize(with_.size());
  for (std::size_t k = 0; k < with_.size(); ++k)
    PetscCallMPI(MPI_Isend(outgoing[k].data(), static_cast<int>(outgoing[k].size()), MPI_DOUBLE, with_[k].first, tag_, comm_,
                           &requests_.emplace_back()));
  for (std::size_t k = 0; k < with_.size(); ++k) {
    MPI_Status status;
    int count = 0;
    PetscCallMPI(MPI_Probe(with_[k].first, tag_, comm_, &status));
    PetscCallMPI(MPI_Get_count(&status, MPI_DOUBLE, &count));
    (*incoming)[k].resize(count);
    PetscCallMPI(MPI_Recv((*incoming)[k].data(), count, MPI_DOUBLE, with_[k].first, tag_, comm_, MPI_STATUS_IGNORE));
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
