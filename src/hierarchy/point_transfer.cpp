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

PetscErrorCode PointTransfer::Transfer(double dt, LevelInterface *border)
{
  const double h = fine_.Geometry().grid.spacing;
  const double fine_dt = dt / ratio_, shift = rule_.velocity_shift ? 0.5 * (dt - fine_dt) : 0;
  PetscFunctionBeginUser;
  PetscCall(SplitRing());
  std::vector<int> entering = PointsIn(coarse_.PointStore().Arrays(), WidenedBox(fine_.Geometry(), rule_.enter * h), true);
  const PointArrays coarse = coarse_.PointStore().Arrays();
  entering.erase(std::remove_if(entering.begin(), entering.end(), [&](int p) { return fine_.OwnerOf(coarse, p) < 0; }),
                 entering.end()); // beyond the finer grid, which ends the run soon: not to be split
  const std::vector<int> leaving = PointsIn(fine_.PointStore().Arrays(), WidenedBox(fine_.Geometry(), rule_.leave * h), false);
  int counts[2] = {static_cast<int>(entering.size()), static_cast<int>(leaving.size())};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT, MPI_SUM, world_));
  budgets_.points_entered += static_cast<double>(entering.size());
  budgets_.points_left += static_cast<double>(leaving.size());
  if (counts[0] > 0) {
    const std::vector<int> parents = ParentsAmong(entering);
    std::vector<VelocitySample> samples;
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
    if (rule_.merge) PetscCall(MergeSiblings(world_, coarse_, numbers_, ratio_, rule_.most_loss, &budgets_));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::SplitRing()
{
  const Box box = WidenedBox(fine_.Geometry(), rule_.ring * fine_.Geometry().grid.spacing);
  std::vector<VelocitySample> samples;
  PetscFunctionBeginUser;
  if (rule_.ring == 0) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<int> near = PointsIn(coarse_.PointStore().Arrays(), box, true);
  const std::vector<int> parents = ParentsAmong(near);
  PetscCall(coarse_.SampleVelocity(parents, &samples));
  PetscCall(Split(parents, samples, &near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointTransfer::Send(Level &from, Level &to, const std::vector<int> &points, double step, double shift)
{
  Migrants migrants;
  std::vector<VelocitySample> samples;
  PetscFunctionBeginUser;
  if (shift != 0) PetscCall(from.SampleVelocity(points, &samples));
  const PointArrays a = from.PointStore().Arrays();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int p = points[k];
    migrants.Add(p, to.OwnerOf(a, p));
    for (int d = 0; d < a.dim && shift != 0; ++d)
      a.velocity[PointArrays::At(p, a.dim) + d] += shift / step * samples[k].change[d];
  }
  Budgets sent, received;
  const int before = to.PointStore().Count();
  PetscCall(from.SumPoints(migrants.points, &sent));
  PetscCall(MovePoints(world_, from.PointStore(), to.PointStore(), migrants));
  std::vector<int> incoming(to.PointStore().Count() - before); // at the end of the storage
  std::iota(incoming.begin(), incoming.end(), before);
  PetscCall(to.SumPoints(incoming, &received));
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
