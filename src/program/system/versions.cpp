// The versions of the program and of the libraries that it runs with.
#include "program/system/versions.hpp"

#include "base/petsc.hpp"
#include "base/text.hpp"
#include "program/system/hdf5_file.hpp"

#include <algorithm>

namespace mlgimp
{

static constexpr const char *kVersion = "0.2";

std::vector<std::pair<std::string, std::string>> Versions()
{
  unsigned major, minor, release;
  int length;
  char library[MPI_MAX_LIBRARY_VERSION_STRING];
  const auto join = [](auto a, auto b, auto c) { return Format("{}.{}.{}", a, b, c); };
  H5get_libversion(&major, &minor, &release);
  MPI_Get_library_version(library, &length);
  const std::string name(library, std::min<std::size_t>(std::string(library).find(','), static_cast<std::size_t>(length)));
  return {{"mlgimp", kVersion},
          {"PETSc", join(PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
          {"MPI", name},
          {"HDF5", join(major, minor, release)}};
}

} // namespace mlgimp
