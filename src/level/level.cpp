// Grids and layouts of a level, and its explicit step as a list of verbs.
#include "level/level.hpp"

#include "grid/strain_rates.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

void PlaceSides(const Model &model, LevelGeometry *level)
{
  for (const Side side : SidesOf{level->grid.dim}) {
    level->sides.kind[side] = level->border[side] ? BoundaryKind::kFree : model.sides[side];
    level->sides.node[side] = SignOf(side) < 0 ? 0 : level->grid.cells[AxisOf(side)];
  }
}

/// What nodes hold that are full of the lightest material, and what is too little to count.
static NodalSettings NodalSettingsOf(const Model &model, double h)
{
  NodalSettings nodal = model.nodal;
  double density = HUGE_VAL;
  for (const auto &material : model.materials) density = std::min(density, material->Density());
  nodal.full_mass = density * (model.geometry.Dim() == 3 ? h * h * h : h * h * model.geometry.OutOfPlane(h));
  nodal.mass_cutoff = kEmptyNode * nodal.full_mass;
  return nodal;
}

PetscErrorCode Level::Create(MPI_Comm world, const LevelGeometry &geometry, const GridLayout &layout,
                             const LevelSettings &settings)
{
  PetscFunctionBeginUser;
  world_ = world;
  geometry_ = geometry;
  settings_ = settings;
  nodal_ = NodalSettingsOf(model_, geometry.grid.spacing);
  sweeps_ = {CreateKernels(model_.geometry.kind, model_.shape_function), model_.Table()};
  node_bodies_.SetGroups(settings.body_groups);
  PetscCall(CreateGrid(layout));
  PetscCall(stores_.Create(world, model_, *grid_, geometry_.PointNodes()));
  PetscCall(contact_.Create(model_));
  PetscCall(contact_.Regroup(world, *grid_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::CreateGrid(const GridLayout &layout)
{
  auto grid = std::make_unique<Grid>();
  PetscFunctionBeginUser;
  PetscCall(grid->Create(world_, geometry_.grid, layout, model_.VolumeAverages(), model_.short_wave.On()));
  for (const Side side : kAllSides)
    if (geometry_.sides.kind[side] == BoundaryKind::kSymmetry) grid->EndPointsAt(side, geometry_.sides.node[side]);
  grid->WidenThinPoints(model_.LeastHalfSize());
  grid_ = std::move(grid);
  Couple({}); // until it is coupled anew
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Level::Couple(CoupledLevel coupled)
{
  coupled_ = std::move(coupled);
  if (!grid_->Participates()) return;
  std::vector<double> shares(grid_->Ghosted().Count(), 1.0);
  if (coupled_.coarser)
    ForEach(grid_->Ghosted(), [&](Index node) { shares[grid_->Place(node)] = coupled_.coarser->BlendOf(node).beta; });
  for (const std::ptrdiff_t place : coupled_.places.interface) shares[place] = LightNodes::kWithFiner;
  light_.Create(*grid_, geometry_.sides, nodal_, model_.geometry.HasHoop(), std::move(shares));
}

PetscErrorCode Level::Repartition(const GridLayout &layout)
{
  PetscFunctionBeginUser;
  PetscCall(CreateGrid(layout));
  PetscCall(contact_.Regroup(world_, *grid_));
  PetscCall(stores_.Redistribute(*grid_, geometry_.PointNodes()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::Move(const LevelGeometry &geometry, const GridLayout &layout)
{
  PetscFunctionBeginUser;
  geometry_ = geometry;
  PetscCall(Repartition(layout));
  contact_.SetPressures({}); // of columns that are others now
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::SetActive(bool active)
{
  PetscFunctionBeginUser;
  if (active) {
    stores_.Drift().per_step = PointDrift().per_step;
    PetscCall(contact_.Watch(world_, *grid_, true, kAllNodes));
  } else {
    contact_.Deactivate();
    budgets_.noise_energy = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::View(const std::string &prefix, double time)
{
  PetscBool nodes = PETSC_FALSE;
  const Budgets before = budgets_;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(stores_.Own().View(prefix));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &nodes));
  if (nodes) {
    PetscCall(PointsToGrid(time));
    PetscCall(grid_->ShareSums());
    budgets_ = before;
  }
  PetscCall(grid_->View(prefix, nodal_.mass_cutoff));
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <class Sweep> PetscErrorCode Level::ForEachStore(double flops, Sweep sweep)
{
  PetscFunctionBeginUser;
  for (Points *store : stores_.All()) {
    const bool owned = store == &stores_.Own();
    PointFailure failure;
    Budgets discarded;
    if (!owned && store->Count() == 0) continue;
    const PointArrays points = store->Arrays();
    sweep(SweepView{*grid_, points, sweeps_.bodies, owned}, owned ? budgets_ : discarded, failure);
    if (owned) step_.Record(failure);
    PetscCall(PetscLogFlops(flops * points.count));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::PointsToGrid(double time)
{
  const Flops flops(model_.geometry.Dim());
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.points_to_grid, 0, 0, 0, 0));
  grid_->Arrays().ClearSums();
  step_.applied.clear();
  PetscCall(ForEachStore(flops.points_to_grid, [&](const SweepView &view, Budgets &budgets, PointFailure &) {
    sweeps_.kernels->PointsToGrid(view, model_.acceleration, time, budgets);
  }));
  PointFailure failure;
  for (Points *store : stores_.All())
    AddLoads(*grid_, *store, store == &stores_.Own(), model_.loads, model_.geometry, time, step_.applied, failure);
  step_.Record(failure);
  PetscCall(PetscLogEventEnd(events_.points_to_grid, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Finds light nodes from the sums of points, and gives theirs to those that they hang on.
PetscErrorCode Level::FindLightNodes()
{
  PetscFunctionBeginUser;
  PetscCall(node_bodies_.Find(*grid_, {stores_.Own().Arrays(), stores_.Copies(0).Arrays(), stores_.Copies(1).Arrays()}));
  light_.Find(*grid_, node_bodies_, coupled_.finer_masses);
  PetscCall(light_.Restrict(grid_->Halo(), &grid_->Sums()->mass, NodeLayout::kSums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of points, J.
static double KineticEnergy(const PointArrays &points)
{
  const double *const velocity = points.velocity, *const mass = points.mass;
  double energy = 0;
  for (int axis = 0; axis < points.dim; ++axis)
#pragma omp simd reduction(+ : energy)
    for (int p = 0; p < points.count; ++p)
      energy += 0.5 * mass[p] * velocity[points.dim * p + axis] * velocity[points.dim * p + axis];
  return energy;
}

PetscErrorCode Level::GatherForces(TimeStep step)
{
  PetscFunctionBeginUser;
  budgets_.noise_energy = 0; // also on a rank that has lost its part of the grid
  nodal_.gravity = model_.gravity_share.Value(step.time) * model_.nodal.gravity;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  step_.time = step.time, step_.scale = step.scale;
  if (model_.stress_update == StressUpdate::kUsf) PetscCall(StrainBeforeForces(step.dt));
  PetscCall(PointsToGrid(step.time));
  budgets_.hoop_impulse += step.dt * budgets_.hoop_force;
  PetscCall(PetscLogEventBegin(events_.halo, 0, 0, 0, 0));
  PetscCall(grid_->ShareSums());
  AddLoadImpulse(*grid_, step_.applied, nodal_.mass_cutoff, step.dt, budgets_);
  PetscCall(FindLightNodes());
  PetscCall(PetscLogEventEnd(events_.halo, 0, 0, 0, 0));
  if (step_.measures_noise && step.last)
    budgets_.noise_energy = KineticEnergy(stores_.Own().Arrays()) - KineticEnergy(*grid_, nodal_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::UpdateNodes(double dt)
{
  const Flops flops(model_.geometry.Dim());
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.grid_update, 0, 0, 0, 0));
  UpdateVelocities(*grid_, nodal_, dt);
  PetscCall(PetscLogFlops(flops.node * static_cast<double>(grid_->Owned().Count())));
  PetscCall(PetscLogEventEnd(events_.grid_update, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::FinishNodes(TimeStep step, const TipStep &tip)
{
  PetscFunctionBeginUser;
  contact_.Begin(tip, stores_.Drift().per_step * geometry_.grid.spacing);
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  ApplyBoundaryConditions(*grid_, geometry_.sides, nodal_, budgets_);
  if (model_.HasContact()) coupled_.following.Find(grid_->Nodes(), coupled_.places, light_, *model_.indenter, tip.start);
  PetscCall(contact_.Solve(Parts(), step, tip, &coupled_));
  if (coupled_.on || contact_.IsActive()) PetscCall(Timed(events_.halo, [&] { return grid_->BroadcastVelocity(); }));
  if (nodal_.HasBodyForces()) AddBodyWork(*grid_, nodal_, step.dt, budgets_);
  const int components = NodeLayout::Velocity(model_.geometry.Dim());
  PetscCall(Timed(events_.halo, [&] { return light_.Prolong(grid_->Halo(), grid_->Arrays().VelocityArray(), components); }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::StrainBeforeForces(double dt)
{
  GridToPointsPlan plan = {dt, step_.scale};
  PetscFunctionBeginUser;
  plan.second_velocity = true;
  plan.change_velocity = plan.move = false;
  PetscCall(PointsToGrid(step_.time));
  PetscCall(Timed(events_.halo, [&] { return grid_->ShareSums(); }));
  PetscCall(FindLightNodes());
  VelocitiesFromSums(*grid_, geometry_.sides, nodal_);
  PetscCall(light_.Prolong(grid_->Halo(), grid_->Arrays().RatesArray(), NodeLayout::Rates(model_.geometry.Dim())));
  PetscCall(GridToPoints(plan));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::GridToPoints(const GridToPointsPlan &plan)
{
  const Flops flops(model_.geometry.Dim());
  const LogScope log(events_.grid_to_points);
  PetscFunctionBeginUser;
  PetscCall(ForEachStore(flops.grid_to_points + plan.strain * flops.stress + plan.short_wave.On() * flops.short_wave,
                         [&](const SweepView &view, Budgets &budgets, PointFailure &failure) {
                           sweeps_.kernels->GridToPoints(view, plan, budgets, failure);
                         }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::AddWorkOfLoads(const SpreadPlan &spread)
{
  PetscFunctionBeginUser;
  if (model_.loads.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<double> motion = MeanMotion(*grid_, nodal_.mass_cutoff, spread.momentum);
  PetscCall(light_.Prolong(grid_->Halo(), motion.data(), model_.geometry.Dim()));
  AddLoadWork(*grid_, step_.applied, motion, spread.dt, budgets_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::SpreadChange(const SpreadPlan &plan)
{
  const Flops flops(model_.geometry.Dim());
  const int dim = model_.geometry.Dim(), shared = plan.project ? NodeLayout::Projected(dim) + dim : plan.momentum ? dim : 0;
  PetscFunctionBeginUser;
  if (!plan.momentum && model_.VolumeAverages() == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Timed(events_.grid_to_points, [&] {
    return ForEachStore(flops.spread_change, [&](const SweepView &view, Budgets &budgets, PointFailure &) {
      sweeps_.kernels->SpreadChange(view, plan, budgets);
    });
  }));
  if (model_.HasSecondVelocity()) step_.ahead = AdvanceContactNodes(*grid_, contact_.Changes(), light_);
  PetscCall(Timed(events_.halo, [&] { return grid_->ShareRates(shared); }));
  if (!plan.momentum) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      Timed(events_.halo, [&] { return light_.Restrict(grid_->Halo(), grid_->Arrays().RatesArray(), NodeLayout::Rates(dim)); }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::FindRates(const SpreadPlan &spread, double xpic)
{
  const Flops flops(model_.geometry.Dim());
  const SecondVelocityPlan plan = {coupled_.places.held, coupled_.following.Places(), xpic};
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.grid_update, 0, 0, 0, 0));
  budgets_.contact_work += WorkOnPoints(*grid_, contact_.Changes(), step_.ahead, spread.momentum);
  PetscCall(AddWorkOfLoads(spread));
  if (spread.momentum) {
    DivideRates(*grid_, geometry_.sides, nodal_, plan, budgets_);
    PetscCall(Timed(events_.halo, [&] {
      return light_.Prolong(grid_->Halo(), grid_->Arrays().RatesArray(), NodeLayout::Rates(model_.geometry.Dim()));
    }));
    FinishRates(*grid_, nodal_, plan);
  }
  if (model_.short_wave.On()) FindStrainRates(*grid_, model_.geometry.HasHoop());
  PetscCall(PetscLogFlops(flops.rates * static_cast<double>(grid_->Owned().Count())));
  PetscCall(PetscLogEventEnd(events_.grid_update, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::AdvancePoints(double dt)
{
  const double xpic = settings_.xpic.InStep(step_.taken);
  const double damped = nodal_.xpic_fraction > 0 ? 0 : nodal_.damping * dt; // XPIC takes that motion by itself
  const bool second = model_.HasSecondVelocity();
  const bool counts_energy = coupled_.on || model_.VolumeAverages() > 0;
  const SpreadPlan spread = {dt, second || xpic > 0, xpic > 0, {damped, counts_energy}};
  GridToPointsPlan plan = {dt, step_.scale};
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  if (model_.indenter) PetscCall(contact_.PrepareSurface(Parts(), stores_.Drift().path * geometry_.grid.spacing));
  step_.ahead.clear();
  if (spread.momentum || counts_energy) grid_->Arrays().ClearRates();
  PetscCall(SpreadChange(spread));
  PetscCall(FindRates(spread, xpic));
  plan.change_velocity = !spread.momentum;
  plan.second_velocity = second;
  plan.strain = model_.stress_update != StressUpdate::kUsf;
  plan.short_wave = model_.short_wave;
  plan.xpic_fraction = xpic;
  plan.velocity = spread.velocity;
  PetscCall(GridToPoints(plan));
  if (model_.indenter) PetscCall(contact_.MoveSurface(Parts(), second, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::EndStep()
{
  PetscFunctionBeginUser;
  ++step_.taken;
  const bool due = stores_.CountDrift();
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  if (due) PetscCall(stores_.Migrate());
  if (step_.taken % settings_.sort_interval == 0) PetscCall(stores_.Sort());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
