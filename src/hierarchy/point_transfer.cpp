// Moving points between levels, splitting and merging.
#include "hierarchy/point_transfer.hpp"

#include "hierarchy/merging.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

Box WidenedBox(const LevelGeometry &geometry, double distance)
{
  Box box;
  for (int axis = 0; axis < 2; ++axis) {
    const double lower = geometry.grid.lower[axis], upper = lower + geometry.grid.cells[axis] * geometry.grid.spacing;
    box.lower[axis] = geometry.border[2 * axis] ? lower - distance : -HUGE_VAL;
    box.upper[axis] = geometry.border[2 * axis + 1] ? upper + distance : HUGE_VAL;
  }
  return box;
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

int PointNumbers::ChildIndex(std::int64_t id) const { return static_cast<int>((id - RangeOf(id).start) % children_); }

/// The points of a level inside or outside a box; in most blocks there are none.
PetscErrorCode PointTransfer::Select(Level &level, const Box &box, bool inside, std::vector<int> *points)
{
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(level.PointStore().Arrays(&a));
  for (int first = 0; first < a.count; first += kBlock) {
    const int count = std::min(kBlock, a.count - first);
    const double *const x = a.position + 2 * static_cast<std::ptrdiff_t>(first);
    const auto selected = [=](int p) { return box.Contains({x[2 * p], x[2 * p + 1]}) == inside; };
    double found = 0;
#pragma omp simd reduction(+ : found)
    for (int p = 0; p < count; ++p) found += selected(p) ? 1.0 : 0.0;
    for (int p = 0; found > 0 && p < count; ++p)
      if (selected(p)) points->push_back(first + p);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void AddChange(const PointSums &before, const PointSums &after, PointTransferTotals *totals)
{
  totals->mass_error += std::abs(after.mass - before.mass);
  for (int d = 0; d < 2; ++d) totals->momentum_error += std::abs(after.momentum[d] - before.momentum[d]);
  const double strain = after.strain_energy - before.strain_energy;
  totals->energy += after.kinetic_energy - before.kinetic_energy + strain;
  totals->strain_energy += strain;
}

PetscErrorCode PointTransfer::Transfer(double dt, LevelInterface *border)
{
  const double h = fine_.Geometry().grid.spacing;
  const double fine_dt = dt / ratio_, shift = rule_.velocity_shift ? 0.5 * (dt - fine_dt) : 0;
  std::vector<int> entering, leaving;
  PetscFunctionBeginUser;
  PetscCall(SplitRing());
  PetscCall(Select(coarse_, WidenedBox(fine_.Geometry(), rule_.enter * h), true, &entering));
  PetscCall(Select(fine_, WidenedBox(fine_.Geometry(), rule_.leave * h), false, &leaving));
  int counts[2] = {static_cast<int>(entering.size()), static_cast<int>(leaving.size())};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT, MPI_SUM, world_));
  totals_.entered += static_cast<double>(entering.size());
  totals_.left += static_cast<double>(leaving.size());
  if (counts[0] > 0) {
    std::vector<int> parents;
    std::vector<Level::VelocitySample> samples;
    PetscCall(FindParents(entering, &parents));
    PetscCall(coarse_.SampleVelocity(parents, &samples)); // before the nodal sums are used for the forces
    if (border) {
      PetscCall(coarse_.GatherForcesOf(entering, -1));
      PetscCall(border->ShiftForces(false));
    }
    PetscCall(Split(parents, samples, &entering));
    PetscCall(Send(coarse_, fine_, entering, dt, shift));
  }
  if (counts[1] > 0) {
    if (border) {
      PetscCall(fine_.GatherForcesOf(leaving, 1));
      PetscCall(border->ShiftForces(true));
    }
    PetscCall(Send(fine_, coarse_, leaving, fine_dt, -shift));
    if (rule_.merge) PetscCall(MergeSiblings(world_, coarse_, numbers_, ratio_, &totals_));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::SplitRing()
{
  std::vector<int> near, parents;
  std::vector<Level::VelocitySample> samples;
  PetscFunctionBeginUser;
  if (rule_.ring == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Select(coarse_, WidenedBox(fine_.Geometry(), rule_.ring * fine_.Geometry().grid.spacing), true, &near));
  PetscCall(FindParents(near, &parents));
  PetscCall(coarse_.SampleVelocity(parents, &samples));
  PetscCall(Split(parents, samples, &near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::Send(Level &from, Level &to, const std::vector<int> &points, double step, double shift)
{
  Migrants migrants;
  std::vector<Level::VelocitySample> samples;
  PointArrays a;
  PetscFunctionBeginUser;
  if (shift != 0) PetscCall(from.SampleVelocity(points, &samples));
  PetscCall(from.PointStore().Arrays(&a));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int p = points[k];
    migrants.Add(p, to.OwnerOf(a, p));
    for (int d = 0; d < 2 && shift != 0; ++d) a.velocity[2 * p + d] += shift / step * samples[k].change[d];
  }
  PointSums sent, received;
  const int before = to.PointStore().Count();
  PetscCall(from.SumPoints(migrants.points, &sent));
  PetscCall(MovePoints(world_, from.PointStore(), to.PointStore(), migrants));
  std::vector<int> incoming(to.PointStore().Count() - before); // at the end of the storage
  std::iota(incoming.begin(), incoming.end(), before);
  PetscCall(to.SumPoints(incoming, &received));
  totals_.points_adrift += static_cast<double>(migrants.points.size()) - static_cast<double>(incoming.size());
  totals_.mass_adrift += sent.mass - received.mass;
  for (int d = 0; d < 2; ++d) totals_.momentum_adrift[d] += sent.momentum[d] - received.momentum[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Those of some points of the coarser level that are of its size.
PetscErrorCode PointTransfer::FindParents(const std::vector<int> &points, std::vector<int> *parents)
{
  const double h = fine_.Geometry().grid.spacing;
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(coarse_.PointStore().Arrays(&a));
  for (int p : points) {
    const double usual = 0.5 * h / coarse_.Physics().bodies[a.body[p]].points_per_cell;
    const double size = std::max(a.half_size[2 * p], a.half_size[2 * p + 1]);
    if (size <= 0.75 * ratio_ * usual) continue;
    if (numbers_.CanSplit(a.id[p]))
      parents->push_back(p);
    else
      ++totals_.unsplit;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Splits the parents among some points of the coarser level, and adds the children to the points.
PetscErrorCode PointTransfer::Split(const std::vector<int> &parents, const std::vector<Level::VelocitySample> &samples,
                                    std::vector<int> *points)
{
  const int children = ratio_ * ratio_;
  PointSums before, after;
  PointArrays a;
  PetscFunctionBeginUser;
  if (parents.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(coarse_.SumPoints(*points, &before));
  int next = coarse_.PointStore().Count();
  PetscCall(coarse_.PointStore().Resize(next + static_cast<int>(parents.size()) * (children - 1)));
  PetscCall(coarse_.PointStore().Arrays(&a));
  for (std::size_t k = 0; k < parents.size(); ++k)
    for (int child = children - 1; child >= 0; --child) { // the first takes the parent's place, last
      const int target = child ? next++ : parents[k];
      if (child) points->push_back(target);
      MakeChild(a, parents[k], target, child, samples[k].L);
    }
  PetscCall(coarse_.SumPoints(*points, &after));
  AddChange(before, after, &totals_);
  totals_.split += static_cast<double>(parents.size());
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PointTransfer::MakeChild(const PointArrays &a, int parent, int target, int child, const double L[4]) const
{
  const int place[2] = {child % ratio_, child / ratio_};
  const double *F = a.F + 4 * parent;
  Vec3 offset;
  for (int d = 0; d < 2; ++d) offset[d] = ((2 * place[d] + 1.0) / ratio_ - 1) * a.half_size[2 * parent + d];
  const Vec3 dx = Multiply(F, offset), dv = Multiply(L, dx);
  int faces = a.faces[parent];
  for (int s = 0; s < kSides; ++s) {
    const Side side = static_cast<Side>(s);
    if (place[AxisOf(side)] == (SignOf(side) < 0 ? 0 : ratio_ - 1)) continue;
    faces &= ~OuterFaceBit(side);
  }
  for (int k = 0; k < a.loads; ++k) {
    const bool at_load = faces & OuterFaceBit(coarse_.Physics().loads[k].side);
    a.load_share[a.loads * target + k] = at_load ? a.load_share[a.loads * parent + k] : 0;
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
  if (a.history)
    std::copy_n(a.history + a.history_components * parent, a.history_components, a.history + a.history_components * target);
}

} // namespace mlgimp
