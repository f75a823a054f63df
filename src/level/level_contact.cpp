// What a level does with contact in a step, and what it adds up of it.
#include "level/level.hpp"

#include <algorithm>

namespace mlgimp
{

/// The contact as it is now; area: this rank's part.
void Level::NoteContact(const ContactReport &report, double area)
{
  budgets_.contact_points = report.local_points;
  budgets_.contact_half_width = report.half_width;
  budgets_.peak_pressure = report.peak_pressure;
  budgets_.contact_area = area;
}

void Level::Rest()
{
  NoteContact({}, 0);
  tip_ = {};
  budgets_.noise_energy = 0;
}

static Vec3 VelocityOf(const Grid &grid, std::ptrdiff_t node)
{
  Vec3 velocity{};
  std::copy_n(grid.Velocity(node).velocity, grid.Geometry().dim, velocity.begin());
  return velocity;
}

ContactView Level::ViewOfContact(double time, double dt, const TipStep &tip)
{
  return {*grid_, points_, bodies_, geometry_.sides, *model_.indenter, model_.geometry, nodal_.mass_cutoff, time, dt, tip};
}

PetscErrorCode Level::FindContactPressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(points_.Count(), 0.0);
  if (contact_ && grid_->Participates()) PetscCall(contact_->PressuresOnPoints(ViewOfContact(time_, 0, {tip, tip}), pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::ApplyContact(double time, double dt, const TipStep &tip)
{
  const Indenter &indenter = *model_.indenter;
  ContactReport report;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.contact, 0, 0, 0, 0));
  const ContactView view = ViewOfContact(time, dt, tip);
  std::vector<Vec3> shared;
  for (const CoupledNode &coupled : coupled_nodes_) shared.push_back(VelocityOf(*grid_, coupled.node));
  PetscCall(contact_->Apply(view, &report));
  pushed_ = report.pushed;
  tip_ = {report.travel, report.limited, -report.impulse[indenter.up] / dt, report.half_width, report.reach};
  for (std::size_t k = 0; k < shared.size(); ++k) {
    const std::ptrdiff_t node = coupled_nodes_[k].node;
    budgets_.shared_contact_impulse +=
        coupled_nodes_[k].share * grid_->Sums()[node].mass * Norm(VelocityOf(*grid_, node) - shared[k]);
  }
  PetscCallMPI(MPI_Comm_rank(grid_->Comm(), &rank));
  if (!report.solved && failure_.kind == LevelFailure::kNone) failure_ = {LevelFailure::kContact, {}, time};
  NoteContact(report, rank == 0 ? report.area : 0);
  budgets_.penetration = std::max<double>(budgets_.penetration, report.penetration);
  budgets_.contact_cells = std::max<double>(budgets_.contact_cells, report.half_width / grid_->Geometry().spacing);
  budgets_.penetration_cells = std::max<double>(budgets_.penetration_cells, report.penetration / grid_->Geometry().spacing);
  budgets_.contact_impulse += report.impulse;
  budgets_.support_impulse += report.side_impulse;
  budgets_.indenter_work += Dot(report.impulse, tip.end - tip.start + indenter.Up(-report.travel)) / dt;
  budgets_.friction_impulse += report.friction_impulse;
  budgets_.friction_work += report.friction_work;
  budgets_.contact_steps += report.set_updates > 0;
  budgets_.contact_set_updates += report.set_updates;
  budgets_.contact_fallbacks += report.fallback;
  PetscCall(PetscLogEventEnd(events_.contact, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
