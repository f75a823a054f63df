// Agreement of all ranks on a problem that one of them may have.
#include "program/agree.hpp"

#ifdef MLGIMP_FAULTS
#include <cstdio>
#include <cstdlib>
#include <set>
#include <sstream>
#endif

namespace mlgimp
{

static PetscErrorCode ShareTextOf(MPI_Comm comm, PetscMPIInt owner, std::string *text)
{
  int length = static_cast<int>(text->size());
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, owner, comm));
  text->resize(length);
  if (length > 0) PetscCallMPI(MPI_Bcast(text->data(), length, MPI_CHAR, owner, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#ifdef MLGIMP_FAULTS
static void InjectFault(int rank, const char *place, std::string *problem)
{
  static std::set<std::string> passed;
  const char *order = std::getenv("MLGIMP_FAULT");
  if (!order || !passed.insert(place).second) return;
  if (order == std::string("list")) {
    if (rank == 0) std::fprintf(stderr, "fault place: %s\n", place);
    return;
  }
  std::istringstream words(order);
  std::string name;
  int failing = -1;
  words >> name >> failing;
  if (name == place && rank == failing) *problem = "injected at " + name + " on rank " + std::to_string(rank);
}
#endif

PetscErrorCode Agree(MPI_Comm comm, [[maybe_unused]] const char *place, std::string *problem)
{
  PetscMPIInt rank, size, first;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
#ifdef MLGIMP_FAULTS
  InjectFault(rank, place, problem);
#endif
  first = problem->empty() ? size : rank;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first < size) PetscCall(ShareTextOf(comm, first, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ShareText(MPI_Comm comm, std::string *text)
{
  PetscFunctionBeginUser;
  PetscCall(ShareTextOf(comm, 0, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
