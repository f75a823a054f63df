// Boxes that move: points to the levels they belong to now, new grids, and the borders between them.
#include "hierarchy/hierarchy.hpp"
#include "hierarchy/partition/balance.hpp"
#include "hierarchy/transfer/merging.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace mlgimp
{

LevelGeometry GeometryOf(const LevelRules &rules, const Model &model, const Box &box, int k, int padding)
{
  const double h = rules.CellSize(k);
  LevelGeometry geometry;
  geometry.grid = {box.lower, h, {}, padding, rules.dim};
  for (int axis = 0; axis < rules.dim; ++axis)
    geometry.grid.cells[axis] = static_cast<int>(std::lround((box.upper[axis] - box.lower[axis]) / h));
  for (const Side side : SidesOf{rules.dim}) {
    geometry.border[side] = std::abs(box.At(side) - rules.domain.At(side)) > 1e-6 * h;
  }
  PlaceSides(model, &geometry);
  return geometry;
}

std::vector<LevelGeometry> Hierarchy::GeometriesOf(const std::vector<Box> &boxes) const
{
  std::vector<LevelGeometry> geometries;
  for (int l = 0; l < Levels(); ++l)
    geometries.push_back(GeometryOf(settings_.rules, *model_, boxes[l], l, settings_.levels[l].grid.padding));
  return geometries;
}

PetscErrorCode Hierarchy::ShareReach()
{
  double largest[2] = {follow_.half_width, follow_.reach};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, comm_));
  follow_.half_width = largest[0], follow_.reach = largest[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where the contact has been since the last check, and as much wider as the indenter is that will meet the surface until the
/// next: a flat punch touches with all of it at once. The surface around it is that of the finest level.
PetscErrorCode Hierarchy::FindContact(double time, double next_check, ContactPlace *place)
{
  const Indenter &indenter = *model_->indenter;
  Points &finest = levels_[follow_.plan.active - 1]->PointStore();
  const PointArrays a = finest.Arrays();
  double top = indenter.initial_surface;
  PetscFunctionBeginUser;
  for (int p : finest.SurfacePoints()) top = std::max(top, a.Position(p)[indenter.up]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPI_DOUBLE, MPI_MAX, comm_));
  PetscCall(ShareReach());
  const double now = indenter.Depth(tip_.At(time)), soon = indenter.Depth(tip_.At(next_check));
  const double wider = std::max(0.0, indenter.HalfWidth(soon) - indenter.HalfWidth(now));
  *place = {tip_.At(time), follow_.half_width, follow_.reach + wider, indenter.initial_surface, top};
  follow_.half_width = follow_.reach = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Splits the points that the new boxes give to finer levels, as often as their size asks; they stay where they are. The
/// velocities around them are those of their present level.
PetscErrorCode Hierarchy::SplitIntoBoxes(const std::vector<LevelGeometry> &next, int active)
{
  const int ratio = settings_.ratio;
  const Index parts{ratio, ratio, settings_.rules.dim == 3 ? ratio : 1};
  PetscFunctionBeginUser;
  for (int l = 0; l + 1 < active; ++l) {
    Level &level = *levels_[l];
    PetscCall(level.FindVelocities());
    for (int t = l + 1; t < active; ++t) {
      const double h = next[t].grid.spacing;
      Budgets &totals = transfers_[t - 1]->Totals();
      std::vector<int> points = PointsIn(level.PointStore().Arrays(), WidenedBox(next[t], kEnter * h), true);
      const std::vector<int> parents = FindParents(level, points, h, ratio, *numbers_, &totals);
      PetscCall(SplitPoints(level, {parts, *numbers_}, parents, level.SampleVelocity(parents), &points, &totals));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The finest level that a point of level l belongs to.
static int LevelOf(const std::vector<LevelGeometry> &levels, int active, Vec3 x, int l)
{
  for (int t = active - 1; t > 0; --t)
    if (WidenedBox(levels[t], (t > l ? kEnter : kLeave) * levels[t].grid.spacing).Contains(x)) return t;
  return 0;
}

/// Moves every point to the storage of its new level, on the rank where it is.
PetscErrorCode Hierarchy::SortIntoBoxes(const std::vector<LevelGeometry> &next, int active)
{
  std::vector<std::vector<Migrants>> leaving(Levels(), std::vector<Migrants>(Levels()));
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    const PointArrays a = levels_[l]->PointStore().Arrays();
    for (int p = 0; p < a.count; ++p)
      if (const int t = LevelOf(next, active, a.Position(p), l); t != l) leaving[l][t].Add(p, 0);
  }
  for (int l = 0; l < Levels(); ++l) {
    std::vector<int> gone;
    for (int t = 0; t < Levels(); ++t) {
      const Migrants &migrants = leaving[l][t];
      const double count = static_cast<double>(migrants.points.size());
      PetscCall(AppendPoints(levels_[l]->PointStore(), migrants.points, levels_[t]->PointStore()));
      gone.insert(gone.end(), migrants.points.begin(), migrants.points.end());
      for (int b = l; b < t; ++b) transfers_[b]->Totals().points_entered += count;
      for (int b = t; b < l; ++b) transfers_[b]->Totals().points_left += count;
    }
    std::sort(gone.begin(), gone.end());
    levels_[l]->PointStore().Remove(gone);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Gives a level its new grid, or sends its new points to their owners on the one it has.
PetscErrorCode Hierarchy::PlaceLevel(int l, const LevelGeometry &geometry)
{
  Level &level = *levels_[l];
  const GridGeometry &now = level.Geometry().grid;
  GridLayout layout;
  PetscFunctionBeginUser;
  if (geometry.grid.lower == now.lower && geometry.grid.cells == now.cells) {
    PetscCall(level.Migrate(true));
    PetscCall(level.Sort());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(LayoutFor(comm_, level.PointStore(), geometry.grid, settings_.points_per_rank, &layout));
  PetscCall(level.Move(geometry, layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Siblings that a box has left behind become their parents, and these theirs.
PetscErrorCode Hierarchy::MergeLeft()
{
  PetscFunctionBeginUser;
  for (int l = Levels() - 2; l >= 0 && settings_.merge_siblings; --l)
    for (int finer = Levels() - 1; finer > l; --finer)
      PetscCall(MergeSiblings(comm_, *levels_[l], *numbers_, settings_.ratio, settings_.most_loss, &transfers_[l]->Totals()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::MoveLevels(const BoxPlan &next)
{
  const std::vector<LevelGeometry> geometries = GeometriesOf(next.boxes);
  PetscFunctionBeginUser;
  PetscCall(SplitIntoBoxes(geometries, next.active));
  PetscCall(SortIntoBoxes(geometries, next.active));
  follow_.plan = next;
  settings_.levels = geometries;
  for (int l = 0; l < Levels(); ++l) {
    PetscCall(PlaceLevel(l, geometries[l]));
    if (IsActive(l))
      PetscCall(levels_[l]->Activate());
    else
      levels_[l]->Deactivate();
  }
  PetscCall(MergeLeft());
  for (auto &transfer : transfers_) transfer->InvalidateClearance();
  PetscCall(Reconnect(false));
  PetscCall(MapRanks());
  if (settings_.follow.kind == FollowKind::kContact) tip_.SetLevel(next.active - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What a border's transfers have added up beyond what they had, as a move of the finer level.
static PetscErrorCode MoveOf(MPI_Comm comm, const Budgets &before, const Budgets &now, LevelMove *move)
{
  double sums[5] = {now.points_split - before.points_split, now.points_merged - before.points_merged,
                    now.transfer_mass_error - before.transfer_mass_error,
                    now.transfer_momentum_error - before.transfer_momentum_error, now.transfer_energy - before.transfer_energy};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 5, MPI_DOUBLE, MPI_SUM, comm));
  move->split = sums[0], move->merged = sums[1];
  move->mass_error = sums[2], move->momentum_error = sums[3], move->energy = sums[4];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem)
{
  const FollowSettings &follow = settings_.follow;
  const BoxPlan now = follow_.plan;
  BoxPlan next;
  ContactPlace place;
  std::vector<Budgets> before;
  PetscFunctionBeginUser;
  if (follow.kind == FollowKind::kContact) PetscCall(FindContact(time, next_check, &place));
  if (!(follow.kind == FollowKind::kContact ? FollowContact(settings_.rules, follow, place, now, &next)
                                            : FollowPath(settings_.rules, follow, time, now, &next)))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (const int k = FindMisplaced(settings_.rules, next.boxes); k > 0) {
    *problem = "level " + std::to_string(k) + " has followed its path to where its box does not lie in level " +
               std::to_string(k - 1) + ", as deep as the borders need";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (const auto &transfer : transfers_) before.push_back(transfer->Totals());
  PetscCall(Timed(events_.balance, [&] { return MoveLevels(next); }));
  surface_.BoxesHaveMoved();
  for (int l = 1; l < Levels(); ++l) {
    LevelMove move{step, time, l, IsActive(l), next.boxes[l]};
    PetscCall(MoveOf(comm_, before[l - 1], transfers_[l - 1]->Totals(), &move));
    if (IsActive(l) || l < now.active) moves->push_back(move);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::RestoreFollowing(const FollowState &state)
{
  PetscFunctionBeginUser;
  follow_ = state;
  settings_.levels = GeometriesOf(state.plan.boxes);
  for (int l = 1; l < Levels(); ++l) PetscCall(PlaceLevel(l, settings_.levels[l]));
  PetscCall(Reconnect(false));
  if (settings_.follow.kind == FollowKind::kContact) tip_.SetLevel(state.plan.active - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
