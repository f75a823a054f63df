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
  if (model.indenter && model.contact.method != "none") PetscCall(CreateContact(model.contact, group_, &method_));
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

void LevelContact::Rest()
{
  Record({}, 0);
  tip_ = {};
}

PetscErrorCode LevelContact::Watch(MPI_Comm world, const Grid &grid, bool within_reach, const IndexBox &zone)
{
  PetscFunctionBeginUser;
  InvalidateClearance();
  reach_.active = within_reach;
  if (within_reach) reach_.nodes = zone;
  if (!method_) PetscFunctionReturn(PETSC_SUCCESS);
  group_.SetZone(reach_.nodes);
  if (grid.Nodes().BlocksIn(reach_.nodes) == group_.Blocks()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SharePressures(world, grid));
  PetscCall(group_.Create(grid.Nodes(), reach_.nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::Regroup(const Grid &grid)
{
  PetscFunctionBeginUser;
  if (method_) PetscCall(group_.Create(grid.Nodes(), reach_.nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::SharePressures(MPI_Comm world, const Grid &grid)
{
  const PetscMPIInt root = Root(grid);
  std::vector<std::pair<std::int64_t, double>> list;
  PetscFunctionBeginUser;
  if (!method_) PetscFunctionReturn(PETSC_SUCCESS);
  InvalidateClearance();
  for (const auto &pressure : method_->Pressures()) list.push_back(pressure);
  int bytes = static_cast<int>(list.size() * sizeof list[0]);
  PetscCallMPI(MPI_Bcast(&bytes, 1, MPI_INT, root, world));
  list.resize(bytes / sizeof list[0]);
  PetscCallMPI(MPI_Bcast(list.data(), bytes, MPI_BYTE, root, world));
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
  touches_ = reach_.active && group_.Participates() && clearance_.left <= Norm(tip.end - clearance_.tip);
  tip_ = {tip.FreeTravel()};
  changes_.clear(), surface_motion_.Begin();
  if (!touches_) Record({}, 0);
}

/// Nodes that also move those of the next finer level: what contact there has done to them is contact, not coupling of levels;
/// and in their velocities is the impulse of contact here in the step before, in whose place that of this step comes.
void LevelContact::TakeShared(const ContactSite &site, std::vector<CoupledNode> *coupled)
{
  if (!borders_.finer) return;
  for (CoupledNode &one : *coupled) {
    SharedNode &node = borders_.finer[one.node];
    const double mass = site.grid.Sums()[one.node].mass + node.finer_mass;
    if (mass <= site.mass_cutoff) node = {}; // the last point has left
    const Vec3 expected = node.impulse == Vec3{} ? Vec3{} : 1 / mass * node.impulse, by = node.finer_contact_change - expected;
    if (by != Vec3{}) changes_.push_back({one.node, by});
    one.change = one.change - node.finer_contact_change;
    const NodeVelocity now = site.grid.Velocity(one.node);
    for (int axis = 0; axis < site.grid.Geometry().dim; ++axis)
      now.velocity[axis] -= expected[axis], now.change[axis] -= expected[axis];
    node.impulse = {};
  }
}

PetscErrorCode LevelContact::Solve(const ContactSite &site, TimeStep step, const TipStep &tip, std::vector<CoupledNode> *coupled)
{
  PetscFunctionBeginUser;
  if (!method_) PetscFunctionReturn(PETSC_SUCCESS);
  TakeShared(site, coupled);
  if (!reach_.active) PetscFunctionReturn(PETSC_SUCCESS);
  surface_.Approach(*site.model.indenter, tip.end, kPointRange * site.geometry.grid.spacing);
  reaches_coarser_level_ = group_.Blocks().size() < site.grid.Nodes().Layout().ranks.size(); // where some ranks do not know
  if (touches_) PetscCall(Apply(site, step, tip));
  if (borders_.coarser && reaches_coarser_level_) PetscCall(borders_.coarser->Spread(&changes_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::Apply(const ContactSite &site, TimeStep step, const TipStep &tip)
{
  const LogScope log(events_.contact);
  const NodeMotion nodes(site.grid, site.geometry.sides, site.light, site.mass_cutoff, group_, borders_.coarser, borders_.finer);
  ContactReport report;
  PetscFunctionBeginUser;
  PetscCall(method_->Apply(site.Of(surface_), nodes, {step.time, step.dt, tip}, &report));
  reaches_coarser_level_ = reaches_coarser_level_ || report.may_reach_coarser_level;
  changes_.insert(changes_.end(), report.contact_nodes.begin(), report.contact_nodes.end());
  failed_ = failed_ || !report.solved;
  clearance_.left = report.clearance, clearance_.tip = tip.end;
  surface_motion_.SetPressed(report.columns);
  Record(report, RankIn(group_.Comm()) == 0 ? report.area : 0);
  AddUp(report, *site.model.indenter, step, tip, site.geometry.grid.spacing);
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

PetscErrorCode LevelContact::PrepareSurface(const ContactSite &site, double path)
{
  const LogScope log(events_.surface);
  PetscFunctionBeginUser;
  if (IsActive())
    PetscCall(surface_motion_.Prepare(site.grid, surface_, site.bodies, site.points, path));
  else
    surface_motion_.PrepareFar(surface_);
  strain_under_.Clear();
  if (touches_ && site.model.HasMetal()) strain_under_.Begin(site.Of(surface_), clearance_.tip);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::MoveSurface(const ContactSite &site, bool rates, double dt)
{
  std::vector<char> by_rates;
  double work = 0;
  PetscFunctionBeginUser;
  for (const int average : site.bodies.average) by_rates.push_back(rates && average < 0);
  PetscCall(Timed(events_.surface, [&] {
    return surface_motion_.Finish(site.grid, site.geometry.sides, site.points.Arrays(), by_rates, site.mass_cutoff, dt,
                                  &surface_);
  }));
  if (!touches_ || !site.model.HasMetal()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Timed(events_.contact, [&] { return method_->Flow(strain_under_.End(site.points.Arrays()), &surface_, &work); }));
  budgets_.contact_plastic_work += work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::PressuresOnPoints(const ContactSite &site, Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(site.points.Count(), 0.0);
  if (IsActive() && group_.Participates()) PetscCall(method_->PressuresOnPoints(site.Of(surface_), tip, pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelContact::PressuresOnPatches(const ContactSite &site, Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->clear();
  if (IsActive() && group_.Participates()) PetscCall(method_->PressuresOnPatches(site.Of(surface_), tip, pressures));
  pressures->resize(surface_.Patches().size());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
