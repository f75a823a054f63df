// Coulomb friction in the active-set loop: a semi-smooth Newton method for pressures and tractions together.
//
// With d the diagonal of a column's tractions, y = d tau - s and b = d mu lambda, friction is tau = y/d where |y| <= b, which is
// stick, and tau = mu lambda y/|y| beyond, which is slip. Rows of columns that stick are those of A. With e = y/|y| and the share
// b/|y| of the last solution, T = I - e e^T, slip is, without its terms of second order,
//   d (I - share T) tau - d mu e lambda + share T (A x - r - u c) = 0.
// In the plane T = 0: the states of a set decide everything. In space |tau| <= mu lambda is a circle.
#include "level/contact/active_set.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// T_ab of a column.
double Across(const SlipState &state, int a, int b) { return (a == b ? 1.0 : 0.0) - state.direction[a] * state.direction[b]; }

/// The diagonal of a column's tractions: one for both axes, so that a circle stays one.
double Stiffness(const PetscScalar *diagonal, PetscInt row, int tractions)
{
  return tractions == 1 ? diagonal[row + 1] : std::max(diagonal[row + 1], diagonal[row + 2]);
}

/// State of a column whose traction times the stiffness would be y if it could be anything.
SlipState StateOf(const double y[2], int tractions, double bound)
{
  const double size = tractions == 1 ? std::abs(y[0]) : std::hypot(y[0], y[1]);
  SlipState state;
  if (!(size > bound)) return state;
  state = {true, {y[0] / size, tractions == 1 ? 0 : y[1] / size}, bound / size};
  return state;
}

/// True where two states give equations that differ by more than the square of what matters.
bool Differs(const SlipState &a, const SlipState &b, int tractions)
{
  constexpr double kSmall = 1e-8;
  double change = tractions == 1 ? 0 : std::abs(a.share - b.share);
  for (int k = 0; k < 2; ++k) change = std::max(change, std::abs(a.direction[k] - b.direction[k]));
  return a.slips != b.slips || change > kSmall;
}

} // namespace

