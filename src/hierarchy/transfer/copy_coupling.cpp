// The coupling by copies: the first ones, their renewal, and the momentum that they lose.
#include "hierarchy/transfer/copy_coupling.hpp"

#include <cmath>

namespace mlgimp
{

PetscErrorCode CopyCoupling::Add(Level &coarse, Level &fine, int ghost_cells)
{
  PetscFunctionBeginUser;
  if (levels_.empty()) levels_.push_back(&coarse);
  levels_.push_back(&fine);
  borders_.push_back(std::make_unique<CopyBorder>());
  PetscCall(borders_.back()->Create(comm_, coarse, fine, ratio_, repairs_, {ghost_cells}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyCoupling::Begin(double dt)
{
  PetscFunctionBeginUser;
  if (state_.ready) PetscFunctionReturn(PETSC_SUCCESS);
  for (std::size_t b = 0; b < borders_.size(); ++b) PetscCall(borders_[b]->Exchange(dt / std::pow(ratio_, b)));
  PetscCall(MeasureMomentum(&state_.momentum_left));
  state_.ready = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyCoupling::DecideByPlace(int l)
{
  PetscFunctionBeginUser;
  if (!repairs_.owner_flags) PetscCall(borders_[l]->DecideByPlace());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Momentum of all points less the impulses since the start.
PetscErrorCode CopyCoupling::MeasureMomentum(Vec3 *left) const
{
  *left = {};
  PetscFunctionBeginUser;
  for (Level *level : levels_) {
    const Budgets &budgets = level->Totals();
    const PointArrays a = level->PointStore().Arrays();
    for (int p = 0; p < a.count; ++p) *left = *left + a.mass[p] * a.Velocity(p);
    *left = *left - budgets.support_impulse - budgets.xpic_side_impulse - budgets.gravity_impulse - budgets.load_impulse -
            budgets.damping_impulse - budgets.contact_impulse;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, left->data(), 3, MPI_DOUBLE, MPI_SUM, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyCoupling::Finish()
{
  Vec3 left;
  double mass = 0;
  PetscFunctionBeginUser;
  if (!repairs_.momentum_correction) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeasureMomentum(&left));
  for (auto &border : borders_) mass += border->RingMass();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mass, 1, MPI_DOUBLE, MPI_SUM, comm_));
  if (mass == 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (auto &border : borders_) border->CorrectMomentum((1 / mass) * (state_.momentum_left - left));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
