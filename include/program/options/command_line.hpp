// The command line and the options files that it names, as words for PETSc.
#pragma once

#include "base/petsc.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// What the user has typed. Options files are read here, once, so that pipes will do, and stand in the words at their place.
struct CommandLine {
  std::vector<std::string> words; ///< "-name", "value", ...; what comes later overrides
  std::string name;               ///< of the last options file, without folder and ending; "run" where there is none
  std::string problem;            ///< one line, or empty
  bool help = false;              ///< -help, --help or -h was among the words, and is there no more
  bool version = false;           ///< -version or --version was, likewise
  bool presets = false;           ///< -presets or --presets
};

/// Reads it on the first rank and gives it to all. Call after MPI_Init, before PetscInitialize. Collective.
CommandLine ReadCommandLine(int argc, char **argv);

/// What the program says where it is started without any option, and what -help begins with. program: as it was called. Files
/// that they name are those that lie beside the program, in the project or as installed.
std::string Usage(const std::string &program);
std::string HelpHead(const std::string &program);

} // namespace mlgimp
