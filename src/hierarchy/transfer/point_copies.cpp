// Copies of points on neighbouring levels: which ranks hold them, and how they are renewed.
#include "hierarchy/transfer/point_copies.hpp"

#include "hierarchy/transfer/point_transfer.hpp"
#include "level/samples.hpp"

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
  outer_ = finer ? WidenedBox(geometry, widths.outside * geometry.grid.spacing) : kEverywhere;
  PetscCall(unit_.Create(StateSize()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Numbers of a point that change in a step.
int PointCopies::StateSize() const
{
  int size = 0;
  for (const PointFieldInfo &field : from_->PointStore().Table()) size += field.evolves ? field.components : 0;
  return size;
}

/// The points to copy and the ranks they go to, ordered by rank.
Migrants PointCopies::FindSources()
{
  const PointArrays a = from_->PointStore().Arrays();
  std::vector<std::pair<PetscMPIInt, int>> list;
  Migrants found;
  for (int p = 0; p < a.count; ++p) {
    const Vec3 x = a.Position(p);
    if (outer_.Contains(x) && !inner_.Contains(x)) list.emplace_back(to_->Stores().OwnerOf(a, p), p);
  }
  std::sort(list.begin(), list.end());
  for (const auto &[rank, p] : list) found.Add(p, rank);
  return found;
}

PetscErrorCode PointCopies::Renew(double step, double dt_shift, bool smooth)
{
  Migrants found = FindSources();
  PetscFunctionBeginUser;
  int changed = found.points != sources_.points || found.ranks != sources_.ranks || from_->PointStore().Version() != version_ ||
                to_->Stores().Copies(origin_).Version() != copy_version_;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, world_));
  if (changed) {
    sources_ = std::move(found);
    PetscCall(Rebuild());
  }
  PetscCall(PackState(step, dt_shift, smooth));
  PetscCall(PetscSFBcastBegin(exchange_, unit_, state_.data(), copies_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(exchange_, unit_, state_.data(), copies_.data(), MPI_REPLACE));
  UnpackState();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointCopies::Rebuild()
{
  Points &copies = to_->Stores().Copies(origin_);
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Calls work(data, components, place) for each field that evolves, with its place in a point's state.
template <class Work> static void ForEachEvolving(Points &points, Work work)
{
  int place = 0;
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = points.Table()[k];
    const PointField which = static_cast<PointField>(k);
    if (!field.evolves || field.components == 0) continue;
    work(which, static_cast<double *>(points.Field(which)), field.components, place);
    place += field.components;
  }
}

PetscErrorCode PointCopies::PackState(double step, double dt_shift, bool smooth)
{
  const std::vector<int> &points = sources_.points;
  const int size = StateSize();
  std::vector<VelocitySample> samples;
  std::vector<double> tensors;
  PetscFunctionBeginUser;
  if (dt_shift != 0) samples = SampleVelocity(*from_, points);
  if (smooth) PetscCall(SmoothTensors(*from_, points, &tensors));
  ForEachEvolving(from_->PointStore(), [&](PointField field, const double *data, int components, int place) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      double *const to = &state_[size * k + place];
      const bool tensor = smooth && (field == kDeformation || field == kStress);
      std::copy_n(tensor ? &tensors[8 * k + (field == kStress ? 4 : 0)] : data + PointArrays::At(points[k], components),
                  components, to);
      for (int d = 0; field == kVelocity && dt_shift != 0 && d < components; ++d) to[d] += dt_shift / step * samples[k].change[d];
    }
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PointCopies::UnpackState()
{
  Points &copies = to_->Stores().Copies(origin_);
  const int size = StateSize();
  ForEachEvolving(copies, [&](PointField, double *data, int components, int place) {
    for (int p = 0; p < copies.Count(); ++p)
      std::copy_n(&copies_[static_cast<std::size_t>(size) * p + place], components, data + PointArrays::At(p, components));
  });
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
  const LogScope log(fine_->Parts().events.coupling);
  const double fine_dt = dt / ratio_, shift = repairs_.velocity_shift ? 0.5 * (dt - fine_dt) : 0;
  PetscFunctionBeginUser;
  PetscCall(to_fine_.Renew(dt, shift, repairs_.strain_smoothing));
  PetscCall(to_coarse_.Renew(fine_dt, -shift, false));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A level's own points on the wrong side go, its copies on the right side become its own.
static PetscErrorCode KeepByPlace(Level &level, int origin, const Box &box, bool inside)
{
  Migrants right;
  PetscFunctionBeginUser;
  level.PointStore().Remove(PointsIn(level.PointStore().Arrays(), box, !inside));
  right.points = PointsIn(level.Stores().Copies(origin).Arrays(), box, inside);
  right.ranks.assign(right.points.size(), 0);
  PetscCall(MovePoints(PETSC_COMM_SELF, level.Stores().Copies(origin), level.PointStore(), right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyBorder::DecideByPlace()
{
  const LogScope log(fine_->Parts().events.transfer);
  const Box box = WidenedBox(fine_->Geometry(), 0);
  PetscFunctionBeginUser;
  PetscCall(KeepByPlace(*coarse_, 1, box, false));
  PetscCall(KeepByPlace(*fine_, 0, box, true));
  PetscCall(coarse_->Stores().Migrate(true));
  PetscCall(fine_->Stores().Migrate(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void CopyBorder::CorrectMomentum(Vec3 dv)
{
  for (PointCopies *copies : {&to_fine_, &to_coarse_}) {
    const PointArrays a = copies->Owner().PointStore().Arrays();
    for (int p : copies->Sources())
      for (int d = 0; d < a.dim; ++d) a.velocity[PointArrays::At(p, a.dim) + d] += dv[d];
  }
}

double CopyBorder::RingMass()
{
  double mass = 0;
  for (PointCopies *copies : {&to_fine_, &to_coarse_}) {
    const PointArrays a = copies->Owner().PointStore().Arrays();
    for (int p : copies->Sources()) mass += a.mass[p];
  }
  return mass;
}

} // namespace mlgimp
