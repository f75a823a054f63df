// Families of siblings: found on all ranks, gathered on one, averaged.
#include "hierarchy/merging.hpp"

#include <algorithm>
#include <map>
#include <optional>

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
    if (LargestComponent(a.HalfSize(p)) < 0.75 * usual && numbers.Parent(a.id[p]) >= 0) found->push_back({a.id[p], rank, p});
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

/// Makes the field of the first of a family what the rule says of all; mass: of points, before it is merged itself.
void MergeReals(MergeRule rule, int components, const double *mass, const std::vector<Sibling> &family, double *field)
{
  for (int c = 0; c < components && rule != MergeRule::kFirst; ++c) {
    double &merged = field[PointArrays::At(family.front().point, components) + c];
    double sum = 0, weighted = 0, total = 0, largest = merged;
    for (const Sibling &s : family) {
      const double value = field[PointArrays::At(s.point, components) + c], m = mass[s.point];
      weighted += m * value, total += m, sum += value, largest = std::max(largest, value);
    }
    merged = rule == MergeRule::kMean ? weighted / total : rule == MergeRule::kSum ? sum : largest;
  }
}

double PlaneDeterminant(const double *F) { return F[0] * F[3] - F[1] * F[2]; }

/// In axisymmetry: what the radii of the parent follow from. Siblings lie evenly about it, heavier ones outside.
struct ParentRadius {
  double initial = 0, volume_ratio = 0; ///< mean of the siblings' R; mean by mass of their J = det F r/R

  ParentRadius(const PointArrays &a, const std::vector<Sibling> &family)
  {
    double mass = 0;
    for (const Sibling &s : family) {
      const double stretch = a.position[PointArrays::At(s.point, 2)] / a.initial_radius[s.point];
      initial += a.initial_radius[s.point] / static_cast<double>(family.size());
      volume_ratio += a.mass[s.point] * PlaneDeterminant(a.F + PointArrays::At(s.point, 4)) * stretch;
      mass += a.mass[s.point];
    }
    volume_ratio /= mass;
  }
  /// R, and the r with which the volume is the sum of the siblings'.
  void Set(const PointArrays &a, int parent) const
  {
    a.initial_radius[parent] = initial;
    a.position[PointArrays::At(parent, 2)] = initial * volume_ratio / PlaneDeterminant(a.F + PointArrays::At(parent, 4));
  }
};

/// The first of a family becomes its parent.
PetscErrorCode MakeParent(Points &points, const std::vector<Sibling> &family, std::int64_t id, int ratio)
{
  const int first = family.front().point;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(points.Arrays(&a));
  const std::optional<ParentRadius> radius = a.initial_radius ? std::optional<ParentRadius>({a, family}) : std::nullopt;
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *data = nullptr;
    if (k == kMass || field.components == 0) continue; // the mass comes last: means are by it
    PetscCall(points.Field(static_cast<PointField>(k), &data));
    if (field.merge == MergeRule::kBits)
      for (const Sibling &s : family) static_cast<int *>(data)[first] |= static_cast<int *>(data)[s.point];
    else if (field.type == FieldType::kReal)
      MergeReals(field.merge, field.components, a.mass, family, static_cast<double *>(data));
  }
  MergeReals(MergeRule::kSum, 1, a.mass, family, a.mass);
  a.id[first] = id;
  for (int d = 0; d < a.dim; ++d) a.half_size[PointArrays::At(first, a.dim) + d] *= ratio;
  if (radius) radius->Set(a, first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode MergeSiblings(MPI_Comm world, Level &level, const PointNumbers &numbers, int ratio, Budgets *budgets)
{
  const int children = level.Geometry().grid.dim == 3 ? ratio * ratio * ratio : ratio * ratio;
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
    Budgets before, after;
    for (const Sibling &s : family) points.push_back(s.point);
    PetscCall(level.SumPoints(points, &before));
    PetscCall(MakeParent(level.PointStore(), family, parent, ratio));
    PetscCall(level.SumPoints({points.front()}, &after));
    AddChange(before, after, budgets);
    spent.insert(spent.end(), points.begin() + 1, points.end());
    budgets->points_merged += 1;
  }
  std::sort(spent.begin(), spent.end());
  PetscCall(level.PointStore().Remove(spent));
  PetscCall(level.Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
