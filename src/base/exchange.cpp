// One sparse exchange: who gets how much is told first, then all messages are under way at once.
#include "base/exchange.hpp"

namespace mlgimp
{

namespace
{

constexpr PetscMPIInt kFewRanks = 8; // among so many a message to each takes no longer than a collective call

/// Records for or from a rank.
struct Group {
  PetscMPIInt rank;
  int count;
};

/// The counts for and from all other ranks, each in a message of its own.
PetscErrorCode SwapCounts(MPI_Comm comm, const std::vector<Group> &targets, std::vector<Group> *sources)
{
  const PetscMPIInt ranks = RanksOf(comm), mine = RankIn(comm);
  PetscMPIInt tag;
  MPI_Comm inner;
  std::vector<int> outgoing(ranks, 0), incoming(ranks, 0);
  std::vector<MPI_Request> requests;
  PetscFunctionBeginUser;
  for (const Group &target : targets) outgoing[target.rank] = target.count;
  incoming[mine] = outgoing[mine];
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  for (PetscMPIInt rank = 0; rank < ranks; ++rank) {
    if (rank == mine) continue;
    PetscCallMPI(MPI_Irecv(&incoming[rank], 1, MPI_INT, rank, tag, inner, &requests.emplace_back()));
    PetscCallMPI(MPI_Isend(&outgoing[rank], 1, MPI_INT, rank, tag, inner, &requests.emplace_back()));
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCall(PetscCommDestroy(&inner));
  for (PetscMPIInt rank = 0; rank < ranks; ++rank)
    if (incoming[rank] > 0) sources->push_back({rank, incoming[rank]});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The ranks that send something, in their order.
PetscErrorCode FindSources(MPI_Comm comm, const std::vector<Group> &targets, std::vector<Group> *sources)
{
  PetscMPIInt number, *from = nullptr;
  int *incoming = nullptr;
  std::vector<PetscMPIInt> ranks;
  std::vector<int> counts;
  PetscFunctionBeginUser;
  if (RanksOf(comm) <= kFewRanks) {
    PetscCall(SwapCounts(comm, targets, sources));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (const auto &[rank, count] : targets) ranks.push_back(rank), counts.push_back(count);
  PetscCall(PetscCommBuildTwoSided(comm, 1, MPI_INT, static_cast<PetscMPIInt>(ranks.size()), ranks.data(), counts.data(), &number,
                                   &from, static_cast<void *>(&incoming)));
  for (int k = 0; k < number; ++k) sources->push_back({from[k], incoming[k]});
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(incoming));
  std::sort(sources->begin(), sources->end(), [](const Group &a, const Group &b) { return a.rank < b.rank; });
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ShareFromFirst(MPI_Comm comm, std::vector<double> *values)
{
  const PetscMPIInt ranks = RanksOf(comm), count = static_cast<PetscMPIInt>(values->size());
  PetscMPIInt tag;
  MPI_Comm inner;
  std::vector<MPI_Request> requests;
  PetscFunctionBeginUser;
  if (ranks > kFewRanks) {
    PetscCallMPI(MPI_Bcast(values->data(), count, MPI_DOUBLE, 0, comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  if (RankIn(comm) > 0) PetscCallMPI(MPI_Irecv(values->data(), count, MPI_DOUBLE, 0, tag, inner, &requests.emplace_back()));
  for (PetscMPIInt rank = 1; RankIn(comm) == 0 && rank < ranks; ++rank)
    PetscCallMPI(MPI_Isend(values->data(), count, MPI_DOUBLE, rank, tag, inner, &requests.emplace_back()));
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCall(PetscCommDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ExchangeBytes(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks, const void *outgoing,
                             std::vector<char> *incoming)
{
  PetscMPIInt tag;
  MPI_Comm inner; // PETSc's own, with tags that nobody else uses
  MPI_Datatype record;
  std::vector<Group> targets, sources;
  std::vector<MPI_Request> requests;
  PetscFunctionBeginUser;
  for (const PetscMPIInt rank : ranks) {
    if (targets.empty() || targets.back().rank != rank) targets.push_back({rank, 0});
    ++targets.back().count;
  }
  PetscCall(FindSources(comm, targets, &sources));
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &record));
  PetscCallMPI(MPI_Type_commit(&record));
  std::size_t total = 0;
  for (const Group &source : sources) total += bytes * source.count;
  incoming->resize(total);
  char *to = incoming->data();
  for (const Group &source : sources) {
    PetscCallMPI(MPI_Irecv(to, source.count, record, source.rank, tag, inner, &requests.emplace_back()));
    to += bytes * source.count;
  }
  const char *from = static_cast<const char *>(outgoing);
  for (const Group &target : targets) {
    PetscCallMPI(MPI_Isend(from, target.count, record, target.rank, tag, inner, &requests.emplace_back()));
    from += bytes * target.count;
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCallMPI(MPI_Type_free(&record));
  PetscCall(PetscCommDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