/// The states that previous tractions leave: what has none sticks.
PetscErrorCode ActiveSetSolver::StartFriction()
{
  constexpr double kAtBound = 1 - 1e-6;
  PetscFunctionBeginUser;
  slips_.assign(size_ / (1 + tractions_), {});
  PetscCall(WithNumbers({lambda_, active_}, [&](const PetscScalar *values, PetscScalar *active) {
    for (PetscInt k = 0; k < size_; k += 1 + tractions_) {
      const double tau[2] = {values[k + 1], tractions_ > 1 ? values[k + 2] : 0}, bound = kAtBound * friction_ * values[k];
      for (int a = 1; a <= tractions_; ++a) active[k + a] = active[k];
      if (values[k] > 0) slips_[k / (1 + tractions_)] = StateOf(tau, tractions_, bound);
      slips_[k / (1 + tractions_)].share = 0; // the direction is known, not how firm it is
    }
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The matrix of the columns in their states. Those that are open stay as zeros.
PetscErrorCode ActiveSetSolver::SetFrictionPart()
{
  const PetscScalar *diagonal;
  PetscScalar *active;
  PetscInt first;
  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(A_, &first, nullptr));
  PetscCall(MatZeroEntries(active_part_));
  PetscCall(VecGetArrayRead(diagonal_, &diagonal));
  PetscCall(VecGetArray(active_, &active));
  for (PetscInt k = 0; k < size_; ++k) {
    const PetscInt pressure = k - k % (1 + tractions_), row = first + k;
    const int a = static_cast<int>(k - pressure) - 1;
    const SlipState &state = slips_[k / (1 + tractions_)];
    active[k] = active[pressure];
    if (active[k] == 0) {
      PetscCall(MatSetValue(active_part_, row, row, diagonal[k], ADD_VALUES));
    } else if (a < 0 || !state.slips) {
      PetscCall(AddRow(row, row, 1));
    } else {
      const double d = Stiffness(diagonal, pressure, tractions_);
      PetscCall(MatSetValue(active_part_, row, first + pressure, -d * friction_ * state.direction[a], ADD_VALUES));
      for (int b = 0; b < tractions_; ++b) {
        const double across = state.share * Across(state, a, b);
        PetscCall(MatSetValue(active_part_, row, first + pressure + 1 + b, d * ((a == b) - across), ADD_VALUES));
        if (across != 0) PetscCall(AddRow(first + pressure + 1 + b, row, across));
      }
    }
  }
  PetscCall(VecRestoreArray(active_, &active));
  PetscCall(VecRestoreArrayRead(diagonal_, &diagonal));
  PetscCall(MatAssemblyBegin(active_part_, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(active_part_, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds a row of A times a factor to a row of the active part.
PetscErrorCode ActiveSetSolver::AddRow(PetscInt from, PetscInt to, double factor)
{
  PetscInt count;
  const PetscInt *columns;
  const PetscScalar *values;
  PetscFunctionBeginUser;
  PetscCall(MatGetRow(A_, from, &count, &columns, &values));
  std::vector<PetscScalar> scaled(values, values + count);
  for (PetscScalar &value : scaled) value *= factor;
  PetscCall(MatSetValues(active_part_, 1, &to, count, columns, scaled.data(), ADD_VALUES));
  PetscCall(MatRestoreRow(A_, from, &count, &columns, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the rows of columns that slip have of a right side: share T of it.
PetscErrorCode ActiveSetSolver::ProjectSlips(Vec right_side, Vec projected)
{
  PetscFunctionBeginUser;
  PetscCall(WithNumbers({right_side, projected}, [&](const PetscScalar *from, PetscScalar *to) {
    for (PetscInt k = 0; k < size_; ++k) {
      const SlipState &state = slips_[k / (1 + tractions_)];
      const PetscInt pressure = k - k % (1 + tractions_);
      if (IsPressure(k) || !state.slips || to[pressure] == 0) continue;
      to[k] = 0;
      for (int b = 0; b < tractions_; ++b)
        to[k] += state.share * Across(state, static_cast<int>(k - pressure) - 1, b) * from[pressure + 1 + b];
    }
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Columns open and close as without friction; those that are closed stick or slip.
PetscErrorCode ActiveSetSolver::UpdateFriction(int *changed)
{
  PetscFunctionBeginUser;
  PetscCall(FindSlack());
  *changed = 0;
  const auto update = [&](PetscScalar *active, const PetscScalar *x, const PetscScalar *slack, const PetscScalar *diagonal) {
    for (PetscInt k = 0; k < size_; k += 1 + tractions_) {
      const PetscScalar now = active[k] != 0 ? x[k] > 0 : slack[k] < 0;
      const double d = Stiffness(diagonal, k, tractions_),
                   y[2] = {d * x[k + 1] - slack[k + 1], tractions_ > 1 ? d * x[k + 2] - slack[k + 2] : 0};
      SlipState &state = slips_[k / (1 + tractions_)];
      const double bound = std::isinf(friction_) ? friction_ : d * friction_ * std::max(x[k], 0.0);
      const SlipState next = now != 0 ? StateOf(y, tractions_, bound) : SlipState();
      *changed = *changed || now != active[k] || Differs(next, state, tractions_);
      active[k] = now;
      state = next;
    }
  };
  PetscCall(WithNumbers({active_, lambda_, work_, diagonal_}, update));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, changed, 1, MPI_INT, MPI_MAX, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tractions as large as friction allows at most, beside pressures that are not negative; and the heat that slipping makes.
PetscErrorCode ActiveSetSolver::SettleFriction(ActiveSetReport *report)
{
  constexpr double kAtBound = 1 - 1e-6;
  PetscScalar carried = 0;
  PetscFunctionBeginUser;
  PetscCall(WithNumbers({lambda_}, [&](PetscScalar *x) {
    for (PetscInt k = 0; k < size_; k += 1 + tractions_) {
      const double bound = x[k] > 0 ? friction_ * x[k] : 0,
                   size = tractions_ == 1 ? std::abs(x[k + 1]) : std::hypot(x[k + 1], x[k + 2]);
      for (int a = 1; a <= tractions_; ++a)
        if (size > kAtBound * bound) x[k + a] *= bound / size;
      x[k] = std::max(x[k], 0.0);
    }
  }));
  if (report->fallback && travels_) PetscCall(VecDot(c_, lambda_, &carried));
  if (carried > 0) PetscCall(VecScale(lambda_, load_ / carried));
  PetscCall(FindSlack());
  PetscCall(WithNumbers({lambda_, work_}, [&](const PetscScalar *x, const PetscScalar *slip) {
    for (PetscInt k = 0; k < size_; k += 1 + tractions_) {
      double squares = 0, work = 0;
      for (int a = 1; a <= tractions_; ++a) squares += x[k + a] * x[k + a], work -= x[k + a] * slip[k + a] / scale_;
      if (std::sqrt(squares) >= kAtBound * friction_ * x[k]) report->heat += std::max(work, 0.0); // else it sticks
    }
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
