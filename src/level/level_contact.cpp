// What a level does with contact in a step, and what it adds up of it.
#include "level/level.hpp"

#include "contact/node_motion.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// The contact as it is now; area: this rank's part.
void Level::RecordContact(const ContactReport &report, double area)
{
  budgets_.contact_points = report.local_points;
  budgets_.contact_half_width = report.half_width;
  budgets_.contact_axes = model_.geometry.kind == GeometryKind::kPlaneStrain ? 1 : 2;
  budgets_.contact_width_power = area > 0 ? std::pow(report.half_width, budgets_.contact_axes) : 0;
  budgets_.peak_pressure = report.peak_pressure;
  budgets_.contact_area = area;
  budgets_.contact_strain_energy = report.stored;
  budgets_.contact_coarseness = report.crosses_border;
}

void Level::Deactivate()
{
  RecordContact({}, 0);
  tip_ = {};
  budgets_.noise_energy = 0;
}

PetscErrorCode Level::WatchContact(bool within_reach, const IndexBox &zone)
{
  PetscFunctionBeginUser;
  InvalidateClearance();
  clock_.contact_active = within_reach;
  if (within_reach) clock_.contact_zone = zone;
  PetscCall(Regroup());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::Activate()
{
  PetscFunctionBeginUser;
  clock_.drift_per_step = LevelClock().drift_per_step;
  PetscCall(WatchContact(true, kAllNodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::SetClock(const LevelClock &clock)
{
  PetscFunctionBeginUser;
  clock_ = clock;
  PetscCall(Regroup());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lets the ranks with nodes in the zone of contact be its group. What the next step starts from goes to all ranks.
PetscErrorCode Level::Regroup()
{
  PetscFunctionBeginUser;
  if (!contact_) PetscFunctionReturn(PETSC_SUCCESS);
  group_.SetZone(clock_.contact_zone);
  if (grid_->BlocksIn(clock_.contact_zone) == group_.Blocks()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SharePressures());
  PetscCall(group_.Create(*grid_, clock_.contact_zone));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Brings the contact pressures from the first rank of the group to all, whichever will be in the next.
PetscErrorCode Level::SharePressures()
{
  const PetscMPIInt root = ContactRoot();
  std::vector<std::pair<std::int64_t, double>> list;
  PetscFunctionBeginUser;
  if (!contact_) PetscFunctionReturn(PETSC_SUCCESS);
  InvalidateClearance();
  for (const auto &pressure : contact_->Pressures()) list.push_back(pressure);
  int bytes = static_cast<int>(list.size() * sizeof list[0]);
  PetscCallMPI(MPI_Bcast(&bytes, 1, MPI_INT, root, world_));
  list.resize(bytes / sizeof list[0]);
  PetscCallMPI(MPI_Bcast(list.data(), bytes, MPI_BYTE, root, world_));
  contact_->SetPressures(ContactPressures(list.begin(), list.end()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Nodes that also move those of the next finer level: what contact there has done to them is contact, not coupling of levels;
/// and in their velocities is the impulse of contact here in the step before, in whose place that of this step comes.
void Level::PrepareSharedNodes()
{
  if (!shared_) return;
  for (CoupledNode &one : coupled_nodes_) {
    SharedNode &node = shared_[one.node];
    const double mass = grid_->Sums()[one.node].mass + node.finer_mass;
    if (mass <= nodal_.mass_cutoff) node = {}; // the last point has left
    const Vec3 expected = node.impulse == Vec3{} ? Vec3{} : 1 / mass * node.impulse, by = node.finer_contact_change - expected;
    if (by != Vec3{}) contact_nodes_.push_back({one.node, by});
    one.change = one.change - node.finer_contact_change;
    const NodeVelocity now = grid_->Velocity(one.node);
    for (int axis = 0; axis < grid_->Geometry().dim; ++axis)
      now.velocity[axis] -= expected[axis], now.change[axis] -= expected[axis];
    node.impulse = {};
  }
}

/// The blended nodes near the indenter. Where it is alone decides, so that ranks, and runs that go on, find the same ones.
void Level::FindFollowing(Vec3 tip)
{
  const double moved = Norm(tip - blended_tip_);
  blended_tip_ = tip;
  blended_off_.resize(coupled_places_.blended.size(), -HUGE_VAL);
  following_.clear();
  for (std::size_t k = 0; k < blended_off_.size(); ++k) {
    const Index node = coupled_places_.blended[k];
    if ((blended_off_[k] -= moved) > coupled_places_.reach) continue;
    const Vec3 x{grid_->Coordinate(0, node[0]), grid_->Coordinate(1, node[1]), grid_->Coordinate(2, node[2])};
    const std::ptrdiff_t place = grid_->Place(node);
    blended_off_[k] = model_.indenter->Gap(x, tip).distance;
    if (!light_.IsLight(place) && blended_off_[k] < coupled_places_.reach) following_.push_back(place);
  }
}

SurfaceInputs Level::SurfaceNow() { return {*grid_, model_.geometry, surface_, points_, bodies_, *model_.indenter}; }

PetscErrorCode Level::FindContactPressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(points_.Count(), 0.0);
  if (ContactActive() && group_.Participates()) PetscCall(contact_->PressuresOnPoints(SurfaceNow(), tip, pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::FindSurfacePressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->clear();
  if (ContactActive() && group_.Participates()) PetscCall(contact_->PressuresOnPatches(SurfaceNow(), tip, pressures));
  pressures->resize(surface_.Patches().size());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::ApplyContact(TimeStep step, const TipStep &tip)
{
  const Indenter &indenter = *model_.indenter;
  ContactReport report;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.contact, 0, 0, 0, 0));
  const NodeMotion nodes(*grid_, geometry_.sides, light_, nodal_.mass_cutoff, group_, border_, shared_);
  PetscCall(contact_->Apply(SurfaceNow(), nodes, {step.time, step.dt, tip}, &report));
  reaches_coarser_level_ = reaches_coarser_level_ || report.may_reach_coarser_level;
  contact_nodes_.insert(contact_nodes_.end(), report.contact_nodes.begin(), report.contact_nodes.end());
  tip_ = {report.travel, report.limited, -report.impulse[indenter.up] / step.dt, report.half_width, report.reach};
  if (!report.solved && failure_.kind == LevelFailure::kNone) failure_ = {LevelFailure::kContact, {}, step.time};
  contact_clearance_ = report.clearance;
  surface_motion_.SetPressed(report.columns);
  touched_ = true;
  contact_tip_ = tip.end;
  RecordContact(report, RankIn(group_.Comm()) == 0 ? report.area : 0);
  budgets_.penetration = std::max<double>(budgets_.penetration, report.penetration);
  budgets_.contact_cells = std::max<double>(budgets_.contact_cells, report.half_width / grid_->Geometry().spacing);
  budgets_.penetration_cells = std::max<double>(budgets_.penetration_cells, report.penetration / grid_->Geometry().spacing);
  budgets_.contact_impulse += report.impulse;
  budgets_.support_impulse += report.side_impulse;
  budgets_.indenter_work += Dot(report.impulse, tip.end - tip.start + indenter.Up(-report.travel)) / step.dt;
  budgets_.friction_impulse += report.friction_impulse;
  budgets_.friction_work += report.friction_work;
  budgets_.contact_steps += report.set_updates > 0;
  budgets_.contact_set_updates += report.set_updates;
  PetscCall(PetscLogEventEnd(events_.contact, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Finds how corners of the surface will move, before the points do.
PetscErrorCode Level::PrepareSurface()
{
  PetscFunctionBeginUser;
  if (!model_.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.surface, 0, 0, 0, 0));
  if (ContactActive())
    PetscCall(surface_motion_.Prepare(*grid_, surface_, bodies_, points_, drift_path_ * geometry_.grid.spacing));
  else
    surface_motion_.PrepareFar(surface_);
  strain_under_.Clear();
  if (touched_ && model_.HasMetal()) strain_under_.Begin(SurfaceNow(), contact_tip_);
  PetscCall(PetscLogEventEnd(events_.surface, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// rates: points that do not average their volume are strained by the second velocity.
PetscErrorCode Level::MoveSurface(bool rates, double dt)
{
  std::vector<char> by_rates;
  double work = 0;
  PetscFunctionBeginUser;
  if (!model_.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.surface, 0, 0, 0, 0));
  for (const int average : bodies_.average) by_rates.push_back(rates && average < 0);
  PetscCall(surface_motion_.Finish(*grid_, geometry_.sides, points_.Arrays(), by_rates, nodal_.mass_cutoff, dt, &surface_));
  PetscCall(PetscLogEventEnd(events_.surface, 0, 0, 0, 0));
  if (!touched_ || !model_.HasMetal()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.contact, 0, 0, 0, 0));
  PetscCall(contact_->Flow(strain_under_.End(points_.Arrays()), &surface_, &work));
  budgets_.contact_plastic_work += work;
  PetscCall(PetscLogEventEnd(events_.contact, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
