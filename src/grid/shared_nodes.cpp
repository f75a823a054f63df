// The exchange of nodal sums between neighbouring ranks.
#include "grid/shared_nodes.hpp"

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

SharedNodes::~SharedNodes()
{
  PetscFunctionBegin;
  if (comm_ != MPI_COMM_NULL) PetscCallVoid(PetscCommDestroy(&comm_));
  PetscFunctionReturnVoid();
}

PetscErrorCode SharedNodes::Create(MPI_Comm comm, std::vector<Common> with)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCommDuplicate(comm, &comm_, &tag_));
  rank_ = RankIn(comm);
  with_ = std::move(with);
  for (const auto &[rank, nodes] : with_) all_.insert(all_.end(), nodes.begin(), nodes.end());
  std::sort(all_.begin(), all_.end());
  all_.erase(std::unique(all_.begin(), all_.end()), all_.end());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends and receives as many numbers of each node.
PetscErrorCode SharedNodes::Exchange(int numbers)
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

std::vector<PetscMPIInt> SharedNodes::Ranks() const
{
  std::vector<PetscMPIInt> ranks;
  for (const auto &[rank, nodes] : with_) ranks.push_back(rank);
  return ranks;
}

PetscErrorCode SharedNodes::Send(const std::vector<std::vector<double>> &outgoing, std::vector<std::vector<double>> *incoming)
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

PetscErrorCode SharedNodes::Sum(const std::vector<NodalField> &fields)
{
  int numbers = 0;
  PetscFunctionBeginUser;
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
  auto other = with_.begin();
  for (; other != with_.end() && other->first < rank_; ++other) next = add(other->second, next);
  add(all_, own_.data());
  for (; other != with_.end(); ++other) next = add(other->second, next);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
