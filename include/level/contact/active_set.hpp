// The complementarity problem of contact pressures: a primal-dual active set around a KSP.
#pragma once

#include "base/handle.hpp"

#include <vector>

namespace mlgimp
{

/// This rank's rows of: A lambda - r >= 0, lambda >= 0, one of them zero in each row.
struct ComplementarityProblem {
  std::vector<PetscInt> rows, columns; ///< global numbers of each entry of A; entries of one place are added up
  std::vector<PetscScalar> values;     ///< every row has one on the diagonal, and their sum there is above zero
  std::vector<double> r;               ///< [rows of this rank]
};

struct ActiveSetReport {
  int set_updates = 0, linear_iterations = 0, active = 0;
  bool fallback = false, solved = true;
};

/// Finds lambda on all ranks of a communicator together.
class ActiveSetSolver
{
public:
  /// Creates the KSP with the prefix -contact_ and reads its options. `symmetric` chooses the default method. Collective on comm,
  /// which must outlive the solver.
  PetscErrorCode Create(MPI_Comm comm, bool symmetric);
  /// lambda [rows of this rank]: the previous pressures on entry (the set starts from them), the solution on return. report: the
  /// same on all ranks. Collective.
  PetscErrorCode Solve(const ComplementarityProblem &problem, std::vector<double> *lambda, ActiveSetReport *report);

private:
  PetscErrorCode SetPattern(const ComplementarityProblem &problem);
  PetscErrorCode SetValues(const ComplementarityProblem &problem, const std::vector<double> &lambda);
  PetscErrorCode SolveActive(ActiveSetReport *report);
  PetscErrorCode SolveByRowSums();
  PetscErrorCode StartSet();
  PetscErrorCode UpdateSet(int *changed);

  MPI_Comm comm_ = MPI_COMM_NULL;
  KSPHandle ksp_;
  MatHandle A_, active_part_;
  VecHandle diagonal_, r_, lambda_, active_, work_; ///< active: 1 or 0
  std::vector<PetscInt> rows_, columns_;            ///< of the entries that the matrices were made for
  PetscInt size_ = -1;                              ///< rows of this rank
};

} // namespace mlgimp
