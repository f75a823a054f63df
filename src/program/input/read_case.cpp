// Options to case, group by group.
#include "program/input/read_case.hpp"

#include "program/advice/case_checks.hpp"

#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <limits>
#include <unistd.h>

namespace mlgimp
{

namespace
{

const Range kCellSizes = Closed(1e-100, 1e100); ///< size: m

void ReadGeometry(OptionReader &reader, Geometry *geometry)
{
  const std::vector<std::string> kinds(std::begin(kGeometryNames), std::end(kGeometryNames));
  std::string kind = kinds[0];
  geometry->kind = static_cast<GeometryKind>(
      reader.Choice({"-geometry", "kinematics; in axisymmetry x is the radius and y the axis"}, kinds, &kind));
  if (reader.Read({"-thickness", "plane_strain: out-of-plane thickness", "m", kPositive}, &geometry->thickness) &&
      geometry->kind != GeometryKind::kPlaneStrain)
    reader.Refuse("-thickness", geometry->thickness, "left out with -geometry {}: it is of plane strain", kind);
  reader.SetDim(geometry->Dim());
}

const std::vector<std::string> kSideKinds = {"free", "symmetry", "fixed"}; // in the order of BoundaryKind

/// In axisymmetry the domain begins at the axis, which is a side of symmetry, or beyond it.
void CheckAxis(OptionReader &reader, Case *c)
{
  const double lower = c->domain.lower[0];
  if (!c->model.geometry.HasHoop()) return;
  if (lower < 0) reader.Refuse("-domain_lower", c->domain.lower, "at x >= 0, the radius; the axis is x = 0");
  if (lower > 0 && lower < 2 * c->cell_size)
    reader.Refuse("-domain_lower", c->domain.lower, "at x = 0, the axis, or at least two cells, {}, from it", 2 * c->cell_size);
  if (lower > 0) return;
  const BoundaryKind kind = c->model.sides[kXLower];
  if (kind != BoundaryKind::kSymmetry)
    reader.Refuse("-boundary_x_lower", kSideKinds[static_cast<int>(kind)], "symmetry or left out: it is the axis");
}

void ReadGrid(OptionReader &reader, Case *c)
{
  ReadGeometry(reader, &c->model.geometry);
  reader.Read({"-domain_lower", "lower corner of the level-0 grid", "m"}, &c->domain.lower, kRequired);
  reader.Read({"-domain_upper", "upper corner of the level-0 grid", "m"}, &c->domain.upper, kRequired);
  reader.Read({"-cell_size", "edge of a level-0 cell", "m", kPositive}, &c->cell_size, kRequired);
  for (int s = 0; s < (reader.Help() ? kSides : 2 * c->Dim()); ++s) {
    const bool is_axis = c->model.geometry.HasHoop() && s == kXLower && c->domain.lower[0] == 0;
    std::string kind = is_axis && !reader.Help() ? "symmetry" : "free";
    c->model.sides[s] = static_cast<BoundaryKind>(
        reader.Choice({Format("-boundary_{}", kSideNames[s]), "side of the domain"}, kSideKinds, &kind));
  }
  if (reader.Help()) return;
  if (!kCellSizes.Contains(c->cell_size))
    reader.Refuse("-cell_size", c->cell_size, "{}, so that areas are numbers too", kCellSizes.Text());
  for (int axis = 0; axis < c->Dim(); ++axis) {
    const double edge = c->domain.upper[axis] - c->domain.lower[axis], cells = edge / c->cell_size;
    if (!(cells > 0)) reader.Refuse("-domain_upper", c->domain.upper, "above -domain_lower {}", reader.Text(c->domain.lower));
    if (cells > 1e6) reader.Refuse("-cell_size", c->cell_size, "at least a millionth of the domain's edges");
    const double whole = std::max(1.0, std::round(cells));
    if (std::abs(cells - whole) > 1e-6 * std::max(1.0, cells))
      reader.Refuse("-cell_size", c->cell_size,
                    "a whole fraction of the domain's edges {} to a millionth; {} cells along {} have {}",
                    reader.Text(c->domain.upper - c->domain.lower), FormatNumber(whole), "xyz"[axis], FormatNumber(edge / whole));
  }
  CheckAxis(reader, c);
  // Nodal values are counted by ints, also by PETSc; four more nodes an axis leave room for the grid's padding.
  const int max_nodes = std::numeric_limits<int>::max() / NodeLayout::Viewed(c->Dim());
  double nodes = 1;
  for (int axis = 0; axis < c->Dim(); ++axis) nodes *= c->Cells(axis) + 4.0;
  if (nodes > max_nodes)
    reader.Refuse("-cell_size", c->cell_size, "such that the grid has at most {} nodes; it would have {}",
                  FormatNumber(max_nodes), FormatNumber(nodes));
}

void ReadMethod(OptionReader &reader, Case *c)
{
  const std::vector<std::string> updates = {"usl", "usf", "musl"};
  std::string update = "musl";
  constexpr double kAtRest = 0.001, kByStrain = 8; // of the viscosity
  constexpr double kMetalXpic = 0.02, kIncompressibleXpic = 0.05;
  std::vector<double> viscosity = {kAtRest, kByStrain};
  Model &model = c->model;
  reader.Choice({"-shape_function", "weights of points on nodes"}, ShapeFunctions(), &model.shape_function);
  model.stress_update =
      static_cast<StressUpdate>(reader.Choice({"-stress_update", "when strain and stress advance in a step"}, updates, &update));
  if (model.stress_update == StressUpdate::kUsf && c->levels > 1)
    reader.Refuse("-stress_update", update, "usl or musl with more than one level");
  if (model.stress_update == StressUpdate::kUsf && model.VolumeAverages() > 0)
    reader.Refuse("-stress_update", update, "usl or musl with -NAME_volume_average, the default of j2");
  reader.Read({"-short_wave_viscosity",
               "a,b of the viscosity min(0.3, a + b E^2 + motion) on the short-wave strain rate; 0,0 = none", "", kNotNegative, 2,
               2},
              &viscosity);
  model.short_wave = {viscosity[0], viscosity[1]};
  for (const auto &material : model.materials) {
    constexpr double kIncompressible = 4; // lambda/mu at a Poisson's ratio of 0.4, from which borders of levels make waves
    const Elasticity &elastic = material->Elastic();
    const bool is_crystal = elastic.fastest > (1 + kRounding) * (elastic.lambda + 2 * elastic.mu);
    if (material->Traits().flows) model.nodal.xpic_fraction = std::max(model.nodal.xpic_fraction, kMetalXpic);
    if (c->levels > 1 && (is_crystal || elastic.lambda >= kIncompressible * (1 - 1e-9) * elastic.mu))
      model.nodal.xpic_fraction = kIncompressibleXpic;
  }
  c->quasi_static.own_xpic = !reader.Read({"-xpic_fraction",
                                           "share of XPIC per step in the velocity update; 0 = pure FLIP (0.02 with j2 or "
                                           "-quasi_static, 0.05 with levels and a Poisson's ratio of 0.4 or a crystal)",
                                           "", Closed(0, 1)},
                                          &model.nodal.xpic_fraction);
  reader.Read({"-xpic_order", "order of XPIC; 1 = PIC", "", Closed(1, 2)}, &model.nodal.xpic_order);
  c->quasi_static.own_damping = !reader.Read(
      {"-damping", "mass-proportional damping rate for quasi-static runs", "1/s", kNotNegative}, &model.nodal.damping);
}

void ReadTime(OptionReader &reader, Case *c)
{
  reader.Read({"-end_time", "end of the run", "s", kPositive}, &c->time.end_time);
  reader.Read({"-max_steps", "level-0 steps at which the run ends; 0 = no limit", "", kNotNegative}, &c->time.max_steps);
  reader.Read({"-time_step", "level-0 time step; 0 = from -cfl", "s", kNotNegative}, &c->time.time_step);
  const bool cfl = reader.Read(
      {"-cfl",
       "time step as a fraction of h/(c + |v|), c the current wave speed (0.6 with -quasi_static and boxes on cell lines)",
       "",
       {0, kLargestCfl, true, false}},
      &c->time.cfl);
  c->quasi_static.own_step = !cfl && c->time.time_step == 0;
  reader.Read({"-max_wall_time", "time by the clock before which the run writes a checkpoint and ends", "s", kPositive},
              &c->time.max_wall_time);
}

/// Whether a terminal shows the output. mpiexec may give ranks a terminal of its own whose lines end in a file, so the first rank
/// decides.
bool OnTerminal(MPI_Comm comm)
{
  int watched = RanksOf(comm) == 1 && isatty(STDOUT_FILENO);
  for (const char *set_by_mpiexec : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"})
    if (getenv(set_by_mpiexec)) watched = 0;
  MPI_Bcast(&watched, 1, MPI_INT, 0, comm);
  return watched;
}

/// What PETSc's viewers show of each level at the end of the run; -help lists level 0.
void ReadViewers(OptionReader &reader, int levels)
{
  for (int l = 0; l < levels; ++l) {
    const std::string start = Format("-level_{}_", l), end = " of the level at the end of the run, to one of PETSc's viewers";
    reader.Viewer({start + "dm_view", "the grid" + end});
    reader.Viewer({start + "points_view", "the points" + end});
    reader.Viewer({start + "nodes_view", "mass, momentum, velocity and force on the nodes" + end});
  }
}

void ReadOutput(OptionReader &reader, Case *c)
{
  OutputSettings &out = c->output;
  out.directory = "output/" + c->name;
  reader.Read({"-output_dir", "folder for the results (default: output/ and the name of the options file)"}, &out.directory);
  reader.Read({"-overwrite", "replace the results that the folder holds"}, &out.overwrite);
  std::string check;
  if (FindValue("-check", &check) && check.empty()) ExitOnError(PetscOptionsSetValue(nullptr, "-check", "text"));
  check = "none";
  reader.Choice(
      {"-check", "sets the case up, takes a few steps to see what they cost, and prints what the case is, in place of a run"},
      {"none", "text", "json"}, &check);
  if (check != "none") out.check = check;
  reader.Read({"-history_interval", "level-0 steps between rows of history.csv", "", Closed(1, 2e9)}, &out.history_interval);
  reader.Read({"-frames", "number of equally spaced point frames behind that of the start, the last at the end; 0 = none", "",
               Closed(0, 1e6)},
              &out.frames);
  std::string precision = "double";
  out.single_precision =
      reader.Choice({"-frame_precision", "real numbers in frames but places: of 8 bytes, or of 4, which nearly halves the files"},
                    {"double", "single"}, &precision) == 1;
  reader.Read({"-checkpoint_interval", "level-0 steps between checkpoints; 0 = none", "", kNotNegative},
              &out.checkpoint_interval);
  reader.Read({"-restart", "checkpoint to go on from, on any number of ranks"}, &out.restart);
  out.monitor = OnTerminal(reader.Comm());
  reader.Read({"-monitor", "progress line (default: true on a terminal, without mpiexec)"}, &out.monitor);
  reader.Read({"-contact_monitor", "a line per step about the contact solve"}, &c->model.contact.monitor);
  reader.Read({"-sort_interval", "steps between sorts of the points", "", Closed(1, 2e9)}, &c->hierarchy.sort_interval);
  reader.Read(
      {"-rebalance_threshold", "max/mean points per rank that triggers a re-cut of the grid", "", {1, HUGE_VAL, false, true}},
      &c->hierarchy.rebalance_threshold);
  reader.Read({"-points_per_rank", "a level with fewer points than this for each rank uses fewer ranks", "", Closed(1, 2e9)},
              &c->hierarchy.points_per_rank);
  ReadViewers(reader, c->levels);
}

} // namespace

/// Reads one titled group of options with `read`.
template <class Read> static void Group(OptionReader &reader, const char *title, Read read)
{
  std::exception_ptr refusal; // kept until PETSc's end of the group, which frees what its beginning took
  const auto group = [&]() -> PetscErrorCode {
    PetscFunctionBeginUser;
    PetscOptionsBegin(reader.Comm(), nullptr, title, nullptr);
    reader.SetItems(PetscOptionsObject);
    try {
      read();
    } catch (const InputRefused &) {
      refusal = std::current_exception();
    }
    PetscOptionsEnd();
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  ExitOnError(group());
  if (refusal) std::rethrow_exception(refusal);
}

static void ReadGroups(OptionReader &reader, Case *c)
{
  std::vector<std::string> materials, bodies;
  Group(reader, "Grid", [&] { ReadGrid(reader, c); });
  Group(reader, "Levels (1: each level but the coarsest)", [&] { ReadLevels(reader, c); });
  Group(reader, "Materials (NAME: each name in -materials)", [&] { ReadMaterials(reader, c, &materials); });
  Group(reader, "Bodies (NAME: each name in -bodies)", [&] { ReadBodies(reader, materials, c, &bodies); });
  Group(reader, "Loads (NAME: each name in -loads)", [&] { ReadLoads(reader, bodies, c); });
  Group(reader, "Method", [&] { ReadMethod(reader, c); });
  reader.Identify(false);
  Group(reader, "Time", [&] { ReadTime(reader, c); });
  reader.Identify(true);
  Group(reader, "Indenter and contact", [&] { ReadIndenter(reader, c); });
  reader.Identify(false);
  Group(reader, "Output", [&] { ReadOutput(reader, c); });
  c->identity = reader.Identity();
  if (reader.Help()) return;
  CheckFollowing(reader, *c);
  PlaceLevels(c);
  if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0) reader.Refuse("-end_time", "", "given, or -max_steps");
  CheckPaths(reader, *c);
  CheckTimes(reader, *c);
  if (c->model.indenter) CheckLevelsHoldTip(reader, *c);
  WarnOfCells(reader, *c);
}

/// The names of all options that a case can have, with those of the bodies, materials and loads that this one names; none where
/// their names are wrong.
static std::vector<std::string> AllNames(MPI_Comm comm)
{
  OptionReader reader(comm, true);
  Case any;
  reader.OnlyLearnNames();
  try {
    ReadGroups(reader, &any);
  } catch (const InputRefused &) {
    return {};
  }
  return reader.Known();
}

void ReadCase(OptionReader &reader, Case *c)
{
  std::string problem;
  try {
    ReadGroups(reader, c);
  } catch (const InputRefused &refusal) {
    problem = refusal.what();
  }
  // An option that is misspelt comes first: it may be the one that seems to be missing, or leave a default that is wrong.
  const std::vector<std::string> all = reader.Help() ? std::vector<std::string>() : AllNames(reader.Comm());
  if (!all.empty()) RefuseMisspelt(all);
  if (!problem.empty()) Refuse(problem);
}

} // namespace mlgimp
