// Writing of checkpoints.
#include "program/checkpoint/format.hpp"

#include <cstdio>

namespace mlgimp
{

std::string CheckpointPath(const std::string &directory, long step)
{
  char name[48];
  std::snprintf(name, sizeof name, "/checkpoint_%06ld.h5", step);
  return directory + name;
}

/// A list as numbers of a file.
template <class List> static std::vector<double> Numbers(const List &list)
{
  return std::vector<double>(list.begin(), list.end());
}

/// A group with the number of points of each rank and all their fields.
static void WritePoints(H5Writer &file, MPI_Comm comm, const std::string &group, Points &points)
{
  const int count = points.Count();
  const Slab slab = MakeSlab(comm, count);
  std::vector<int> counts(RankIn(comm) == 0 ? RanksOf(comm) : 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  file.Group(group);
  file.List(group + "/counts", Numbers(counts));
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    if (field.components == 0) continue;
    void *const data = points.Field(static_cast<PointField>(k));
    file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
  }
}

static void AddBox(const Box &box, std::vector<double> *numbers)
{
  numbers->insert(numbers->end(), box.lower.begin(), box.lower.end());
  numbers->insert(numbers->end(), box.upper.begin(), box.upper.end());
}

static Box TakeBox(const double *n) { return {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}}; }

static constexpr std::size_t kOfBox = 6, kOfMove = 9; ///< size: numbers of a box; of a move beside its box

std::vector<double> FollowingAsNumbers(const FollowState &now, const std::vector<LevelMove> &moves)
{
  std::vector<double> numbers = {double(now.plan.active), now.half_width, now.reach};
  for (const Box &box : now.plan.boxes) AddBox(box, &numbers);
  for (const LevelMove &m : moves) {
    for (double x :
         {m.step, m.time, double(m.level), double(m.active), m.split, m.merged, m.mass_error, m.momentum_error, m.energy})
      numbers.push_back(x);
    AddBox(m.box, &numbers);
  }
  return numbers;
}

bool FollowingFromNumbers(const std::vector<double> &numbers, int levels, FollowState *now, std::vector<LevelMove> *moves)
{
  const std::size_t fixed = 3 + kOfBox * levels;
  if (numbers.size() < fixed || (numbers.size() - fixed) % (kOfMove + kOfBox) != 0) return false;
  *now = {{{}, static_cast<int>(numbers[0])}, numbers[1], numbers[2]};
  for (int l = 0; l < levels; ++l) now->plan.boxes.push_back(TakeBox(&numbers[3 + kOfBox * l]));
  for (std::size_t k = fixed; k < numbers.size(); k += kOfMove + kOfBox) {
    const double *const n = &numbers[k];
    moves->push_back({n[0], n[1], static_cast<int>(n[2]), n[3] != 0, TakeBox(n + kOfMove), n[4], n[5], n[6], n[7], n[8]});
  }
  return true;
}

/// A list that is the same on all ranks, or that the first rank alone has.
static void WriteList(H5Writer &file, MPI_Comm comm, const std::string &name, const std::vector<double> &values)
{
  file.List(name, RankIn(comm) == 0 ? values : std::vector<double>());
}

static void WriteLevel(H5Writer &file, Hierarchy &hierarchy, int l)
{
  const MPI_Comm comm = hierarchy.Comm();
  Level &level = hierarchy.At(l);
  const std::string group = LevelName(l);
  const GridLayout &layout = level.Mesh().Nodes().Layout();
  const PointDrift &drift = level.Stores().Drift();
  const ContactGroup &contact = level.Contact().Group();
  std::vector<double> keys, pressures;
  WritePoints(file, comm, group, level.PointStore());
  std::vector<double> pace = {double(level.Step().taken), drift.now, drift.per_step, double(level.Contact().WithinReach())};
  for (const Index &corner : {contact.Zone().lower, contact.Zone().upper}) pace.insert(pace.end(), corner.begin(), corner.end());
  file.Attribute(group, "pace", pace);
  for (int axis = 0; axis < 3; ++axis) WriteList(file, comm, group + kWidthNames[axis], Numbers(layout.widths[axis]));
  WriteList(file, comm, group + "/ranks", Numbers(layout.ranks));
  if (RankIn(comm) == contact.Root())
    for (const auto &[key, pressure] : level.Contact().Pressures()) {
      keys.push_back(static_cast<double>(key));
      pressures.push_back(pressure);
    }
  std::vector<double> patches;
  ExitOnError(hierarchy.SurfaceOf().Gather(l, &patches));
  WriteList(file, comm, group + "/patches", patches);
  file.List(group + "/pressure_keys", keys);
  file.List(group + "/pressures", pressures);
  for (int origin = 0; origin < 2 && hierarchy.Copies().ready; ++origin)
    WritePoints(file, comm, CopiesName(l, origin), level.Stores().Copies(origin));
}

/// The first rank writes what a border keeps.
static void WriteBorder(H5Writer &file, Hierarchy &hierarchy, int b)
{
  std::vector<double> state;
  ExitOnError(hierarchy.Connected().Border(b).GatherState(&state));
  file.List(BorderName(b), state);
}

std::string WriteCheckpoint(const std::string &directory, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                            const RunState &state)
{
  const MPI_Comm comm = hierarchy.Comm();
  const auto text = [comm](const std::vector<std::string> &lines) { return RankIn(comm) == 0 ? Join(lines, "\n") : ""; };
  H5Writer file;
  std::vector<double> totals;
  const CopyState copies = hierarchy.Copies();
  for (const Budgets *part : PartsOfBudgets(hierarchy.Connected())) part->AppendKept(&totals);
  file.Open(comm, CheckpointPath(directory, state.step), true);
  file.Attribute("/", "format_version", {double(kFormatVersion)});
  file.Text("/identity", text(identity)); // of any length, as no attribute may be
  file.Attribute("/", "state", ToNumbers(state));
  file.Attribute("/", "copies",
                 {double(copies.ready), copies.momentum_left[0], copies.momentum_left[1], copies.momentum_left[2]});
  file.Dataset("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(totals.size()), MakeSlab(comm, 1), totals.data());
  WriteList(file, comm, "/tip", hierarchy.Tip().State());
  if (!state.quasi_static.empty()) WriteList(file, comm, "/quasi_static", state.quasi_static);
  if (!state.test.clock.empty()) WriteList(file, comm, "/test_clock", state.test.clock);
  WriteList(file, comm, "/watched", state.watched);
  file.Text("/warnings", text(state.warnings));
  file.Attribute("/", "patch_drift", {hierarchy.SurfaceOf().Drift()});
  ExitOnError(hierarchy.Boxes().ShareReach());
  WriteList(file, comm, "/following", FollowingAsNumbers(hierarchy.Boxes().State(), state.moves));
  for (int l = 0; l < hierarchy.Levels(); ++l) WriteLevel(file, hierarchy, l);
  for (int b = 0; b + 1 < hierarchy.Levels(); ++b) WriteBorder(file, hierarchy, b);
  return file.Finish();
}

} // namespace mlgimp
