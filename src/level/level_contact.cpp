// What contact does in a step of a level, and what is added up of it.
#include "level/level_contact.hpp"

#include "contact/node_motion.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

PetscErrorCode LevelContact::Create(const Model &model)
{
  PetscFunctionBeginUser;
  budgets_.contact_axes = model.geometry.kind == GeometryKind::kPlaneStrain ? 1 : 2;
  if (model.HasContact()) PetscCall(CreateContact(model.contact, group_, &method_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The contact as it is now; area: this rank's part.
void LevelContact::Record(const ContactReport &report, double area)
{
  budgets_.contact_points = report.local_points;
  budgets_.contact_half_width = report.half_width;
  budgets_.contact_width_power = area > 0 ? std::pow(report.half_width, budgets_.contact_axes) : 0;
  budgets_.peak_pressure = report.peak_pressure;
  budgets_.contact_area = area;
  budgets_.contact_strain_energy = report.stored;
  budgets_.contact_coarseness = report.crosses_border;
}

void LevelContact::Deactivate()
{
  Record({}, 0);
  tip_ = {};
}

PetscErrorCode LevelContact::Watch(MPI_Comm world, const Grid &grid, bool within_reach, const IndexBox &zone)
{
  PetscFunctionBeginUser;
  InvalidateClearance();
  within_reach_ = within_reach;
  if (within_reach) group_.SetZone(zone);
  if (method_ && grid.Nodes().BlocksIn(group_.Zone()) != group_.Blocks()) PetscCall(Regroup(world, grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::Regroup(MPI_Comm world, const Grid &grid)
{
  PetscFunctionBeginUser;
  if (!method_) PetscFunctionReturn(PETSC_SUCCESS);
  InvalidateClearance();
  PetscCall(SharePressures(world));
  PetscCall(group_.Create(grid.Nodes(), group_.Zone()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Brings the pressures from the first rank of the group to all, whichever will be in the next.
PetscErrorCode LevelContact::SharePressures(MPI_Comm world)
{
  std::vector<std::pair<std::int64_t, double>> list;
  PetscFunctionBeginUser;
  for (const auto &pressure : method_->Pressures()) list.push_back(pressure);
  int bytes = static_cast<int>(list.size() * sizeof list[0]);
  PetscCallMPI(MPI_Bcast(&bytes, 1, MPI_INT, group_.Root(), world));
  list.resize(bytes / sizeof list[0]);
  PetscCallMPI(MPI_Bcast(list.data(), bytes, MPI_BYTE, group_.Root(), world));
  method_->SetPressures(ContactPressures(list.begin(), list.end()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LevelContact::SetPressures(const ContactPressures &pressures)
{
  if (method_) method_->SetPressures(pressures);
}

void LevelContact::Begin(const TipStep &tip, double drift)
{
  clearance_.left -= drift;
  touches_ = within_reach_ && group_.Participates() && clearance_.left <= Norm(tip.end - clearance_.tip);
  tip_ = {tip.FreeTravel()};
  changes_.clear(), surface_motion_.Begin();
  if (!touches_) Record({}, 0);
}

/// Nodes that also move those of the next finer level: what contact there has done to them is contact, not coupling of levels;
/// and in their velocities is the impulse of contact here in the step before, in whose place that of this step comes.
void LevelContact::TakeShared(const LevelParts &level, CoupledLevel *coupled)
{
  if (!coupled->finer) return;
  for (const std::ptrdiff_t place : coupled->nodes) {
    SharedNode &node = coupled->finer[place];
    const double mass = level.grid.Sums()[place].mass + node.finer_mass;
    if (mass <= level.nodal.mass_cutoff) node = {}; // the last point has left
    const Vec3 expected = node.impulse == Vec3{} ? Vec3{} : 1 / mass * node.impulse, by = node.finer_contact_change - expected;
    if (by != Vec3{}) changes_.push_back({place, by});
    const NodeVelocity now = level.grid.Velocity(place);
    for (int axis = 0; axis < level.grid.Geometry().dim; ++axis)
      now.velocity[axis] -= expected[axis], now.change[axis] -= expected[axis];
    node.impulse = {};
  }
}

PetscErrorCode LevelContact::Solve(const LevelParts &level, TimeStep step, const TipStep &tip, CoupledLevel *coupled)
{
  PetscFunctionBeginUser;
  if (!method_) PetscFunctionReturn(PETSC_SUCCESS);
  TakeShared(level, coupled);
  if (!within_reach_) PetscFunctionReturn(PETSC_SUCCESS);
  surface_.Approach(*level.model.indenter, tip.end, kPointRange * level.geometry.grid.spacing);
  reaches_coarser_level_ = group_.Blocks().size() < level.grid.Nodes().Layout().ranks.size(); // where some ranks do not know
  if (touches_) PetscCall(Apply(level, step, tip, *coupled));
  if (coupled->coarser && reaches_coarser_level_) PetscCall(coupled->coarser->Spread(&changes_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::Apply(const LevelParts &level, TimeStep step, const TipStep &tip, const CoupledLevel &coupled)
{
  const LogScope log(level.events.contact);
  const NodeMotion nodes(level.grid, level.geometry.sides, level.light, level.nodal.mass_cutoff, group_, coupled.coarser,
                         coupled.finer);
  ContactReport report;
  PetscFunctionBeginUser;
  PetscCall(method_->Apply(level.InputsOf(surface_), nodes, {step.time, step.dt, tip}, &report));
  reaches_coarser_level_ = reaches_coarser_level_ || report.may_reach_coarser_level;
  changes_.insert(changes_.end(), report.contact_nodes.begin(), report.contact_nodes.end());
  if (!report.solved) level.step.Fail(LevelFailure::kContact);
  clearance_.left = report.clearance, clearance_.tip = tip.end;
  surface_motion_.SetPressed(report.columns);
  Record(report, RankIn(group_.Comm()) == 0 ? report.area : 0);
  AddUp(report, *level.model.indenter, step, tip, level.geometry.grid.spacing);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LevelContact::AddUp(const ContactReport &report, const Indenter &indenter, TimeStep step, const TipStep &tip, double spacing)
{
  tip_ = {report.travel, report.limited, -report.impulse[indenter.up] / step.dt, report.half_width, report.reach};
  budgets_.penetration = std::max<double>(budgets_.penetration, report.penetration);
  budgets_.contact_cells = std::max<double>(budgets_.contact_cells, report.half_width / spacing);
  budgets_.penetration_cells = std::max<double>(budgets_.penetration_cells, report.penetration / spacing);
  budgets_.contact_impulse += report.impulse;
  budgets_.support_impulse += report.side_impulse;
  budgets_.indenter_work += Dot(report.impulse, tip.end - tip.start + indenter.Up(-report.travel)) / step.dt;
  budgets_.friction_impulse += report.friction_impulse;
  budgets_.friction_work += report.friction_work;
  budgets_.contact_steps += report.set_updates > 0;
  budgets_.contact_set_updates += report.set_updates;
}

PetscErrorCode LevelContact::PrepareSurface(const LevelParts &level, double path)
{
  const LogScope log(level.events.surface);
  PetscFunctionBeginUser;
  if (IsActive())
    PetscCall(surface_motion_.Prepare(level.grid, surface_, level.bodies, level.points, path));
  else
    surface_motion_.PrepareFar(surface_);
  strain_under_.Clear();
  if (touches_ && level.model.Flows()) strain_under_.Begin(level.InputsOf(surface_), clearance_.tip);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::MoveSurface(const LevelParts &level, bool second, double dt)
{
  std::vector<char> by_rates;
  double work = 0;
  PetscFunctionBeginUser;
  for (const int average : level.bodies.average) by_rates.push_back(second && average < 0);
  PetscCall(Timed(level.events.surface, [&] {
    return surface_motion_.Finish(level.grid, level.geometry.sides, level.points.Arrays(), by_rates, level.nodal.mass_cutoff, dt,
                                  &surface_);
  }));
  if (!touches_ || !level.model.Flows()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      Timed(level.events.contact, [&] { return method_->Flow(strain_under_.End(level.points.Arrays()), &surface_, &work); }));
  budgets_.contact_plastic_work += work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::PressuresOnPoints(const LevelParts &level, Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(level.points.Count(), 0.0);
  if (IsActive() && group_.Participates()) PetscCall(method_->PressuresOnPoints(level.InputsOf(surface_), tip, pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::PressuresOnPatches(const LevelParts &level, Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->clear();
  if (IsActive() && group_.Participates()) PetscCall(method_->PressuresOnPatches(level.InputsOf(surface_), tip, pressures));
  pressures->resize(surface_.Patches().size());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
