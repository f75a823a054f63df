// Recursion over levels, and what is due between steps of level 0.
#include "hierarchy/hierarchy.hpp"

#include "level/flow.hpp"
#include "level/samples.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace mlgimp
{

static constexpr int kSplitInterval = 16; ///< steps of a level between two checks for points that are drawn out

/// The points of each level, whose numbers follow those of the level before.
static std::vector<Seeding> SeedLevels(const Model &model, const HierarchySettings &settings)
{
  const auto level_at = [levels = settings.levels, follows = settings.follow.kind != FollowKind::kNone](Vec3 x) {
    int l = follows ? 0 : static_cast<int>(levels.size()) - 1; // points that boxes leave behind need a parent to become again
    while (l > 0 && !WidenedBox(levels[l], 0).Contains(x)) --l;
    return l;
  };
  SeedingLevels places = {{}, level_at, settings.ratio};
  std::vector<Seeding> seedings;
  for (const LevelGeometry &level : settings.levels) places.grids.push_back(level.grid);
  for (int l = 0; l < static_cast<int>(settings.levels.size()); ++l)
    seedings.emplace_back(model, places, l, settings.levels[l].sides, l > 0 ? seedings.back().EndId() : 0);
  return seedings;
}

PetscErrorCode Hierarchy::Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings, const LogEvents &events,
                                 bool fill)
{
  const std::vector<Seeding> seedings = SeedLevels(model, settings);
  std::vector<Level *> levels;
  PetscFunctionBeginUser;
  model_ = &model;
  PetscCall(levels_.Create(comm, model, settings, events, seedings));
  tip_.Create(model.indenter ? &*model.indenter : nullptr, settings.tip_level, Levels());
  regrid_.Begin(model);
  for (int l = 0; l < Levels(); ++l) {
    PetscCall(RegisterLevelStage(l, &stages_.emplace_back()));
    levels.push_back(&At(l));
  }
  surface_.Create(comm, levels, settings.ratio);
  if (settings.coupling == LevelCoupling::kPoints) {
    copies_.emplace(comm, settings.ratio, settings.repairs);
    for (int b = 0; b + 1 < Levels(); ++b) PetscCall(copies_->Add(At(b), At(b + 1), settings.ghost_cells));
  }
  if (!fill) PetscFunctionReturn(PETSC_SUCCESS);
  for (int l = 0; l < Levels(); ++l) PetscCall(seedings[l].Fill(At(l).Mesh().Nodes(), At(l).PointStore()));
  for (int b = 0; b + 1 < Levels(); ++b) PetscCall(levels_.Transfer(b).Transfer(1, nullptr));
  for (int l = 0; l < Levels() && Levels() > 1; ++l) PetscCall(levels_.Rebalance(l)); // for the points that have just crossed
  for (int l = 0; l < Levels(); ++l) PetscCall(At(l).Stores().Sort());                // seeds come row by row
  if (model.indenter) PetscCall(surface_.Seed(seedings, tip_.At(0)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::View(double time)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) PetscCall(levels_.At(l).View("level_" + std::to_string(l) + "_", time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Advance(TimeStep step)
{
  PetscFunctionBeginUser;
  if (model_->indenter) PetscCall(surface_.Watch(regrid_.Active(), levels_.OwnerChanges()));
  if (levels_.Settings().coupling == LevelCoupling::kNodes || Levels() == 1)
    PetscCall(AdvanceLevel(0, step, 0));
  else
    PetscCall(AdvanceLevelWithCopies(0, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::AdvanceLevel(int l, TimeStep step, int substep)
{
  const StageScope stage(stages_[l]);
  const int ratio = levels_.Settings().ratio;
  const Vec3 tip = tip_.At(step.time);
  Level &level = levels_.At(l);
  LevelInterface *const coarser = levels_.Coarser(l), *const finer = levels_.Finer(l);
  PetscFunctionBeginUser;
  PetscCall(level.GatherForces(step));
  PetscCall(level.UpdateNodes(step.dt));
  if (coarser) PetscCall(coarser->Advance(substep, step.dt));
  if (finer) {
    PetscCall(finer->CoarseToFine());
    for (int k = 0; k < ratio; ++k) PetscCall(AdvanceLevel(l + 1, step.Part(k, ratio), k));
    PetscCall(finer->FineToCoarse());
  }
  PetscCall(level.FinishNodes(step, tip_.Step(l, tip, step)));
  if (finer) PetscCall(finer->TakeContact());
  PetscCall(RecordTip(l, step));
  PetscCall(level.AdvancePoints(step.dt));
  if (finer) PetscCall(levels_.Transfer(l).Transfer(step.dt, finer));
  PetscCall(RefineStretched(l, step.End()));
  PetscCall(level.EndStep());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Takes up what contact did to the tip in a step of level l, and how wide it was.
PetscErrorCode Hierarchy::RecordTip(int l, TimeStep step)
{
  PetscFunctionBeginUser;
  PetscCall(tip_.Follow(Comm(), l, levels_.At(l).Contact(), step));
  regrid_.Widen(levels_.At(l).Contact().Tip());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Every kSplitInterval steps of level l: splits points of metal that are drawn out, and halves patches of the surface.
PetscErrorCode Hierarchy::RefineStretched(int l, double time)
{
  Level &level = levels_.At(l);
  PetscFunctionBeginUser;
  if ((level.Step().taken + 1) % kSplitInterval != 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (model_->SplitsStretched()) {
    StraightenBoxes(*model_, level.PointStore().Arrays());
    if (level.Contact().IsActive()) ExposePoints(*model_, level.Geometry(), level.PointStore(), tip_.At(time));
    PetscCall(Timed(levels_.Events().transfer, [&] { return SplitStretched(Comm(), level, levels_.Numbers()); }));
    for (int b = 0; b + 1 < Levels(); ++b) levels_.Transfer(b).InvalidateClearance();
    level.Contact().InvalidateClearance();
  }
  if (model_->indenter) surface_.Split(l, tip_.At(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same for levels that are coupled by copies of points.
PetscErrorCode Hierarchy::AdvanceLevelWithCopies(int l, TimeStep step)
{
  const StageScope stage(stages_[l]);
  Level &level = levels_.At(l);
  PetscFunctionBeginUser;
  if (l == 0) PetscCall(copies_->Begin(step.dt));
  PetscCall(level.GatherForces(step));
  PetscCall(level.UpdateNodes(step.dt));
  PetscCall(level.FinishNodes(step, tip_.Step(l, tip_.At(step.time), step)));
  PetscCall(level.AdvancePoints(step.dt));
  PetscCall(level.EndStep());
  if (l + 1 < Levels()) {
    for (int k = 0; k < levels_.Settings().ratio; ++k)
      PetscCall(AdvanceLevelWithCopies(l + 1, step.Part(k, levels_.Settings().ratio)));
    PetscCall(copies_->DecideByPlace(l));
    PetscCall(levels_.Transfer(l).Transfer(step.dt, nullptr));
    PetscCall(copies_->Exchange(l, step.dt));
  }
  if (l == 0) PetscCall(copies_->Finish());
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Hierarchy::MeasureNoise(bool measures)
{
  for (int l = 0; l < Levels(); ++l) At(l).Step().measures_noise = measures;
}

PetscErrorCode Hierarchy::Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem)
{
  bool moved = false;
  PetscFunctionBeginUser;
  PetscCall(regrid_.Follow(step, time, next_check, moves, problem, &moved));
  if (moved) surface_.BoxesHaveMoved();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::CheckSpeeds(SpeedCheck *speeds)
{
  double values[3] = {}; // largest of all ranks
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    Level &level = At(l);
    double wave = 0, point = 0;
    FindLargestSpeeds(level, &wave, &point);
    values[0] = std::max(values[0], wave);
    values[1] = std::max(values[1], point);
    if (level.Step().failure.kind != LevelFailure::kNone) values[2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 3, MPI_DOUBLE, MPI_MAX, Comm()));
  *speeds = {values[0], values[1], values[2] > 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The nodes of level l that points in a box may touch until they are checked again, with half their size and as much more, and
/// those of the next coarser level that these hang on.
static IndexBox ZoneOf(const HierarchySettings &settings, int l, const Box &near, double drift)
{
  const GridGeometry &grid = settings.levels[l].grid;
  const double room = drift + (2 + (l > 0 ? settings.ratio : 0)) * grid.spacing;
  IndexBox zone = grid.NodeBox();
  for (int axis = 0; axis < grid.dim; ++axis) {
    const double first = zone.lower[axis], end = zone.upper[axis];
    const double lower = (near.lower[axis] - room - grid.lower[axis]) / grid.spacing,
                 upper = (near.upper[axis] + room - grid.lower[axis]) / grid.spacing;
    zone.lower[axis] = static_cast<int>(std::clamp(std::floor(lower), first, end - 1));
    zone.upper[axis] = static_cast<int>(std::clamp(std::ceil(upper) + 1, first + 1, end));
  }
  return zone;
}

/// Widens boxes to those of all ranks; a rank's box may hold nothing.
static PetscErrorCode UniteBoxes(MPI_Comm comm, std::vector<Box> *boxes)
{
  static_assert(sizeof(Box) == 6 * sizeof(double));
  const auto negate_lower = [&] {
    for (Box &box : *boxes) box.lower = -1.0 * box.lower;
  };
  PetscFunctionBeginUser;
  negate_lower();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, boxes->data(), static_cast<int>(6 * boxes->size()), MPI_DOUBLE, MPI_MAX, comm));
  negate_lower();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Activates contact on the levels whose points the indenter can press on, and gives each level the zone that contact may touch.
/// Points of neighbouring levels may become its own.
PetscErrorCode Hierarchy::WatchContact(double time, double travel, double drift)
{
  constexpr Box kNowhere{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  std::vector<Box> near(Levels(), kNowhere), touching(Levels(), kNowhere);
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    const double h = levels_.Settings().levels[l].grid.spacing, room = travel + drift;
    FindNearIndenter(At(l), tip_.At(time), TouchRange(model_->contact) * h + room, &touching[l]);
    for (int other = std::max(l - 1, 0); other < std::min(l + 2, Levels()); ++other)
      FindNearIndenter(At(other), tip_.At(time), kPointRange * h + room, &near[l]);
  }
  PetscCall(UniteBoxes(Comm(), &near));
  PetscCall(UniteBoxes(Comm(), &touching));
  for (int l = 0; l < Levels(); ++l) {
    const bool within_reach = touching[l].lower[0] < HUGE_VAL;
    const IndexBox zone = within_reach ? ZoneOf(levels_.Settings(), l, near[l], drift) : IndexBox{};
    PetscCall(At(l).Contact().Watch(Comm(), At(l).Mesh(), within_reach, zone));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Adapt(const SpeedCheck &speeds, double time, double dt, int steps)
{
  constexpr double kSafety = 2, kSurprise = 0.02; // of speeds; cells a step, where a body at rest is set in motion
  const double drift = steps * std::max(kSafety * speeds.point_speed * dt, kSurprise * levels_.Settings().levels[0].grid.spacing);
  PetscFunctionBeginUser;
  if (model_->indenter) PetscCall(WatchContact(time, tip_.Reach(time, dt, steps), drift));
  PetscCall(levels_.Balance());
  for (int l = 0; l < Levels(); ++l)
    levels_.At(l).Stores().BoundDrift(speeds.point_speed, dt / std::pow(levels_.Settings().ratio, l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
