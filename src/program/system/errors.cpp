// The end of a run by an error.
#include "program/system/errors.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <new>
#include <unistd.h>

namespace mlgimp
{

std::string OneLine(std::string text)
{
  while (!text.empty() && text.back() == '\n') text.pop_back(); // PETSc's messages end with one
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c); }, '?');
  return text;
}

void Warn(MPI_Comm comm, const std::string &line)
{
  if (RankIn(comm) == 0) std::fprintf(stderr, "mlgimp: warning: %s\n", OneLine(line).c_str());
}

static void PrintError(const std::string &line) { std::fprintf(stderr, "mlgimp: error: %s\n", OneLine(line).c_str()); }

/// Ends all ranks; one that is alone without MPI's ten lines about it.
[[noreturn]] static void EndAll()
{
  if (RanksOf(MPI_COMM_WORLD) > 1) MPI_Abort(MPI_COMM_WORLD, 1);
  _exit(1);
}

/// The last words of a program that has no memory left, without asking for any.
[[noreturn]] static void EndWithoutMemory()
{
  constexpr char kStart[] = "mlgimp: error: ", kEnd[] = "\n";
  for (const char *part : {kStart, kOutOfMemory, kEnd}) (void)!write(STDERR_FILENO, part, std::char_traits<char>::length(part));
  EndAll();
}

static ErrorExit *installed = nullptr; ///< a handler of exceptions gets nothing from its caller

void Refuse(const std::string &line)
{
  if (installed) installed->Meet(line);
  throw Refused(line);
}

/// Uncaught exceptions end here before any object is destroyed: destructors may wait for other ranks, as that of a file.
[[noreturn]] static void EndByException()
{
  std::string line = "unknown exception";
  try {
    std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc &) {
    line = kOutOfMemory;
  } catch (const std::exception &error) {
    line = error.what();
  }
  installed->Meet(line);
  MPI_Finalize();
  _exit(1);
}

PetscErrorCode ErrorExit::Install()
{
  MPI_Comm_dup(MPI_COMM_WORLD, &comm_); // its own, so that no collective call that is under way meets it
  rank_ = RankIn(comm_);
  installed = this;
  std::set_new_handler(EndWithoutMemory);
  std::set_terminate(EndByException);
  return PetscPushErrorHandler(Handle, this);
}

void ErrorExit::Free() { MPI_Comm_free(&comm_); }

/// True where every rank gets here within a few seconds.
bool ErrorExit::AllArrive() const
{
  constexpr double kTimeout = 3; // size: s
  const double start = MPI_Wtime();
  MPI_Request arrival;
  int done = 0;
  MPI_Ibarrier(comm_, &arrival);
  for (MPI_Test(&arrival, &done, MPI_STATUS_IGNORE); !done && MPI_Wtime() - start < kTimeout;) {
    usleep(1000);
    MPI_Test(&arrival, &done, MPI_STATUS_IGNORE);
  }
  return done;
}

void ErrorExit::Meet(const std::string &line)
{
  if (met_) return;
  met_ = true;
  if (AllArrive()) {
    if (rank_ == 0) PrintError(line);
    return;
  }
  constexpr useconds_t kTurn = 200000, kLastTurn = 2000000; // size: us; the first of several ranks that fail ends the others
  usleep(std::min(static_cast<useconds_t>(rank_) * kTurn, kLastTurn));
  PrintError(line);
  EndAll();
}

/// Every error of PETSc and of our own calls passes here.
PetscErrorCode ErrorExit::Handle(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                 PetscErrorType type, const char *message, void *context)
{
  const std::string text = message ? OneLine(message) : "", where = function ? function : "unknown";
  if (type == PETSC_ERROR_REPEAT) return code;
  switch (code) {
  case PETSC_ERR_MEM:
    static_cast<ErrorExit *>(context)->Meet(kOutOfMemory);
    break;
  case PETSC_ERR_SIG: // a defect: the trace helps
    return PetscTraceBackErrorHandler(comm, line, function, file ? file : "unknown", code, type, message, nullptr);
  case PETSC_ERR_FP: // PETSc aborts next
    PrintError("floating-point exception (-fp_trap); infinite values are normal here for what has no limit");
    EndAll();
  default:
    if (where == "PetscReallocAlign") { // whose error for missing memory has another number
      static_cast<ErrorExit *>(context)->Meet(kOutOfMemory);
      break;
    }
    static_cast<ErrorExit *>(context)->Meet(
        Format("PETSc: {} (error {} in {}); if a PETSc option was given, see its value; -on_error_abort shows where", text, code,
               where));
  }
  return code;
}

} // namespace mlgimp
