// SiblingGroups of siblings: found on the rank that their parent's number names, gathered on that of the first, averaged.
#include "hierarchy/transfer/merging.hpp"

#include "base/exchange.hpp"
#include "level/samples.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace mlgimp
{

namespace
{

constexpr double kMaxDistortion = 0.05; ///< of a family that becomes one point where losses are bounded, cells
constexpr double kNoStrain = 1e-4;      ///< losses are no larger part of less: such energies hang on rounding

struct Sibling {
  std::int64_t id;
  int rank, point;
};
using SiblingGroups = std::map<std::int64_t, std::vector<Sibling>>; ///< by the parent's number

/// Half an edge of the points that a level is seeded with, m.
double UsualSize(Level &level, int body)
{
  return 0.5 * level.Geometry().grid.spacing / level.Parts().model.bodies[body].points_per_cell;
}

/// This rank's points that are smaller than usual on their level and were made by splitting.
std::vector<Sibling> FindSmall(Level &level, const PointNumbers &numbers, PetscMPIInt rank)
{
  constexpr double kMaxSmallSize = 0.75; // of the usual half size
  const PointArrays a = level.PointStore().Arrays();
  std::vector<Sibling> found;
  for (int p = 0; p < a.count; ++p) {
    if (LargestComponent(a.HalfSize(p)) < kMaxSmallSize * UsualSize(level, a.body[p]) && numbers.Parent(a.id[p]) >= 0)
      found.push_back({a.id[p], rank, p});
  }
  return found;
}

/// Groups siblings, each family in the order of its numbers, and keeps whole families only.
SiblingGroups WholeFamilies(const std::vector<Sibling> &siblings, const PointNumbers &numbers, int children)
{
  SiblingGroups families;
  for (const Sibling &s : siblings) families[numbers.Parent(s.id)].push_back(s);
  for (auto family = families.begin(); family != families.end();)
    family = static_cast<int>(family->second.size()) == children ? std::next(family) : families.erase(family);
  for (auto &[parent, family] : families)
    std::sort(family.begin(), family.end(), [](const Sibling &s, const Sibling &t) { return s.id < t.id; });
  return families;
}

/// Which of this rank's siblings have to go where, so that whole families meet on the rank of their first; families: of all
/// ranks.
PetscErrorCode AssignMergeRanks(MPI_Comm world, std::vector<Sibling> siblings, const PointNumbers &numbers, int children,
                                Migrants *migrants, int *families)
{
  struct Order {
    int rank, point, to;
  };
  std::vector<Order> orders;
  const auto home = [&, ranks = RanksOf(world)](const Sibling &s) { return static_cast<int>(numbers.Parent(s.id) % ranks); };
  PetscFunctionBeginUser;
  PetscCall(ExchangeRecords(world, &siblings, home));
  const SiblingGroups whole = WholeFamilies(siblings, numbers, children);
  for (const auto &[parent, family] : whole)
    for (const Sibling &s : family)
      if (s.rank != family.front().rank) orders.push_back({s.rank, s.point, family.front().rank});
  PetscCall(ExchangeRecords(world, &orders, [](const Order &order) { return order.rank; }));
  std::sort(orders.begin(), orders.end(), [](const Order &a, const Order &b) { return a.point < b.point; });
  for (const Order &order : orders) migrants->Add(order.point, order.to);
  *families = static_cast<int>(whole.size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, families, 1, MPI_INT, MPI_SUM, world));
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

/// In axisymmetry the mean of the siblings' R, which lie evenly about their parent, heavier ones outside; else 0.
double MeanInitialRadius(const PointArrays &a, const std::vector<Sibling> &family)
{
  double sum = 0;
  for (const Sibling &s : family) sum += a.initial_radius ? a.initial_radius[s.point] : 0;
  return sum / static_cast<double>(family.size());
}

/// In axisymmetry the parent's R, and the r with which its volume is the sum of the siblings'.
void SetRadius(const PointArrays &a, int parent, double initial, double volume_ratio)
{
  a.initial_radius[parent] = initial;
  a.position[PointArrays::At(parent, 2)] = initial * volume_ratio / Determinant(a.F + PointArrays::At(parent, 4), 2);
}

/// Mean by mass of the siblings' J = det F, with the hoop.
double MeanVolumeRatio(const PointArrays &a, const std::vector<Sibling> &family)
{
  double sum = 0, mass = 0;
  for (const Sibling &s : family) sum += a.mass[s.point] * a.VolumeRatio(s.point), mass += a.mass[s.point];
  return sum / mass;
}

/// For metals, as means of tensors do not keep determinants: F gets the mean J of the siblings, and the stress its pressure.
void SetVolumeRatio(const Material &metal, const PointArrays &a, int parent, double J)
{
  double *const F = a.F + PointArrays::At(parent, a.dim * a.dim);
  double *const s = a.stress + PointArrays::At(parent, a.stress_components);
  const double grown = std::pow(J / a.VolumeRatio(parent), 1.0 / a.dim);
  const double more = metal.Elastic().Bulk() * std::log(J) / J - (s[0] + s[1] + s[2]) / 3;
  for (int k = 0; k < a.dim * a.dim; ++k) F[k] *= grown;
  for (int k = 0; k < 3; ++k) s[k] += more;
}

/// The first of a family becomes its parent.
void MakeParent(const Model &model, Points &points, const std::vector<Sibling> &family, std::int64_t id, int ratio)
{
  const int first = family.front().point;
  const PointArrays a = points.Arrays();
  const double volume_ratio = MeanVolumeRatio(a, family), radius = MeanInitialRadius(a, family);
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    void *const data = points.Field(static_cast<PointField>(k));
    if (k == kMass || field.components == 0) continue; // the mass comes last: means are by it
    if (field.merge == MergeRule::kBits)
      for (const Sibling &s : family) static_cast<int *>(data)[first] |= static_cast<int *>(data)[s.point];
    else if (field.type == FieldType::kReal)
      MergeReals(field.merge, field.components, a.mass, family, static_cast<double *>(data));
  }
  MergeReals(MergeRule::kSum, 1, a.mass, family, a.mass);
  a.id[first] = id;
  for (int d = 0; d < a.dim; ++d) a.half_size[PointArrays::At(first, a.dim) + d] *= ratio;
  if (a.initial_radius) SetRadius(a, first, radius, volume_ratio);
  const Material &material = model.MaterialOf(a.body[first]);
  if (material.Traits().flows) SetVolumeRatio(material, a, first, volume_ratio);
}

/// The part of a family's strain energy that may be missing in its parent: as much energy as that of a parent of the usual size
/// may. So the energy that mergers change in a cell does not depend on how small its points are, and where strain changes like
/// the logarithm of the way to a tip, points of all sizes become larger in the end.
double AllowedLoss(Level &level, int point, int ratio, double most_loss)
{
  const PointArrays a = level.PointStore().Arrays();
  double smaller = 1;
  for (int d = 0; d < a.dim; ++d) smaller *= UsualSize(level, a.body[point]) / (ratio * a.HalfSize(point)[d]);
  return most_loss * std::max(1.0, smaller);
}

/// How far the middles of the siblings' edges are from where they would be in one box with their mean F, at most, m. Of metals
/// that have flowed the strain energy says nothing of that.
double Distortion(const PointArrays &a, const std::vector<Sibling> &family, int ratio)
{
  const double share = 1.0 / static_cast<double>(family.size());
  Vec3 middle{};
  double most = 0;
  for (const Sibling &s : family) middle = middle + share * a.Position(s.point);
  const auto by_mean = [&](Vec3 X) {
    Vec3 x{};
    for (const Sibling &s : family) x = x + share * a.Deform(s.point, X);
    return x;
  };
  for (int child = 0; child < static_cast<int>(family.size()); ++child) { // in the order of their places, as they were split
    const int p = family[child].point, place[3] = {child % ratio, child / ratio % ratio, child / (ratio * ratio)};
    Vec3 X{};
    for (int axis = 0; axis < a.dim; ++axis) X[axis] = (2 * place[axis] + 1 - ratio) * a.HalfSize(p)[axis];
    const Vec3 off = a.Position(p) - middle - by_mean(X);
    for (int axis = 0; axis < a.dim; ++axis) {
      Vec3 edge{};
      edge[axis] = a.HalfSize(p)[axis];
      const Vec3 turned = a.Deform(p, edge) - by_mean(edge);
      most = std::max({most, Norm(off + turned), Norm(off - turned)});
    }
  }
  return most;
}

} // namespace

