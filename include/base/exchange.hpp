// Sending plain records to the ranks they belong to.
#pragma once

#include "base/petsc.hpp"

#include <algorithm>
#include <climits>
#include <numeric>
#include <type_traits>
#include <vector>

namespace mlgimp
{

/// Sends records of `bytes` each, one after the other in `outgoing`: the k-th to ranks[k], which do not fall. What comes is
/// ordered by the ranks it comes from. Only the first `receivers` ranks may get something. Collective.
PetscErrorCode ExchangeBytes(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks, PetscMPIInt receivers,
                             const void *outgoing, std::vector<char> *incoming);

/// Copies numbers from the first rank, which all know how many are, to the others: to few of them directly. Collective.
PetscErrorCode ShareFromFirst(MPI_Comm comm, std::vector<double> *values);

/// The records of all ranks, ordered by rank, on every rank. Collective.
template <class Record> PetscErrorCode GatherRecords(MPI_Comm comm, const std::vector<Record> &mine, std::vector<Record> *all)
{
  static_assert(std::is_trivially_copyable_v<Record>, "records travel as bytes");
  const int bytes = static_cast<int>(mine.size() * sizeof(Record));
  std::vector<int> counts(RanksOf(comm)), starts(counts.size() + 1, 0);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  all->resize(static_cast<std::size_t>(starts.back()) / sizeof(Record));
  PetscCallMPI(MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all->data(), counts.data(), starts.data(), MPI_BYTE, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends every record to the rank that `rank_of(record)` names, and drops it where that is negative. On return `records` are
/// those that have come, ordered by the ranks they come from and as they stood there, so that a fixed number of ranks repeats bit
/// for bit. Where only the first `receivers` ranks are named, the others get no messages. Collective.
template <class Record, class RankOf>
PetscErrorCode ExchangeRecords(MPI_Comm comm, std::vector<Record> *records, RankOf rank_of, PetscMPIInt receivers = INT_MAX)
{
  static_assert(std::is_trivially_copyable_v<Record>, "records travel as bytes");
  std::vector<PetscMPIInt> ranks;
  std::vector<char> incoming;
  PetscFunctionBeginUser;
  records->erase(std::remove_if(records->begin(), records->end(), [&](const Record &r) { return rank_of(r) < 0; }),
                 records->end());
  if (RanksOf(comm) == 1) PetscFunctionReturn(PETSC_SUCCESS);
  std::stable_sort(records->begin(), records->end(), [&](const Record &a, const Record &b) { return rank_of(a) < rank_of(b); });
  for (const Record &record : *records) ranks.push_back(rank_of(record));
  PetscCall(ExchangeBytes(comm, sizeof(Record), ranks, std::min(receivers, RanksOf(comm)), records->data(), &incoming));
  records->resize(incoming.size() / sizeof(Record));
  std::copy(incoming.begin(), incoming.end(), static_cast<char *>(static_cast<void *>(records->data())));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
