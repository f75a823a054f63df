// mlgimp: multi-level generalized interpolation material point method for indentation and contact.
#include "level/active_set.hpp"
#include "program/case.hpp"
#include "program/simulation.hpp"

#include <cstdio>

static const char kHelp[] =
    "mlgimp: explicit GIMP simulation of indentation and contact in plane strain.\n\n"
    "  bin/mlgimp -options_file options/NAME.opts [-option value ...]\n"
    "  mpiexec -n N bin/mlgimp -options_file options/NAME.opts\n\n";

namespace
{

using namespace mlgimp;

/// Prints the message of an error once and in one line; errors that are not the user's keep PETSc's trace.
PetscErrorCode OneLineHandler(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                              PetscErrorType type, const char *message, void *context)
{
  int rank = 0;
  if (type == PETSC_ERROR_REPEAT) return code;
  if (code != PETSC_ERR_USER_INPUT && code != PETSC_ERR_ARG_UNKNOWN_TYPE)
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, context);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) std::fprintf(stderr, "mlgimp: error: %s\n", message);
  return code;
}

PetscErrorCode Main()
{
  PetscBool help = PETSC_FALSE;
  Case settings;
  PetscFunctionBeginUser;
  PetscCall(PetscLogDefaultBegin()); // the summary tells shares of the time
  PetscCall(PetscOptionsHasHelp(nullptr, &help));
  OptionReader reader(PETSC_COMM_WORLD, help);
  PetscCall(ReadCase(reader, &settings));
  if (help) {
    ActiveSetSolver solver; // lists the options of the contact solver
    PetscCall(solver.Create(true));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  Simulation simulation(settings);
  PetscCall(simulation.SetUp(PETSC_COMM_WORLD));
  PetscCall(reader.RefuseUnused());
  PetscCall(simulation.Run());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

int main(int argc, char **argv)
{
  int rank = 0, ranks = 1;
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::string message = rank == 0 ? CheckCommandLine(argc, argv) : "";
  int bad = !message.empty();
  MPI_Bcast(&bad, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (bad) {
    if (rank == 0) std::fprintf(stderr, "mlgimp: error: %s\n", message.c_str());
    MPI_Finalize();
    return 1;
  }
  PetscErrorCode code = PetscInitialize(&argc, &argv, nullptr, kHelp);
  if (!code) {
    code = PetscPushErrorHandler(OneLineHandler, nullptr);
    if (!code) code = Main();
    // Input is refused on all ranks alike; other errors may be one rank's, and the others would wait for it.
    if (code && code != PETSC_ERR_USER_INPUT && code != PETSC_ERR_ARG_UNKNOWN_TYPE) MPI_Abort(MPI_COMM_WORLD, 1);
    PetscPopErrorHandler();
    PetscErrorCode end = PetscFinalize();
    if (!code) code = end;
  }
  MPI_Finalize();
  return code ? 1 : 0;
}
