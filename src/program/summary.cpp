// Writing of summary.json.
#include "program/summary.hpp"

#include "program/agree.hpp"
#include "program/files.hpp"
#include "program/hdf5_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace mlgimp
{

namespace
{

std::string Quoted(const std::string &text)
{
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  }
  return quoted + "\"";
}

std::string Pair(Vec2 x) { return "[" + FormatNumber(x[0]) + ", " + FormatNumber(x[1]) + "]"; }

/// Seconds in an event over the stages of all levels, on this rank.
PetscErrorCode EventSeconds(const std::vector<PetscLogStage> &stages, PetscLogEvent event, double *seconds)
{
  PetscEventPerfInfo info;
  PetscFunctionBeginUser;
  *seconds = 0;
  for (PetscLogStage stage : stages) {
    PetscCall(PetscLogEventGetPerfInfo(stage, event, &info));
    *seconds += info.time;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string Versions()
{
  unsigned major, minor, release;
  int mpi_major, mpi_minor, length;
  char library[MPI_MAX_LIBRARY_VERSION_STRING];
  std::ostringstream json;
  H5get_libversion(&major, &minor, &release);
  MPI_Get_version(&mpi_major, &mpi_minor);
  MPI_Get_library_version(library, &length);
  const std::string name(library, std::min<std::size_t>(std::string(library).find(','), static_cast<std::size_t>(length)));
  json << "{\"mlgimp\": " << Quoted(kVersion) << ", \"PETSc\": \"" << PETSC_VERSION_MAJOR << '.' << PETSC_VERSION_MINOR << '.'
       << PETSC_VERSION_SUBMINOR << "\", \"MPI\": " << Quoted(name) << ", \"HDF5\": \"" << major << '.' << minor << '.' << release
       << "\"}";
  return json.str();
}

std::string LevelJson(const Level &level, double points, double largest, double time_step)
{
  const GridGeometry &grid = level.Geometry().grid;
  const int ranks = level.Mesh().Layout().Blocks();
  std::ostringstream json;
  json << "{\"lower\": " << Pair(grid.lower) << ", \"upper\": "
       << Pair(grid.lower + grid.spacing * Vec2{static_cast<double>(grid.cells[0]), static_cast<double>(grid.cells[1])})
       << ", \"cell_size\": " << FormatNumber(grid.spacing) << ", \"points\": " << FormatNumber(points)
       << ", \"cells\": " << static_cast<long>(grid.cells[0]) * grid.cells[1] << ", \"steps\": " << level.Steps()
       << ", \"time_step\": " << FormatNumber(time_step)
       << ", \"imbalance\": " << FormatNumber(points > 0 ? largest * ranks / points : 1) << ", \"ranks\": " << ranks << "}";
  return json.str();
}

} // namespace

PetscErrorCode WriteSummary(const SummaryInput &in, std::string *problem)
{
  PetscMPIInt rank, ranks;
  Books books;
  Hierarchy &hierarchy = in.hierarchy;
  double times[6] = {in.step_seconds, 0, 0, 0, in.point_steps, 0};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCallMPI(MPI_Comm_size(hierarchy.Comm(), &ranks));
  PetscCall(hierarchy.ReduceBooks(&books));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.contact, &times[1]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.halo, &times[2]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.transfer, &times[3]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.coupling, &times[5]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, times, 6, MPI_DOUBLE, MPI_SUM, hierarchy.Comm()));
  const double total = std::max(times[0], 1e-30);
  double mapped = 0, unmapped = 0;
  hierarchy.BytesBetweenLevels(&mapped, &unmapped);
  const int ratio = in.settings.hierarchy.ratio;
  const double created = (books.points_split - books.points_merged) * (ratio * ratio - 1) - in.state.initial_created;
  std::ostringstream json;
  json << "{\n  \"status\": " << Quoted(in.status) << ",\n  \"case\": " << Quoted(in.settings.name) << ",\n  \"ranks\": " << ranks
       << ",\n  \"levels\": [";
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    double points = 0, largest = 0;
    PetscCall(hierarchy.PointsOn(l, &points, &largest));
    json << (l ? ", " : "") << "\n    " << LevelJson(hierarchy.At(l), points, largest, in.state.time_step / std::pow(ratio, l));
  }
  json << "\n  ],\n  \"steps\": " << in.state.step << ",\n  \"simulated_time\": " << FormatNumber(in.state.time)
       << ",\n  \"wall_seconds\": " << FormatNumber(in.wall_seconds)
       << ",\n  \"seconds_per_point_step\": " << FormatNumber(times[4] > 0 ? times[0] / times[4] : 0)
       << ",\n  \"contact_share\": " << FormatNumber(times[1] / total)
       << ",\n  \"halo_share\": " << FormatNumber(times[2] / total)
       << ",\n  \"transfer_share\": " << FormatNumber(times[3] / total)
       << ",\n  \"coupling_share\": " << FormatNumber(times[5] / total)
       << ",\n  \"bytes_between_levels\": {\"mapped\": " << FormatNumber(mapped) << ", \"unmapped\": " << FormatNumber(unmapped)
       << "},\n  \"mass_error\": " << FormatNumber(books.mass / in.state.initial_mass - 1)
       << ",\n  \"points_created\": " << FormatNumber(created)
       << ",\n  \"points_lost\": " << FormatNumber(in.state.initial_points + created - books.points)
       << ",\n  \"transfers\": {\"entered\": " << FormatNumber(books.points_entered)
       << ", \"left\": " << FormatNumber(books.points_left) << ", \"split\": " << FormatNumber(books.points_split)
       << ", \"merged\": " << FormatNumber(books.points_merged) << ", \"mass_error\": " << FormatNumber(books.transfer_mass_error)
       << ", \"momentum_error\": " << FormatNumber(books.transfer_momentum_error)
       << ", \"points_adrift\": " << FormatNumber(books.points_adrift) << ", \"mass_adrift\": " << FormatNumber(books.mass_adrift)
       << ", \"momentum_adrift\": " << Pair({books.momentum_adrift[0], books.momentum_adrift[1]}) << "}"
       << ",\n  \"contact_steps\": " << FormatNumber(books.contact_steps)
       << ",\n  \"contact_set_updates\": " << FormatNumber(books.contact_set_updates)
       << ",\n  \"contact_fallbacks\": " << FormatNumber(books.contact_fallbacks)
       << ",\n  \"clamped_half_sizes\": " << FormatNumber(books.clamped_sizes) << ",\n  \"versions\": " << Versions() << "\n}\n";
  if (rank == 0) *problem = ReplaceFile(in.settings.output.directory + "/summary.json", json.str());
  PetscCall(Agree(hierarchy.Comm(), "summary", problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
