// Agreement of all ranks on a problem that one of them may have.
#pragma once

#include "base/petsc.hpp"

#include <string>

namespace mlgimp
{

/// Makes the problem of the first rank that has one that of all, so that none waits for another in a collective call: to be
/// called after everything that a rank reads, solves or decides by itself. problem: empty, or one line. Collective.
///
/// place: a name for tests. Built with MLGIMP_FAULTS the program takes a problem from the environment variable MLGIMP_FAULT:
/// "list" prints the places that a run passes, "PLACE RANK KIND" makes that rank fail where the run first gets to the place: by
/// a problem, or by an error, an exception or a lack of memory that the others do not know of.
PetscErrorCode Agree(MPI_Comm comm, const char *place, std::string *problem);

/// The first rank's text, on every rank. Collective.
PetscErrorCode ShareText(MPI_Comm comm, std::string *text);

} // namespace mlgimp
