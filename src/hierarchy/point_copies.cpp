// Copies of points on neighbouring levels: who has some, and how they are renewed.
#include "hierarchy/point_copies.hpp"

#include "hierarchy/point_transfer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

PetscErrorCode PointCopies::Create(MPI_Comm world, Level &coarse, Level &fine, bool finer, const GhostWidths &widths)
{
  PetscFunctionBeginUser;
  world_ = world;
  from_ = finer ? &coarse : &fine;
  to_ = finer ? &fine : &coarse;
  origin_ = finer ? 0 : 1;
  const LevelGeometry &geometry = fine.Geometry();
  inner_ = finer ? WidenedBox(geometry, 0) : WidenedBox(geometry, -widths.inside * coarse.Geometry().grid.spacing);
  outer_ =
      finer ? WidenedBox(geometry, widths.outside * geometry.grid.spacing) : Box{{-HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL}};
  PetscCallMPI(MPI_Type_contiguous(StateSize(), MPI_DOUBLE, &unit_));
  PetscCallMPI(MPI_Type_commit(&unit_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PointCopies::~PointCopies()
{
  if (unit_ != MPI_DATATYPE_NULL) MPI_Type_free(&unit_);
}

/// Numbers of a point that change in a step: position, velocity, F, stress, short-wave stress, internal variables.
int PointCopies::StateSize() const { return 15 + from_->Physics().HistoryComponents(); }

/// The points to copy and the ranks they go to, ordered by rank.
PetscErrorCode PointCopies::FindSources(Migrants *found)
{
  PointArrays a;
  std::vector<std::pair<PetscMPIInt, int>> list;
  PetscFunctionBeginUser;
  PetscCall(from_->PointStore().Arrays(&a));
  for (int p = 0; p < a.count; ++p) {
    const Vec3 x = {a.position[2 * p], a.position[2 * p + 1]};
    if (!outer_.Contains(x) || inner_.Contains(x)) continue;
    list.emplace_back(to_->OwnerOf(a, p), p);
  }
  std::sort(list.begin(), list.end());
  for (const auto &[rank, p] : list) found->Add(p, rank);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointCopies::Renew(double step, double dt_shift, bool smooth)
{
  Migrants found;
  PetscFunctionBeginUser;
  PetscCall(FindSources(&found));
  int changed = found.points != sources_.points || found.ranks != sources_.ranks || from_->PointStore().Version() != version_ ||
                to_->CopyStore(origin_).Version() != copy_version_;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, world_));
  if (changed) {
    sources_ = std::move(found);
    PetscCall(Rebuild());
  }
  PetscCall(PackState(step, dt_shift, smooth));
  PetscCall(PetscSFBcastBegin(exchange_, unit_, state_.data(), copies_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(exchange_, unit_, state_.data(), copies_.data(), MPI_REPLACE));
  PetscCall(UnpackState());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointCopies::Rebuild()
{
  Points &copies = to_->CopyStore(origin_);
  std::vector<PetscSFNode> origins;
  PetscFunctionBeginUser;
  PetscCall(copies.Resize(0));
  PetscCall(CopyPoints(world_, from_->PointStore(), copies, sources_, &origins));
  PetscCall(PetscSFCreate(world_, exchange_.Out()));
  PetscCall(PetscSFSetGraph(exchange_, static_cast<PetscInt>(sources_.points.size()), static_cast<PetscInt>(origins.size()),
                            nullptr, PETSC_COPY_VALUES, origins.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(exchange_));
  version_ = from_->PointStore().Version();
  copy_version_ = copies.Version();
  state_.resize(sources_.points.size() * StateSize());
  copies_.resize(origins.size() * StateSize());
  ++rebuilds_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointCopies::PackState(double step, double dt_shift, bool smooth)
{
  const std::vector<int> &points = sources_.points;
  std::vector<Level::VelocitySample> samples;
  std::vector<double> tensors;
  PointArrays a;
  PetscFunctionBeginUser;
  if (dt_shift != 0) PetscCall(from_->SampleVelocity(points, &samples));
  if (smooth) PetscCall(from_->SmoothTensors(points, &tensors));
  PetscCall(from_->PointStore().Arrays(&a));
  double *next = state_.data();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int p = points[k];
    next = std::copy_n(a.position + 2 * p, 2, next);
    for (int d = 0; d < 2; ++d) *next++ = a.velocity[2 * p + d] + (dt_shift != 0 ? dt_shift / step * samples[k].change[d] : 0);
    next = std::copy_n(smooth ? &tensors[8 * k] : a.F + 4 * p, 4, next);
    next = std::copy_n(smooth ? &tensors[8 * k + 4] : a.stress + 4 * p, 4, next);
    next = std::copy_n(a.short_wave_stress + 3 * p, 3, next);
    if (a.history) next = std::copy_n(a.history + a.history_components * p, a.history_components, next);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointCopies::UnpackState()
{
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(to_->CopyStore(origin_).Arrays(&a));
  const double *next = copies_.data();
  auto take = [&next](double *to, int count) {
    std::copy_n(next, count, to);
    next += count;
  };
  for (int p = 0; p < a.count; ++p) {
    take(a.position + 2 * p, 2);
    take(a.velocity + 2 * p, 2);
    take(a.F + 4 * p, 4);
    take(a.stress + 4 * p, 4);
    take(a.short_wave_stress + 3 * p, 3);
    if (a.history) take(a.history + a.history_components * p, a.history_components);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, const CopyRepairs &repairs,
                                  const GhostWidths &widths)
{
  PetscFunctionBeginUser;
  coarse_ = &coarse;
  fine_ = &fine;
  ratio_ = ratio;
  repairs_ = repairs;
  PetscCall(to_fine_.Create(world, coarse, fine, true, widths));
  PetscCall(to_coarse_.Create(world, coarse, fine, false, widths));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::Exchange(double dt)
{
  const double fine_dt = dt / ratio_, shift = repairs_.velocity_shift ? 0.5 * (dt - fine_dt) : 0;
  PetscFunctionBeginUser;
  PetscCall(to_fine_.Renew(dt, shift, repairs_.strain_smoothing));
  PetscCall(to_coarse_.Renew(fine_dt, -shift, false));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Points of a store inside or outside a box.
static PetscErrorCode Select(Points &points, const Box &box, bool inside, std::vector<int> *list)
{
  PointArrays a;
  PetscFunctionBeginUser;
  PetscCall(points.Arrays(&a));
  for (int p = 0; p < a.count; ++p)
    if (box.Contains({a.position[2 * p], a.position[2 * p + 1]}) == inside) list->push_back(p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A level's own points on the wrong side go, its copies on the right side become its own.
static PetscErrorCode KeepByPlace(Level &level, int origin, const Box &box, bool inside)
{
  std::vector<int> wrong;
  Migrants right;
  PetscFunctionBeginUser;
  PetscCall(Select(level.PointStore(), box, !inside, &wrong));
  PetscCall(level.PointStore().Remove(wrong));
  PetscCall(Select(level.CopyStore(origin), box, inside, &right.points));
  right.ranks.assign(right.points.size(), 0);
  PetscCall(MovePoints(PETSC_COMM_SELF, level.CopyStore(origin), level.PointStore(), right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::DecideByPlace()
{
  const Box box = WidenedBox(fine_->Geometry(), 0);
  PetscFunctionBeginUser;
  PetscCall(KeepByPlace(*coarse_, 1, box, false));
  PetscCall(KeepByPlace(*fine_, 0, box, true));
  PetscCall(coarse_->Migrate(true));
  PetscCall(fine_->Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::CorrectMomentum(Vec3 dv)
{
  PetscFunctionBeginUser;
  for (PointCopies *copies : {&to_fine_, &to_coarse_}) {
    PointArrays a;
    PetscCall(copies->Owner().PointStore().Arrays(&a));
    for (int p : copies->Sources())
      for (int d = 0; d < 2; ++d) a.velocity[2 * p + d] += dv[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::RingMass(double *mass)
{
  PetscFunctionBeginUser;
  *mass = 0;
  for (PointCopies *copies : {&to_fine_, &to_coarse_}) {
    PointArrays a;
    PetscCall(copies->Owner().PointStore().Arrays(&a));
    for (int p : copies->Sources()) *mass += a.mass[p];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
