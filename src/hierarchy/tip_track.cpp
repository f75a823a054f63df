// The tip's way under load control, over levels and ranks.
#include "hierarchy/tip_track.hpp"

#include <algorithm>
#include <numeric>

namespace mlgimp
{

void TipTrack::Create(const Indenter *indenter, int tip_level, int levels)
{
  indenter_ = indenter;
  tip_level_ = tip_level;
  load_on_other_levels_.assign(levels, 0.0);
}

void TipTrack::SetLevel(int tip_level)
{
  tip_level_ = tip_level;
  std::fill(load_on_other_levels_.begin(), load_on_other_levels_.end(), 0.0);
}

Vec3 TipTrack::At(double time) const
{
  if (!indenter_) return {};
  if (!IsByLoad()) return indenter_->Tip(time - clock_.delay);
  return indenter_->tip - indenter_->Up(travel_ + speed_ * (time - time_)) + indenter_->Sideways(time);
}

double TipTrack::Load(TimeStep step) const
{
  return indenter_->by_load->force.Mean(step.time - clock_.delay, step.End() - clock_.delay) + clock_.more_load;
}

TipStep TipTrack::Step(int l, Vec3 start, TimeStep step) const
{
  if (!IsByLoad() || l != tip_level_) return {start, At(step.End()), {}};
  const double others = std::accumulate(load_on_other_levels_.begin(), load_on_other_levels_.end(), 0.0);
  const double load = std::max(0.0, Load(step) - others);
  const Vec3 sideways = indenter_->Sideways(step.End()) - indenter_->Sideways(step.time);
  return {start, start + sideways, LoadInStep{load, indenter_->by_load->largest_speed * step.dt}};
}

PetscErrorCode TipTrack::Follow(MPI_Comm comm, int l, const LevelContact &contact, TimeStep step)
{
  TipReport tip = contact.Tip();
  PetscFunctionBeginUser;
  if (!IsByLoad()) PetscFunctionReturn(PETSC_SUCCESS);
  if (l != tip_level_) {
    load_on_other_levels_[l] = tip.load;
    if (contact.IsActive()) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &load_on_other_levels_[l], 1, MPI_DOUBLE, MPI_SUM, comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (contact.Group().Size() < RanksOf(comm)) PetscCallMPI(MPI_Bcast(&tip, sizeof tip, MPI_BYTE, contact.Group().Root(), comm));
  travel_ += tip.travel;
  speed_ = tip.travel / step.dt;
  time_ = step.End();
  overrun_ = tip.limited && tip.travel > 0 ? overrun_ + tip.travel : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

double TipTrack::Reach(double time, double dt, int steps) const
{
  double reach = 0; // the whole way: it may turn
  for (int k = 0; k < steps && indenter_; ++k) {
    const double from = time + k * dt, to = time + (k + 1) * dt;
    reach += Norm(IsByLoad() ? indenter_->Sideways(to) - indenter_->Sideways(from) : At(to) - At(from));
  }
  return IsByLoad() ? reach + steps * dt * indenter_->by_load->largest_speed : reach;
}

std::vector<double> TipTrack::State() const
{
  std::vector<double> state;
  if (!IsByLoad()) return state;
  state = {time_, travel_, speed_, overrun_};
  state.insert(state.end(), load_on_other_levels_.begin(), load_on_other_levels_.end());
  return state;
}

void TipTrack::SetState(const std::vector<double> &state)
{
  if (!IsByLoad()) return;
  time_ = state[0], travel_ = state[1], speed_ = state[2], overrun_ = state[3];
  std::copy(state.begin() + 4, state.end(), load_on_other_levels_.begin());
}

} // namespace mlgimp
