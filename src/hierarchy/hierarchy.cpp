// Recursion over levels, reductions over ranks, and balance.
#include "hierarchy/hierarchy.hpp"

#include "level/flow.hpp"

#include "hierarchy/partition/balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace mlgimp
{

static constexpr int kSplitInterval = 16; ///< steps of a level between two checks for points that are drawn out

PetscErrorCode Hierarchy::Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings, const LogEvents &events,
                                 bool fill)
{
  std::int64_t first_id = 0;
  std::vector<Seeding> seedings;
  const auto level_at = [levels = settings.levels, follows = settings.follow.kind != FollowKind::kNone](Vec3 x) {
    int l = follows ? 0 : static_cast<int>(levels.size()) - 1; // points that boxes leave behind need a parent to become again
    while (l > 0 && !WidenedBox(levels[l], 0).Contains(x)) --l;
    return l;
  };
  SeedingLevels places = {{}, level_at, settings.ratio};
  for (const LevelGeometry &level : settings.levels) places.grids.push_back(level.grid);
  PetscFunctionBeginUser;
  comm_ = comm;
  model_ = &model;
  settings_ = settings;
  events_ = events;
  levels_.resize(settings.levels.size());
  follow_.plan = {settings.follow.start, Levels()};
  tip_.Create(model.indenter ? &*model.indenter : nullptr, settings.tip_level, Levels());
  for (int l = 0; l < Levels(); ++l) {
    seedings.emplace_back(model, places, l, settings.levels[l].sides, first_id);
    first_id = seedings.back().EndId();
    PetscCall(RegisterLevelStage(l, &stages_.emplace_back()));
    PetscCall(CreateLevel(l, seedings.back()));
  }
  std::vector<Level *> levels;
  for (auto &level : levels_) levels.push_back(level.get());
  surface_.Create(comm, levels, settings.ratio);
  std::vector<int> groups(model.bodies.size());
  std::iota(groups.begin(), groups.end(), 0);
  for (const Seeding &seeding : seedings) PetscCall(seeding.JoinTouching(comm, &groups));
  for (auto &level : levels_) level->SetBodyGroups(groups);
  PetscCall(CreateInterfaces(first_id));
  PetscCall(MapRanks());
  for (int l = 0; l < Levels(); ++l) CoupleNodes(l);
  if (!fill) PetscFunctionReturn(PETSC_SUCCESS);
  for (int l = 0; l < Levels(); ++l) PetscCall(seedings[l].Fill(levels_[l]->Mesh(), levels_[l]->PointStore()));
  for (auto &transfer : transfers_) PetscCall(transfer->Transfer(1, nullptr));
  for (int l = 0; l < Levels() && Levels() > 1; ++l) PetscCall(Rebalance(l)); // for the points that have just crossed
  for (auto &level : levels_) PetscCall(level->Sort());                       // seeds come row by row
  if (model_->indenter) PetscCall(surface_.Seed(seedings, tip_.At(0)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::CreateInterfaces(std::int64_t seeds)
{
  const bool copies = settings_.coupling == LevelCoupling::kPoints;
  const PointTransferRule by_nodes = {kEnter, kLeave, 0, false, settings_.merge_siblings, settings_.most_loss};
  const PointTransferRule by_points = {0, 0, settings_.ghost_cells + 2, settings_.repairs.velocity_shift, false, 0};
  const int dim = settings_.levels[0].grid.dim;
  numbers_.emplace(seeds, static_cast<int>(std::lround(std::pow(settings_.ratio, dim))));
  PetscFunctionBeginUser;
  if (copies) copies_.emplace(comm_, settings_.ratio, settings_.repairs);
  for (int b = 0; b + 1 < Levels(); ++b) {
    Level &coarse = *levels_[b], &fine = *levels_[b + 1];
    borders_.push_back(std::make_unique<LevelInterface>());
    transfers_.push_back(
        std::make_unique<PointTransfer>(comm_, coarse, fine, settings_.ratio, *numbers_, copies ? by_points : by_nodes));
    PetscCall(RenewInterface(b, false));
    if (!copies) continue;
    PetscCall(copies_->Add(coarse, fine, settings_.ghost_cells));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::CreateLevel(int l, const Seeding &seeding)
{
  GridLayout layout;
  std::vector<Index> nodes;
  PetscFunctionBeginUser;
  seeding.ListNodes(comm_, &nodes);
  PetscCall(FirstLayout(comm_, RanksOf(comm_), settings_.points_per_rank, nodes, settings_.levels[l].grid, &layout));
  levels_[l] = std::make_unique<Level>(*model_, events_);
  PetscCall(levels_[l]->Create(comm_, settings_.levels[l], layout));
  levels_[l]->SetSortInterval(settings_.sort_interval);
  levels_[l]->SetXpic({model_->nodal.xpic_fraction, std::pow(settings_.ratio, l)});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the blocks of all levels exchange in a step of level 0.
PetscErrorCode Hierarchy::FindTraffic(std::vector<BlockTraffic> *traffic) const
{
  PetscFunctionBeginUser;
  for (int b = 0; b + 1 < Levels(); ++b) PetscCall(borders_[b]->AddTraffic(b, std::pow(settings_.ratio, b), traffic));
  PetscFunctionReturn(PETSC_SUCCESS);
}

RankMap Hierarchy::RanksInUse() const
{
  RankMap map;
  for (const auto &level : levels_) map.push_back(level->Mesh().Layout().ranks);
  return map;
}

/// Gives the blocks of all levels to the ranks that save most messages between levels.
PetscErrorCode Hierarchy::MapRanks()
{
  std::vector<BlockTraffic> traffic;
  PetscFunctionBeginUser;
  PetscCall(FindTraffic(&traffic));
  const RankMap map = RanksInUse(), better = ImproveMap(traffic, RanksOf(comm_), map);
  for (int l = 0; l < Levels(); ++l) {
    if (better[l] == map[l]) continue;
    GridLayout layout = levels_[l]->Mesh().Layout();
    layout.ranks = better[l];
    PetscCall(levels_[l]->Repartition(layout));
    PetscCall(Reconnect(true));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::View(double time)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) PetscCall(levels_[l]->View("level_" + std::to_string(l) + "_", time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::BytesBetweenLevels(double *mapped, double *unmapped) const
{
  std::vector<BlockTraffic> traffic;
  RankMap map = RanksInUse();
  PetscFunctionBeginUser;
  PetscCall(FindTraffic(&traffic));
  *mapped = BytesBetweenRanks(traffic, map);
  for (auto &level : map) std::iota(level.begin(), level.end(), 0);
  *unmapped = BytesBetweenRanks(traffic, map);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Creates a border anew, with the totals and, where its nodes are the same, the state it had.
PetscErrorCode Hierarchy::RenewInterface(int b, bool keeps_state)
{
  auto border = std::make_unique<LevelInterface>();
  PetscFunctionBeginUser;
  const double width = settings_.rules.blend_widths.empty() ? kBlendWidth : settings_.rules.blend_widths[b];
  PetscCall(border->Create(comm_, *levels_[b], *levels_[b + 1], settings_.ratio, width));
  if (keeps_state) PetscCall(border->TakeState(*borders_[b]));
  border->Totals() = borders_[b]->Totals();
  borders_[b] = std::move(border);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Hierarchy::CoupleNodes(int l)
{
  std::vector<CoupledNode> nodes;
  CoupledPlaces places;
  if (!CoupledByNodes()) return;
  levels_[l]->SetBorders({l > 0 ? borders_[l - 1].get() : nullptr, IsActive(l + 1) ? borders_[l]->Shared() : nullptr},
                         IsActive(l + 1) ? borders_[l]->FinerMasses() : nullptr);
  if (l > 0) nodes = borders_[l - 1]->FineNodes(), places = borders_[l - 1]->FinePlaces();
  if (IsActive(l + 1)) {
    const LevelInterface &finer = *borders_[l];
    nodes.insert(nodes.end(), finer.CoarseNodes().begin(), finer.CoarseNodes().end());
    places.interface = finer.HeldCoarseNodes();
    places.held.insert(places.held.end(), places.interface.begin(), places.interface.end());
  }
  levels_[l]->SetCoupledNodes(std::move(nodes), std::move(places));
}

PetscErrorCode Hierarchy::Reconnect(bool keeps_state)
{
  PetscFunctionBeginUser;
  for (int b = 0; b + 1 < Levels(); ++b) PetscCall(RenewInterface(b, keeps_state));
  for (int l = 0; l < Levels(); ++l) CoupleNodes(l);
  surface_.OwnersHaveChanged();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::RestoreInterfaceState(int b, const std::vector<double> &state)
{
  PetscFunctionBeginUser;
  PetscCall(RenewInterface(b, false));
  PetscCall(borders_[b]->RestoreState(state));
  const bool last = b + 2 == Levels(); // until then the next border has places of the layout before
  for (int l = 0; last && l < Levels(); ++l) CoupleNodes(l);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Advance(TimeStep step)
{
  PetscFunctionBeginUser;
  if (model_->indenter) PetscCall(surface_.Watch(follow_.plan.active));
  if (settings_.coupling == LevelCoupling::kNodes || Levels() == 1)
    PetscCall(AdvanceLevel(0, step, 0));
  else
    PetscCall(AdvanceLevelWithCopies(0, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::AdvanceLevel(int l, TimeStep step, int substep)
{
  const StageScope stage(stages_[l]);
  const int ratio = settings_.ratio;
  const Vec3 tip = tip_.At(step.time);
  Level &level = *levels_[l];
  LevelInterface *const coarser = l > 0 ? borders_[l - 1].get() : nullptr, *const finer =
                                                                               IsActive(l + 1) ? borders_[l].get() : nullptr;
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
  if (finer) PetscCall(transfers_[l]->Transfer(step.dt, finer));
  PetscCall(RefineStretched(l, step.End()));
  PetscCall(level.EndStep());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Takes up what contact did to the tip in a step of level l, and how wide it was.
PetscErrorCode Hierarchy::RecordTip(int l, TimeStep step)
{
  const TipReport &contact = levels_[l]->Contact().Tip();
  PetscFunctionBeginUser;
  PetscCall(tip_.Follow(comm_, l, *levels_[l], step));
  follow_.half_width = std::max(follow_.half_width, contact.half_width);
  follow_.reach = std::max(follow_.reach, contact.reach);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Every kSplitInterval steps of level l: splits points of metal that are drawn out, and halves patches of the surface.
PetscErrorCode Hierarchy::RefineStretched(int l, double time)
{
  Level &level = *levels_[l];
  PetscFunctionBeginUser;
  if ((level.Steps() + 1) % kSplitInterval != 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (model_->SplitsStretched()) {
    StraightenBoxes(*model_, level.PointStore().Arrays());
    if (level.Contact().IsActive()) ExposePoints(*model_, level.Geometry(), level.PointStore(), tip_.At(time));
    PetscCall(Timed(events_.transfer, [&] { return SplitStretched(comm_, level, *numbers_); }));
    for (auto &transfer : transfers_) transfer->InvalidateClearance();
    level.Contact().InvalidateClearance();
  }
  if (model_->indenter) level.SplitSurface(tip_.At(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same for levels that are coupled by copies of points.
PetscErrorCode Hierarchy::AdvanceLevelWithCopies(int l, TimeStep step)
{
  const StageScope stage(stages_[l]);
  Level &level = *levels_[l];
  PetscFunctionBeginUser;
  if (l == 0) PetscCall(copies_->Begin(step.dt));
  PetscCall(level.GatherForces(step));
  PetscCall(level.UpdateNodes(step.dt));
  PetscCall(level.FinishNodes(step, tip_.Step(l, tip_.At(step.time), step)));
  PetscCall(level.AdvancePoints(step.dt));
  PetscCall(level.EndStep());
  if (l + 1 < Levels()) {
    for (int k = 0; k < settings_.ratio; ++k) PetscCall(AdvanceLevelWithCopies(l + 1, step.Part(k, settings_.ratio)));
    PetscCall(copies_->DecideByPlace(l));
    PetscCall(transfers_[l]->Transfer(step.dt, nullptr));
    PetscCall(copies_->Exchange(l, step.dt));
  }
  if (l == 0) PetscCall(copies_->Finish());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::CheckSpeeds(SpeedCheck *speeds)
{
  double values[3] = {}; // largest of all ranks
  PetscFunctionBeginUser;
  for (const auto &level : levels_) {
    double wave = 0, point = 0;
    level->LargestSpeeds(&wave, &point);
    values[0] = std::max(values[0], wave);
    values[1] = std::max(values[1], point);
    if (level->Failure().kind != LevelFailure::kNone) values[2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 3, MPI_DOUBLE, MPI_MAX, comm_));
  *speeds = {values[0], values[1], values[2] > 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The nodes of level l that points in a box may touch until they are checked again, with half their size and as much more, and
/// those of the next coarser level that these hang on.
IndexBox Hierarchy::ZoneOf(int l, const Box &near, double drift) const
{
  const GridGeometry &grid = settings_.levels[l].grid;
  const double room = drift + (2 + (l > 0 ? settings_.ratio : 0)) * grid.spacing;
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

/// Activates contact on the levels whose points the indenter can press on, and gives each level the zone that contact may touch.
/// Points of neighbouring levels may become its own.
PetscErrorCode Hierarchy::WatchContact(double time, double travel, double drift)
{
  constexpr Box kNowhere{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  constexpr int kOfLevel = 7; // size: whether its own points are near; minus the lower end and the upper end of all that are
  std::vector<double> largest;
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    const double range = kPointRange * settings_.levels[l].grid.spacing + travel + drift;
    const double touch = range + (TouchRange(model_->contact) - kPointRange) * settings_.levels[l].grid.spacing;
    Box near = kNowhere, touching = kNowhere;
    levels_[l]->FindNearIndenter(tip_.At(time), range, &near);
    levels_[l]->FindNearIndenter(tip_.At(time), touch, &touching);
    largest.push_back(touching.lower[0] < HUGE_VAL);
    for (int other = std::max(l - 1, 0); other < std::min(l + 2, Levels()); ++other)
      if (other != l) levels_[other]->FindNearIndenter(tip_.At(time), range, &near);
    for (const double x : near.lower) largest.push_back(-x);
    largest.insert(largest.end(), near.upper.begin(), near.upper.end());
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, comm_));
  for (int l = 0; l < Levels(); ++l) {
    const double *const n = &largest[static_cast<std::size_t>(kOfLevel) * l];
    const bool awake = n[0] > 0;
    const Box near{{-n[1], -n[2], -n[3]}, {n[4], n[5], n[6]}};
    PetscCall(levels_[l]->WatchContact(awake, awake ? ZoneOf(l, near, drift) : IndexBox{}));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Adapt(const SpeedCheck &speeds, double time, double dt, int steps)
{
  constexpr double kSafety = 2, kSurprise = 0.02; // of speeds; cells a step, where a body at rest is set in motion
  const double drift = steps * std::max(kSafety * speeds.point_speed * dt, kSurprise * settings_.levels[0].grid.spacing);
  std::vector<double> total, largest;
  PetscFunctionBeginUser;
  if (model_->indenter) PetscCall(WatchContact(time, tip_.Reach(time, dt, steps), drift));
  PetscCall(CountPoints(&total, &largest));
  for (int l = 0; l < Levels(); ++l) {
    if (NeedsBalance(l, total[l], largest[l])) PetscCall(Timed(events_.balance, [&] { return Rebalance(l); }));
    levels_[l]->BoundDrift(speeds.point_speed, dt / std::pow(settings_.ratio, l));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether a level must be cut anew: a rank has too many of its points, or they have become too many or too few for its ranks.
bool Hierarchy::NeedsBalance(int l, double total, double largest) const
{
  const int blocks = levels_[l]->Mesh().Layout().Blocks();
  return largest * blocks > settings_.rebalance_threshold * total ||
         NeedsOtherRanks(total, blocks, RanksOf(comm_), settings_.points_per_rank);
}

PetscErrorCode Hierarchy::CountPoints(std::vector<double> *total, std::vector<double> *largest)
{
  PetscFunctionBeginUser;
  total->clear();
  for (const auto &level : levels_) total->push_back(level->PointStore().Count());
  *largest = *total;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, total->data(), Levels(), MPI_DOUBLE, MPI_SUM, comm_));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest->data(), Levels(), MPI_DOUBLE, MPI_MAX, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Rebalance(int l)
{
  GridLayout layout;
  bool changed = false;
  PetscFunctionBeginUser;
  PetscCall(BetterLayout(comm_, *levels_[l], settings_.points_per_rank, &layout, &changed));
  if (!changed) PetscFunctionReturn(PETSC_SUCCESS);
  const bool other_ranks = layout.Blocks() != levels_[l]->Mesh().Layout().Blocks();
  PetscCall(levels_[l]->Repartition(layout));
  PetscCall(Reconnect(true));
  if (other_ranks) PetscCall(MapRanks());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
