// Writing of checkpoints.
#include "program/checkpoint_format.hpp"

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
static PetscErrorCode WritePoints(H5Writer &file, MPI_Comm comm, const std::string &group, Points &points)
{
  PetscMPIInt rank, size;
  Slab slab;
  const int count = points.Count();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  std::vector<int> counts(rank == 0 ? size : 0);
  PetscCall(MakeSlab(comm, count, &slab));
  PetscCallMPI(MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm));
  PetscCall(file.Group(group));
  PetscCall(file.List(group + "/counts", Numbers(counts)));
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *data = nullptr;
    if (field.components == 0) continue;
    PetscCall(points.Field(static_cast<PointField>(k), &data));
    PetscCall(file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteLevel(H5Writer &file, Hierarchy &hierarchy, int l)
{
  Level &level = hierarchy.At(l);
  const std::string group = LevelName(l);
  const GridLayout &layout = level.Mesh().Layout();
  const LevelClock &clock = level.Clock();
  std::vector<double> keys, pressures;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  const bool first = rank == 0;
  PetscCall(WritePoints(file, hierarchy.Comm(), group, level.PointStore()));
  PetscCall(file.Attribute(group, "pace", {double(clock.steps), clock.drift, clock.drift_per_step, double(clock.contact_awake)}));
  for (int axis = 0; axis < 3; ++axis)
    PetscCall(file.List(group + kWidthNames[axis], first ? Numbers(layout.widths[axis]) : std::vector<double>()));
  PetscCall(file.List(group + "/ranks", first ? Numbers(layout.ranks) : std::vector<double>()));
  if (rank == layout.ranks[0])
    for (const auto &[key, pressure] : level.Pressures()) {
      keys.push_back(static_cast<double>(key));
      pressures.push_back(pressure);
    }
  PetscCall(file.List(group + "/pressure_keys", keys));
  PetscCall(file.List(group + "/pressures", pressures));
  for (int origin = 0; origin < 2 && hierarchy.Copies().ready; ++origin)
    PetscCall(WritePoints(file, hierarchy.Comm(), CopiesName(l, origin), level.CopyStore(origin)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The first rank writes what a border keeps.
static PetscErrorCode WriteBorder(H5Writer &file, Hierarchy &hierarchy, int b)
{
  std::vector<double> state;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  PetscCall(hierarchy.GatherInterfaceState(b, &state));
  PetscCall(file.List(BorderName(b), rank == 0 ? state : std::vector<double>()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode WriteCheckpoint(const std::string &directory, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                               const RunState &state, std::string *problem)
{
  H5Writer file;
  Slab slab;
  PetscMPIInt rank;
  std::vector<double> totals;
  const CopyState &copies = hierarchy.Copies();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(hierarchy.Comm(), &rank));
  for (const Budgets *part : hierarchy.Parts()) part->AppendKept(&totals);
  PetscCall(MakeSlab(hierarchy.Comm(), 1, &slab));
  PetscCall(file.Open(hierarchy.Comm(), CheckpointPath(directory, state.step), true));
  PetscCall(file.Attribute("/", "format_version", {double(kFormatVersion)}));
  PetscCall(file.Text("/identity", rank == 0 ? Join(identity, "\n") : "")); // of any length, as no attribute may be
  PetscCall(file.Attribute("/", "state", StateAsNumbers(state)));
  PetscCall(file.Attribute("/", "copies",
                           {double(copies.ready), copies.momentum_left[0], copies.momentum_left[1], copies.momentum_left[2]}));
  PetscCall(file.Dataset("/totals", H5T_NATIVE_DOUBLE, static_cast<int>(totals.size()), slab, totals.data()));
  for (int l = 0; l < hierarchy.Levels(); ++l) PetscCall(WriteLevel(file, hierarchy, l));
  for (int b = 0; b + 1 < hierarchy.Levels(); ++b) PetscCall(WriteBorder(file, hierarchy, b));
  PetscCall(file.Finish(problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
