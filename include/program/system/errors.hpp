// The end of a run by an error: one line, printed once, and no rank that waits for another.
//
// An error of all ranks alike, as a refused option is, ends the program cleanly. After an error of some ranks alone the others
// would wait for ever, so that these ranks end all. Which it is shows by whether all ranks arrive within a few seconds.
#pragma once

#include "base/petsc.hpp"
#include "base/text.hpp"

#include <stdexcept>
#include <string>

namespace mlgimp
{

/// Ends all ranks together after the error line was printed, so that destructors may wait for other ranks.
/// For main and tests alone to catch; what() is the line.
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Ends the run with one line that all ranks agree on.
[[noreturn]] void Refuse(const std::string &line);
template <class... Values> [[noreturn]] void Refuse(const char *line, const Values &...values)
{
  Refuse(Format(line, values...));
}

/// Ends the run after PETSc has failed and has printed its error.
inline void ExitOnError(PetscErrorCode code)
{
  if (code) throw Refused("PETSc");
}

/// A line "mlgimp: warning: ..." by the first rank.
void Warn(MPI_Comm comm, const std::string &line);

/// A message as one line that no terminal takes for orders: other characters become question marks.
std::string OneLine(std::string text);

/// What out-of-memory errors say, of whatever library.
inline constexpr char kOutOfMemory[] = "out of memory; try a larger -cell_size, or more machines";

class ErrorExit
{
public:
  /// Call after MPI_Init and before PetscInitialize; catches PETSc's errors, exceptions and failures of `new` from there on,
  /// where they happen: before destructors run that may wait for other ranks.
  PetscErrorCode Install();
  /// Returns where all ranks call it; else prints the line and ends all. The first call counts.
  void Meet(const std::string &line);
  void Free();

private:
  static PetscErrorCode Handle(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                               PetscErrorType type, const char *message, void *context);
  bool AllArrive() const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  bool met_ = false;
};

} // namespace mlgimp
