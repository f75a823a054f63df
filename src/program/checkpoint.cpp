// Writing and reading of checkpoints.
#include "program/checkpoint.hpp"

#include "program/frames.hpp"
#include "program/hdf5_file.hpp"
#include "program/options.hpp"

#include <cstdio>

namespace mlgimp
{

static constexpr double kFormatVersion = 4;

static hid_t H5Type(FieldType type)
{
  switch (type) {
  case FieldType::kInt32: return H5T_NATIVE_INT;
  case FieldType::kInt64: return H5T_NATIVE_INT64;
  default: return H5T_NATIVE_DOUBLE;
  }
}

static std::vector<double> BooksAsNumbers(const Books &books)
{
  const double *first = reinterpret_cast<const double *>(&books);
  return {first, first + sizeof(Books) / sizeof(double)};
}

static std::string GroupName(int l) { return "/level_" + std::to_string(l); }

static std::string BorderName(int b) { return "/border_force_" + std::to_string(b); }

/// The first rank writes the coarse forces at a border, two numbers a row.
static PetscErrorCode WriteBorder(H5Writer &file, int b, Hierarchy &hierarchy)
{
  std::vector<double> forces;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCall(hierarchy.GatherBorderForces(b, &forces));
  const hsize_t rows = forces.size() / 2;
  file.Dataset(BorderName(b), H5T_NATIVE_DOUBLE, 2, {0, rank == 0 ? rows : 0, rows}, forces.data());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode WriteCheckpoint(const std::string &directory, const std::vector<std::string> &identity,
                               Hierarchy &hierarchy, const RunState &s)
{
  H5Writer file;
  Books books;
  char name[48];
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(hierarchy.Comm(), &size));
  std::snprintf(name, sizeof name, "/checkpoint_%06ld.h5", s.step);
  PetscCall(hierarchy.ReduceBooks(&books));
  PetscCall(file.Open(hierarchy.Comm(), directory + name));
  file.Attribute("/", "format_version", kFormatVersion);
  file.Attribute("/", "identity", Join(identity, "\n"));
  file.Attribute("/", "state", std::vector<double>{s.time, s.time_step, s.wave_speed, static_cast<double>(s.step),
                                                   static_cast<double>(s.frames), s.initial_mass, s.initial_points,
                                                   s.impulse_at_row, s.time_at_row, s.penetration, s.initial_created});
  file.Attribute("/", "books", BooksAsNumbers(books));
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    Level &level = hierarchy.At(l);
    Points &points = level.PointStore();
    const std::string group = GroupName(l);
    Slab slab;
    const int count = points.Count();
    std::vector<int> counts(size);
    PetscCall(MakeSlab(hierarchy.Comm(), count, &slab));
    PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, hierarchy.Comm()));
    file.Group(group);
    file.Attribute(group, "steps", static_cast<double>(level.Steps()));
    file.Attribute(group, "counts", std::vector<double>(counts.begin(), counts.end()));
    for (const auto axis : {0, 1}) {
      const auto &widths = level.Mesh().Layout().widths[axis];
      file.Attribute(group, axis ? "rows" : "columns", std::vector<double>(widths.begin(), widths.end()));
    }
    const auto &ranks = level.Mesh().Layout().ranks;
    file.Attribute(group, "ranks", std::vector<double>(ranks.begin(), ranks.end()));
    for (int k = 0; k < kPointFields; ++k) {
      const PointFieldInfo &field = points.Table()[k];
      void *data = nullptr;
      if (field.components == 0) continue;
      PetscCall(points.Field(static_cast<PointField>(k), &data));
      file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
    }
  }
  for (int b = 0; b + 1 < hierarchy.Levels(); ++b) PetscCall(WriteBorder(file, b, hierarchy));
  PetscCall(file.Finish());
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace
{

/// The first option that two runs do not share, as a message; empty where there is none.
std::string FirstDifference(const std::vector<std::string> &now, const std::vector<std::string> &then)
{
  for (std::size_t k = 0; k < std::max(now.size(), then.size()); ++k) {
    const std::string a = k < now.size() ? now[k] : "nothing", b = k < then.size() ? then[k] : "nothing";
    if (a != b) return "this run has '" + a + "' where the checkpoint has '" + b + "'";
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

/// Reads one level; false where something is missing.
PetscErrorCode ReadLevel(const H5Reader &file, const std::string &group, Level &level, MPI_Comm comm, bool *good)
{
  PetscMPIInt rank, size;
  std::vector<double> counts, widths[2], ranks;
  double steps = 0;
  hsize_t total = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  *good = file.Has(group) && file.Attribute(group, "steps", &steps) && file.Attribute(group, "counts", &counts) &&
          file.Attribute(group, "columns", &widths[0]) && file.Attribute(group, "rows", &widths[1]) &&
          file.Attribute(group, "ranks", &ranks) &&
          file.Rows(group + "/id", &total);
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  const Slab slab = MakeReadSlab(counts, size, rank, total);
  Points &points = level.PointStore();
  if (static_cast<int>(counts.size()) == size) {
    GridLayout layout;
    for (int axis = 0; axis < 2; ++axis) layout.widths[axis].assign(widths[axis].begin(), widths[axis].end());
    layout.ranks.assign(ranks.begin(), ranks.end());
    PetscCall(level.Recut(layout));
  }
  PetscCall(points.Resize(static_cast<int>(slab.count)));
  for (int k = 0; k < kPointFields && *good; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *data = nullptr;
    if (field.components == 0) continue;
    PetscCall(points.Field(static_cast<PointField>(k), &data));
    *good = file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
  }
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  level.SetSteps(static_cast<long>(steps));
  if (static_cast<int>(counts.size()) != size) {
    PetscCall(level.Migrate(true));
    PetscCall(level.Sort());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadBorder(const H5Reader &file, int b, Hierarchy &hierarchy, bool *good)
{
  hsize_t rows = 0;
  PetscFunctionBeginUser;
  *good = file.Rows(BorderName(b), &rows);
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<double> forces(2 * rows);
  if (rows > 0) *good = file.Dataset(BorderName(b), H5T_NATIVE_DOUBLE, 2, {0, rows, rows}, forces.data());
  if (*good) PetscCall(hierarchy.RestoreBorderForces(b, forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ReadCheckpoint(const std::string &path, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                              RunState *s)
{
  MPI_Comm comm = hierarchy.Comm();
  H5Reader file;
  double version = 0;
  std::string then;
  std::vector<double> state, numbers;
  PetscFunctionBeginUser;
  PetscCheck(file.Open(comm, path), comm, PETSC_ERR_USER_INPUT, "-restart %s: must be a whole checkpoint; it is missing, cut short or no HDF5 file", path.c_str());
  PetscCheck(file.Attribute("/", "format_version", &version) && file.Attribute("/", "identity", &then), comm,
             PETSC_ERR_USER_INPUT, "-restart %s: must be a checkpoint of mlgimp", path.c_str());
  PetscCheck(version == kFormatVersion, comm, PETSC_ERR_USER_INPUT, "-restart %s: must have format version %g; it has %g", path.c_str(), kFormatVersion, version);
  const std::string difference = FirstDifference(identity, Split(then, '\n'));
  PetscCheck(difference.empty(), comm, PETSC_ERR_USER_INPUT, "-restart %s: must be of the same case; %s", path.c_str(), difference.c_str());
  bool good = file.Attribute("/", "state", &state) && file.Attribute("/", "books", &numbers) && state.size() == 11 &&
              numbers.size() == sizeof(Books) / sizeof(double);
  for (int l = 0; l < hierarchy.Levels() && good; ++l) PetscCall(ReadLevel(file, GroupName(l), hierarchy.At(l), comm, &good));
  for (int b = 0; b + 1 < hierarchy.Levels() && good; ++b) PetscCall(ReadBorder(file, b, hierarchy, &good));
  PetscCheck(good, comm, PETSC_ERR_USER_INPUT, "-restart %s: must be a whole checkpoint; parts of it are missing", path.c_str());
  Books books;
  std::copy(numbers.begin(), numbers.end(), reinterpret_cast<double *>(&books));
  PetscCall(hierarchy.RestoreBooks(books));
  *s = {state[0], state[1], state[2], static_cast<long>(state[3]), static_cast<int>(state[4]),
        state[5], state[6], state[10], state[7], state[8], state[9]};
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
