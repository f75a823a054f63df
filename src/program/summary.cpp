// Writing of summary.json.
#include "program/summary.hpp"

#include "program/agree.hpp"
#include "program/files.hpp"
#include "program/hdf5_file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace mlgimp
{

namespace
{

using Json = nlohmann::ordered_json;

/// Counts are sums of doubles, but whole; what is not finite becomes null.
Json Number(double x)
{
  constexpr double kLargestWhole = 9007199254740992; // 2^53
  return std::abs(x) <= kLargestWhole && x == std::floor(x) ? Json(static_cast<std::int64_t>(x)) : Json(x);
}

Json Numbers(Vec3 x, int dim)
{
  Json list = Json::array();
  for (int axis = 0; axis < dim; ++axis) list.push_back(Number(x[axis]));
  return list;
}

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

Json Versions()
{
  unsigned major, minor, release;
  int length;
  char library[MPI_MAX_LIBRARY_VERSION_STRING];
  const auto join = [](auto a, auto b, auto c) { return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c); };
  H5get_libversion(&major, &minor, &release);
  MPI_Get_library_version(library, &length);
  const std::string name(library, std::min<std::size_t>(std::string(library).find(','), static_cast<std::size_t>(length)));
  return {{"mlgimp", kVersion},
          {"PETSc", join(PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
          {"MPI", name},
          {"HDF5", join(major, minor, release)}};
}

Json LevelJson(const Level &level, double points, double largest, double time_step)
{
  const GridGeometry &grid = level.Geometry().grid;
  const int ranks = level.Mesh().Layout().Blocks();
  const auto upper = [&](int axis) { return grid.lower[axis] + grid.cells[axis] * grid.spacing; };
  return {{"lower", Numbers(grid.lower, grid.dim)},
          {"upper", Numbers({upper(0), upper(1), upper(2)}, grid.dim)},
          {"cell_size", Number(grid.spacing)},
          {"points", Number(points)},
          {"cells", static_cast<long>(grid.cells[0]) * grid.cells[1] * (grid.dim == 3 ? grid.cells[2] : 1)},
          {"steps", level.Steps()},
          {"time_step", Number(time_step)},
          {"imbalance", Number(points > 0 ? largest * ranks / points : 1)},
          {"ranks", ranks}};
}

/// Those that are shown there, in the order of the table.
Json BudgetsJson(const Budgets &budgets, Shown shown, int dim)
{
  Json json = Json::object();
  for (const Budget &row : budgets)
    if (row.shown == shown) json[row.name] = row.components > 1 ? Numbers(row.value, dim) : Number(row.value[0]);
  return json;
}

} // namespace

PetscErrorCode WriteSummary(const SummaryInput &in, std::string *problem)
{
  PetscMPIInt rank, ranks;
  Budgets budgets;
  Hierarchy &hierarchy = in.hierarchy;
  double times[6] = {in.step_seconds, 0, 0, 0, in.point_steps, 0};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCallMPI(MPI_Comm_size(hierarchy.Comm(), &ranks));
  PetscCall(hierarchy.ReduceBudgets(&budgets));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.contact, &times[1]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.halo, &times[2]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.transfer, &times[3]));
  PetscCall(EventSeconds(hierarchy.Stages(), in.events.coupling, &times[5]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, times, 6, MPI_DOUBLE, MPI_SUM, hierarchy.Comm()));
  const double total = std::max(times[0], 1e-30);
  double mapped = 0, unmapped = 0;
  hierarchy.BytesBetweenLevels(&mapped, &unmapped);
  const int ratio = in.settings.hierarchy.ratio;
  const double created =
      (budgets.points_split - budgets.points_merged) * (std::pow(ratio, in.settings.Dim()) - 1) - in.state.initial_created;
  Json levels = Json::array();
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    double points = 0, largest = 0;
    PetscCall(hierarchy.PointsOn(l, &points, &largest));
    levels.push_back(LevelJson(hierarchy.At(l), points, largest, in.state.time_step / std::pow(ratio, l)));
  }
  Json json = {{"status", in.status},
               {"case", in.settings.name},
               {"ranks", ranks},
               {"levels", levels},
               {"steps", in.state.step},
               {"simulated_time", Number(in.state.time)},
               {"wall_seconds", Number(in.wall_seconds)},
               {"seconds_per_point_step", Number(times[4] > 0 ? times[0] / times[4] : 0)},
               {"contact_share", Number(times[1] / total)},
               {"halo_share", Number(times[2] / total)},
               {"transfer_share", Number(times[3] / total)},
               {"coupling_share", Number(times[5] / total)},
               {"bytes_between_levels", {{"mapped", Number(mapped)}, {"unmapped", Number(unmapped)}}},
               {"mass_error", Number(budgets.mass / in.state.initial_mass - 1)},
               {"points_created", Number(created)},
               {"points_lost", Number(in.state.initial_points + created - budgets.points)},
               {"transfers", BudgetsJson(budgets, Shown::kTransfers, in.settings.Dim())}};
  json.update(BudgetsJson(budgets, Shown::kSummary, in.settings.Dim()));
  json["versions"] = Versions();
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; // what is no UTF-8 is replaced
  if (rank == 0) *problem = ReplaceFile(in.settings.output.directory + "/summary.json", text);
  PetscCall(Agree(hierarchy.Comm(), "summary", problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
