// Moving points between levels, splitting and merging.
#include "levels/crossing.hpp"

#include "levels/merging.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

LevelPlaces PlacesOf(const LevelGeometry &geometry)
{
  constexpr double kWidening = 0.999; // cells; not one, where points may lie at the start
  LevelPlaces places;
  for (int axis = 0; axis < 2; ++axis) {
    const double h = geometry.grid.spacing, lower = geometry.grid.lower[axis], upper = lower + geometry.grid.cells[axis] * h;
    const bool below = geometry.border[2 * axis], above = geometry.border[2 * axis + 1];
    places.seeds.lower[axis] = below ? lower : -HUGE_VAL;
    places.seeds.upper[axis] = above ? upper : HUGE_VAL;
    places.owned.lower[axis] = below ? lower - kWidening * h : -HUGE_VAL;
    places.owned.upper[axis] = above ? upper + kWidening * h : HUGE_VAL;
  }
  return places;
}

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

int PointNumbers::ChildIndex(std::int64_t id) const
{
  return static_cast<int>((id - RangeOf(id).start) % children_);
}

PetscErrorCode Crossing::FindEntering(std::vector<int> *points)
{
  const Box box = PlacesOf(fine_.Geometry()).owned;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(coarse_.PointStore().Arrays(&a));
  for (int p = 0; p < a.count; ++p)
    if (box.Contains({a.position[2 * p], a.position[2 * p + 1]})) points->push_back(p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Crossing::FindLeaving(std::vector<int> *points)
{
  const Box box = PlacesOf(fine_.Geometry()).owned;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(fine_.PointStore().Arrays(&a));
  for (int p = 0; p < a.count; ++p)
    if (!box.Contains({a.position[2 * p], a.position[2 * p + 1]})) points->push_back(p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds up mass and momentum of some points.
static PetscErrorCode Sum(Points &points, const std::vector<int> &list, double sums[3])
{
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(points.Arrays(&a));
  std::fill_n(sums, 3, 0.0);
  for (int p : list) {
    sums[0] += a.mass[p];
    for (int d = 0; d < 2; ++d) sums[1 + d] += a.mass[p] * a.velocity[2 * p + d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Books what splitting or merging turned `before` into.
static void BookErrors(const double before[3], const double after[3], CrossingTotals &totals)
{
  totals.mass_error += std::abs(after[0] - before[0]);
  totals.momentum_error += std::abs(after[1] - before[1]) + std::abs(after[2] - before[2]);
}

PetscErrorCode Crossing::Transfer()
{
  std::vector<int> entering, leaving;
  double before[3], after[3];
  PetscFunctionBeginUser;
  PetscCall(FindEntering(&entering));
  PetscCall(FindLeaving(&leaving));
  int counts[2] = {static_cast<int>(entering.size()), static_cast<int>(leaving.size())};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT, MPI_SUM, world_));
  if (counts[0] > 0) {
    PetscCall(Sum(coarse_.PointStore(), entering, before));
    totals_.entered += static_cast<double>(entering.size());
    PetscCall(Split(&entering));
    PetscCall(Sum(coarse_.PointStore(), entering, after));
    BookErrors(before, after, totals_);
    PetscCall(Send(coarse_, fine_, entering));
  }
  if (counts[1] > 0) {
    totals_.left += static_cast<double>(leaving.size());
    PetscCall(Send(fine_, coarse_, leaving));
    if (merge_) PetscCall(MergeSiblings(world_, coarse_, numbers_, ratio_, &totals_));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Crossing::Send(Level &from, Level &to, const std::vector<int> &points)
{
  const Grid &mesh = to.Mesh();
  Departures departures{points, {}};
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(from.PointStore().Arrays(&a));
  for (int p : points)
    departures.ranks.push_back(mesh.OwnerOfNode(mesh.Nearest(0, a.position[2 * p]), mesh.Nearest(1, a.position[2 * p + 1])));
  PetscCall(MovePoints(world_, from.PointStore(), to.PointStore(), departures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Crossing::Split(std::vector<int> *entering)
{
  const int children = ratio_ * ratio_;
  const double h = fine_.Geometry().grid.spacing;
  std::vector<int> parents;
  std::vector<double> L;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(coarse_.PointStore().Arrays(&a));
  for (int p : *entering) {
    const double usual = 0.5 * h / coarse_.Physics().bodies[a.body[p]].points_per_cell;
    const double size = std::max(a.half_size[2 * p], a.half_size[2 * p + 1]);
    if (size > 0.75 * ratio_ * usual && numbers_.CanSplit(a.id[p])) parents.push_back(p);
  }
  if (parents.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(coarse_.VelocityGradients(parents, &L));
  int next = a.count;
  PetscCall(coarse_.PointStore().Resize(a.count + static_cast<int>(parents.size()) * (children - 1)));
  PetscCall(coarse_.PointStore().Arrays(&a));
  for (std::size_t k = 0; k < parents.size(); ++k) {
    for (int child = children - 1; child >= 0; --child) { // the first takes the parent's place, last
      const int target = child ? next++ : parents[k];
      if (child) entering->push_back(target);
      MakeChild(a, parents[k], target, child, &L[4 * k]);
    }
  }
  totals_.split += static_cast<double>(parents.size());
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Crossing::MakeChild(const PointArrays &a, int parent, int target, int child, const double L[4]) const
{
  const int place[2] = {child % ratio_, child / ratio_};
  const double *F = a.F + 4 * parent;
  Vec2 offset;
  for (int d = 0; d < 2; ++d) offset[d] = ((2 * place[d] + 1.0) / ratio_ - 1) * a.half_size[2 * parent + d];
  const Vec2 dx = Multiply(F, offset), dv = Multiply(L, dx);
  int faces = a.faces[parent];
  for (int s = 0; s < kSides; ++s) {
    const Side side = static_cast<Side>(s);
    if (place[AxisOf(side)] == (SignOf(side) < 0 ? 0 : ratio_ - 1)) continue;
    faces &= ~OuterFaceBit(side);
    for (std::size_t k = 0; k < coarse_.Physics().loads.size(); ++k)
      if (coarse_.Physics().loads[k].side == side) faces &= ~LoadBit(static_cast<int>(k));
  }
  a.id[target] = numbers_.Child(a.id[parent], child);
  a.mass[target] = a.mass[parent] / (ratio_ * ratio_);
  a.body[target] = a.body[parent];
  a.faces[target] = faces;
  for (int d = 0; d < 2; ++d) {
    a.position[2 * target + d] = a.position[2 * parent + d] + dx[d];
    a.velocity[2 * target + d] = a.velocity[2 * parent + d] + dv[d];
    a.half_size[2 * target + d] = a.half_size[2 * parent + d] / ratio_;
  }
  if (target == parent) return;
  std::copy_n(a.F + 4 * parent, 4, a.F + 4 * target);
  std::copy_n(a.stress + 4 * parent, 4, a.stress + 4 * target);
  std::copy_n(a.short_wave_stress + 3 * parent, 3, a.short_wave_stress + 3 * target);
  if (a.history) std::copy_n(a.history + a.history_components * parent, a.history_components, a.history + a.history_components * target);
}

} // namespace mlgimp
