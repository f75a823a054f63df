// Creation of levels and borders, their ranks, and the balance between these.
#include "hierarchy/connected_levels.hpp"

#include "hierarchy/partition/balance.hpp"

#include <cmath>
#include <numeric>

namespace mlgimp
{

PetscErrorCode ConnectedLevels::Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings,
                                       const LogEvents &events, const std::vector<Seeding> &seedings)
{
  std::vector<int> groups(model.bodies.size());
  PetscFunctionBeginUser;
  comm_ = comm;
  settings_ = settings;
  events_ = events;
  levels_.resize(settings.levels.size());
  active_ = Count();
  std::iota(groups.begin(), groups.end(), 0);
  for (const Seeding &seeding : seedings) PetscCall(seeding.JoinTouching(comm, &groups));
  for (int l = 0; l < Count(); ++l) PetscCall(CreateLevel(model, l, seedings[l], groups));
  PetscCall(CreateBorders(seedings.back().EndId()));
  PetscCall(MapRanks());
  for (int l = 0; l < Count(); ++l) CoupleNodes(l);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::CreateLevel(const Model &model, int l, const Seeding &seeding, const std::vector<int> &groups)
{
  const XpicSchedule xpic(model.nodal.xpic_fraction, std::pow(settings_.ratio, l));
  GridLayout layout;
  std::vector<Index> nodes;
  PetscFunctionBeginUser;
  seeding.ListNodes(comm_, &nodes);
  PetscCall(FirstLayout(comm_, RanksOf(comm_), settings_.points_per_rank, nodes, settings_.levels[l].grid, &layout));
  levels_[l] = std::make_unique<Level>(model, events_);
  PetscCall(levels_[l]->Create(comm_, settings_.levels[l], layout, {xpic, settings_.sort_interval, groups}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::CreateBorders(std::int64_t seeds)
{
  const bool copies = settings_.coupling == LevelCoupling::kPoints;
  const PointTransferRule by_nodes = {kEnter, kLeave, 0, false, settings_.merge_siblings, settings_.most_loss};
  const PointTransferRule by_points = {0, 0, settings_.ghost_cells + 2, settings_.repairs.velocity_shift, false, 0};
  const int dim = settings_.levels[0].grid.dim;
  numbers_.emplace(seeds, static_cast<int>(std::lround(std::pow(settings_.ratio, dim))));
  PetscFunctionBeginUser;
  for (int b = 0; b + 1 < Count(); ++b) {
    Level &coarse = *levels_[b], &fine = *levels_[b + 1];
    borders_.push_back(std::make_unique<LevelInterface>());
    transfers_.push_back(
        std::make_unique<PointTransfer>(comm_, coarse, fine, settings_.ratio, *numbers_, copies ? by_points : by_nodes));
    PetscCall(RenewBorder(b, false));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the blocks of all levels exchange in a step of level 0.
PetscErrorCode ConnectedLevels::FindTraffic(std::vector<BlockTraffic> *traffic) const
{
  PetscFunctionBeginUser;
  for (int b = 0; b + 1 < Count(); ++b) PetscCall(borders_[b]->Nodes().AddTraffic(b, std::pow(settings_.ratio, b), traffic));
  PetscFunctionReturn(PETSC_SUCCESS);
}

RankMap ConnectedLevels::RanksInUse() const
{
  RankMap map;
  for (const auto &level : levels_) map.push_back(level->Mesh().Nodes().Layout().ranks);
  return map;
}

PetscErrorCode ConnectedLevels::MapRanks()
{
  std::vector<BlockTraffic> traffic;
  PetscFunctionBeginUser;
  PetscCall(FindTraffic(&traffic));
  const RankMap map = RanksInUse(), better = ImproveMap(traffic, RanksOf(comm_), map);
  for (int l = 0; l < Count(); ++l) {
    if (better[l] == map[l]) continue;
    GridLayout layout = levels_[l]->Mesh().Nodes().Layout();
    layout.ranks = better[l];
    PetscCall(levels_[l]->Repartition(layout));
    PetscCall(Reconnect(true));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::BytesBetweenLevels(double *mapped, double *unmapped) const
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
PetscErrorCode ConnectedLevels::RenewBorder(int b, bool keeps_state)
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

void ConnectedLevels::CoupleNodes(int l)
{
  CoupledLevel coupled;
  if (!settings_.CouplesNodes()) return;
  coupled.on = true;
  if (LevelInterface *const coarser = Coarser(l)) {
    coupled.nodes = coarser->Nodes().Coupled().fine, coupled.places = coarser->Nodes().Coupled().fine_places;
    coupled.coarser = &coarser->Contact();
  }
  if (LevelInterface *const finer = Finer(l)) {
    const CoupledOfBorder &border = finer->Nodes().Coupled();
    CoupledPlaces &places = coupled.places;
    coupled.nodes.insert(coupled.nodes.end(), border.coarse.begin(), border.coarse.end());
    places.interface = border.held_coarse;
    places.held.insert(places.held.end(), places.interface.begin(), places.interface.end());
    coupled.finer = finer->Contact().Shared(), coupled.finer_masses = finer->FinerMasses();
  }
  levels_[l]->Couple(std::move(coupled));
}

PetscErrorCode ConnectedLevels::Reconnect(bool keeps_state)
{
  PetscFunctionBeginUser;
  for (int b = 0; b + 1 < Count(); ++b) PetscCall(RenewBorder(b, keeps_state));
  for (int l = 0; l < Count(); ++l) CoupleNodes(l);
  ++owner_changes_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::RestoreBorder(int b, const std::vector<double> &state)
{
  PetscFunctionBeginUser;
  PetscCall(RenewBorder(b, false));
  PetscCall(borders_[b]->RestoreState(state));
  const bool last = b + 2 == Count(); // until then the next border has places of the layout before
  for (int l = 0; last && l < Count(); ++l) CoupleNodes(l);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::Rebalance(int l)
{
  GridLayout layout;
  bool changed = false;
  PetscFunctionBeginUser;
  PetscCall(BetterLayout(comm_, *levels_[l], settings_.points_per_rank, &layout, &changed));
  if (!changed) PetscFunctionReturn(PETSC_SUCCESS);
  const bool other_ranks = layout.Blocks() != levels_[l]->Mesh().Nodes().Layout().Blocks();
  PetscCall(levels_[l]->Repartition(layout));
  PetscCall(Reconnect(true));
  if (other_ranks) PetscCall(MapRanks());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::Balance()
{
  std::vector<double> total, largest;
  PetscFunctionBeginUser;
  PetscCall(CountPoints(&total, &largest));
  for (int l = 0; l < Count(); ++l) {
    const int blocks = levels_[l]->Mesh().Nodes().Layout().Blocks();
    const bool uneven = largest[l] * blocks > settings_.rebalance_threshold * total[l];
    if (uneven || NeedsOtherRanks(total[l], blocks, RanksOf(comm_), settings_.points_per_rank))
      PetscCall(Timed(events_.balance, [&] { return Rebalance(l); }));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConnectedLevels::CountPoints(std::vector<double> *total, std::vector<double> *largest) const
{
  PetscFunctionBeginUser;
  total->clear();
  for (const auto &level : levels_) total->push_back(level->PointStore().Count());
  *largest = *total;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, total->data(), Count(), MPI_DOUBLE, MPI_SUM, comm_));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest->data(), Count(), MPI_DOUBLE, MPI_MAX, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
