// Reading of checkpoints. Each rank reads its part by itself; after each part all agree on whether to go on.
#include "program/advice/warnings.hpp"
#include "program/checkpoint/checks.hpp"
#include "program/checkpoint/format.hpp"
#include "program/slow_test/clock.hpp"
#include "program/slow_test/watch.hpp"
#include "program/system/agree.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

class CheckpointReader
{
public:
  CheckpointReader(const Case &settings, Hierarchy &hierarchy) : case_(settings), hierarchy_(hierarchy), comm_(hierarchy.Comm())
  {
  }
  void Read(RunState *state, bool *same_ranks);

private:
  void Open();
  void ReadHead(RunState *state);
  void ReadFollowing(RunState *state);
  void ReadTotals();
  void CountPoints(const RunState &state);
  void ReadLevel(const RunState &state, int l);
  void ReadLayout(int l);
  void ReadPoints(const std::string &group, Level &level, Points &points);
  void ReadPatches(const std::string &group, int l);
  void ReadBorder(int b);
  void CheckWhole(const RunState &state);
  void AgreeOnError(const char *place);

  void Record(const std::string &wrong)
  {
    if (wrong_.empty()) wrong_ = wrong;
  }
  /// Notes what is not there, or not as it should be.
  bool Found(bool found, const std::string &name)
  {
    if (!found) Record(Format("parts of it are missing or damaged: {}", name));
    return found;
  }
  /// The same of numbers, which must be finite: a list of any length, and an attribute of as many as `values` has.
  bool FoundList(const std::string &name, std::vector<double> *values)
  {
    return Found(file_.List(name, values), name) && AreFinite(*values, name);
  }
  bool FoundAttribute(const std::string &object, const std::string &name, std::vector<double> *values)
  {
    return Found(file_.Attribute(object, name, values), name) && AreFinite(*values, name);
  }
  bool AreFinite(const std::vector<double> &numbers, const std::string &name)
  {
    const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (!finite) Record(Format("{} has a value that is not finite", name));
    return finite;
  }
  bool Follows() const { return case_.hierarchy.follow.kind != FollowKind::kNone; }
  /// Whether points are neither lost nor doubled: the paper's rule of ownership by place does both.
  bool KeepsPoints() const
  {
    return case_.levels == 1 || case_.hierarchy.coupling == LevelCoupling::kNodes || case_.hierarchy.repairs.owner_flags;
  }

  const Case &case_;
  Hierarchy &hierarchy_;
  MPI_Comm comm_;
  H5Reader file_;
  std::string wrong_; ///< the first thing that is wrong, on this rank
  std::size_t writers_ = 0;
  bool same_ranks_ = false;
};

/// Ends the run where any rank has found something wrong.
void CheckpointReader::AgreeOnError(const char *place)
{
  wrong_ = Agree(comm_, place, wrong_);
  if (!wrong_.empty())
    Refuse("-restart {}: must be a whole checkpoint{}{}", Shortened(case_.output.restart), wrong_[0] == ' ' ? "" : "; ", wrong_);
}

/// The first option that two runs do not share, as a message; empty where there is none.
std::string FirstDifference(const std::vector<std::string> &now, const std::vector<std::string> &then)
{
  for (std::size_t k = 0; k < std::max(now.size(), then.size()); ++k) {
    const std::string a = k < now.size() ? now[k] : "nothing", b = k < then.size() ? then[k] : "nothing";
    if (a != b) return Format("this run has '{}' where the checkpoint has '{}'", Shortened(a), Shortened(b));
  }
  return "";
}

/// The first rank opens the file before the others: most errors are found there, with one message.
void CheckpointReader::Open()
{
  const std::string &path = case_.output.restart;
  std::vector<double> version(1, 0.0);
  const PetscMPIInt rank = RankIn(comm_);
  const auto groups_are_whole = [this] {
    bool all = file_.IsWholeGroup("/");
    std::string then; // a file of another case, which may have other levels, is refused by ReadHead
    if (!file_.Text("/identity", &then) || !FirstDifference(case_.identity, Split(then, '\n')).empty()) return all;
    for (int l = 0; l < hierarchy_.Levels(); ++l) all = all && file_.IsWholeGroup(LevelName(l));
    return all;
  };
  const std::string unknown = " of this version of mlgimp; it is missing, cut short, damaged or something else";
  if (rank == 0 && (!file_.Open(path) || !file_.Attribute("/", "format_version", &version) || !std::isfinite(version[0])))
    wrong_ = unknown;
  else if (rank == 0 && version[0] == kFormatVersion)
    Found(groups_are_whole(), "an index of names");
  AgreeOnError("checkpoint_format");
  MPI_Bcast(version.data(), 1, MPI_DOUBLE, 0, comm_);
  if (version[0] != kFormatVersion)
    Refuse("-restart {}: must have format version {}; it has {}", Shortened(path), kFormatVersion, FormatNumber(version[0]));
  if (rank != 0 && !file_.Open(path)) wrong_ = Format("{}, or not every rank can read it", unknown);
  AgreeOnError("checkpoint_open");
}

