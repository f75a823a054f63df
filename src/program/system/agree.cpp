// Agreement of all ranks on a problem that one of them may have.
#include "program/system/agree.hpp"

#include "base/text.hpp"
#include "program/system/errors.hpp"

#include <utility>

#ifdef MLGIMP_FAULTS
#include <cstdio>
#include <cstdlib>
#include <new>
#include <set>
#include <sstream>
#include <stdexcept>
#endif

namespace mlgimp
{

std::string ShareText(MPI_Comm comm, std::string text, PetscMPIInt owner)
{
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, owner, comm);
  text.resize(static_cast<std::size_t>(length));
  if (length > 0) MPI_Bcast(text.data(), length, MPI_CHAR, owner, comm);
  return text;
}

#ifdef MLGIMP_FAULTS
static PetscErrorCode InjectFault(int rank, const char *place, std::string *problem)
{
  static std::set<std::string> passed;
  const char *order = std::getenv("MLGIMP_FAULT");
  PetscFunctionBeginUser;
  if (!order || !passed.insert(place).second) PetscFunctionReturn(PETSC_SUCCESS);
  if (order == std::string("list") && rank == 0) std::fprintf(stderr, "fault place: %s\n", place);
  std::istringstream words(order);
  std::string name, kind;
  int failing = -1;
  words >> name >> failing >> kind;
  if (name != place || rank != failing) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string text = Format("injected at {} on rank {}", name, rank);
  PetscCheck(kind != "error", PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", text.c_str());
  if (kind == "exception") throw std::runtime_error(text);
  if (kind == "memory") throw std::bad_alloc();
  *problem = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}
#endif

std::string Agree(MPI_Comm comm, [[maybe_unused]] const char *place, std::string problem)
{
  const PetscMPIInt ranks = RanksOf(comm);
#ifdef MLGIMP_FAULTS
  ExitOnError(InjectFault(RankIn(comm), place, &problem));
#endif
  PetscMPIInt first = problem.empty() ? ranks : RankIn(comm);
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm);
  return first < ranks ? ShareText(comm, std::move(problem), first) : "";
}

} // namespace mlgimp
