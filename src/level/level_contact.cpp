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
  budgets_.contact_coarseness = report.crosses;
}

void Level::Rest()
{
  NoteContact({}, 0);
  tip_ = {};
  budgets_.noise_energy = 0;
}

PetscErrorCode Level::WatchContact(bool within_reach, const IndexBox &zone)
{
  PetscFunctionBeginUser;
  LookForContact();
  clock_.contact_awake = within_reach;
  if (within_reach) clock_.contact_zone = zone;
  PetscCall(Regroup());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::Wake()
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
  LookForContact();
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
    const double mass = grid_->Sums()[one.node].mass + node.finer_mass, felt = 1 - LackOf(least_masses_[one.node], mass);
    if (mass <= nodal_.mass_cutoff) node = {}; // the last point has left
    const Vec3 expected = node.impulse == Vec3{} ? Vec3{} : 1 / mass * node.impulse, by = node.finer_push - expected;
    if (by != Vec3{}) pushed_.push_back({one.node, by});
    one.change = one.change - node.finer_push;
    const NodeVelocity now = grid_->Velocity(one.node);
    for (int axis = 0; axis < grid_->Geometry().dim; ++axis)
      now.velocity[axis] -= felt * expected[axis], now.change[axis] -= expected[axis];
    node.impulse = {};
  }
}

/// The blended nodes near the indenter. Where it is alone decides, so that ranks, and runs that go on, find the same ones.
void Level::FindFollowing(Vec3 tip)
{
  following_.clear();
  for (const Index node : coupled_places_.blended) {
    const Vec3 x{grid_->Coordinate(0, node[0]), grid_->Coordinate(1, node[1]), grid_->Coordinate(2, node[2])};
    if (model_.indenter->Gap(x, tip).distance < coupled_places_.reach) following_.push_back(grid_->Place(node));
  }
}

ContactView Level::ViewOfContact(double time, double dt, const TipStep &tip)
{
  return {*grid_, group_, points_, bodies_, geometry_.sides, *model_.indenter,     model_.geometry,      nodal_.mass_cutoff,
          time,   dt,     tip,     border_, shared_,         least_masses_.data(), later_masses_.data(), &nodal_};
}

PetscErrorCode Level::FindContactPressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(points_.Count(), 0.0);
  if (ContactAwake() && group_.Participates())
    PetscCall(contact_->PressuresOnPoints(ViewOfContact(time_, 0, {tip, tip}), pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::ApplyContact(double time, double dt, const TipStep &tip)
{
  const Indenter &indenter = *model_.indenter;
  ContactReport report;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.contact, 0, 0, 0, 0));
  const ContactView view = ViewOfContact(time, dt, tip);
  PetscCall(contact_->Apply(view, &report));
  pushes_beyond_ = pushes_beyond_ || report.at_border;
  pushed_.insert(pushed_.end(), report.pushed.begin(), report.pushed.end());
  tip_ = {report.travel, report.limited, -report.impulse[indenter.up] / dt, report.half_width, report.reach};
  if (!report.solved && failure_.kind == LevelFailure::kNone) failure_ = {LevelFailure::kContact, {}, time};
  contact_room_ = report.room;
  contact_tip_ = tip.end;
  NoteContact(report, RankIn(group_.Comm()) == 0 ? report.area : 0);
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
