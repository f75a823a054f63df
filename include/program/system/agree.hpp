// Agreement of all ranks on a problem that one of them may have.
#pragma once

#include "base/petsc.hpp"

#include <string>

namespace mlgimp
{

/// The problem of the first rank that has one, on every rank, so that none waits for another in a collective call: to be
/// called after everything that a rank reads, solves or decides by itself. A problem is one line, or empty. Collective.
///
/// place: a name for tests. Built with MLGIMP_FAULTS the program takes a problem from the environment variable MLGIMP_FAULT:
/// "list" prints the places that a run passes, "PLACE RANK KIND" makes that rank fail where the run first gets to the place: by
/// a problem, or by an error, an exception or missing memory that the other ranks do not see.
std::string Agree(MPI_Comm comm, const char *place, std::string problem);

/// The same of a problem that the first rank alone may have: what its work() returns. Collective.
template <class Work> std::string OnFirstRank(MPI_Comm comm, const char *place, Work work)
{
  return Agree(comm, place, RankIn(comm) == 0 ? work() : std::string());
}

/// A rank's text, on every rank. Collective.
std::string ShareText(MPI_Comm comm, std::string text, PetscMPIInt owner = 0);

} // namespace mlgimp
