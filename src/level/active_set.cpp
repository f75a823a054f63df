// Active-set loop for contact pressures.
#include "level/active_set.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace mlgimp
{

static constexpr int kMaxSetUpdates = 20;

PetscErrorCode ActiveSetSolver::Create(bool symmetric)
{
  PC pc;
  PetscFunctionBeginUser;
  PetscCall(KSPCreate(PETSC_COMM_SELF, ksp_.Out()));
  PetscCall(KSPSetOptionsPrefix(ksp_, "contact_"));
  PetscCall(KSPSetType(ksp_, symmetric ? KSPCG : KSPGMRES));
  PetscCall(KSPGetPC(ksp_, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSetTolerances(ksp_, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSetInitialGuessNonzero(ksp_, PETSC_TRUE));
  PetscCall(KSPSetFromOptions(ksp_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ActiveSetSolver::Resize(int size, int reach)
{
  PetscFunctionBeginUser;
  if (size == size_ && reach == reach_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPReset(ksp_));
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, size, size, std::min(2 * reach + 1, size), nullptr, matrix_.Out()));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, size, right_side_.Out()));
  PetscCall(VecDuplicate(right_side_, solution_.Out()));
  size_ = size;
  reach_ = reach;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A power of two, so that it changes no digit, by which the largest entry on the diagonal is from 1 to 2. Entries have the size
/// of dt^2/m, 1e-30 in small cases, and PETSc's direct solvers take pivots below 2e-14 and singular values below 1e-12 for zero.
static double ScaleOf(const BandMatrix &A)
{
  double largest = DBL_MIN;
  for (int row = 0; row < A.size; ++row) largest = std::max(largest, A.At(row, row));
  return std::ldexp(1.0, -std::ilogb(largest));
}

/// Solves the equations of the active unknowns; the others stay in the system as zeros, so that its size is kept.
PetscErrorCode ActiveSetSolver::SolveActive(const BandMatrix &A, const std::vector<double> &r, const std::vector<char> &active,
                                            std::vector<double> &lambda, ActiveSetReport *report)
{
  KSPConvergedReason reason;
  PetscInt iterations;
  PetscScalar *right_side, *solution;
  const double scale = ScaleOf(A);
  std::vector<PetscInt> columns(2 * A.reach + 1);
  std::vector<PetscScalar> row_values(2 * A.reach + 1);
  PetscFunctionBeginUser;
  PetscCall(VecGetArray(right_side_, &right_side));
  PetscCall(VecGetArray(solution_, &solution));
  for (PetscInt row = 0; row < A.size; ++row) {
    PetscInt count = 0;
    for (int column = A.First(row); column <= A.Last(row); ++column) {
      const bool kept = column == row || (active[row] && active[column]);
      columns[count] = column;
      row_values[count++] = kept ? scale * A.At(row, column) : 0;
    }
    PetscCall(MatSetValues(matrix_, 1, &row, count, columns.data(), row_values.data(), INSERT_VALUES));
    right_side[row] = active[row] ? scale * r[row] : 0;
    solution[row] = active[row] ? lambda[row] : 0;
  }
  PetscCall(VecRestoreArray(right_side_, &right_side));
  PetscCall(VecRestoreArray(solution_, &solution));
  PetscCall(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  PetscCall(KSPSetOperators(ksp_, matrix_, matrix_));
  PetscCall(KSPSolve(ksp_, right_side_, solution_));
  PetscCall(KSPGetConvergedReason(ksp_, &reason));
  PetscCall(KSPGetIterationNumber(ksp_, &iterations));
  report->linear_iterations += static_cast<int>(iterations);
  report->solved = report->solved && reason > 0;
  PetscCall(VecGetArray(solution_, &solution));
  std::copy(solution, solution + A.size, lambda.begin());
  PetscCall(VecRestoreArray(solution_, &solution));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// lambda_j = max(0, r_j / sum_k A_jk): each unknown by itself, for a set that does not settle. Columns on both sides of a
/// sharp tip push against each other, so that the sum may vanish: it is at least A_jj.
static void SolveByRowSums(const BandMatrix &A, const std::vector<double> &r, std::vector<double> &lambda)
{
  for (int row = 0; row < A.size; ++row) {
    double sum = 0;
    for (int column = A.First(row); column <= A.Last(row); ++column) sum += A.At(row, column);
    lambda[row] = std::max(0.0, r[row] / std::max(sum, A.At(row, row)));
  }
}

PetscErrorCode ActiveSetSolver::Solve(const BandMatrix &A, const std::vector<double> &r, std::vector<double> &lambda,
                                      ActiveSetReport *report)
{
  std::vector<char> active(A.size);
  PetscFunctionBeginUser;
  *report = {};
  if (A.size == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Resize(A.size, A.reach));
  const bool warm = std::any_of(lambda.begin(), lambda.end(), [](double value) { return value > 0; });
  for (int k = 0; k < A.size; ++k) active[k] = warm ? lambda[k] > 0 : r[k] > 0;
  for (bool changed = true; changed;) {
    if (report->set_updates++ == kMaxSetUpdates) {
      report->fallback = true;
      SolveByRowSums(A, r, lambda);
      break;
    }
    if (std::none_of(active.begin(), active.end(), [](char a) { return a; }))
      std::fill(lambda.begin(), lambda.end(), 0.0);
    else
      PetscCall(SolveActive(A, r, active, lambda, report));
    if (!report->solved) break;
    changed = false;
    for (int row = 0; row < A.size; ++row) {
      double slack = -r[row];
      for (int column = A.First(row); column <= A.Last(row); ++column) slack += A.At(row, column) * lambda[column];
      const char now = active[row] ? lambda[row] > 0 : slack < 0;
      changed = changed || now != active[row];
      active[row] = now;
    }
  }
  for (double &value : lambda) value = std::max(value, 0.0);
  report->active = static_cast<int>(std::count_if(lambda.begin(), lambda.end(), [](double value) { return value > 0; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
