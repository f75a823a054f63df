// mlgimp: multi-level generalized interpolation material point method for indentation and contact.
#include "level/active_set.hpp"
#include "program/case.hpp"
#include "program/hdf5_file.hpp"
#include "program/simulation.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

static const char kHelp[] = "mlgimp: explicit GIMP simulation of indentation and contact in plane strain.\n\n"
                            "  bin/mlgimp -options_file options/NAME.opts [-option value ...]\n"
                            "  mpiexec -n N bin/mlgimp -options_file options/NAME.opts\n\n";

namespace
{

using namespace mlgimp;

PetscErrorCode OutOfMemory()
{
  std::fprintf(stderr, "mlgimp: error: out of memory; try a larger -cell_size, or more machines\n");
  return PETSC_ERR_MEM;
}

/// True for a path that ends with one of the names.
bool EndsWith(const std::string &path, const std::vector<std::string> &names)
{
  return std::find(names.begin(), names.end(), path.substr(path.find_last_of('/') + 1)) != names.end();
}

/// Prints the message of an error once and in one line; errors that are not the user's keep PETSc's trace.
PetscErrorCode OneLineHandler(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                              PetscErrorType type, const char *message, void *context)
{
  int rank = 0;
  bool *of_user = static_cast<bool *>(context);
  if (type == PETSC_ERROR_REPEAT) return code;
  if (code == PETSC_ERR_MEM) return OutOfMemory();
  // What these files of PETSc find wrong is a value of one of its options; the last opens files on the first rank alone.
  const bool petsc_option =
      code == PETSC_ERR_ARG_UNKNOWN_TYPE || EndsWith(file, {"options.c", "aoptions.c", "viewreg.c", "filev.c"});
  if (code != PETSC_ERR_USER_INPUT && !petsc_option)
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, context);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const char *what =
      petsc_option ? "a PETSc option, -log_view, -contact_ksp_... or another, has a value that is not allowed: " : "";
  if (rank == 0 && !*of_user) std::fprintf(stderr, "mlgimp: error: %s%s\n", what, OneLine(message).c_str());
  *of_user = !EndsWith(file, {"filev.c"});
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

/// Call before MPI_Init. What the user has chosen stays.
static void ChooseLayersOfMpi()
{
  AvoidSharedFilePointers();
  // Halos are small: copying them through shared memory takes less than asking the kernel to copy, which containers forbid.
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
}

int main(int argc, char **argv)
{
  int rank = 0, ranks = 1;
  std::signal(SIGXFSZ, SIG_IGN); // a file that may not grow is told like a full disk
  ChooseLayersOfMpi();
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::string message = rank == 0 ? CheckCommandLine(argc, argv) : "";
  int bad = !message.empty();
  MPI_Bcast(&bad, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (bad) {
    if (rank == 0) std::fprintf(stderr, "mlgimp: error: %s\n", OneLine(message).c_str());
    MPI_Finalize();
    return 1;
  }
  bool of_user = false; // such an error is that of all ranks alike; any other may be one rank's, and the others would wait
  PetscErrorCode code = PetscPushErrorHandler(OneLineHandler, &of_user);
  if (!code) code = PetscInitialize(&argc, &argv, nullptr, kHelp);
  if (!code) {
    try {
      code = Main();
    } catch (const std::bad_alloc &) {
      code = OutOfMemory();
    }
    if (code && !of_user) MPI_Abort(MPI_COMM_WORLD, 1);
    const PetscErrorCode end = PetscFinalize(); // reads options too
    if (end && !of_user) MPI_Abort(MPI_COMM_WORLD, 1);
    if (!code) code = end;
  }
  MPI_Finalize();
  return code ? 1 : 0;
}
