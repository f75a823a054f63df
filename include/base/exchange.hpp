// Sending plain records to the ranks they belong to.
#pragma once

#include "base/petsc.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <vector>

namespace mlgimp
{

inline constexpr PetscMPIInt kFewRanks = 8; ///< size: among so many a message to each takes no longer than a collective call

/// Which rank may send to which other rank in an exchange among few ranks, as all of them know it: a bit for each pair (sender,
/// receiver).
using SendPattern = std::uint64_t;
inline constexpr SendPattern kAnyToAny = ~SendPattern(0); // size
inline constexpr SendPattern Sends(PetscMPIInt from, PetscMPIInt to) { return SendPattern(1) << (kFewRanks * from + to); }
inline constexpr SendPattern kFirstToAll = 0xff;                  ///< those from the first rank
inline constexpr SendPattern kAllToFirst = 0x0101010101010101ULL; ///< those to it

/// Sends records of `bytes` each, one after the other in `outgoing`: the k-th to ranks[k], which do not fall. What comes is
/// ordered by the ranks it comes from. Collective.
PetscErrorCode ExchangeBytes(MPI_Comm comm, std::size_t bytes, const std::vector<PetscMPIInt> &ranks, SendPattern pattern,
                             const void *outgoing, std::vector<char> *incoming);

/// Copies numbers from the first rank, which all know how many are, to the others: among few directly, to those of the pattern.
/// Collective.
PetscErrorCode ShareFromFirst(MPI_Comm comm, std::vector<double> *values, SendPattern pattern);

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

/// Copies a list from the first rank to all. Collective.
template <class Record> PetscErrorCode BroadcastList(MPI_Comm comm, std::vector<Record> *list)
{
  int count = static_cast<int>(list->size());
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&count, 1, MPI_INT, 0, comm));
  list->resize(count);
  PetscCallMPI(MPI_Bcast(list->data(), static_cast<int>(count * sizeof(Record)), MPI_BYTE, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends every record to the rank that `rank_of(record)` names, and drops it where that is negative. On return `records` are
/// those that have come, ordered by the ranks they come from and as they stood there, so that a fixed number of ranks repeats bit
/// for bit. Collective.
template <class Record, class RankOf>
PetscErrorCode ExchangeRecords(MPI_Comm comm, std::vector<Record> *records, RankOf rank_of, SendPattern pattern = kAnyToAny)
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
  PetscCall(ExchangeBytes(comm, sizeof(Record), ranks, pattern, records->data(), &incoming));
  records->resize(incoming.size() / sizeof(Record));
  std::copy(incoming.begin(), incoming.end(), static_cast<char *>(static_cast<void *>(records->data())));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
