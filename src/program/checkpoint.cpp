// Writing and reading of checkpoints.
#include "program/checkpoint.hpp"

#include "program/frames.hpp"
#include "program/hdf5_file.hpp"
#include "program/options.hpp"
#include "program/seal.hpp"

#include <cstdio>

namespace mlgimp
{

static constexpr double kFormatVersion = 6;

static hid_t H5Type(FieldType type)
{
  switch (type) {
  case FieldType::kInt32:
    return H5T_NATIVE_INT;
  case FieldType::kInt64:
    return H5T_NATIVE_INT64;
  default:
    return H5T_NATIVE_DOUBLE;
  }
}

static std::string LevelName(int l) { return "/level_" + std::to_string(l); }

/// Group of the copies of points that the next coarser (0) or finer level (1) owns.
static std::string CopiesName(int l, int origin) { return LevelName(l) + "/copies_" + std::to_string(origin); }

static std::string BorderName(int b) { return "/border_force_" + std::to_string(b); }

static std::vector<double> StateAsNumbers(const RunState &s)
{
  return {s.time,         s.time_step,      s.step_settings[0], s.step_settings[1], s.step_settings[2], s.wave_speed,
          double(s.step), double(s.frames), s.initial_mass,     s.initial_points,   s.initial_created,  s.impulse_at_row,
          s.time_at_row,  s.penetration};
}

static RunState StateFromNumbers(const std::vector<double> &n)
{
  return {n[0],  n[1], {n[2], n[3], n[4]}, n[5], static_cast<long>(n[6]), static_cast<int>(n[7]), n[8], n[9], n[10], n[11],
          n[12], n[13]};
}

/// Pairs of numbers that this rank, if any, writes for all.
static PetscErrorCode WritePairs(H5Writer &file, MPI_Comm comm, const std::string &name, const std::vector<double> &pairs)
{
  Slab slab;
  PetscFunctionBeginUser;
  PetscCall(MakeSlab(comm, static_cast<int>(pairs.size() / 2), &slab));
  file.Dataset(name, H5T_NATIVE_DOUBLE, 2, slab, pairs.data());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A group with the number of points of each rank and all their fields.
static PetscErrorCode WritePoints(H5Writer &file, MPI_Comm comm, const std::string &group, Points &points)
{
  PetscMPIInt size;
  Slab slab;
  const int count = points.Count();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  std::vector<int> counts(size);
  PetscCall(MakeSlab(comm, count, &slab));
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  file.Group(group);
  file.Attribute(group, "counts", std::vector<double>(counts.begin(), counts.end()));
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *data = nullptr;
    if (field.components == 0) continue;
    PetscCall(points.Field(static_cast<PointField>(k), &data));
    file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteLevel(H5Writer &file, Hierarchy &hierarchy, int l)
{
  Level &level = hierarchy.At(l);
  const std::string group = LevelName(l);
  const GridLayout &layout = level.Mesh().Layout();
  const LevelPace &pace = level.Pace();
  std::vector<double> pressures;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCall(WritePoints(file, hierarchy.Comm(), group, level.PointStore()));
  file.Attribute(group, "pace",
                 std::vector<double>{double(pace.steps), pace.drift, pace.drift_per_step, double(pace.contact_awake)});
  file.Attribute(group, "columns", std::vector<double>(layout.widths[0].begin(), layout.widths[0].end()));
  file.Attribute(group, "rows", std::vector<double>(layout.widths[1].begin(), layout.widths[1].end()));
  file.Attribute(group, "ranks", std::vector<double>(layout.ranks.begin(), layout.ranks.end()));
  if (rank == layout.ranks[0])
    for (const auto &[key, pressure] : level.Pressures()) pressures.insert(pressures.end(), {static_cast<double>(key), pressure});
  PetscCall(WritePairs(file, hierarchy.Comm(), group + "/pressures", pressures));
  for (int origin = 0; origin < 2 && hierarchy.Copies().ready; ++origin)
    PetscCall(WritePoints(file, hierarchy.Comm(), CopiesName(l, origin), level.CopyStore(origin)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The first rank writes the coarse forces at a border.
static PetscErrorCode WriteBorder(H5Writer &file, Hierarchy &hierarchy, int b)
{
  std::vector<double> forces;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCall(hierarchy.GatherBorderState(b, &forces));
  if (rank != 0) forces.clear();
  PetscCall(WritePairs(file, hierarchy.Comm(), BorderName(b), forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode WriteCheckpoint(const std::string &directory, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                               const RunState &state, std::string *problem)
{
  H5Writer file;
  Slab slab;
  char name[48];
  const std::vector<double> totals = hierarchy.Totals();
  const CopyState &copies = hierarchy.Copies();
  PetscFunctionBeginUser;
  std::snprintf(name, sizeof name, "/checkpoint_%06ld.h5", state.step);
  PetscCall(MakeSlab(hierarchy.Comm(), 1, &slab));
  PetscCall(file.Open(hierarchy.Comm(), directory + name));
  file.Attribute("/", "format_version", kFormatVersion);
  file.Attribute("/", "identity", Join(identity, "\n"));
  file.Attribute("/", "state", StateAsNumbers(state));
  file.Attribute("/", "copies", std::vector<double>{double(copies.ready), copies.momentum_left[0], copies.momentum_left[1]});
  file.Dataset("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(totals.size()), slab, totals.data());
  for (int l = 0; l < hierarchy.Levels(); ++l) PetscCall(WriteLevel(file, hierarchy, l));
  for (int b = 0; b + 1 < hierarchy.Levels(); ++b) PetscCall(WriteBorder(file, hierarchy, b));
  PetscCall(file.Finish(true, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace
{

/// The first option that two runs do not share, as a message; empty where there is none.
std::string FirstDifference(const std::vector<std::string> &now, const std::vector<std::string> &then)
{
  for (std::size_t k = 0; k < std::max(now.size(), then.size()); ++k) {
    const std::string a = k < now.size() ? now[k] : "nothing", b = k < then.size() ? then[k] : "nothing";
    if (a != b) return "this run has '" + Shortened(a) + "' where the checkpoint has '" + Shortened(b) + "'";
  }
  return "";
}

/// This rank's rows: those it wrote where the number of ranks is the same, else an equal share.
Slab MakeReadSlab(const std::vector<double> &counts, int size, int rank, hsize_t total)
{
  Slab slab{0, 0, total};
  if (static_cast<int>(counts.size()) == size) {
    for (int k = 0; k < rank; ++k) slab.start += static_cast<hsize_t>(counts[k]);
    slab.count = static_cast<hsize_t>(counts[rank]);
  } else {
    slab.start = total * rank / size;
    slab.count = total * (rank + 1) / size - slab.start;
  }
  return slab;
}

/// Pairs of numbers, on every rank.
bool ReadPairs(const H5Reader &file, const std::string &name, std::vector<double> *pairs)
{
  hsize_t rows = 0;
  if (!file.Rows(name, &rows)) return false;
  pairs->resize(2 * rows);
  return rows == 0 || file.Dataset(name, H5T_NATIVE_DOUBLE, 2, {0, rows, rows}, pairs->data());
}

/// Reads points into an empty store, in the order of the file; false where something is missing.
PetscErrorCode ReadPoints(const H5Reader &file, MPI_Comm comm, const std::string &group, Points &points, bool *good)
{
  PetscMPIInt rank, size;
  std::vector<double> counts;
  hsize_t total = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  *good = file.Has(group) && file.Attribute(group, "counts", &counts) && file.Rows(group + "/id", &total);
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  const Slab slab = MakeReadSlab(counts, size, rank, total);
  PetscCall(points.Resize(static_cast<int>(slab.count)));
  for (int k = 0; k < kPointFields && *good; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *data = nullptr;
    if (field.components == 0) continue;
    PetscCall(points.Field(static_cast<PointField>(k), &data));
    *good = file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The layout of a level's grid, where as many ranks wrote it.
PetscErrorCode ReadLayout(const H5Reader &file, const std::string &group, Level &level, bool *good)
{
  std::vector<double> widths[2], ranks;
  GridLayout layout;
  PetscFunctionBeginUser;
  *good = file.Attribute(group, "columns", &widths[0]) && file.Attribute(group, "rows", &widths[1]) &&
          file.Attribute(group, "ranks", &ranks);
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  for (int axis = 0; axis < 2; ++axis) layout.widths[axis].assign(widths[axis].begin(), widths[axis].end());
  layout.ranks.assign(ranks.begin(), ranks.end());
  PetscCall(level.Recut(layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Reads one level; false where something is missing.
PetscErrorCode ReadLevel(const H5Reader &file, Hierarchy &hierarchy, int l, bool same_ranks, bool *good)
{
  Level &level = hierarchy.At(l);
  const std::string group = LevelName(l);
  std::vector<double> pace, pairs;
  ContactPressures pressures;
  PetscFunctionBeginUser;
  *good = file.Has(group) && file.Attribute(group, "pace", &pace) && pace.size() == 4 &&
          ReadPairs(file, group + "/pressures", &pairs);
  if (*good && same_ranks) PetscCall(ReadLayout(file, group, level, good));
  if (*good) PetscCall(ReadPoints(file, hierarchy.Comm(), group, level.PointStore(), good));
  for (int origin = 0; origin < 2 && *good && hierarchy.Copies().ready; ++origin) {
    PetscCall(ReadPoints(file, hierarchy.Comm(), CopiesName(l, origin), level.CopyStore(origin), good));
  }
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  for (std::size_t k = 0; k < pairs.size(); k += 2) pressures[static_cast<std::int64_t>(pairs[k])] = pairs[k + 1];
  level.SetPressures(pressures);
  level.SetPace({static_cast<long>(pace[0]), pace[1], pace[2], pace[3] != 0});
  if (same_ranks) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(level.Migrate(true));
  PetscCall(level.MigrateCopies());
  PetscCall(level.Sort());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadBorder(const H5Reader &file, Hierarchy &hierarchy, int b, bool *good)
{
  std::vector<double> forces;
  PetscFunctionBeginUser;
  *good = ReadPairs(file, BorderName(b), &forces);
  if (*good) PetscCall(hierarchy.RestoreBorderState(b, forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Totals of each rank that wrote: each its own where there are as many now, else all on the first.
PetscErrorCode ReadTotals(const H5Reader &file, Hierarchy &hierarchy, bool *same_ranks, bool *good)
{
  PetscMPIInt rank, size;
  hsize_t ranks = 0;
  const std::size_t count = hierarchy.Totals().size();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCallMPI(MPI_Comm_size(hierarchy.Comm(), &size));
  *good = file.Rows("/totals", &ranks);
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<double> all(ranks * count), mine(count, 0.0);
  *good = file.Dataset("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(count), {0, ranks, ranks}, all.data());
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  *same_ranks = ranks == static_cast<hsize_t>(size);
  for (std::size_t r = 0; r < ranks; ++r)
    for (std::size_t k = 0; k < count; ++k)
      if (*same_ranks ? static_cast<int>(r) == rank : rank == 0) mine[k] += all[r * count + k];
  hierarchy.RestoreTotals(mine);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The format that a whole checkpoint names; 0 for any other file. Formats before this one may have had no seal. One rank.
double FormatOf(const std::string &path)
{
  H5Reader file;
  double version = 0;
  const SealState seal = FindSeal(path);
  if (seal == SealState::kBroken || !file.Open(MPI_COMM_SELF, path) || !file.Attribute("/", "format_version", &version)) return 0;
  return seal == SealState::kWhole || version < kFormatVersion ? version : 0;
}

/// Ends the run where the file is no whole checkpoint of this format.
PetscErrorCode OpenCheckpoint(MPI_Comm comm, const std::string &path, H5Reader *file)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  double version = rank == 0 ? FormatOf(path) : 0;
  PetscCallMPI(MPI_Bcast(&version, 1, MPI_DOUBLE, 0, comm));
  PetscCheck(
      version > 0, comm, PETSC_ERR_USER_INPUT,
      "-restart %s: must be a whole checkpoint of this version of mlgimp; it is missing, cut short, damaged or something else",
      Shortened(path).c_str());
  PetscCheck(version == kFormatVersion, comm, PETSC_ERR_USER_INPUT, "-restart %s: must have format version %g; it has %g",
             Shortened(path).c_str(), kFormatVersion, version);
  PetscCheck(file->Open(comm, path), comm, PETSC_ERR_USER_INPUT, "-restart %s: must be a file that every rank can read",
             Shortened(path).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ReadCheckpoint(const std::string &path, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                              RunState *s, bool *same_ranks)
{
  MPI_Comm comm = hierarchy.Comm();
  H5Reader file;
  std::string then;
  std::vector<double> state, copies;
  PetscFunctionBeginUser;
  PetscCall(OpenCheckpoint(comm, path, &file));
  bool good = file.Attribute("/", "identity", &then) && file.Attribute("/", "state", &state) &&
              file.Attribute("/", "copies", &copies) && state.size() == StateAsNumbers({}).size() && copies.size() == 3;
  const std::string difference = good ? FirstDifference(identity, Split(then, '\n')) : "";
  PetscCheck(difference.empty(), comm, PETSC_ERR_USER_INPUT, "-restart %s: must be of the same case; %s", Shortened(path).c_str(),
             difference.c_str());
  if (good) hierarchy.SetCopies({copies[0] != 0, {copies[1], copies[2]}});
  if (good) PetscCall(ReadTotals(file, hierarchy, same_ranks, &good));
  for (int l = 0; l < hierarchy.Levels() && good; ++l) PetscCall(ReadLevel(file, hierarchy, l, *same_ranks, &good));
  for (int b = 0; b + 1 < hierarchy.Levels() && good; ++b) PetscCall(ReadBorder(file, hierarchy, b, &good));
  PetscCheck(good, comm, PETSC_ERR_USER_INPUT, "-restart %s: must be a whole checkpoint; parts of it are missing",
             Shortened(path).c_str());
  *s = StateFromNumbers(state);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
