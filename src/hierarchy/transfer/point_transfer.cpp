// Moving points between levels, splitting and merging.
#include "hierarchy/transfer/point_transfer.hpp"

#include "hierarchy/transfer/merging.hpp"
#include "level/samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

Box WidenedBox(const LevelGeometry &geometry, double distance)
{
  Box box = kEverywhere;
  for (int axis = 0; axis < geometry.grid.dim; ++axis) {
    const double lower = geometry.grid.lower[axis], upper = lower + geometry.grid.cells[axis] * geometry.grid.spacing;
    box.lower[axis] = geometry.border[2 * axis] ? lower - distance : -HUGE_VAL;
    box.upper[axis] = geometry.border[2 * axis + 1] ? upper + distance : HUGE_VAL;
  }
  return box;
}

std::vector<int> PointsIn(const PointArrays &a, const Box &box, bool inside)
{
  std::vector<int> points;
  for (int first = 0; first < a.count; first += kBlock) { // in most blocks there are none
    const int count = std::min(kBlock, a.count - first);
    const double *const x = a.position + PointArrays::At(first, a.dim);
    const auto selected = [=, third = a.dim - 1](int p) {
      const double *const at = x + (third + 1) * p;
      return box.Contains({at[0], at[1], third == 2 ? at[third] : 0}) == inside;
    };
    double found = 0;
#pragma omp simd reduction(+ : found)
    for (int p = 0; p < count; ++p) found += selected(p) ? 1.0 : 0.0;
    for (int p = 0; found > 0 && p < count; ++p)
      if (selected(p)) points.push_back(first + p);
  }
  return points;
}

double MinDistance(const PointArrays &a, const Box &box, bool inside)
{
  const double sign = inside ? 1 : -1;
  double way = HUGE_VAL;
  for (int p = 0; p < a.count; ++p) {
    const Vec3 x = a.Position(p);
    double depth = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) depth = std::min({depth, x[axis] - box.lower[axis], box.upper[axis] - x[axis]});
    way = std::min(way, sign * depth);
  }
  return way;
}

/// How far the points of all ranks are from entering and from leaving the finer level.
PetscErrorCode PointTransfer::FindClearance(double clearance[2])
{
  PetscFunctionBeginUser;
  clearance[0] = MinDistance(coarse_.PointStore().Arrays(), BoxAt(rule_.enter), false);
  clearance[1] = MinDistance(fine_.PointStore().Arrays(), BoxAt(rule_.leave), true);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, clearance, 2, MPI_DOUBLE, MPI_MIN, world_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::Transfer(double dt, LevelInterface *border)
{
  const LogScope log(fine_.Parts().events.transfer);
  const double fine_dt = dt / ratio_, shift = rule_.velocity_shift ? 0.5 * (dt - fine_dt) : 0;
  double clearance[2];
  PetscFunctionBeginUser;
  PetscCall(SplitRing());
  clearance_ -= coarse_.Stores().Drift().per_step * coarse_.Geometry().grid.spacing;
  if (clearance_ > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindClearance(clearance));
  // Points that reach one of the two levels across another border are more than a cell away from this one.
  clearance_ = border ? std::min({clearance[0], clearance[1], fine_.Geometry().grid.spacing}) : 0;
  if (clearance_ <= 0) coarse_.Contact().InvalidateClearance(), fine_.Contact().InvalidateClearance();
  const std::vector<int> leaving = PointsIn(fine_.PointStore().Arrays(), BoxAt(rule_.leave), false);
  if (clearance[0] <= 0) PetscCall(Enter(PointsIn(coarse_.PointStore().Arrays(), BoxAt(rule_.enter), true), dt, shift, border));
  if (clearance[1] <= 0) {
    budgets_.points_left += static_cast<double>(leaving.size());
    if (border) {
      PetscCall(GatherForcesOf(fine_, leaving, 1));
      PetscCall(border->ShiftForces(true));
    }
    PetscCall(Send(fine_, coarse_, leaving, fine_dt, -shift));
    if (rule_.merge) PetscCall(MergeSiblings(world_, coarse_, numbers_, ratio_, rule_.most_loss, &budgets_));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Splits those of the points that are of coarse size, and sends all to the finer level.
PetscErrorCode PointTransfer::Enter(std::vector<int> points, double dt, double shift, LevelInterface *border)
{
  const PointArrays coarse = coarse_.PointStore().Arrays();
  PetscFunctionBeginUser;
  points.erase(std::remove_if(points.begin(), points.end(), [&](int p) { return fine_.Stores().OwnerOf(coarse, p) < 0; }),
               points.end()); // beyond the finer grid, which ends the run soon: not to be split
  budgets_.points_entered += static_cast<double>(points.size());
  const std::vector<int> parents = ParentsAmong(points);
  // Before the nodal sums are used for the forces.
  const std::vector<VelocitySample> samples = SampleVelocity(coarse_, parents);
  if (border) {
    PetscCall(GatherForcesOf(coarse_, points, -1));
    PetscCall(border->ShiftForces(false));
  }
  PetscCall(Split(parents, samples, &points));
  PetscCall(Send(coarse_, fine_, points, dt, shift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::SplitRing()
{
  const Box box = BoxAt(rule_.ring);
  PetscFunctionBeginUser;
  if (rule_.ring == 0) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<int> near = PointsIn(coarse_.PointStore().Arrays(), box, true);
  const std::vector<int> parents = ParentsAmong(near);
  PetscCall(Split(parents, SampleVelocity(coarse_, parents), &near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::Send(Level &from, Level &to, const std::vector<int> &points, double step, double shift)
{
  Migrants migrants;
  std::vector<VelocitySample> samples;
  PetscFunctionBeginUser;
  if (shift != 0) samples = SampleVelocity(from, points);
  const PointArrays a = from.PointStore().Arrays();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int p = points[k];
    migrants.Add(p, to.Stores().OwnerOf(a, p));
    for (int d = 0; d < a.dim && shift != 0; ++d)
      a.velocity[PointArrays::At(p, a.dim) + d] += shift / step * samples[k].change[d];
  }
  const int before = to.PointStore().Count();
  const Budgets sent = SumPoints(from, migrants.points);
  PetscCall(MovePoints(world_, from.PointStore(), to.PointStore(), migrants));
  std::vector<int> incoming(to.PointStore().Count() - before); // at the end of the storage
  std::iota(incoming.begin(), incoming.end(), before);
  const Budgets received = SumPoints(to, incoming);
  budgets_.points_adrift += static_cast<double>(migrants.points.size()) - static_cast<double>(incoming.size());
  budgets_.mass_adrift += sent.mass - received.mass;
  budgets_.momentum_adrift += sent.momentum - received.momentum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Splits the parents among some points of the coarser level, and adds the children to the points.
PetscErrorCode PointTransfer::Split(const std::vector<int> &parents, const std::vector<VelocitySample> &samples,
                                    std::vector<int> *points)
{
  const Index parts{ratio_, ratio_, coarse_.Geometry().grid.dim == 3 ? ratio_ : 1};
  PetscFunctionBeginUser;
  PetscCall(SplitPoints(coarse_, {parts, numbers_}, parents, samples, points, &budgets_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
