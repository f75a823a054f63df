// summary.json: what a run was, how it ended and what it cost.
#include "program/run/summary.hpp"

#include "base/index.hpp"
#include "program/slow_test/clock.hpp"
#include "program/system/agree.hpp"
#include "program/system/files.hpp"
#include "program/system/versions.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace mlgimp
{

namespace
{

using Json = nlohmann::ordered_json;

/// Counts are sums of doubles, but whole; what is not finite becomes null.
Json Number(double x)
{
  return std::abs(x) <= kLargestWhole && x == std::floor(x) ? Json(static_cast<std::int64_t>(x)) : Json(x);
}

Json Numbers(Vec3 x, int dim)
{
  Json list = Json::array();
  for (int axis = 0; axis < dim; ++axis) list.push_back(Number(x[axis]));
  return list;
}

/// Seconds in an event over the stages of all levels, on this rank.
double EventSeconds(const std::vector<PetscLogStage> &stages, PetscLogEvent event)
{
  PetscEventPerfInfo info;
  double seconds = 0;
  for (PetscLogStage stage : stages) {
    ExitOnError(PetscLogEventGetPerfInfo(stage, event, &info));
    seconds += info.time;
  }
  return seconds;
}

/// Whether -log_view is in a format for which PETSc keeps times by their place in a tree of events, and not of events alone.
bool LogsTree()
{
  std::string viewer;
  FindValue("-log_view", &viewer);
  return viewer.find("ascii_xml") != std::string::npos || viewer.find("ascii_flamegraph") != std::string::npos;
}

Json VersionsJson()
{
  Json json;
  for (const auto &[name, version] : Versions()) json[name] = version;
  return json;
}

Json LevelJson(Level &level, double points, double largest, double time_step)
{
  const GridGeometry &grid = level.Geometry().grid;
  const int ranks = level.Mesh().Nodes().Layout().Blocks();
  const auto upper = [&](int axis) { return grid.lower[axis] + grid.cells[axis] * grid.spacing; };
  return {{"lower", Numbers(grid.lower, grid.dim)},
          {"upper", Numbers({upper(0), upper(1), upper(2)}, grid.dim)},
          {"cell_size", Number(grid.spacing)},
          {"points", Number(points)},
          {"cells", static_cast<long>(grid.cells[0]) * grid.cells[1] * (grid.dim == 3 ? grid.cells[2] : 1)},
          {"steps", level.Step().taken},
          {"time_step", Number(time_step)},
          {"imbalance", Number(points > 0 ? largest * ranks / points : 1)},
          {"ranks", ranks}};
}

/// {name: value} of "name value", as text.
Json OptionsJson(const std::vector<std::string> &options)
{
  Json json = Json::object();
  for (const std::string &option : options) {
    const std::size_t space = option.find(' ');
    json[option.substr(0, space)] = option.substr(space + 1);
  }
  return json;
}

/// Those that are shown there, in the order of the table.
Json BudgetsJson(const Budgets &budgets, Shown shown, int dim)
{
  Json json = Json::object();
  for (const Budget &row : budgets)
    if (row.shown == shown) json[row.name] = row.components > 1 ? Numbers(row.value, dim) : Number(row.value[0]);
  return json;
}

/// What a slow test has chosen, and what inertia and damping came to.
Json QuasiStaticJson(const Case &c, const QuasiStaticWatch &watch)
{
  const QuasiStaticPlan &plan = c.quasi_static;
  return {{"tolerance", plan.tolerance},
          {"transit", Number(plan.pace.transit)},
          {"transits", Number(plan.pace.transits)},
          {"distance", Number(plan.distance)},
          {"start", Number(plan.pace.start)},
          {"speed", Number(watch.SoFar().speed)},
          {"speed_over_wave_speed", Number(watch.SoFar().speed / plan.wave_speed)},
          {"damping", Number(c.model.nodal.damping)},
          {"damping_ratio", Number(plan.damping_ratio)},
          {"xpic_fraction", Number(c.model.nodal.xpic_fraction)},
          {"cfl", Number(c.time.cfl)},
          {"end_time", Number(plan.end_time)},
          {"kinetic_over_internal", Number(watch.SoFar().kinetic_share)},
          {"added_load", Number(watch.SoFar().load_share)},
          {"noise_over_work", Number(watch.SoFar().noise_share)},
          {"hold_drift", Number(watch.SoFar().hold_drift)}};
}

/// The legs of a test that has a clock, and how many transits of a wave each has taken.
Json TestJson(const TestPlan &test, const RunState &state)
{
  Json legs = Json::array();
  for (std::size_t k = 0; k < test.legs.size(); ++k) {
    const TestLeg &leg = test.legs[k];
    legs.push_back({{"hold", leg.Holds()},
                    {"from", Number(leg.times.front())},
                    {"to", Number(leg.times.back())},
                    {"transits", Number(TestClock::TransitsOf(state.test.clock, k))}});
  }
  return {{"time", Number(state.test.time)}, {"creep", Number(test.creep)}, {"legs", legs}};
}

Json MovesJson(const std::vector<LevelMove> &moves, int dim)
{
  Json list = Json::array();
  for (const LevelMove &move : moves)
    list.push_back({{"step", Number(move.step)},
                    {"time", Number(move.time)},
                    {"level", move.level},
                    {"active", move.active},
                    {"lower", Numbers(move.box.lower, dim)},
                    {"upper", Numbers(move.box.upper, dim)},
                    {"split", Number(move.split)},
                    {"merged", Number(move.merged)},
                    {"mass_error", Number(move.mass_error)},
                    {"momentum_error", Number(move.momentum_error)},
                    {"energy", Number(move.energy)}});
  return list;
}

} // namespace

std::string WriteSummary(const Case &c, Hierarchy &hierarchy, const RunState &state, const RunCost &cost, const RowWriter &rows,
                         const std::string &status)
{
  const MPI_Comm comm = hierarchy.Comm();
  const std::vector<PetscLogStage> &stages = hierarchy.Stages();
  enum { kSteps, kPointSteps, kContact, kHalo, kTransfer, kCoupling, kSweep, kTimes };
  double times[kTimes] = {cost.level_seconds,
                          cost.point_steps,
                          EventSeconds(stages, cost.events.contact),
                          EventSeconds(stages, cost.events.halo),
                          EventSeconds(stages, cost.events.transfer),
                          EventSeconds(stages, cost.events.coupling),
                          EventSeconds(stages, cost.events.points_to_grid)};
  MPI_Allreduce(MPI_IN_PLACE, times, kTimes, MPI_DOUBLE, MPI_SUM, comm);
  const bool has_times = times[kSweep] > 0 && !LogsTree(); // another log, as -log_trace, may keep none
  const auto share = [&](int event) { return has_times ? Number(times[event] / std::max(times[kSteps], 1e-30)) : Json(nullptr); };
  double mapped = 0, unmapped = 0;
  Budgets budgets;
  ExitOnError(hierarchy.ReduceBudgets(&budgets));
  ExitOnError(hierarchy.Connected().BytesBetweenLevels(&mapped, &unmapped));
  const double created = Case::PointsCreated(budgets) - state.initial_created;
  Json levels = Json::array();
  std::vector<double> points, largest;
  ExitOnError(hierarchy.Connected().CountPoints(&points, &largest));
  for (int l = 0; l < hierarchy.Levels(); ++l)
    levels.push_back(LevelJson(hierarchy.At(l), points[l], largest[l], state.time_step / std::pow(c.hierarchy.ratio, l)));
  Json json = {{"status", status},
               {"case", c.name},
               {"ranks", RanksOf(comm)},
               {"levels", levels},
               {"steps", state.step},
               {"simulated_time", Number(state.time)},
               {"wall_seconds", Number(MPI_Wtime() - cost.begin)},
               {"seconds_per_point_step", Number(times[kPointSteps] > 0 ? times[kSteps] / times[kPointSteps] : 0)},
               {"contact_share", share(kContact)},
               {"halo_share", share(kHalo)},
               {"transfer_share", share(kTransfer)},
               {"coupling_share", share(kCoupling)},
               {"bytes_between_levels", {{"mapped", Number(mapped)}, {"unmapped", Number(unmapped)}}},
               {"mass_error", Number(budgets.mass / state.initial_mass - 1)},
               {"points_created", Number(created)},
               {"points_lost", Number(state.initial_points + created - budgets.points)},
               {"transfers", BudgetsJson(budgets, Shown::kTransfers, c.Dim())}};
  json.update(BudgetsJson(budgets, Shown::kSummary, c.Dim()));
  json["contact_excess"] = Number(budgets.GivenByContact() + budgets.friction_work - budgets.indenter_work);
  json["noise_energy"] = Number(budgets.noise_energy);
  if (c.quasi_static.on) json["quasi_static"] = QuasiStaticJson(c, rows.Watch());
  if (c.quasi_static.test.On()) json["test"] = TestJson(c.quasi_static.test, state);
  if (c.hierarchy.follow.kind != FollowKind::kNone) json["regrids"] = MovesJson(state.moves, c.Dim());
  json["warnings"] = rows.Advice().Lines();
  json["options"] = OptionsJson(c.identity);
  json["versions"] = VersionsJson();
  return OnFirstRank(comm, "summary", [&] { // what is no UTF-8 is replaced
    return ReplaceFile(c.output.directory + "/summary.json", json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  });
}

} // namespace mlgimp