void CheckpointReader::ReadHead(RunState *state)
{
  std::vector<double> numbers = ToNumbers(RunState()), copies(4), tip, watch, clock, watched, drift(1);
  std::string then, lines, difference;
  std::vector<std::string> warnings;
  const bool with_copies = case_.levels > 1 && case_.hierarchy.coupling == LevelCoupling::kPoints;
  if (Found(file_.Text("/identity", &then), "identity")) difference = FirstDifference(case_.identity, Split(then, '\n'));
  AgreeOnError("checkpoint_identity");
  difference = Agree(comm_, "checkpoint_case", difference);
  if (!difference.empty()) Refuse("-restart {}: must be of the same case; {}", Shortened(case_.output.restart), difference);
  if (Found(file_.Attribute("/", "state", &numbers), "state")) Record(WrongState(numbers, case_));
  if (FoundAttribute("/", "copies", &copies) && copies[0] != (with_copies ? 1 : 0))
    Record("its copies of points are inconsistent");
  if (FoundAttribute("/", "patch_drift", &drift)) hierarchy_.SurfaceOf().SetDrift(drift[0]);
  if (FoundList("/tip", &tip)) Record(WrongTip(tip, hierarchy_.Tip().State().size(), numbers[0]));
  if (case_.quasi_static.on) FoundList("/quasi_static", &watch);
  Found(QuasiStaticWatch(case_.quasi_static).IsState(watch), "quasi_static");
  if (case_.quasi_static.test.On()) FoundList("/test_clock", &clock);
  Found(TestClock::IsState(clock, case_.quasi_static.test.legs.size()), "test_clock");
  if (Found(file_.Text("/warnings", &lines), "warnings") && !lines.empty()) warnings = Split(lines, '\n');
  FoundList("/watched", &watched);
  Found(Warnings::IsState(watched, warnings), "watched");
  AgreeOnError("checkpoint_state");
  *state = FromNumbers<RunState>(numbers.data());
  state->quasi_static = watch;
  state->test.clock = clock;
  state->watched = watched;
  state->warnings = warnings;
  hierarchy_.Tip().SetState(tip);
  hierarchy_.SetCopies({copies[0] != 0, {copies[1], copies[2], copies[3]}});
}

/// Puts the boxes where they were.
void CheckpointReader::ReadFollowing(RunState *state)
{
  std::vector<double> numbers;
  FollowState following;
  if (FoundList("/following", &numbers) && !FollowingFromNumbers(numbers, case_.levels, &following, &state->moves))
    Record("its boxes are inconsistent with this case");
  if (wrong_.empty()) Record(WrongBoxes(following, case_));
  AgreeOnError("checkpoint_following");
  if (Follows()) ExitOnError(hierarchy_.Boxes().Restore(following));
}

