// Children of points, and points that are drawn out.
#include "hierarchy/transfer/splitting.hpp"

#include "level/samples.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

PointNumbers::Range PointNumbers::RangeOf(std::int64_t id) const
{
  Range range{0, seeds_};
  while (id >= range.start + range.count) range = {range.start + range.count, range.count * children_};
  return range;
}

bool PointNumbers::CanSplit(std::int64_t id) const
{
  const Range range = RangeOf(id);
  return range.count <= (INT64_MAX / 4 - range.start) / (children_ + 1);
}

std::int64_t PointNumbers::Child(std::int64_t id, int child) const
{
  const Range range = RangeOf(id);
  return range.start + range.count + (id - range.start) * children_ + child;
}

std::int64_t PointNumbers::Parent(std::int64_t id) const
{
  const Range range = RangeOf(id);
  return range.start == 0 ? -1 : range.start - range.count / children_ + (id - range.start) / children_;
}

int PointNumbers::ChildIndex(std::int64_t id) const { return static_cast<int>((id - RangeOf(id).start) % children_); }

void AddChange(const Budgets &before, const Budgets &after, Budgets *budgets)
{
  budgets->transfer_mass_error += std::abs(after.mass - before.mass);
  for (int d = 0; d < 3; ++d) budgets->transfer_momentum_error += std::abs(after.momentum[d] - before.momentum[d]);
  const double strain = after.strain_energy - before.strain_energy;
  budgets->transfer_energy += after.kinetic_energy - before.kinetic_energy + strain;
  budgets->transfer_strain_energy += strain;
}

/// Place of a child among its siblings along each axis.
static Index PlaceOf(int child, const Index &parts)
{
  return {child % parts[0], child / parts[0] % parts[1], child / (parts[0] * parts[1])};
}

/// From the centre of an undeformed parent to that of a child, m.
static Vec3 InitialOffsetOf(const PointArrays &a, int parent, int child, const Index &parts)
{
  const Vec3 half = a.HalfSize(parent);
  const Index place = PlaceOf(child, parts);
  Vec3 offset;
  for (int d = 0; d < 3; ++d) offset[d] = ((2 * place[d] + 1.0) / parts[d] - 1) * half[d];
  return offset;
}

/// The same where both are deformed.
static Vec3 OffsetOf(const PointArrays &a, int parent, int child, const Index &parts)
{
  return a.Deform(parent, InitialOffsetOf(a, parent, child, parts));
}

/// In axisymmetry, the mean by mass of the children's places less the parent's: heavier ones lie outside.
static Vec3 MeanOffset(const PointArrays &a, int parent, const PointSplit &split)
{
  const double r = a.position[PointArrays::At(parent, a.dim)];
  Vec3 mean{};
  for (int child = 0; child < split.Children(); ++child) {
    const Vec3 dx = OffsetOf(a, parent, child, split.parts);
    mean = mean + (1 + dx[0] / r) / split.Children() * dx;
  }
  return mean;
}

/// Makes a copy of the parent one of its children: a share of its box and mass, moving with v + L (x - the mean by mass of the
/// children). In axisymmetry shares of mass are those of the radii, and R = r/F_zz, so that volumes and F_zz are kept.
static void MakeChild(const Model &model, const PointArrays &a, int target, int child, const PointSplit &split,
                      const VelocitySample &sample)
{
  const int dim = a.dim;
  const Index place = PlaceOf(child, split.parts);
  const Vec3 dX = InitialOffsetOf(a, target, child, split.parts), dx = a.Deform(target, dX);
  Vec3 mean{};
  if (a.initial_radius) {
    const double r = a.position[PointArrays::At(target, dim)];
    mean = MeanOffset(a, target, split);
    a.mass[target] *= (r + dx[0]) / r;
    a.initial_radius[target] *= (r + dx[0]) / r;
  }
  for (int d = 0; d < dim; ++d) {
    const std::ptrdiff_t at = PointArrays::At(target, dim) + d;
    for (int b = 0; b < dim; ++b) a.velocity[at] += sample.L[dim * d + b] * (dx[b] - mean[b]);
    a.position[at] += dx[d];
    a.initial_position[at] += dX[d];
    a.half_size[at] /= split.parts[d];
  }
  a.id[target] = split.numbers.Child(a.id[target], child);
  a.mass[target] /= split.Children();
  for (const Side side : SidesOf{dim}) {
    if (place[AxisOf(side)] != (SignOf(side) < 0 ? 0 : split.parts[AxisOf(side)] - 1)) a.faces[target] &= ~OuterFaceBit(side);
  }
  for (int k = 0; k < a.loads; ++k)
    if (!(a.faces[target] & OuterFaceBit(model.loads[k].side))) a.load_share[PointArrays::At(target, a.loads) + k] = 0;
}

