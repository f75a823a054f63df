// The way of a free tip, over levels and ranks.
#include "hierarchy/tip_track.hpp"

#include <algorithm>
#include <cmath>
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
  if (!IsFree()) return indenter_->Tip(time - clock_.delay);
  return indenter_->tip - indenter_->Up(travel_ + speed_ * (time - time_)) + indenter_->Sideways(time);
}

double TipTrack::Load(TimeStep step) const
{
  return indenter_->by_load->Mean(step.time - clock_.delay, step.End() - clock_.delay) + clock_.more_load;
}

double TipTrack::OnOtherLevels() const
{
  return std::accumulate(load_on_other_levels_.begin(), load_on_other_levels_.end(), 0.0);
}

double TipTrack::Deflection(double time) const
{
  if (!IsFree()) return 0;
  return indenter_->by_load ? deflection_ : Driven(time) - travel_ - speed_ * (time - time_);
}

double TipTrack::SpringEnergy(double time) const
{
  const double deflection = Deflection(time);
  return deflection == 0 ? 0 : 0.5 * deflection * deflection / indenter_->compliance.At(radius_);
}

TipStep TipTrack::Step(int l, Vec3 start, TimeStep step) const
{
  if (!IsFree() || l != tip_level_) return {start, At(step.End()), {}};
  const double most = indenter_->largest_speed * step.dt, others = OnOtherLevels();
  const Vec3 sideways = indenter_->Sideways(step.End()) - indenter_->Sideways(step.time);
  if (indenter_->by_load) return {start, start + sideways, LoadInStep{std::max(0.0, Load(step) - others), most}};
  const double stiffness = 1 / indenter_->compliance.At(radius_);
  return {start, start + sideways, LoadInStep{stiffness * (Driven(step.End()) - travel_) - others, most, stiffness}};
}

/// After a step: the way that what gives way has taken under load control, and the radius that it knows in the next.
void TipTrack::Stretch(const TipReport &tip, TimeStep step)
{
  const IndenterCompliance &compliance = indenter_->compliance;
  const double known = std::max(radius_, compliance.least), found = std::max(tip.half_width, compliance.least);
  const double width = compliance.narrows ? found : std::max(found, known);
  if (indenter_->by_load) deflection_ = tip.limited ? 0 : compliance.At(radius_) * Load(step);
  radius_ = width + (known - width) * std::exp(-compliance.wave_speed * step.dt / (2 * width));
}

PetscErrorCode TipTrack::Follow(MPI_Comm comm, int l, const LevelContact &contact, TimeStep step)
{
  TipReport tip = contact.Tip();
  PetscFunctionBeginUser;
  if (!IsFree()) PetscFunctionReturn(PETSC_SUCCESS);
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
  if (indenter_->compliance.Any()) Stretch(tip, step);
  PetscFunctionReturn(PETSC_SUCCESS);
}

double TipTrack::Reach(double time, double dt, int steps) const
{
  double reach = 0; // the whole way: it may turn
  for (int k = 0; k < steps && indenter_; ++k) {
    const double from = time + k * dt, to = time + (k + 1) * dt;
    reach += Norm(IsFree() ? indenter_->Sideways(to) - indenter_->Sideways(from) : At(to) - At(from));
  }
  return IsFree() ? reach + steps * dt * indenter_->largest_speed : reach;
}

std::vector<double> TipTrack::State() const
{
  std::vector<double> state;
  if (!IsFree()) return state;
  state = {time_, travel_, speed_, overrun_, radius_, deflection_};
  state.insert(state.end(), load_on_other_levels_.begin(), load_on_other_levels_.end());
  return state;
}

void TipTrack::SetState(const std::vector<double> &state)
{
  if (!IsFree()) return;
  time_ = state[0], travel_ = state[1], speed_ = state[2], overrun_ = state[3];
  radius_ = state[4], deflection_ = state[5];
  std::copy(state.begin() + 6, state.end(), load_on_other_levels_.begin());
}

} // namespace mlgimp
