// What a level does with contact in a step, and what it adds up of it.
#include "level/level.hpp"

#include "contact/body.hpp"
#include "contact/segments.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// The contact as it is now; area: this rank's part.
void Level::NoteContact(const ContactReport &report, double area)
{
  budgets_.contact_points = report.local_points;
  budgets_.contact_half_width = report.half_width;
  budgets_.contact_axes = model_.geometry.kind == GeometryKind::kPlaneStrain ? 1 : 2;
  budgets_.contact_width_power = area > 0 ? std::pow(report.half_width, budgets_.contact_axes) : 0;
  budgets_.peak_pressure = report.peak_pressure;
  budgets_.contact_area = area;
  budgets_.contact_strain_energy = report.stored;
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
    const double mass = grid_->Sums()[one.node].mass + node.finer_mass;
    if (mass <= nodal_.mass_cutoff) node = {}; // the last point has left
    const Vec3 expected = node.impulse == Vec3{} ? Vec3{} : 1 / mass * node.impulse, by = node.finer_push - expected;
    if (by != Vec3{}) pushed_.push_back({one.node, by});
    one.change = one.change - node.finer_push;
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

ContactView Level::ViewOfContact(double time, double dt, const TipStep &tip)
{
  return {*grid_, group_, points_, surface_, bodies_, geometry_.sides, *model_.indenter, model_.geometry, nodal_.mass_cutoff,
          time,   dt,     tip,     border_,  shared_, &light_};
}

PetscErrorCode Level::FindContactPressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->assign(points_.Count(), 0.0);
  if (ContactAwake() && group_.Participates())
    PetscCall(contact_->PressuresOnPoints(ViewOfContact(time_, 0, {tip, tip}), pressures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::FindSurfacePressures(Vec3 tip, std::vector<double> *pressures)
{
  PetscFunctionBeginUser;
  pressures->clear();
  if (ContactAwake() && group_.Participates())
    PetscCall(contact_->PressuresOnPatches(ViewOfContact(time_, 0, {tip, tip}), pressures));
  pressures->resize(surface_.Patches().size());
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
  for (const PressedColumn &one : report.columns) pressed_around_[one.key] = one.share;
  flows_ = model_.HasMetal();
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
  PetscCall(PetscLogEventEnd(events_.contact, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The part of the motion of a place of the surface that goes with the nodes: where contact presses they are in balance with the
/// forces in the body on any line of nodes, and points are not; in bodies that flow where it presses all around, as the crest
/// beside a steep tip, where few points are, runs away with them.
double Level::HeldByContact(Vec3 x, double distance, bool flows)
{
  constexpr double kLeast = 0.25, kFade = 0.25; // share of the surface; cells off the indenter
  double share = 0;
  if (pressed_around_.empty()) return 0;
  const double off = distance / (kFade * geometry_.grid.spacing);
  if (off >= 1 || !flows) return 1 - SmoothStep(off);
  const ContactView view = ViewOfContact(time_, 0, {contact_tip_, contact_tip_});
  ForEachColumn(view, Locate(*grid_, x, geometry_.grid.dim), [&](std::int64_t key, Index, double hat) {
    if (const auto found = pressed_around_.find(key); found != pressed_around_.end()) share += hat * found->second;
  });
  return SmoothStep((share - kLeast) / (1 - kLeast)) * (1 - SmoothStep(off));
}

void Level::SplitSurface(Vec3 tip)
{
  // Cells: longer than a point's face, than half of it, and than a quarter: where segments come into contact row by row, each
  // is a step of the load; in space, where there are many, that counts while the contact is small.
  constexpr double kFar = 0.55, kNear = 0.375, kTouching = 0.19, kTouch = 0.95, kSmall = 2;
  const int dim = geometry_.grid.dim;
  const double h = geometry_.grid.spacing;
  surface_.Split(model_.geometry, [&](const SurfacePatch &patch) {
    const Vec3 center = patch.Center(dim);
    const double off = model_.indenter->Gap(center, tip).distance / h;
    const bool beside = dim == 3 && std::hypot(center[0] - tip[0], center[1] - tip[1]) > kSmall * h;
    return h * (off > kPointRange ? kFar : off > kTouch || beside ? kNear : kTouching);
  });
}

/// Finds how corners of the surface will move, before the points do.
PetscErrorCode Level::PrepareSurface()
{
  std::vector<NearPoints::Place> places;
  PetscFunctionBeginUser;
  if (!model_.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.surface, 0, 0, 0, 0));
  const double range = kContactRange * geometry_.grid.spacing; // no segment is beyond it, and nodes and points move alike
  corners_.clear();
  for (const SurfaceCorner &corner : surface_.Corners()) {
    corners_.push_back({1, {}});
    if (!ContactAwake() || corner.gap.distance > range) continue;
    const bool flows = bodies_.material[corner.body]->IsMetal();
    corners_.back().by_nodes = HeldByContact(corner.x, corner.gap.distance, flows);
    if (corners_.back().by_nodes < 1) places.push_back({corner.x, corner.body});
  }
  if (ContactAwake()) PetscCall(near_.Begin(*grid_, places, points_, drift_path_ * geometry_.grid.spacing));
  PetscCall(PetscLogEventEnd(events_.surface, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// rates: points that do not average their volume are strained by the second velocity.
PetscErrorCode Level::MoveSurface(bool rates, double dt)
{
  std::vector<NearPoints::Sum> sums;
  std::vector<char> by_rates;
  PetscFunctionBeginUser;
  if (!model_.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.surface, 0, 0, 0, 0));
  for (std::size_t body = 0; body < model_.bodies.size(); ++body)
    by_rates.push_back(rates && bodies_.average[body] < 0);
  if (ContactAwake()) PetscCall(near_.Finish(*grid_, points_.Arrays(), &sums));
  auto next = sums.begin();
  for (Surface::CornerMotion &corner : corners_)
    if (corner.by_nodes < 1) corner.sums = *next++;
  surface_.Move(*grid_, geometry_.sides, by_rates, corners_, nodal_.mass_cutoff, dt);
  PetscCall(PetscLogEventEnd(events_.surface, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The plastic strains of the points of the surface near the indenter, and under which columns they lie, before the step's
/// strain.
void Level::NoteStrains()
{
  flowing_.clear(), under_columns_.clear();
  if (!flows_) return;
  const ContactView view = ViewOfContact(time_, 0, {contact_tip_, contact_tip_});
  const PointArrays points = points_.Arrays();
  for (const int p : points_.SurfacePoints()) {
    if (FarFromIndenter(view, points.Position(p)) || !bodies_.Of(points, p).IsMetal()) continue;
    flowing_.push_back({p, points.history[PointArrays::At(p, points.history_components)]});
    ForEachColumn(view, Locate(*grid_, points.Position(p), points.dim), [&](std::int64_t key, Index, double hat) {
      under_columns_.push_back({key, 0, hat * points.mass[p]});
    });
  }
}

/// Tells contact what they have flowed since.
PetscErrorCode Level::LetSurfaceFlow(double dt)
{
  double work = 0;
  PetscFunctionBeginUser;
  if (!flows_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.contact, 0, 0, 0, 0));
  const PointArrays points = points_.Arrays();
  const std::size_t columns = 1U << (points.dim - 1);
  for (std::size_t k = 0; k < flowing_.size(); ++k) {
    const double by = points.history[PointArrays::At(flowing_[k].first, points.history_components)] - flowing_[k].second;
    for (std::size_t c = k * columns; c < (k + 1) * columns; ++c) under_columns_[c].strain = by * under_columns_[c].weight;
  }
  PetscCall(contact_->Flow(ViewOfContact(time_, dt, {contact_tip_, contact_tip_}), under_columns_, &surface_, &work));
  budgets_.contact_plastic_work += work;
  PetscCall(PetscLogEventEnd(events_.contact, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
