// The budgets of a run and its failures, over all levels and ranks.
#include "hierarchy/hierarchy.hpp"

#include <cmath>
#include <cstdio>
#include <string>
#include <type_traits>

namespace mlgimp
{

/// This rank's share of the budgets.
static PetscErrorCode LocalBudgets(Level &level, Budgets *b)
{
  PointSums point_sums;
  PetscFunctionBeginUser;
  PetscCall(level.SumPoints(&point_sums));
  const NodalTotals &nodal = level.Nodal();
  const SweepTotals &sweeps = level.Sweeps();
  const ContactTotals &contact = level.Contacts();
  const LoadTotals &loads = level.Loads();
  b->kinetic_energy += point_sums.kinetic_energy;
  b->strain_energy += point_sums.strain_energy;
  b->mass += point_sums.mass;
  b->points += point_sums.count;
  b->contact_points += contact.last.local_points;
  b->short_wave_dissipation += sweeps.short_wave_dissipation;
  b->plastic_dissipation += sweeps.plastic_dissipation;
  b->xpic_dissipation += sweeps.xpic_dissipation;
  b->clamped_sizes += static_cast<double>(sweeps.clamped_sizes);
  b->damping_dissipation += nodal.damping_dissipation;
  b->external_work += nodal.gravity_work + loads.work;
  b->exchange_energy += nodal.exchange_work;
  b->hoop_impulse += nodal.hoop_impulse;
  b->indenter_work += contact.indenter_work;
  b->contact_work += contact.work;
  b->contact_steps += contact.steps;
  b->contact_set_updates += contact.set_updates;
  b->contact_fallbacks += contact.fallbacks;
  for (int d = 0; d < 3; ++d) {
    b->momentum[d] += point_sums.momentum[d];
    b->support_impulse[d] += nodal.support_impulse[d] + nodal.xpic_side_impulse[d];
    b->stagger_impulse[d] += sweeps.xpic_impulse[d] - nodal.xpic_side_impulse[d]; // between levels; nothing on one
    b->contact_impulse[d] += contact.impulse[d];
    b->load_impulse[d] += loads.impulse[d];
    b->gravity_impulse[d] += nodal.gravity_impulse[d];
    b->damping_impulse[d] += nodal.damping_impulse[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// This rank's share of what borders do.
static void InterfaceBudgets(const InterfaceTotals &border, const PointTransferTotals &transfer, Budgets *b)
{
  for (int d = 0; d < 3; ++d) {
    b->support_impulse[d] += border.support_impulse[d];
    b->stagger_impulse[d] += border.stagger_impulse[d];
  }
  b->transfer_energy += transfer.energy;
  b->points_entered += transfer.entered;
  b->points_left += transfer.left;
  b->points_split += transfer.split;
  b->points_merged += transfer.merged;
  b->points_unsplit += transfer.unsplit;
  b->transfer_mass_error += transfer.mass_error;
  b->transfer_momentum_error += transfer.momentum_error;
  b->points_adrift += transfer.points_adrift;
  b->mass_adrift += transfer.mass_adrift;
  for (int d = 0; d < 3; ++d) b->momentum_adrift[d] += transfer.momentum_adrift[d];
}

PetscErrorCode Hierarchy::ReduceBudgets(Budgets *budgets)
{
  static_assert(sizeof(Budgets) % sizeof(double) == 0, "budgets are reduced as an array of doubles");
  PetscFunctionBeginUser;
  *budgets = {};
  for (auto &level : levels_) PetscCall(LocalBudgets(*level, budgets));
  for (int b = 0; b + 1 < Levels(); ++b) InterfaceBudgets(borders_[b]->Totals(), transfers_[b]->Totals(), budgets);
  if (CoupledByNodes()) {
    budgets->exchange_energy += budgets->strain_energy + budgets->short_wave_dissipation + budgets->plastic_dissipation +
                                budgets->damping_dissipation - budgets->external_work;
    for (const auto &transfer : transfers_) budgets->exchange_energy -= transfer->Totals().strain_energy;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, budgets, sizeof(Budgets) / sizeof(double), MPI_DOUBLE, MPI_SUM, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Calls visit(number) for each of this rank's running totals.
template <class Visit> void Hierarchy::ForEachTotal(Visit visit)
{
  const auto each = [&](auto &...numbers) { (visit(numbers), ...); };
  for (auto &level : levels_) {
    NodalTotals &n = level->Nodal();
    SweepTotals &s = level->Sweeps();
    ContactTotals &c = level->Contacts();
    LoadTotals &loads = level->Loads();
    for (Vec3 *impulse : {&n.support_impulse, &n.gravity_impulse, &loads.impulse, &n.damping_impulse, &n.xpic_side_impulse,
                          &s.xpic_impulse, &c.impulse})
      each((*impulse)[0], (*impulse)[1], (*impulse)[2]);
    each(n.hoop_impulse, n.gravity_work, loads.work, n.exchange_work, n.damping_dissipation);
    each(s.short_wave_dissipation, s.plastic_dissipation, s.xpic_dissipation, s.clamped_sizes);
    each(c.indenter_work, c.work, c.steps, c.set_updates, c.fallbacks);
  }
  for (int b = 0; b + 1 < Levels(); ++b) {
    InterfaceTotals border = borders_[b]->Totals();
    PointTransferTotals transfer = transfers_[b]->Totals();
    for (Vec3 *impulse : {&border.support_impulse, &border.stagger_impulse}) each((*impulse)[0], (*impulse)[1], (*impulse)[2]);
    each(transfer.energy, transfer.strain_energy);
    each(transfer.entered, transfer.left, transfer.split, transfer.merged, transfer.unsplit, transfer.mass_error,
         transfer.momentum_error);
    each(transfer.points_adrift, transfer.mass_adrift, transfer.momentum_adrift[0], transfer.momentum_adrift[1],
         transfer.momentum_adrift[2]);
    borders_[b]->SetTotals(border);
    transfers_[b]->SetTotals(transfer);
  }
}

std::vector<double> Hierarchy::Totals()
{
  std::vector<double> totals;
  ForEachTotal([&](const auto &number) { totals.push_back(static_cast<double>(number)); });
  return totals;
}

bool Hierarchy::RestoreTotals(const std::vector<double> &totals)
{
  constexpr double kLargestCount = 9007199254740992; // 2^53
  auto next = totals.begin();
  bool right = true;
  ForEachTotal([&](auto &number) {
    using Number = std::decay_t<decltype(number)>;
    const double value = *next++;
    const bool fits = !std::is_integral_v<Number> || (value >= 0 && value <= kLargestCount && value == std::floor(value));
    number = fits ? static_cast<Number>(value) : Number{};
    right = right && fits;
  });
  return right;
}

static std::string Describe(const LevelFailure &failure, int l)
{
  char text[400];
  const PointFailure &point = failure.point;
  const char *what = "", *advice = "";
  if (failure.kind == LevelFailure::kContact) {
    std::snprintf(text, sizeof text,
                  "time %.6e, level %d: the contact solve did not converge; try -contact_ksp_monitor, a larger "
                  "-contact_ksp_max_it or another -contact_ksp_type",
                  failure.time, l);
    return text;
  }
  switch (point.kind) {
  case PointFailure::kLeftGrid:
    what = "left the grid";
    advice = "a larger domain, or sides that hold the body";
    break;
  case PointFailure::kDeformedTooFast:
    what = "deforms by more than a half in one step";
    advice = "a smaller -cfl or -time_step, some -xpic_fraction, or a slower load";
    break;
  default:
    what = "has a value that is not finite";
    advice = "a smaller -cfl or -time_step";
  }
  std::snprintf(text, sizeof text, "time %.6e, level %d: point %lld at (%.6e, %.6e) %s; try %s", failure.time, l,
                static_cast<long long>(point.id), point.position[0], point.position[1], what, advice);
  return text;
}

PetscErrorCode Hierarchy::DescribeFailure(std::string *message)
{
  PetscMPIInt rank, size;
  std::string mine;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  PetscCallMPI(MPI_Comm_size(comm_, &size));
  for (int l = 0; l < Levels() && mine.empty(); ++l)
    if (levels_[l]->Failure().kind != LevelFailure::kNone) mine = Describe(levels_[l]->Failure(), l);
  int first = mine.empty() ? size : rank;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm_));
  message->clear();
  if (first == size) PetscFunctionReturn(PETSC_SUCCESS);
  int length = static_cast<int>(mine.size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, first, comm_));
  mine.resize(length);
  PetscCallMPI(MPI_Bcast(mine.data(), length, MPI_CHAR, first, comm_));
  *message = mine;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
