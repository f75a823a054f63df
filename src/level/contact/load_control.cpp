// Active-set loop under load control: the indenter's travel u is one more unknown.
//
// With x1 and x2 the solutions of the active rows for r and c, u = (P - c . x1)/(c . x2) and lambda = x1 + u x2. It is the
// minimum of lambda . A lambda/2 - r . lambda under c . lambda = P, lambda >= 0, so there is one solution where A is positive
// definite.
#include "level/contact/active_set.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// The load and what pressures carry of it; the set keeps rows that can carry some.
PetscErrorCode ActiveSetSolver::SetLoad(const ComplementarityProblem &problem)
{
  PetscFunctionBeginUser;
  for (VecHandle *vector : {&c_, &r_at_rest_, &x1_, &x2_}) PetscCall(VecDuplicate(r_, vector->Out()));
  PetscCall(VecSet(x1_, 0)); // a restart has no other start
  PetscCall(VecSet(x2_, 0));
  PetscCall(VecCopy(r_, r_at_rest_));
  PetscCall(WithNumbers({c_, active_}, [&](PetscScalar *c, PetscScalar *active) {
    for (PetscInt k = 0; k < size_; ++k) {
      c[k] = problem.c[k];
      if (IsPressure(k) && !(c[k] > 0)) active[k] = 0;
    }
  }));
  load_ = problem.load;
  travel_ = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// r with the indenter where it comes to by some travel times the scale.
PetscErrorCode ActiveSetSolver::MoveTo(double travel)
{
  PetscFunctionBeginUser;
  travel_ = travel;
  PetscCall(VecWAXPY(r_, travel, c_, r_at_rest_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Moves the indenter, down or up, to where it touches the first row, and activates that. Where no row can carry a load it moves
/// to infinity.
PetscErrorCode ActiveSetSolver::FindTouch()
{
  PetscInt row = -1;
  struct {
    double ratio;
    int rank;
  } first = {-HUGE_VAL, RankIn(comm_)};
  PetscFunctionBeginUser;
  PetscCall(WithNumbers({c_, r_at_rest_}, [&](const PetscScalar *c, const PetscScalar *r) {
    for (PetscInt k = 0; k < size_; ++k)
      if (IsPressure(k) && c[k] > 0 && r[k] / c[k] > first.ratio) first.ratio = r[k] / c[k], row = k;
  }));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm_));
  PetscCall(WithNumbers({active_}, [&](PetscScalar *active) {
    if (first.rank == RankIn(comm_) && row >= 0) active[row] = 1;
  }));
  travel_ = -first.ratio;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ActiveSetSolver::SolveActiveByLoad(ActiveSetReport *report)
{
  PetscScalar at_rest, by_travel;
  PetscFunctionBeginUser;
  PetscCall(SolveActive(r_at_rest_, x1_, report));
  PetscCall(SolveActive(c_, x2_, report));
  PetscCall(VecDot(c_, x1_, &at_rest));
  PetscCall(VecDot(c_, x2_, &by_travel));
  // Friction that carries more than all the load, in a set that is not yet the right one, leaves the indenter where it was.
  if (by_travel > 0) PetscCall(MoveTo((load_ - at_rest) / by_travel));
  PetscCall(VecWAXPY(lambda_, travel_, x2_, x1_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Pressures that carry the load, or none where it is zero: then the indenter stays, or is lifted where the surface comes up. It
/// goes no farther than most_travel, and the pressures are what they are there.
PetscErrorCode ActiveSetSolver::FindSetByLoad(double most_travel, ActiveSetReport *report)
{
  PetscScalar active;
  PetscFunctionBeginUser;
  PetscCall(VecSum(active_, &active));
  travels_ = load_ > 0;
  if (active == 0 || !travels_) PetscCall(FindTouch());
  if (!travels_) {
    PetscCall(VecSet(active_, 0));
    PetscCall(VecSet(lambda_, 0));
    travel_ = std::min(travel_, 0.0);
  } else if (std::isfinite(travel_)) {
    PetscCall(FindSet(report));
  }
  report->limited = std::abs(travel_) > most_travel;
  if (report->limited) {
    travels_ = false;
    PetscCall(MoveTo(std::copysign(most_travel, travel_)));
    PetscCall(StartSet());
    PetscCall(VecSet(lambda_, 0)); // what a load out of reach would need is no start for the solver
    PetscCall(FindSet(report));
  }
  report->travel = report->solved ? travel_ / scale_ : 0; // a run that ends for it should not fall over numbers that are none
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SolveByRowSums with the travel u that meets the load: lambda_j = max(0, r_j + u c_j)/d_j. The load is a convex function of u
/// that rises, so Newton's method comes down to it from where all rows are active.
PetscErrorCode ActiveSetSolver::SolveByRowSumsAndLoad()
{
  constexpr int kMostIterations = 100;
  const PetscScalar *c, *r, *d;
  PetscScalar *lambda;
  double travel = HUGE_VAL;
  PetscFunctionBeginUser;
  PetscCall(MatGetRowSum(A_, work_));
  PetscCall(VecPointwiseMax(work_, work_, diagonal_));
  PetscCall(VecGetArrayRead(c_, &c));
  PetscCall(VecGetArrayRead(r_at_rest_, &r));
  PetscCall(VecGetArrayRead(work_, &d));
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    double sums[2] = {0, 0}; // of c r/d and c c/d over the rows under pressure
    for (PetscInt k = 0; k < size_; ++k)
      if (IsPressure(k) && c[k] > 0 && (std::isinf(travel) || r[k] + travel * c[k] > 0))
        sums[0] += c[k] * r[k] / d[k], sums[1] += c[k] * c[k] / d[k];
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, comm_));
    const double next = (load_ - sums[0]) / sums[1];
    if (!(next < travel)) break;
    travel = next;
  }
  PetscCall(VecGetArray(lambda_, &lambda));
  for (PetscInt k = 0; k < size_; ++k) {
    const double pushed = (r[k] + travel * c[k]) / d[k];
    lambda[k] = !IsPressure(k) ? pushed : c[k] > 0 ? std::max(0.0, pushed) : 0;
  }
  PetscCall(VecRestoreArray(lambda_, &lambda));
  PetscCall(VecRestoreArrayRead(work_, &d));
  PetscCall(VecRestoreArrayRead(r_at_rest_, &r));
  PetscCall(VecRestoreArrayRead(c_, &c));
  PetscCall(MoveTo(travel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
