// Families of siblings: found on all ranks, gathered on one, averaged.
#include "hierarchy/merging.hpp"

#include <algorithm>
#include <map>

namespace mlgimp
{

namespace
{

struct Sibling {
  std::int64_t id;
  int rank, point;
};
using Families = std::map<std::int64_t, std::vector<Sibling>>; ///< by the parent's number

/// This rank's points that are smaller than usual on their level and were made by splitting.
PetscErrorCode FindSmall(Level &level, const PointNumbers &numbers, PetscMPIInt rank, std::vector<Sibling> *found)
{
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(level.PointStore().Arrays(&a));
  for (int p = 0; p < a.count; ++p) {
    const double usual = 0.5 * level.Geometry().grid.spacing / level.Physics().bodies[a.body[p]].points_per_cell;
    if (std::max(a.half_size[2 * p], a.half_size[2 * p + 1]) < 0.75 * usual && numbers.Parent(a.id[p]) >= 0)
      found->push_back({a.id[p], rank, p});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Groups siblings, each family in the order of its numbers, and keeps whole families only.
Families WholeFamilies(const std::vector<Sibling> &siblings, const PointNumbers &numbers, int children)
{
  Families families;
  for (const Sibling &s : siblings) families[numbers.Parent(s.id)].push_back(s);
  for (auto family = families.begin(); family != families.end();)
    family = static_cast<int>(family->second.size()) == children ? std::next(family) : families.erase(family);
  for (auto &[parent, family] : families)
    std::sort(family.begin(), family.end(), [](const Sibling &s, const Sibling &t) { return s.id < t.id; });
  return families;
}

PetscErrorCode GatherSiblings(MPI_Comm world, const std::vector<Sibling> &mine, std::vector<Sibling> *all)
{
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(world, &size));
  const int bytes = static_cast<int>(mine.size() * sizeof(Sibling));
  std::vector<int> counts(size), starts(size + 1, 0);
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, world));
  for (int k = 0; k < size; ++k) starts[k + 1] = starts[k] + counts[k];
  all->resize(starts[size] / sizeof(Sibling));
  PetscCallMPI(MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all->data(), counts.data(), starts.data(), MPI_BYTE, world));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Mean by mass of a field over a family, into the first.
void Average(double *field, int components, const double *mass, const std::vector<Sibling> &family)
{
  for (int c = 0; c < components; ++c) {
    double sum = 0, total = 0;
    for (const Sibling &s : family) sum += mass[s.point] * field[components * s.point + c], total += mass[s.point];
    field[components * family.front().point + c] = sum / total;
  }
}

void MakeParent(const PointArrays &a, const std::vector<Sibling> &family, std::int64_t id, int ratio)
{
  const int first = family.front().point;
  Average(a.position, 2, a.mass, family);
  Average(a.velocity, 2, a.mass, family);
  Average(a.F, 4, a.mass, family);
  Average(a.stress, 4, a.mass, family);
  Average(a.short_wave_stress, 3, a.mass, family);
  if (a.history) Average(a.history, a.history_components, a.mass, family);
  double mass = 0;
  for (const Sibling &s : family) {
    mass += a.mass[s.point];
    a.faces[first] |= a.faces[s.point];
    for (int k = 0; k < a.loads; ++k) {
      double &share = a.load_share[a.loads * first + k];
      share = std::max(share, a.load_share[a.loads * s.point + k]);
    }
  }
  a.id[first] = id;
  a.mass[first] = mass;
  for (int d = 0; d < 2; ++d) a.half_size[2 * first + d] *= ratio;
}

} // namespace

PetscErrorCode MergeSiblings(MPI_Comm world, Level &level, const PointNumbers &numbers, int ratio, PointTransferTotals *totals)
{
  const int children = ratio * ratio;
  std::vector<Sibling> mine, all;
  std::vector<std::pair<int, PetscMPIInt>> leaving;
  Migrants migrants;
  PetscMPIInt rank;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(world, &rank));
  PetscCall(FindSmall(level, numbers, rank, &mine));
  PetscCall(GatherSiblings(world, mine, &all));
  const Families everywhere = WholeFamilies(all, numbers, children);
  if (everywhere.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const auto &[parent, family] : everywhere)
    for (const Sibling &s : family)
      if (s.rank == rank && family.front().rank != rank) leaving.emplace_back(s.point, family.front().rank);
  std::sort(leaving.begin(), leaving.end());
  for (const auto &[point, to] : leaving) migrants.points.push_back(point), migrants.ranks.push_back(to);
  PetscCall(MovePoints(world, level.PointStore(), level.PointStore(), migrants));

  mine.clear();
  PetscCall(FindSmall(level, numbers, rank, &mine));
  PetscCall(level.PointStore().Arrays(&a));
  std::vector<int> spent;
  for (const auto &[parent, family] : WholeFamilies(mine, numbers, children)) {
    std::vector<int> points;
    PointSums before, after;
    for (const Sibling &s : family) points.push_back(s.point);
    PetscCall(level.SumPoints(points, &before));
    MakeParent(a, family, parent, ratio);
    PetscCall(level.SumPoints({points.front()}, &after));
    AddChange(before, after, totals);
    spent.insert(spent.end(), points.begin() + 1, points.end());
    ++totals->merged;
  }
  std::sort(spent.begin(), spent.end());
  PetscCall(level.PointStore().Remove(spent));
  PetscCall(level.Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
