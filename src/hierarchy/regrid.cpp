// Boxes that move: points to the levels they belong to now, new grids, and the borders between them.
#include "hierarchy/regrid.hpp"

#include "base/text.hpp"
#include "hierarchy/partition/balance.hpp"
#include "hierarchy/transfer/merging.hpp"
#include "level/samples.hpp"

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

std::vector<LevelGeometry> Regrid::GeometriesOf(const std::vector<Box> &boxes) const
{
  std::vector<LevelGeometry> geometries;
  for (int l = 0; l < levels_.Count(); ++l)
    geometries.push_back(GeometryOf(levels_.Settings().rules, *model_, boxes[l], l, levels_.Settings().levels[l].grid.padding));
  return geometries;
}

void Regrid::Widen(const TipReport &contact)
{
  state_.half_width = std::max(state_.half_width, contact.half_width);
  state_.reach = std::max(state_.reach, contact.reach);
}

PetscErrorCode Regrid::ShareReach()
{
  double largest[2] = {state_.half_width, state_.reach};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, levels_.Comm()));
  state_.half_width = largest[0], state_.reach = largest[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where the contact has been since the last check, and as much wider as the indenter is that will meet the surface until the
/// next: a flat punch touches with all of it at once. The surface around it is that of the finest level.
PetscErrorCode Regrid::FindContact(double time, double next_check, ContactPlace *place)
{
  const Indenter &indenter = *model_->indenter;
  Points &finest = levels_.At(state_.plan.active - 1).PointStore();
  const PointArrays a = finest.Arrays();
  double top = indenter.initial_surface;
  PetscFunctionBeginUser;
  for (int p : finest.SurfacePoints()) top = std::max(top, a.Position(p)[indenter.up]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPI_DOUBLE, MPI_MAX, levels_.Comm()));
  PetscCall(ShareReach());
  const double now = indenter.Depth(tip_.At(time)), soon = indenter.Depth(tip_.At(next_check));
  const double wider = std::max(0.0, indenter.HalfWidth(soon) - indenter.HalfWidth(now));
  *place = {tip_.At(time), state_.half_width, state_.reach + wider, indenter.initial_surface, top};
  state_.half_width = state_.reach = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Splits the points that the new boxes give to finer levels, as often as their size asks; they stay where they are. The
/// velocities around them are those of their present level.
PetscErrorCode Regrid::SplitIntoBoxes(const std::vector<LevelGeometry> &next, int active)
{
  const int ratio = levels_.Settings().ratio;
  const Index parts{ratio, ratio, levels_.Settings().rules.dim == 3 ? ratio : 1};
  PetscFunctionBeginUser;
  for (int l = 0; l + 1 < active; ++l) {
    Level &level = levels_.At(l);
    PetscCall(FindVelocities(level));
    for (int t = l + 1; t < active; ++t) {
      const double h = next[t].grid.spacing;
      Budgets &totals = levels_.Transfer(t - 1).Totals();
      std::vector<int> points = PointsIn(level.PointStore().Arrays(), WidenedBox(next[t], kEnter * h), true);
      const std::vector<int> parents = FindParents(level, points, h, ratio, levels_.Numbers(), &totals);
      PetscCall(SplitPoints(level, {parts, levels_.Numbers()}, parents, SampleVelocity(level, parents), &points, &totals));
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
PetscErrorCode Regrid::SortIntoBoxes(const std::vector<LevelGeometry> &next, int active)
{
  std::vector<std::vector<Migrants>> leaving(levels_.Count(), std::vector<Migrants>(levels_.Count()));
  PetscFunctionBeginUser;
  for (int l = 0; l < levels_.Count(); ++l) {
    const PointArrays a = levels_.At(l).PointStore().Arrays();
    for (int p = 0; p < a.count; ++p)
      if (const int t = LevelOf(next, active, a.Position(p), l); t != l) leaving[l][t].Add(p, 0);
  }
  for (int l = 0; l < levels_.Count(); ++l) {
    std::vector<int> gone;
    for (int t = 0; t < levels_.Count(); ++t) {
      const Migrants &migrants = leaving[l][t];
      const double count = static_cast<double>(migrants.points.size());
      PetscCall(AppendPoints(levels_.At(l).PointStore(), migrants.points, levels_.At(t).PointStore()));
      gone.insert(gone.end(), migrants.points.begin(), migrants.points.end());
      for (int b = l; b < t; ++b) levels_.Transfer(b).Totals().points_entered += count;
      for (int b = t; b < l; ++b) levels_.Transfer(b).Totals().points_left += count;
    }
    std::sort(gone.begin(), gone.end());
    levels_.At(l).PointStore().Remove(gone);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Gives a level its new grid, or sends its new points to their owners on the one it has.
PetscErrorCode Regrid::PlaceLevel(int l, const LevelGeometry &geometry)
{
  Level &level = levels_.At(l);
  const GridGeometry &now = level.Geometry().grid;
  GridLayout layout;
  PetscFunctionBeginUser;
  if (geometry.grid.lower == now.lower && geometry.grid.cells == now.cells) {
    PetscCall(level.Stores().Migrate(true));
    PetscCall(level.Stores().Sort());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(LayoutFor(levels_.Comm(), level.PointStore(), geometry.grid, levels_.Settings().points_per_rank, &layout));
  PetscCall(level.Move(geometry, layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Siblings that a box has left behind become their parents, and these theirs.
PetscErrorCode Regrid::MergeLeft()
{
  PetscFunctionBeginUser;
  for (int l = levels_.Count() - 2; l >= 0 && levels_.Settings().merge_siblings; --l)
    for (int finer = levels_.Count() - 1; finer > l; --finer)
      PetscCall(MergeSiblings(levels_.Comm(), levels_.At(l), levels_.Numbers(), levels_.Settings().ratio,
                              levels_.Settings().most_loss, &levels_.Transfer(l).Totals()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Regrid::MoveLevels(const BoxPlan &next)
{
  const std::vector<LevelGeometry> geometries = GeometriesOf(next.boxes);
  PetscFunctionBeginUser;
  PetscCall(SplitIntoBoxes(geometries, next.active));
  PetscCall(SortIntoBoxes(geometries, next.active));
  state_.plan = next;
  levels_.SetBoxes(geometries, next.active);
  for (int l = 0; l < levels_.Count(); ++l) {
    PetscCall(PlaceLevel(l, geometries[l]));
    PetscCall(levels_.At(l).SetActive(IsActive(l)));
  }
  PetscCall(MergeLeft());
  for (int b = 0; b + 1 < levels_.Count(); ++b) levels_.Transfer(b).InvalidateClearance();
  PetscCall(levels_.Reconnect(false));
  PetscCall(levels_.MapRanks());
  if (FollowsContact()) tip_.SetLevel(next.active - 1);
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

PetscErrorCode Regrid::Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem,
                              bool *moved)
{
  const FollowSettings &follow = levels_.Settings().follow;
  const BoxPlan now = state_.plan;
  BoxPlan next;
  ContactPlace place;
  std::vector<Budgets> before;
  PetscFunctionBeginUser;
  *moved = false;
  if (FollowsContact()) PetscCall(FindContact(time, next_check, &place));
  if (!(FollowsContact() ? FollowContact(levels_.Settings().rules, follow, place, now, &next)
                         : FollowPath(levels_.Settings().rules, follow, time, now, &next)))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (const int k = FindMisplaced(levels_.Settings().rules, next.boxes); k > 0) {
    *problem =
        Format("level {} has followed its path to where its box does not lie in level {}, as deep as the borders need", k, k - 1);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int b = 0; b + 1 < levels_.Count(); ++b) before.push_back(levels_.Transfer(b).Totals());
  PetscCall(Timed(levels_.Events().balance, [&] { return MoveLevels(next); }));
  *moved = true;
  for (int l = 1; l < levels_.Count(); ++l) {
    LevelMove move{step, time, l, IsActive(l), next.boxes[l]};
    PetscCall(MoveOf(levels_.Comm(), before[l - 1], levels_.Transfer(l - 1).Totals(), &move));
    if (IsActive(l) || l < now.active) moves->push_back(move);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Regrid::Restore(const FollowState &state)
{
  PetscFunctionBeginUser;
  state_ = state;
  levels_.SetBoxes(GeometriesOf(state.plan.boxes), state.plan.active);
  for (int l = 1; l < levels_.Count(); ++l) PetscCall(PlaceLevel(l, levels_.Settings().levels[l]));
  PetscCall(levels_.Reconnect(false));
  if (FollowsContact()) tip_.SetLevel(state.plan.active - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
