// The budgets of a run and its failures, over all levels and ranks.
#include "hierarchy/run_budgets.hpp"

#include "base/text.hpp"
#include "level/samples.hpp"

#include <cstdio>
#include <string>

namespace mlgimp
{

std::vector<Budgets *> PartsOfBudgets(ConnectedLevels &levels)
{
  std::vector<Budgets *> parts;
  for (int l = 0; l < levels.Count(); ++l) parts.push_back(&levels.At(l).Totals());
  for (int b = 0; b + 1 < levels.Count(); ++b)
    parts.insert(parts.end(), {&levels.Border(b).Totals(), &levels.Transfer(b).Totals()});
  return parts;
}

Budgets SumBudgets(ConnectedLevels &levels, const Model &model)
{
  const bool coupled = levels.Settings().CouplesNodes();
  Budgets sum;
  for (int l = 0; l < levels.Count(); ++l) {
    Budgets part = levels.At(l).Totals();
    SumPoints(levels.At(l), &part);
    if (part.contact_half_width > 0) part.contact_level = l, part.contact_coarseness += levels.Count() - l;
    part.support_impulse += part.xpic_side_impulse;
    if (coupled) part.stagger_impulse += part.xpic_impulse - part.xpic_side_impulse; // between levels; nothing on one
    sum.Add(part);
  }
  for (int b = 0; b + 1 < levels.Count(); ++b) sum.Add(levels.Border(b).Totals()), sum.Add(levels.Transfer(b).Totals());
  if (coupled || (levels.Count() == 1 && model.VolumeAverages() > 0)) {
    sum.exchange_energy += sum.strain_energy + sum.short_wave_dissipation + sum.averaging_work + sum.plastic_work +
                           sum.damping_work - sum.external_work - sum.contact_work;
    for (int b = 0; b + 1 < levels.Count(); ++b) sum.exchange_energy -= levels.Transfer(b).Totals().transfer_strain_energy;
  } else {
    sum.exchange_energy = 0;
  }
  sum.strain_energy += sum.contact_strain_energy;
  sum.plastic_work += sum.contact_plastic_work;
  sum.viscous_work = sum.Viscous();
  sum.dissipated_energy = sum.Dissipated();
  sum.failed = DescribeFailure(levels, model.geometry.Dim()).empty() ? 0 : 1;
  return sum;
}

PetscErrorCode ReduceBudgets(ConnectedLevels &levels, const Model &model, Budgets *budgets)
{
  std::vector<Budgets> sums = {SumBudgets(levels, model)};
  PetscFunctionBeginUser;
  PetscCall(AddRanks(levels.Comm(), &sums));
  *budgets = sums[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static std::string Describe(const LevelFailure &failure, int l, int dim)
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
  std::snprintf(text, sizeof text, "time %.6e, level %d: point %lld at %s %s; try %s", failure.time, l,
                static_cast<long long>(point.id), FormatPlace(point.position, dim).c_str(), what, advice);
  return text;
}

std::string DescribeFailure(ConnectedLevels &levels, int dim)
{
  int first = -1; // the first failure may spoil other levels before it is found
  for (int l = 0; l < levels.Count(); ++l) {
    const LevelFailure &failure = levels.At(l).Step().failure;
    if (failure.kind != LevelFailure::kNone && (first < 0 || failure.time < levels.At(first).Step().failure.time)) first = l;
  }
  return first < 0 ? "" : Describe(levels.At(first).Step().failure, first, dim);
}

} // namespace mlgimp
