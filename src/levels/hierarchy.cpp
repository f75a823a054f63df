// Recursion over levels, reductions over ranks, and balance.
#include "levels/hierarchy.hpp"

#include "levels/balance.hpp"

#include <algorithm>
#include <string>

namespace mlgimp
{

/// The log stage of a level, which hierarchies created one after the other share.
static PetscErrorCode LevelStage(int l, PetscLogStage *stage)
{
  const std::string name = "level " + std::to_string(l);
  PetscFunctionBeginUser;
  PetscCall(PetscLogStageGetId(name.c_str(), stage));
  if (*stage < 0) PetscCall(PetscLogStageRegister(name.c_str(), stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings,
                                 const LogEvents &events, bool fill)
{
  std::int64_t first_id = 0;
  PetscMPIInt ranks;
  PetscFunctionBeginUser;
  comm_ = comm;
  model_ = &model;
  settings_ = settings;
  events_ = events;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  levels_.resize(settings.levels.size());
  for (int l = 0; l < Levels(); ++l) {
    const LevelGeometry &geometry = settings.levels[l];
    const Seeding seeding(model, geometry.grid, geometry.sides, [](Vec2) { return true; }, first_id);
    GridLayout layout;
    PetscCheck(MakeLayout(ranks, seeding.CountByNode(0), seeding.CountByNode(1), &layout), comm, PETSC_ERR_USER_INPUT,
               "-cell_size %.12g: must leave at least %d nodes for each rank in some direction; there are %d x %d cells for %d ranks",
               geometry.grid.spacing, kHaloWidth, geometry.grid.cells[0], geometry.grid.cells[1], ranks);
    PetscCall(LevelStage(l, &stages_.emplace_back()));
    PetscCall(CreateLevel(l, layout));
    if (fill) PetscCall(seeding.Fill(levels_[l]->Mesh(), levels_[l]->PointStore()));
    first_id = seeding.EndId();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::CreateLevel(int l, const GridLayout &layout)
{
  PetscFunctionBeginUser;
  levels_[l] = std::make_unique<Level>(*model_, events_);
  PetscCall(levels_[l]->Create(comm_, settings_.levels[l], layout));
  levels_[l]->SetSortInterval(settings_.sort_interval);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Advance(double time, double dt)
{
  PetscFunctionBeginUser;
  PetscCall(AdvanceLevel(0, time, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::AdvanceLevel(int l, double time, double dt)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogStagePush(stages_[l]));
  PetscCall(levels_[l]->Step(time, dt));
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::MeasurePulse(Pulse *pulse)
{
  double values[3] = {};
  PetscFunctionBeginUser;
  for (auto &level : levels_) {
    double wave = 0, point = 0;
    PetscCall(level->LargestSpeeds(&wave, &point));
    values[0] = std::max(values[0], wave);
    values[1] = std::max(values[1], point);
    if (level->Failure().kind != LevelFailure::kNone) values[2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 3, MPI_DOUBLE, MPI_MAX, comm_));
  *pulse = {values[0], values[1], values[2] > 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Adapt(const Pulse &pulse, double dt)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    double total = 0, largest = 0;
    PetscMPIInt ranks;
    PetscCallMPI(MPI_Comm_size(comm_, &ranks));
    PetscCall(PointsOn(l, &total, &largest));
    if (largest * ranks > settings_.rebalance_threshold * total) PetscCall(Rebalance(l));
    levels_[l]->PlanMigration(pulse.point_speed, dt);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::PointsOn(int l, double *total, double *largest)
{
  const double mine = levels_[l]->PointStore().Count();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(&mine, total, 1, MPI_DOUBLE, MPI_SUM, comm_));
  PetscCallMPI(MPI_Allreduce(&mine, largest, 1, MPI_DOUBLE, MPI_MAX, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::Rebalance(int l)
{
  GridLayout layout;
  bool changed = false;
  PetscFunctionBeginUser;
  PetscCall(ProposeLayout(*levels_[l], &layout, &changed));
  if (changed) PetscCall(levels_[l]->Recut(layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// This rank's share of the books.
static PetscErrorCode LocalBooks(Level &level, Books *b)
{
  PointTally tally;
  PetscFunctionBeginUser;
  PetscCall(level.Tally(&tally));
  const NodalTotals &nodal = level.Nodal();
  const SweepTotals &sweeps = level.Sweeps();
  const ContactTotals &contact = level.Contacts();
  b->kinetic_energy += tally.kinetic_energy;
  b->strain_energy += tally.strain_energy;
  b->mass += tally.mass;
  b->points += tally.count;
  b->contact_points += contact.last.local_points;
  b->short_wave_dissipation += sweeps.short_wave_dissipation;
  b->plastic_dissipation += sweeps.plastic_dissipation;
  b->xpic_dissipation += sweeps.xpic_dissipation;
  b->clamped_sizes += static_cast<double>(sweeps.clamped_sizes);
  b->damping_dissipation += nodal.damping_dissipation;
  b->external_work += nodal.external_work;
  b->indenter_work += contact.indenter_work;
  b->contact_steps += contact.steps;
  b->contact_set_updates += contact.set_updates;
  b->contact_fallbacks += contact.fallbacks;
  for (int d = 0; d < 2; ++d) {
    b->momentum[d] += tally.momentum[d];
    b->support_impulse[d] += nodal.support_impulse[d];
    b->contact_impulse[d] += contact.impulse[d];
    b->load_impulse[d] += nodal.load_impulse[d];
    b->gravity_impulse[d] += nodal.gravity_impulse[d];
    b->damping_impulse[d] += nodal.damping_impulse[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::ReduceBooks(Books *books)
{
  static_assert(sizeof(Books) % sizeof(double) == 0, "books are reduced as an array of doubles");
  PetscFunctionBeginUser;
  *books = {};
  for (auto &level : levels_) PetscCall(LocalBooks(*level, books));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, books, sizeof(Books) / sizeof(double), MPI_DOUBLE, MPI_SUM, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::RestoreBooks(const Books &b)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  if (rank != 0) PetscFunctionReturn(PETSC_SUCCESS);
  NodalTotals &nodal = levels_[0]->Nodal();
  SweepTotals &sweeps = levels_[0]->Sweeps();
  ContactTotals &contact = levels_[0]->Contacts();
  sweeps = {b.short_wave_dissipation, b.plastic_dissipation, b.xpic_dissipation, static_cast<long>(b.clamped_sizes)};
  nodal = {{b.support_impulse[0], b.support_impulse[1]},
           {b.gravity_impulse[0], b.gravity_impulse[1]},
           {b.load_impulse[0], b.load_impulse[1]},
           {b.damping_impulse[0], b.damping_impulse[1]},
           b.external_work,
           b.damping_dissipation};
  contact.impulse = {b.contact_impulse[0], b.contact_impulse[1]};
  contact.indenter_work = b.indenter_work;
  contact.steps = b.contact_steps;
  contact.set_updates = b.contact_set_updates;
  contact.fallbacks = b.contact_fallbacks;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static std::string Describe(const LevelFailure &failure, int l)
{
  char text[400];
  const PointFailure &point = failure.point;
  const char *what = "", *advice = "";
  if (failure.kind == LevelFailure::kContact) {
    std::snprintf(text, sizeof text,
                  "time %.6e, level %d: the contact solve did not converge; try -contact_ksp_monitor, a larger "
                  "-contact_ksp_max_it or another -contact_ksp_type", failure.time, l);
    return text;
  }
  switch (point.kind) {
  case PointFailure::kLeftGrid:
    what = "left the grid";
    advice = "a larger domain, or sides that hold the body";
    break;
  case PointFailure::kDeformedTooFast:
    what = "deforms by more than a quarter in one step";
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
