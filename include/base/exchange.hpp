// Sending plain records to the ranks they belong to.
#pragma once

#include "base/petsc.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <vector>

namespace mlgimp
{

/// Sends groups of records, `bytes` each: counts[k] of them to ranks[k], one group after the other in `outgoing`. What comes is
/// ordered by the ranks it comes from. Collective.
PetscErrorCode ExchangeGroups(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks,
                              const std::vector<int> &counts, const void *outgoing, std::vector<char> *incoming);

/// Sends every record to the rank that `rank_of(record)` names, and drops it where that is negative. On return `records` are
/// those that have come, ordered by the ranks they come from and as they stood there, so that a fixed number of ranks repeats bit
/// for bit. Collective.
template <class Record, class RankOf> PetscErrorCode ExchangeRecords(MPI_Comm comm, std::vector<Record> *records, RankOf rank_of)
{
  static_assert(std::is_trivially_copyable_v<Record>, "records travel as bytes");
  std::vector<PetscMPIInt> ranks;
  std::vector<int> counts;
  std::vector<char> incoming;
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  records->erase(std::remove_if(records->begin(), records->end(), [&](const Record &r) { return rank_of(r) < 0; }),
                 records->end());
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  std::stable_sort(records->begin(), records->end(), [&](const Record &a, const Record &b) { return rank_of(a) < rank_of(b); });
  for (const Record &record : *records) {
    if (ranks.empty() || ranks.back() != rank_of(record)) ranks.push_back(rank_of(record)), counts.push_back(0);
    ++counts.back();
  }
  PetscCall(ExchangeGroups(comm, sizeof(Record), ranks, counts, records->data(), &incoming));
  records->resize(incoming.size() / sizeof(Record));
  std::copy(incoming.begin(), incoming.end(), static_cast<char *>(static_cast<void *>(records->data())));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
