// Active-set loop for contact pressures.
#include "level/contact/active_set.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

static constexpr int kMaxSetUpdates = 20, kMaxFrictionUpdates = 40, kSlipIterations = 300;

PetscErrorCode ActiveSetSolver::Create(MPI_Comm comm, bool symmetric)
{
  PC pc;
  PetscFunctionBeginUser;
  comm_ = comm;
  PetscCall(KSPCreate(comm, ksp_.Out()));
  PetscCall(KSPSetOptionsPrefix(ksp_, "contact_"));
  PetscCall(KSPSetType(ksp_, symmetric ? KSPCG : KSPGMRES));
  if (!symmetric) PetscCall(ExpectSlip());
  PetscCall(KSPGetPC(ksp_, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  // The residual of the first guess may be any times the right side: a contact that lets go leaves a load near zero.
  PetscCall(KSPSetTolerances(ksp_, 1e-10, PETSC_CURRENT, PETSC_MAX_REAL, PETSC_CURRENT));
  PetscCall(KSPSetInitialGuessNonzero(ksp_, PETSC_TRUE));
  PetscCall(KSPSetFromOptions(ksp_));
  PetscCall(KSPMINRESSetRadius(ksp_, PETSC_MAX_REAL)); // pressures in Pa are beyond what it allows by itself
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Slip makes the matrix far from normal: GMRES stands still where it forgets early what it has tried, and without refinement the
/// residual that it reckons falls while the true one stays. Where it does not find the solution, a direct solver does.
PetscErrorCode ActiveSetSolver::ExpectSlip()
{
  PC pc;
  PetscFunctionBeginUser;
  PetscCall(KSPGMRESSetRestart(ksp_, kSlipIterations));
  PetscCall(KSPGMRESSetCGSRefinementType(ksp_, KSP_GMRES_CGS_REFINE_IFNEEDED));
  PetscCall(KSPSetTolerances(ksp_, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT, kSlipIterations));
  PetscCall(KSPCreate(comm_, direct_.Out()));
  PetscCall(KSPSetType(direct_, KSPPREONLY));
  PetscCall(KSPGetPC(direct_, &pc));
  PetscCall(PCSetType(pc, PCREDUNDANT)); // a copy on each rank, as PETSc's own LU works on one
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Makes matrices and vectors anew where the places of entries are not those of the last time.
PetscErrorCode ActiveSetSolver::SetPattern(const ComplementarityProblem &problem)
{
  const PetscInt size = static_cast<PetscInt>(problem.r.size());
  int changed = size != size_ || problem.rows != rows_ || problem.columns != columns_;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, comm_));
  if (!changed) PetscFunctionReturn(PETSC_SUCCESS);
  size_ = size;
  rows_ = problem.rows;
  columns_ = problem.columns;
  std::vector<PetscInt> rows = rows_, columns = columns_; // PETSc may change them
  PetscCall(KSPReset(ksp_));
  if (direct_) PetscCall(KSPReset(direct_));
  PetscCall(MatCreate(comm_, A_.Out()));
  PetscCall(MatSetSizes(A_, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(A_, MATAIJ));
  PetscCall(MatSetPreallocationCOO(A_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
  PetscCall(MatSetValuesCOO(A_, problem.values.data(), INSERT_VALUES)); // only an assembled matrix has an assembled copy
  PetscCall(MatDuplicate(A_, MAT_COPY_VALUES, active_part_.Out()));
  PetscCall(MatCreateVecs(A_, lambda_.Out(), r_.Out()));
  for (VecHandle *vector : {&diagonal_, &active_, &work_}) PetscCall(VecDuplicate(r_, vector->Out()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A and r times a power of two, which changes no digit, by which the largest entry on the diagonal is from 1 to 2. Entries have
/// the size of dt^2/m, 1e-30 in small cases, and PETSc's direct solvers take pivots below 2e-14 and singular values below 1e-12
/// for zero.
PetscErrorCode ActiveSetSolver::SetValues(const ComplementarityProblem &problem, const std::vector<double> &lambda)
{
  PetscReal largest;
  PetscFunctionBeginUser;
  PetscCall(MatSetValuesCOO(A_, problem.values.data(), INSERT_VALUES));
  PetscCall(WithNumbers({r_, lambda_}, [&](PetscScalar *r, PetscScalar *start) {
    std::copy(problem.r.begin(), problem.r.end(), r);
    std::copy(lambda.begin(), lambda.end(), start);
  }));
  PetscCall(MatGetDiagonal(A_, diagonal_));
  PetscCall(VecMax(diagonal_, nullptr, &largest));
  scale_ = std::ldexp(1.0, -std::ilogb(largest));
  PetscCall(MatScale(A_, scale_));
  PetscCall(VecScale(diagonal_, scale_));
  PetscCall(VecScale(r_, scale_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The set that the previous pressures leave; without any, the rows that would be violated.
PetscErrorCode ActiveSetSolver::StartSet()
{
  PetscReal largest;
  PetscFunctionBeginUser;
  PetscCall(VecMax(lambda_, nullptr, &largest));
  PetscCall(WithNumbers({largest > 0 ? lambda_ : r_, active_}, [&](const PetscScalar *values, PetscScalar *active) {
    for (PetscInt k = 0; k < size_; ++k) active[k] = values[k] > 0;
  }));
  if (tractions_) PetscCall(StartFriction());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The matrix of the active unknowns; the others stay in the system as zeros, so that its pattern is kept.
PetscErrorCode ActiveSetSolver::SetActivePart()
{
  PetscFunctionBeginUser;
  if (tractions_) {
    PetscCall(SetFrictionPart());
  } else {
    PetscCall(MatCopy(A_, active_part_, SAME_NONZERO_PATTERN));
    PetscCall(MatDiagonalScale(active_part_, active_, active_));
    PetscCall(MatDiagonalSet(active_part_, diagonal_, INSERT_VALUES));
  }
  PetscCall(KSPSetOperators(ksp_, active_part_, active_part_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves the equations of the active unknowns, from what `solution` has.
PetscErrorCode ActiveSetSolver::SolveActive(Vec right_side, Vec solution, ActiveSetReport *report)
{
  KSPConvergedReason reason;
  PetscInt iterations;
  PetscFunctionBeginUser;
  PetscCall(VecPointwiseMult(work_, active_, right_side));
  PetscCall(VecPointwiseMult(solution, active_, solution));
  if (tractions_) PetscCall(ProjectSlips(right_side, work_));
  PetscCall(KSPSolve(ksp_, work_, solution));
  PetscCall(KSPGetConvergedReason(ksp_, &reason));
  PetscCall(KSPGetIterationNumber(ksp_, &iterations));
  report->linear_iterations += static_cast<int>(iterations);
  if (reason < 0 && direct_) {
    PetscCall(KSPSetOperators(direct_, active_part_, active_part_));
    PetscCall(KSPSolve(direct_, work_, solution));
    PetscCall(KSPGetConvergedReason(direct_, &reason));
  }
  // MINRES ends so at a bound of its solution, where its residual is not small.
  report->solved = report->solved && reason > 0 && reason != KSP_CONVERGED_STEP_LENGTH;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A lambda - r, in work_: what is left of each gap, and slips.
PetscErrorCode ActiveSetSolver::FindSlack()
{
  PetscFunctionBeginUser;
  PetscCall(MatMult(A_, lambda_, work_));
  PetscCall(VecAXPY(work_, -1, r_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A row stays in the set with lambda > 0 and enters it with A lambda - r < 0.
PetscErrorCode ActiveSetSolver::UpdateSet(int *changed)
{
  PetscFunctionBeginUser;
  PetscCall(FindSlack());
  *changed = 0;
  const auto update = [&](PetscScalar *active, const PetscScalar *lambda, const PetscScalar *slack) {
    for (PetscInt k = 0; k < size_; ++k) {
      const PetscScalar now = active[k] != 0 ? lambda[k] > 0 : slack[k] < 0;
      *changed = *changed || now != active[k];
      active[k] = now;
    }
  };
  PetscCall(WithNumbers({active_, lambda_, work_}, update));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, changed, 1, MPI_INT, MPI_MAX, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// lambda_j = r_j / sum_k A_jk: each unknown by itself, for a set that does not settle. Columns on both sides of a sharp tip push
/// against each other, so that the sum may vanish or be negative: it is at least A_jj.
PetscErrorCode ActiveSetSolver::SolveByRowSums()
{
  PetscFunctionBeginUser;
  PetscCall(MatGetRowSum(A_, work_));
  PetscCall(VecPointwiseMax(work_, work_, diagonal_));
  PetscCall(VecPointwiseDivide(lambda_, r_, work_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Changes the set until it stays, and solves with it.
PetscErrorCode ActiveSetSolver::FindSet(ActiveSetReport *report)
{
  int updates = 0;
  const int most = tractions_ ? kMaxFrictionUpdates : kMaxSetUpdates;
  PetscFunctionBeginUser;
  for (int changed = 1; changed && report->solved;) {
    PetscScalar active;
    if (updates++ == most) {
      report->fallback = true;
      PetscCall(travels_ ? SolveByRowSumsAndLoad() : SolveByRowSums());
      break;
    }
    if (tractions_ && updates == most / 2) slips_.assign(slips_.size(), {}); // a cycle: once more, from all that sticks
    PetscCall(VecSum(active_, &active));
    if (active > 0) PetscCall(SetActivePart());
    if (travels_)
      PetscCall(SolveActiveByLoad(report));
    else if (active > 0)
      PetscCall(SolveActive(r_, lambda_, report));
    else
      PetscCall(VecSet(lambda_, 0));
    if (report->solved) PetscCall(tractions_ ? UpdateFriction(&changed) : UpdateSet(&changed));
  }
  report->set_updates += updates;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ActiveSetSolver::Solve(const ComplementarityProblem &problem, std::vector<double> *lambda, ActiveSetReport *report)
{
  PetscFunctionBeginUser;
  *report = {};
  travels_ = false;
  tractions_ = problem.tractions;
  friction_ = problem.friction;
  PetscCall(SetPattern(problem));
  PetscCall(SetValues(problem, *lambda));
  PetscCall(StartSet());
  if (problem.by_load) {
    PetscCall(SetLoad(problem));
    PetscCall(FindSetByLoad(problem.most_travel * scale_, report));
  } else {
    PetscCall(FindSet(report));
  }
  PetscCall(Settle(lambda, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Hands out what was found: pressures that are not negative, and tractions within what friction allows.
PetscErrorCode ActiveSetSolver::Settle(std::vector<double> *lambda, ActiveSetReport *report)
{
  PetscFunctionBeginUser;
  if (tractions_) PetscCall(SettleFriction(report));
  PetscCall(WithNumbers({lambda_}, [&](const PetscScalar *values) {
    for (PetscInt k = 0; k < size_; ++k) {
      (*lambda)[k] = IsPressure(k) ? std::max(values[k], 0.0) : values[k];
      report->active += IsPressure(k) && values[k] > 0;
    }
  }));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &report->active, 1, MPI_INT, MPI_SUM, comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