PetscErrorCode MergeSiblings(MPI_Comm world, Level &level, const PointNumbers &numbers, int ratio, double most_loss,
                             Budgets *budgets)
{
  const Model &model = level.Parts().model;
  const int children = level.Geometry().grid.dim == 3 ? ratio * ratio * ratio : ratio * ratio;
  const PetscMPIInt rank = RankIn(world);
  Migrants migrants;
  int families = 0;
  PetscFunctionBeginUser;
  PetscCall(AssignMergeRanks(world, FindSmall(level, numbers, rank), numbers, children, &migrants, &families));
  if (families == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MovePoints(world, level.PointStore(), level.PointStore(), migrants));

  std::vector<int> spent;
  std::vector<char> record(level.PointStore().RecordBytes());
  for (const auto &[parent, family] : WholeFamilies(FindSmall(level, numbers, rank), numbers, children)) {
    std::vector<int> points;
    for (const Sibling &s : family) points.push_back(s.point);
    const Budgets before = SumPoints(level, points);
    if (std::isfinite(most_loss) &&
        Distortion(level.PointStore().Arrays(), family, ratio) > kMaxDistortion * level.Geometry().grid.spacing)
      continue;
    level.PointStore().Pack(points.front(), record.data());
    const double allowed = AllowedLoss(level, points.front(), ratio, most_loss);
    MakeParent(model, level.PointStore(), family, parent, ratio);
    const Budgets after = SumPoints(level, {points.front()});
    const Material &material = model.MaterialOf(level.PointStore().Arrays().body[points.front()]);
    const double least = 0.5 * before.mass * std::pow(kNoStrain * material.SpeedOfSound(), 2);
    if (std::abs(after.strain_energy - before.strain_energy) > allowed * std::max<double>(before.strain_energy, least)) {
      level.PointStore().Unpack(record.data(), points.front());
      continue;
    }
    AddChange(before, after, budgets);
    spent.insert(spent.end(), points.begin() + 1, points.end());
    budgets->points_merged += 1;
    budgets->points_spent += children - 1;
  }
  std::sort(spent.begin(), spent.end());
  level.PointStore().Remove(spent);
  PetscCall(level.Stores().Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