/// Totals of each rank that wrote: each its own where there are as many now, else all on the first.
void CheckpointReader::ReadTotals()
{
  constexpr hsize_t kMaxRanks = 1 << 24; // size
  hsize_t writers = 0;
  std::vector<double> all; // as many for each of the writers, in the order of Parts
  for (const Budgets *part : PartsOfBudgets(hierarchy_.Connected())) part->AppendKept(&all);
  const std::size_t count = all.size();
  if (Found(file_.Rows("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(count), &writers) && writers > 0 && writers <= kMaxRanks,
            "totals")) {
    all.resize(writers * count);
    Found(file_.Dataset("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(count), {0, writers, writers}, all.data()), "totals");
    AreFinite(all, "totals");
  }
  AgreeOnError("checkpoint_totals");
  writers_ = writers;
  same_ranks_ = writers == static_cast<hsize_t>(RanksOf(comm_));
  const PetscMPIInt rank = RankIn(comm_);
  for (std::size_t r = 0; r < writers; ++r) {
    const double *next = &all[r * count];
    for (Budgets *part : PartsOfBudgets(hierarchy_.Connected()))
      if (next && static_cast<int>(same_ranks_ ? r : 0) == rank) next = part->AddKept(next);
    if (!next) Record("totals has a count that is none");
  }
  AgreeOnError("checkpoint_counts");
}

/// Checks that the file has as many points as the run had and created, before memory is allocated for them.
void CheckpointReader::CountPoints(const RunState &state)
{
  double points = 0;
  Budgets budgets;
  for (int l = 0; l < hierarchy_.Levels(); ++l) {
    hsize_t rows = 0;
    std::vector<double> counts;
    const std::string name = LevelName(l) + "/id";
    if (Found(file_.Rows(name, H5T_NATIVE_INT64, 1, &rows), name) && FoundList(LevelName(l) + "/counts", &counts))
      Record(WrongCounts(counts, writers_, static_cast<double>(rows)));
    points += static_cast<double>(rows);
  }
  ExitOnError(hierarchy_.ReduceBudgets(&budgets)); // of totals only: there are no points yet
  const double expected = state.initial_points + Case::PointsCreated(budgets) - state.initial_created;
  if (KeepsPoints() && points != expected)
    Record(Format("it has {} points where the run had {}", FormatNumber(points), FormatNumber(expected)));
  AgreeOnError("checkpoint_points");
}

/// This rank's rows: those it wrote where the number of ranks is the same, else an equal share.
Slab MakeReadSlab(MPI_Comm comm, const std::vector<double> &counts, bool same_ranks, hsize_t total)
{
  const hsize_t rank = RankIn(comm), size = RanksOf(comm);
  Slab slab{0, 0, total};
  if (same_ranks) {
    for (hsize_t k = 0; k < rank; ++k) slab.start += static_cast<hsize_t>(counts[k]);
    slab.count = static_cast<hsize_t>(counts[rank]);
  } else {
    slab.start = total * rank / size;
    slab.count = total * (rank + 1) / size - slab.start;
  }
  return slab;
}

/// Reads points into an empty store, in the order of the file.
void CheckpointReader::ReadPoints(const std::string &group, Level &level, Points &points)
{
  std::vector<double> counts;
  hsize_t total = 0;
  if (FoundList(group + "/counts", &counts) && Found(file_.Rows(group + "/id", H5T_NATIVE_INT64, 1, &total), group + "/id"))
    Record(WrongCounts(counts, writers_, static_cast<double>(total)));
  for (const PointFieldInfo &field : points.Table()) {
    hsize_t rows = 0;
    const std::string name = group + "/" + field.name;
    if (field.components > 0) Found(file_.Rows(name, H5Type(field.type), field.components, &rows) && rows == total, name);
  }
  AgreeOnError("checkpoint_shapes");
  const Slab slab = MakeReadSlab(comm_, counts, same_ranks_, total);
  ExitOnError(points.Resize(static_cast<int>(slab.count)));
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    const std::string name = group + "/" + field.name;
    if (field.components == 0) continue;
    void *const data = points.Field(static_cast<PointField>(k));
    Found(file_.Dataset(name, H5Type(field.type), field.components, slab, data), name);
  }
  AgreeOnError("checkpoint_fields");
  const PointArrays arrays = points.Arrays();
  Record(WrongValues(arrays, static_cast<int>(case_.model.bodies.size())));
  Record(WrongPlaces(arrays, level.Mesh(), level.Geometry().PointNodes(), same_ranks_));
  AgreeOnError("checkpoint_values");
}

/// The layout of a level's grid, which is taken up where as many ranks wrote it.
void CheckpointReader::ReadLayout(int l)
{
  const std::string group = LevelName(l);
  std::array<std::vector<double>, 3> widths;
  std::vector<double> ranks;
  bool found = FoundList(group + "/ranks", &ranks);
  for (int axis = 0; axis < 3; ++axis) found = FoundList(group + kWidthNames[axis], &widths[axis]) && found;
  if (found) Record(WrongLayout(widths, ranks, hierarchy_.At(l).Geometry().grid, writers_));
  AgreeOnError("checkpoint_layout");
  if (!same_ranks_) return;
  GridLayout layout;
  for (int axis = 0; axis < 3; ++axis) layout.widths[axis].assign(widths[axis].begin(), widths[axis].end());
  layout.ranks.assign(ranks.begin(), ranks.end());
  ExitOnError(hierarchy_.At(l).Repartition(layout));
}

void CheckpointReader::ReadLevel(const RunState &state, int l)
{
  Level &level = hierarchy_.At(l);
  const std::string group = LevelName(l);
  std::vector<double> clock(kOfClock), keys, values;
  ContactPressures pressures;
  if (Found(file_.Has(group), group) && FoundAttribute(group, "pace", &clock)) Record(WrongClock(clock, state.step, case_, l));
  if (FoundList(group + "/pressure_keys", &keys) && FoundList(group + "/pressures", &values))
    Record(WrongPressures(keys, values, KeptOfEach(case_.model.contact)));
  AgreeOnError("checkpoint_pace");
  ReadLayout(l);
  ReadPoints(group, level, level.PointStore());
  ReadPatches(group, l);
  for (int origin = 0; origin < 2 && hierarchy_.Copies().ready; ++origin)
    ReadPoints(CopiesName(l, origin), level, level.Stores().Copies(origin));
  for (std::size_t k = 0; k < keys.size(); ++k) pressures[static_cast<std::int64_t>(keys[k])] = values[k];
  level.Contact().SetPressures(pressures);
  IndexBox zone;
  for (int axis = 0; axis < 3; ++axis)
    zone.lower[axis] = static_cast<int>(clock[4 + axis]), zone.upper[axis] = static_cast<int>(clock[7 + axis]);
  level.Step().taken = static_cast<long>(clock[0]);
  level.Stores().Drift().now = clock[1], level.Stores().Drift().per_step = clock[2];
  ExitOnError(level.Contact().Watch(comm_, level.Mesh(), true, zone));
  if (clock[3] == 0) ExitOnError(level.Contact().Watch(comm_, level.Mesh(), false, zone));
  if (same_ranks_) return;
  ExitOnError(level.Stores().Migrate(true));
  ExitOnError(level.Stores().MigrateCopies());
  ExitOnError(level.Stores().Sort());
}

void CheckpointReader::ReadPatches(const std::string &group, int l)
{
  std::vector<double> patches;
  FoundList(group + "/patches", &patches);
  Found(patches.size() % SurfaceOwners::kOfPatch == 0, group + "/patches");
  AgreeOnError("checkpoint_patches");
  ExitOnError(hierarchy_.SurfaceOf().Restore(l, patches));
}

void CheckpointReader::ReadBorder(int b)
{
  std::vector<double> state;
  const std::size_t size = hierarchy_.Copies().ready ? 0 : LevelInterface::kState * hierarchy_.Connected().Border(b).Count();
  FoundList(BorderName(b), &state);
  Found(state.size() == size || (Follows() && state.empty()), BorderName(b)); // a border that has just moved has none
  AgreeOnError("checkpoint_border");
  ExitOnError(hierarchy_.Connected().RestoreBorder(b, state));
}

/// Checks that need the points of all levels together.
void CheckpointReader::CheckWhole(const RunState &state)
{
  constexpr double kMassError = 1e-6; // rounding
  std::vector<std::int64_t> ids;
  Budgets budgets;
  for (int l = 0; l < hierarchy_.Levels(); ++l) {
    const PointArrays points = hierarchy_.At(l).PointStore().Arrays();
    ids.insert(ids.end(), points.id, points.id + points.count);
  }
  ExitOnError(hierarchy_.ReduceBudgets(&budgets));
  if (!std::isfinite(budgets.kinetic_energy) || !std::isfinite(budgets.strain_energy)) Record("its energies are not finite");
  if (KeepsPoints()) {
    if (!(std::abs(budgets.mass / state.initial_mass - 1) <= kMassError)) Record("its mass is not that of the run");
    Record(FindRepeated(comm_, std::move(ids)));
  }
  AgreeOnError("checkpoint_whole");
}

void CheckpointReader::Read(RunState *state, bool *same_ranks)
{
  Open();
  ReadHead(state);
  ReadFollowing(state);
  ReadTotals();
  CountPoints(*state);
  for (int l = 0; l < hierarchy_.Levels(); ++l) ReadLevel(*state, l);
  for (int b = 0; b + 1 < hierarchy_.Levels(); ++b) ReadBorder(b);
  CheckWhole(*state);
  *same_ranks = same_ranks_;
}

} // namespace

void ReadCheckpoint(const Case &settings, Hierarchy &hierarchy, RunState *state, bool *same_ranks)
{
  CheckpointReader reader(settings, hierarchy);
  reader.Read(state, same_ranks);
}

} // namespace mlgimp
