// One sparse exchange: who gets how much is told first, then all messages are under way at once.
#include "base/exchange.hpp"

namespace mlgimp
{

namespace
{

struct Source {
  PetscMPIInt rank;
  int count;
};

/// The ranks that send something, in their order.
PetscErrorCode FindSources(MPI_Comm comm, const std::vector<PetscMPIInt> &ranks, const std::vector<int> &counts,
                           std::vector<Source> *sources)
{
  PetscMPIInt number, *from = nullptr;
  int *incoming = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscCommBuildTwoSided(comm, 1, MPI_INT, static_cast<PetscMPIInt>(ranks.size()), ranks.data(), counts.data(), &number,
                                   &from, static_cast<void *>(&incoming)));
  for (int k = 0; k < number; ++k) sources->push_back({from[k], incoming[k]});
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(incoming));
  std::sort(sources->begin(), sources->end(), [](const Source &a, const Source &b) { return a.rank < b.rank; });
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ExchangeGroups(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks,
                              const std::vector<int> &counts, const void *outgoing, std::vector<char> *incoming)
{
  PetscMPIInt tag;
  MPI_Comm inner; // PETSc's own, with tags that nobody else uses
  MPI_Datatype record;
  std::vector<Source> sources;
  std::vector<MPI_Request> requests;
  PetscFunctionBeginUser;
  PetscCall(FindSources(comm, ranks, counts, &sources));
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &record));
  PetscCallMPI(MPI_Type_commit(&record));
  std::size_t total = 0;
  for (const Source &source : sources) total += bytes * source.count;
  incoming->resize(total);
  char *to = incoming->data();
  for (const Source &source : sources) {
    PetscCallMPI(MPI_Irecv(to, source.count, record, source.rank, tag, inner, &requests.emplace_back()));
    to += bytes * source.count;
  }
  const char *from = static_cast<const char *>(outgoing);
  for (std::size_t k = 0; k < ranks.size(); ++k) {
    PetscCallMPI(MPI_Isend(from, counts[k], record, ranks[k], tag, inner, &requests.emplace_back()));
    from += bytes * counts[k];
  }
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCallMPI(MPI_Type_free(&record));
  PetscCall(PetscCommDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