PetscErrorCode SplitPoints(Level &level, const PointSplit &split, const std::vector<int> &parents,
                           const std::vector<VelocitySample> &samples, std::vector<int> *points, Budgets *budgets)
{
  const Model &model = level.Parts().model;
  const int children = split.Children();
  PetscFunctionBeginUser;
  if (parents.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  const Budgets before = SumPoints(level, *points);
  Points &store = level.PointStore();
  int next = store.Count();
  PetscCall(store.Resize(next + static_cast<int>(parents.size()) * (children - 1)));
  const PointArrays a = store.Arrays();
  for (std::size_t k = 0; k < parents.size(); ++k)
    for (int child = children - 1; child >= 0; --child) { // the first takes the parent's place, last
      const int parent = parents[k], target = child ? next++ : parent;
      if (child) points->push_back(target);
      if (child) store.Copy(parent, target);
      MakeChild(model, a, target, child, split, samples[k]);
    }
  level.Stores().PutBack(*points);
  AddChange(before, SumPoints(level, *points), budgets);
  budgets->points_split += static_cast<double>(parents.size());
  budgets->points_made += static_cast<double>(parents.size()) * (children - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<int> FindParents(Level &level, const std::vector<int> &points, double spacing, int ratio, const PointNumbers &numbers,
                             Budgets *budgets)
{
  constexpr double kMinParentSize = 0.75; // of the coarser level's usual half size
  const PointArrays a = level.PointStore().Arrays();
  std::vector<int> parents;
  for (int p : points) {
    const double usual = 0.5 * spacing / level.Parts().model.bodies[a.body[p]].points_per_cell;
    if (LargestComponent(a.HalfSize(p)) <= kMinParentSize * ratio * usual) continue;
    if (numbers.CanSplit(a.id[p]))
      parents.push_back(p);
    else
      budgets->points_unsplit += 1;
  }
  return parents;
}

/// Points with an edge that has grown longer than a cell, and than twice the usual, along one of `axes` of their undeformed box.
/// A child beyond the grid would be lost: such a point stays whole.
static std::vector<int> FindStretched(Level &level, const PointNumbers &numbers, const std::vector<int> &axes)
{
  constexpr double kMaxHalfEdge = 0.5, kMinRadius = 0.75; // cells; half edges: a child on the axis would have no mass
  const GridGeometry &grid = level.Geometry().grid;
  const PointArrays a = level.PointStore().Arrays();
  const Model &model = level.Parts().model;
  std::vector<int> found;
  const auto lies_within = [&](const Vec3 &x) {
    for (int d = 0; d < a.dim; ++d)
      if (!(x[d] > grid.lower[d] && x[d] < grid.lower[d] + grid.cells[d] * grid.spacing)) return false;
    return true;
  };
  std::vector<double> most2; // of half an edge of a body's points, m2
  for (const Body &body : model.bodies) {
    const double most = grid.spacing * std::max(kMaxHalfEdge, 1.0 / body.points_per_cell);
    most2.push_back(model.materials[body.material]->SplitsStretched() ? most * most : HUGE_VAL);
  }
  for (int p = 0; p < a.count; ++p)
    for (int axis : axes) {
      const Vec3 edge = a.HalfEdge(p, axis);
      if (Dot(edge, edge) <= most2[a.body[p]] || !numbers.CanSplit(a.id[p])) continue;
      if (a.initial_radius && a.Position(p)[0] < kMinRadius * std::abs(edge[0])) continue;
      if (lies_within(a.Position(p) - 0.5 * edge) && lies_within(a.Position(p) + 0.5 * edge)) found.push_back(p);
    }
  return found;
}

PetscErrorCode SplitStretched(MPI_Comm world, Level &level, const PointNumbers &numbers)
{
  const int dim = level.Geometry().grid.dim;
  int any = 0;
  PetscFunctionBeginUser;
  any = !FindStretched(level, numbers, dim == 3 ? std::vector<int>{0, 1, 2} : std::vector<int>{0, 1}).empty();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, world));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  for (int axis = 0; axis < dim; ++axis) {
    Index parts{1, 1, 1};
    parts[axis] = 2;
    std::vector<int> points = FindStretched(level, numbers, {axis});
    const std::vector<int> parents = points;
    PetscCall(SplitPoints(level, {parts, numbers}, parents, SampleVelocity(level, parents), &points, &level.Totals()));
  }
  PetscCall(level.Stores().Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
