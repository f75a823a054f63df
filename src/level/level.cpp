// One explicit step of a level, as a list of its verbs.
#include "level/level.hpp"

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

PetscErrorCode Level::Create(MPI_Comm world, const LevelGeometry &geometry, const GridLayout &layout)
{
  double density = HUGE_VAL;
  PetscFunctionBeginUser;
  geometry_ = geometry;
  world_ = world;
  for (const auto &material : model_.materials) density = std::min(density, material->Density());
  settings_.nodal = model_.nodal;
  settings_.nodal.second_extrapolation = model_.stress_update == StressUpdate::kMusl;
  const double h = geometry.grid.spacing;
  settings_.nodal.full_mass = density * (geometry.grid.dim == 3 ? h * h * h : h * h * model_.geometry.OutOfPlane(h));
  settings_.nodal.mass_cutoff = kEmptyNode * settings_.nodal.full_mass;
  PetscCall(CreateGrid(layout));
  for (Points *store : {&stores_.own, &stores_.copies[0], &stores_.copies[1]})
    PetscCall(store->Create(grid_->Nodes().PointsComm(), model_.geometry.kind, static_cast<int>(model_.loads.size()),
                            model_.HistoryComponents()));
  sweeps_.kernels = CreateKernels(model_.geometry.kind, model_.shape_function);
  PetscCall(contact_.Create(model_));
  PetscCall(contact_.Regroup(*grid_));
  sweeps_.bodies = model_.Table();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::CreateGrid(const GridLayout &layout)
{
  auto grid = std::make_unique<Grid>();
  PetscFunctionBeginUser;
  PetscCall(grid->Create(world_, geometry_.grid, layout, model_.VolumeAverages()));
  for (const Side side : kAllSides)
    if (geometry_.sides.kind[side] == BoundaryKind::kSymmetry) grid->EndPointsAt(side, geometry_.sides.node[side]);
  grid->WidenThinPoints(model_.LeastHalfSize());
  grid_ = std::move(grid);
  SetCoupledPlaces({});
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Level::SetCoupledPlaces(CoupledPlaces places)
{
  coupled_.places = std::move(places);
  coupled_.following.Clear();
  if (!grid_->Participates()) return;
  std::vector<double> shares(grid_->Ghosted().Count(), 1.0);
  if (coupled_.coarser)
    ForEach(grid_->Ghosted(), [&](Index node) { shares[grid_->Place(node)] = coupled_.coarser->BlendOf(node).beta; });
  for (const std::ptrdiff_t place : coupled_.places.interface) shares[place] = LightNodes::kWithFiner;
  light_.Create(*grid_, geometry_.sides, settings_.nodal, model_.geometry.HasHoop(), std::move(shares));
}

void Level::RecordFailure(const PointFailure &failure, double time)
{
  if (failure.kind != PointFailure::kNone && step_.failure.kind == LevelFailure::kNone)
    step_.failure = {LevelFailure::kPoint, failure, time};
}

template <class Sweep> PetscErrorCode Level::ForEachStore(double flops, Sweep sweep)
{
  Points *const stores[3] = {&stores_.own, &stores_.copies[0], &stores_.copies[1]};
  PetscFunctionBeginUser;
  for (int k = 0; k < 3; ++k) {
    const bool owned = k == 0;
    PointFailure failure;
    Budgets discarded;
    if (!owned && stores[k]->Count() == 0) continue;
    const PointArrays points = stores[k]->Arrays();
    sweep(SweepView{*grid_, points, sweeps_.bodies, owned}, owned ? budgets_ : discarded, failure);
    if (owned) RecordFailure(failure, step_.time);
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
  AddLoads(*grid_, stores_.own, true, model_.loads, model_.geometry, time, step_.applied, failure);
  for (Points &copies : stores_.copies)
    AddLoads(*grid_, copies, false, model_.loads, model_.geometry, time, step_.applied, failure);
  RecordFailure(failure, time);
  PetscCall(PetscLogEventEnd(events_.points_to_grid, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Finds light nodes from the sums of points, and gives theirs to those that they hang on.
PetscErrorCode Level::FindLightNodes()
{
  PetscFunctionBeginUser;
  PetscCall(node_bodies_.Find(*grid_, {stores_.own.Arrays(), stores_.copies[0].Arrays(), stores_.copies[1].Arrays()}));
  light_.Find(*grid_, node_bodies_, coupled_.finer_masses);
  PetscCall(light_.Restrict(grid_->Halo(), &grid_->Sums()->mass, NodeLayout::kSums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::GatherForces(TimeStep step)
{
  PetscFunctionBeginUser;
  budgets_.noise_energy = 0; // also on a rank that has lost its part of the grid
  settings_.nodal.gravity = model_.gravity_share.Value(step.time) * model_.nodal.gravity;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  step_.time = step.time;
  if (model_.stress_update == StressUpdate::kUsf) PetscCall(StrainBeforeForces(step.dt));
  PetscCall(PointsToGrid(step.time));
  budgets_.hoop_impulse += step.dt * budgets_.hoop_force;
  PetscCall(PetscLogEventBegin(events_.halo, 0, 0, 0, 0));
  PetscCall(grid_->ShareSums());
  AddLoadImpulse(*grid_, step_.applied, settings_.nodal.mass_cutoff, step.dt, budgets_);
  PetscCall(FindLightNodes());
  PetscCall(PetscLogEventEnd(events_.halo, 0, 0, 0, 0));
  if (settings_.measures_noise) budgets_.noise_energy = NoiseEnergy();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::UpdateNodes(double dt)
{
  const Flops flops(model_.geometry.Dim());
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.grid_update, 0, 0, 0, 0));
  UpdateVelocities(*grid_, settings_.nodal, dt);
  PetscCall(PetscLogFlops(flops.node * static_cast<double>(grid_->Owned().Count())));
  PetscCall(PetscLogEventEnd(events_.grid_update, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::FinishNodes(TimeStep step, const TipStep &tip)
{
  PetscFunctionBeginUser;
  contact_.Begin(tip, clock_.drift_per_step * geometry_.grid.spacing);
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  RecordCoupling(*grid_, settings_.nodal, step.dt, coupled_.nodes);
  ApplyBoundaryConditions(*grid_, geometry_.sides, settings_.nodal, &step_.held_nodes, budgets_);
  if (contact_.Exists()) coupled_.following.Find(grid_->Nodes(), coupled_.places, light_, *model_.indenter, tip.start);
  PetscCall(contact_.Solve(Site(), step, tip, &coupled_.nodes));
  if (contact_.HasFailed() && step_.failure.kind == LevelFailure::kNone) step_.failure = {LevelFailure::kContact, {}, step.time};
  if (coupled_.on || contact_.IsActive()) PetscCall(Timed(events_.halo, [&] { return grid_->BroadcastVelocity(); }));
  if (settings_.nodal.HasBodyForces()) AddBodyWork(*grid_, settings_.nodal, step.dt, budgets_);
  const int components = NodeLayout::Velocity(model_.geometry.Dim());
  PetscCall(Timed(events_.halo, [&] { return light_.Prolong(grid_->Halo(), grid_->Arrays().VelocityArray(), components); }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::StrainBeforeForces(double dt)
{
  const Flops flops(model_.geometry.Dim());
  const RatesPlan plan = {dt, true, {}, 0, false};
  PetscFunctionBeginUser;
  PetscCall(PointsToGrid(step_.time));
  PetscCall(Timed(events_.halo, [&] { return grid_->ShareSums(); }));
  PetscCall(FindLightNodes());
  VelocitiesFromSums(*grid_, geometry_.sides, settings_.nodal);
  PetscCall(light_.Prolong(grid_->Halo(), grid_->Arrays().RatesArray(), NodeLayout::Rates(model_.geometry.Dim())));
  PetscCall(PetscLogEventBegin(events_.grid_to_points, 0, 0, 0, 0));
  PetscCall(ForEachStore(flops.gather_rates + flops.stress, [&](const SweepView &view, Budgets &budgets, PointFailure &failure) {
    sweeps_.kernels->ApplyRates(view, plan, budgets, failure);
  }));
  PetscCall(PetscLogEventEnd(events_.grid_to_points, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// rates: momenta after the step are in the grid's rates.
PetscErrorCode Level::AddWorkOfLoads(bool rates, double dt)
{
  PetscFunctionBeginUser;
  if (model_.loads.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<double> motion = MeanMotion(*grid_, rates, settings_.nodal.mass_cutoff);
  PetscCall(light_.Prolong(grid_->Halo(), motion.data(), model_.geometry.Dim()));
  AddLoadWork(*grid_, step_.applied, motion, dt, budgets_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::ExchangeRates(double dt, double xpic)
{
  const Flops flops(model_.geometry.Dim());
  const SecondVelocityPlan plan = {coupled_.places.held, coupled_.following.Places(), xpic,
                                   coupled_.on || model_.VolumeAverages() > 0};
  const int components = NodeLayout::Rates(model_.geometry.Dim());
  PetscFunctionBeginUser;
  const std::map<std::ptrdiff_t, double> ahead = AdvanceContactNodes(*grid_, contact_.Changes(), light_);
  PetscCall(Timed(events_.halo, [&] { return grid_->ShareRates(xpic > 0, model_.short_wave.On()); }));
  PetscCall(Timed(events_.halo, [&] { return light_.Restrict(grid_->Halo(), grid_->Arrays().RatesArray(), components); }));
  PetscCall(PetscLogEventBegin(events_.grid_update, 0, 0, 0, 0));
  budgets_.contact_work += WorkOnPoints(*grid_, contact_.Changes(), true, ahead);
  PetscCall(AddWorkOfLoads(true, dt));
  if (plan.exchange) AddExchange(*grid_, dt, coupled_.nodes, step_.held_nodes, ahead, budgets_);
  DivideRates(*grid_, geometry_.sides, settings_.nodal, dt, plan, budgets_);
  PetscCall(Timed(events_.halo, [&] { return light_.Prolong(grid_->Halo(), grid_->Arrays().RatesArray(), components); }));
  FinishRates(*grid_, settings_.nodal, plan);
  PetscCall(PetscLogFlops(flops.rates * static_cast<double>(grid_->Owned().Count())));
  PetscCall(PetscLogEventEnd(events_.grid_update, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::AdvancePoints(double dt)
{
  const Flops flops(model_.geometry.Dim());
  // The weights must not change within a step, so F advances in its last sweep.
  const bool rates = model_.UsesRates() || coupled_.on, strain = model_.stress_update != StressUpdate::kUsf;
  const double xpic = settings_.xpic.InStep(clock_.steps);
  const double damped = settings_.nodal.xpic_fraction > 0 ? 0 : settings_.nodal.damping * dt; // XPIC takes that motion by itself
  const GridToPointsPlan first = {dt, strain && !rates, model_.short_wave.On(), rates, xpic > 0, !rates, damped};
  const RatesPlan second = {dt, strain, model_.short_wave, xpic, true};
  const double first_flops = flops.grid_to_points + rates * flops.scatter_rates + first.strain * flops.stress;
  const double second_flops = flops.gather_rates + second.strain * flops.stress + second.short_wave.On() * flops.short_wave;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  if (model_.indenter) PetscCall(contact_.PrepareSurface(Site(), step_.drift_path * geometry_.grid.spacing));
  PetscCall(PetscLogEventBegin(events_.grid_to_points, 0, 0, 0, 0));
  if (rates) grid_->Arrays().ClearRates();
  PetscCall(ForEachStore(first_flops, [&](const SweepView &view, Budgets &budgets, PointFailure &failure) {
    sweeps_.kernels->GridToPoints(view, first, budgets, failure);
  }));
  PetscCall(PetscLogEventEnd(events_.grid_to_points, 0, 0, 0, 0));
  if (!rates) {
    budgets_.contact_work += WorkOnPoints(*grid_, contact_.Changes(), false, {});
    PetscCall(AddWorkOfLoads(false, dt));
    if (model_.indenter) PetscCall(contact_.MoveSurface(Site(), false, dt));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ExchangeRates(dt, xpic));
  PetscCall(PetscLogEventBegin(events_.grid_to_points, 0, 0, 0, 0));
  PetscCall(ForEachStore(second_flops, [&](const SweepView &view, Budgets &budgets, PointFailure &failure) {
    sweeps_.kernels->ApplyRates(view, second, budgets, failure);
  }));
  PetscCall(PetscLogEventEnd(events_.grid_to_points, 0, 0, 0, 0));
  if (model_.indenter) PetscCall(contact_.MoveSurface(Site(), true, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::EndStep()
{
  PetscFunctionBeginUser;
  constexpr double kMaxDrift = 0.9; // cells; the halo has room for one
  ++clock_.steps;
  clock_.drift += clock_.drift_per_step, step_.drift_path += clock_.drift_per_step;
  const bool due = clock_.drift + clock_.drift_per_step > kMaxDrift;
  if (due) clock_.drift = 0; // on ranks without a part of the grid too, so that all ranks have the same value
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  if (due) PetscCall(Migrate());
  if (clock_.steps % settings_.sort_interval == 0) PetscCall(Sort());
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Level::BoundDrift(double largest_speed, double dt)
{
  // Speeds may double before they are measured again, and a body at rest may be set in motion.
  constexpr double kSafety = 2, kSurprise = 0.02; // -, cells a step
  clock_.drift_per_step = std::max(kSafety * largest_speed * dt / grid_->Geometry().spacing, kSurprise);
}

PetscErrorCode Level::SmoothTensors(const std::vector<int> &points, std::vector<double> *tensors)
{
  const std::size_t nodes = grid_->Ghosted().Count();
  PetscFunctionBeginUser;
  tensors->resize(8 * points.size());
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  grid_->Arrays().ClearRates();
  grid_->Arrays().ClearSums();
  PetscCall(ForEachStore(0, [&](const SweepView &view, Budgets &, PointFailure &) {
    Budgets discarded;
    sweeps_.kernels->ScatterTensors(view);
    sweeps_.kernels->PointsToGrid(view, {}, 0, discarded);
  }));
  PetscCall(grid_->ShareRates(true, true));
  PetscCall(grid_->ShareSums());
  for (std::size_t node = 0; node < nodes; ++node) {
    const double mass = std::max(grid_->Sums()[node].mass, settings_.nodal.mass_cutoff);
    for (int c = 0; c < NodeLayout::Rates(2); ++c) grid_->Rates(static_cast<std::ptrdiff_t>(node))[c] /= mass;
  }
  const PointArrays arrays = stores_.own.Arrays();
  for (std::size_t k = 0; k < points.size(); ++k)
    sweeps_.kernels->TensorsAt({*grid_, arrays, sweeps_.bodies}, points[k], &(*tensors)[8 * k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
