// mlgimp: multi-level generalized interpolation material point method for indentation and contact.
#include "contact/pressure_solver.hpp"
#include "program/input/read_case.hpp"
#include "program/options/command_line.hpp"
#include "program/options/presets.hpp"
#include "program/run/simulation.hpp"
#include "program/system/agree.hpp"
#include "program/system/errors.hpp"
#include "program/system/hdf5_file.hpp"
#include "program/system/signals.hpp"
#include "program/system/versions.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>

namespace
{

using namespace mlgimp;

/// For -fp_trap, whose handler prints eight lines about debuggers beside the error.
PetscErrorCode PrintNothing(const char *, ...) { return PETSC_SUCCESS; }

/// The summary has shares of the time from PETSc's log. One that an option has begun stays: the other would take its place.
void BeginLog()
{
  PetscBool begun = PETSC_FALSE;
  ExitOnError(PetscLogIsActive(&begun));
  if (!begun) ExitOnError(PetscLogDefaultBegin());
}

/// Why one of PETSc's views TYPE:FILE:FORMAT of the log cannot be written; an empty string where it can.
std::string WrongLogView(const std::string &view)
{
  const std::vector<std::string> parts = Split(view, ':');
  if (!parts[0].empty() && parts[0] != PETSCVIEWERASCII)
    return Format("must be [{}][:FILE][:FORMAT], as :log.txt for a file", PETSCVIEWERASCII);
  if (parts.size() < 2 || parts[1].empty()) return "";
  const Descriptor file(open(parts[1].c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666), close);
  return file.Valid() ? "" : CannotWrite(parts[1], errno);
}

/// -log_view is written when all is done: what cannot be is refused before the first step.
void CheckLogView(MPI_Comm comm)
{
  std::string views;
  if (!FindValue("-log_view", &views) || views.empty()) return;
  const std::string problem = OnFirstRank(comm, "log_view", [&]() -> std::string {
    for (const std::string &view : Split(views, ','))
      if (const std::string wrong = WrongLogView(view); !wrong.empty()) return Format("-log_view {}: {}", Shortened(view), wrong);
    return "";
  });
  if (problem.empty()) return;
  // Else PETSc would try to write it when it ends, and wait for the first rank.
  ExitOnError(PetscOptionsClearValue(nullptr, "-log_view"));
  Refuse(problem);
}

/// Returns the signal that the run has been stopped by, else 0.
int Main(const CommandLine &line, const std::string &program)
{
  PetscBool help = PETSC_FALSE, traps = PETSC_FALSE;
  Case settings;
  BeginLog();
  if (line.help) {
    ExitOnError(PetscPrintf(PETSC_COMM_WORLD, "%s", HelpHead(program).c_str()));
    ExitOnError(PetscOptionsSetValue(nullptr, "-help", nullptr));
  }
  ExitOnError(PetscOptionsHasHelp(nullptr, &help));
  ExitOnError(PetscOptionsHasName(nullptr, nullptr, "-fp_trap", &traps));
  if (traps) PetscErrorPrintf = PrintNothing;
  OptionReader reader(PETSC_COMM_WORLD, help);
  settings.name = line.name;
  ReadCase(reader, &settings);
  if (help) {
    PressureSolver solver; // lists the options of the contact solver
    ExitOnError(solver.Create());
    return 0;
  }
  CheckLogView(PETSC_COMM_WORLD);
  Simulation simulation(settings);
  simulation.SetUp(PETSC_COMM_WORLD);
  RefuseUnused(reader.Known());
  simulation.WarnAtStart(reader.Warnings());
  if (!settings.output.check.empty()) {
    simulation.Check();
    return 0;
  }
  const int signal = simulation.Run();
  WarnUnused(PETSC_COMM_WORLD);
  return signal;
}

} // namespace

/// Call before MPI_Init. What the user has chosen stays.
static void ChooseLayersOfMpi()
{
  PrepareHdf5();
  // Halos are small: copying them through shared memory takes less than asking the kernel to copy, which containers forbid.
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
  // A process by itself needs no daemon beside it, which would start others if it asked for them.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
}

/// The words of a command line as main gets them; PETSc keeps the pointers.
static std::vector<char *> Pointers(char *program, std::vector<std::string> &all)
{
  std::vector<char *> pointers = {program};
  for (std::string &word : all) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// PETSc's help on its own options, behind ours: PETSc prints it when it starts.
static PetscErrorCode PrintPetscHelp(char *program)
{
  std::vector<std::string> help = {"-help", "-no_signal_handler"}; // its handlers print a trace where a pipe ends early
  std::vector<char *> words = Pointers(program, help);
  int count = static_cast<int>(words.size()) - 1;
  char **first = words.data();
  const PetscErrorCode code = PetscInitialize(&count, &first, nullptr, nullptr);
  return code ? code : PetscFinalize();
}

int main(int argc, char **argv)
{
  std::signal(SIGXFSZ, SIG_IGN); // a file at its size limit is reported like a full disk
  ChooseLayersOfMpi();
  MPI_Init(&argc, &argv);
  const int rank = RankIn(MPI_COMM_WORLD);
  CommandLine line = ReadCommandLine(argc, argv);
  if (line.version && line.problem.empty()) {
    for (const auto &[name, version] : Versions())
      if (rank == 0) std::printf("%s %s\n", name.c_str(), version.c_str());
    MPI_Finalize();
    return 0;
  }
  if (line.presets && line.problem.empty()) {
    if (rank == 0) std::fputs(PresetTable().c_str(), stdout);
    MPI_Finalize();
    return 0;
  }
  if (argc == 1 || !line.problem.empty()) {
    if (rank == 0 && argc == 1) std::fputs(Usage(argv[0]).c_str(), stderr);
    if (rank == 0 && argc > 1) std::fprintf(stderr, "mlgimp: error: %s\n", OneLine(line.problem).c_str());
    MPI_Finalize();
    return 1;
  }
  std::vector<char *> words = Pointers(argv[0], line.words);
  int count = static_cast<int>(words.size()) - 1;
  char **first = words.data();
  int signal = 0;
  ErrorExit errors;
  PetscErrorCode code = errors.Install();
  if (!code) code = PetscInitialize(&count, &first, nullptr, nullptr);
  if (!code) {
    InstallSignals(RanksOf(MPI_COMM_WORLD));
    if (line.help) std::signal(SIGPIPE, SIG_DFL); // as any program in a pipe
    try {
      signal = Main(line, argv[0]);
    } catch (const Refused &) { // its line is printed; nothing else is caught, see errors.hpp
      code = PETSC_ERR_USER_INPUT;
    }
    if (code) PetscOptionsSetValue(nullptr, "-options_left", "false"); // do not list unused options after an error
    const PetscErrorCode end = PetscFinalize();                        // reads options too
    if (!code) code = end;
    if (!code && line.help) code = PrintPetscHelp(argv[0]);
  }
  errors.Free();
  MPI_Finalize();
  if (!code && signal) EndBy(signal);
  return code ? 1 : 0;
}
