// One sparse exchange: few ranks send to each other at once; among many, the numbers of records are exchanged first.
#include "base/exchange.hpp"

namespace mlgimp
{

namespace
{

/// Records for or from a rank.
struct Group {
  PetscMPIInt rank;
  int count;
};

/// Sends a message to each rank that may get something, with or without records: its length gives their number.
PetscErrorCode ExchangeAmongFew(MPI_Comm comm, MPI_Datatype record, std::size_t bytes, const std::vector<Group> &targets,
                                SendPattern pattern, const char *outgoing, std::vector<char> *incoming)
{
  const PetscMPIInt ranks = RanksOf(comm), mine = RankIn(comm);
  PetscMPIInt tag;
  MPI_Comm inner; // PETSc's own, with tags that no other library uses
  std::vector<const char *> from(ranks + 1, outgoing);
  std::vector<int> count(ranks, 0);
  std::vector<MPI_Request> requests;
  PetscFunctionBeginUser;
  for (const Group &target : targets) count[target.rank] = target.count;
  for (PetscMPIInt rank = 0; rank < ranks; ++rank) from[rank + 1] = from[rank] + bytes * count[rank];
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  for (PetscMPIInt rank = 0; rank < ranks; ++rank) {
    if (rank == mine) continue;
    if (pattern & Sends(mine, rank))
      PetscCallMPI(MPI_Isend(from[rank], count[rank], record, rank, tag, inner, &requests.emplace_back()));
    else
      PetscCheck(count[rank] == 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Records for rank %d, which expects none", rank);
  }
  incoming->clear();
  for (PetscMPIInt rank = 0; rank < ranks; ++rank) {
    const std::size_t before = incoming->size();
    MPI_Status status;
    int number = 0;
    if (rank == mine) {
      incoming->insert(incoming->end(), from[rank], from[rank + 1]);
      continue;
    }
    if (!(pattern & Sends(rank, mine))) continue;
    PetscCallMPI(MPI_Probe(rank, tag, inner, &status));
    PetscCallMPI(MPI_Get_count(&status, record, &number));
    incoming->resize(before + bytes * number);
    PetscCallMPI(MPI_Recv(incoming->data() + before, number, record, rank, tag, inner, MPI_STATUS_IGNORE));
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCall(PetscCommDestroy(&inner));
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
  for (const auto &[rank, count] : targets) ranks.push_back(rank), counts.push_back(count);
  PetscCall(PetscCommBuildTwoSided(comm, 1, MPI_INT, static_cast<PetscMPIInt>(ranks.size()), ranks.data(), counts.data(), &number,
                                   &from, static_cast<void *>(&incoming)));
  for (int k = 0; k < number; ++k) sources->push_back({from[k], incoming[k]});
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(incoming));
  std::sort(sources->begin(), sources->end(), [](const Group &a, const Group &b) { return a.rank < b.rank; });
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same among many.
PetscErrorCode ExchangeAmongMany(MPI_Comm comm, MPI_Datatype record, std::size_t bytes, const std::vector<Group> &targets,
                                 const char *outgoing, std::vector<char> *incoming)
{
  PetscMPIInt tag;
  MPI_Comm inner;
  std::vector<Group> sources;
  std::vector<MPI_Request> requests;
  std::size_t total = 0;
  PetscFunctionBeginUser;
  PetscCall(FindSources(comm, targets, &sources));
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  for (const Group &source : sources) total += bytes * source.count;
  incoming->resize(total);
  char *to = incoming->data();
  for (const Group &source : sources) {
    PetscCallMPI(MPI_Irecv(to, source.count, record, source.rank, tag, inner, &requests.emplace_back()));
    to += bytes * source.count;
  }
  const char *from = outgoing;
  for (const Group &target : targets) {
    PetscCallMPI(MPI_Isend(from, target.count, record, target.rank, tag, inner, &requests.emplace_back()));
    from += bytes * target.count;
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCall(PetscCommDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ShareFromFirst(MPI_Comm comm, std::vector<double> *values, SendPattern pattern)
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
  for (PetscMPIInt rank = 1; rank < ranks; ++rank) {
    if (!(pattern & Sends(0, rank))) continue;
    if (RankIn(comm) == 0)
      PetscCallMPI(MPI_Isend(values->data(), count, MPI_DOUBLE, rank, tag, inner, &requests.emplace_back()));
    else if (RankIn(comm) == rank)
      PetscCallMPI(MPI_Irecv(values->data(), count, MPI_DOUBLE, 0, tag, inner, &requests.emplace_back()));
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCall(PetscCommDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ExchangeBytes(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks, SendPattern pattern,
                             const void *outgoing, std::vector<char> *incoming)
{
  const char *const from = static_cast<const char *>(outgoing);
  MPI_Datatype record;
  std::vector<Group> targets;
  PetscFunctionBeginUser;
  for (const PetscMPIInt rank : ranks) {
    if (targets.empty() || targets.back().rank != rank) targets.push_back({rank, 0});
    ++targets.back().count;
  }
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &record));
  PetscCallMPI(MPI_Type_commit(&record));
  if (RanksOf(comm) <= kFewRanks)
    PetscCall(ExchangeAmongFew(comm, record, bytes, targets, pattern, from, incoming));
  else
    PetscCall(ExchangeAmongMany(comm, record, bytes, targets, from, incoming));
  PetscCallMPI(MPI_Type_free(&record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
