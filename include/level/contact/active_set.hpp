// The complementarity problem of contact pressures: a primal-dual active set around a KSP.
//
// Under load control the indenter's travel u in the step is one more unknown, and the load P one more equation:
//   A lambda - r - u c >= 0,  lambda >= 0, complementary,  c . lambda = P.
// With friction the rows of tractions tau stand behind that of their pressure (friction.cpp): with s = A x - r - u c there and x
// all unknowns,  |tau| <= mu lambda,  s = 0 or tau = -mu lambda s/|s|;  tractions take part in c . x = P.
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

  bool by_load = false;
  std::vector<double> c;            ///< [rows of this rank] load of each pressure, m2; zero in rows that can carry none
  double load = 0, most_travel = 0; ///< P, N; largest |u|, at which the load is what it is, m

  int tractions = 0;   ///< rows of tractions behind each of a pressure
  double friction = 0; ///< mu; infinite where surfaces stick
};

struct ActiveSetReport {
  int set_updates = 0, linear_iterations = 0, active = 0;
  bool fallback = false, solved = true;
  double travel = 0;    ///< u
  bool limited = false; ///< the load would need a larger |u|
  double heat = 0;      ///< -sum tau . s of the rows of this rank, J
};

/// Friction on a column: it sticks, or slips with its traction along a direction.
struct SlipState {
  bool slips = false;
  double direction[2] = {0, 0}; ///< of the traction
  double share = 0;             ///< mu lambda/|tau - s/d|, d the diagonal: how stiff the traction is across that direction
};

/// Finds lambda on all ranks of a communicator together.
class ActiveSetSolver
{
public:
  /// Creates the KSP with the prefix -contact_ and reads its options. `symmetric` chooses the default method: CG, or GMRES where
  /// the equations are not, as with friction. Collective on comm, which must outlive the solver.
  PetscErrorCode Create(MPI_Comm comm, bool symmetric);
  /// lambda [rows of this rank]: the previous pressures on entry (the set starts from them), the solution on return. report: the
  /// same on all ranks. Collective.
  PetscErrorCode Solve(const ComplementarityProblem &problem, std::vector<double> *lambda, ActiveSetReport *report);

private:
  PetscErrorCode SetPattern(const ComplementarityProblem &problem);
  PetscErrorCode SetValues(const ComplementarityProblem &problem, const std::vector<double> &lambda);
  PetscErrorCode StartSet();
  PetscErrorCode FindSet(ActiveSetReport *report);
  PetscErrorCode SetActivePart();
  PetscErrorCode ExpectSlip();
  PetscErrorCode SolveActive(Vec right_side, Vec solution, ActiveSetReport *report);
  PetscErrorCode FindSlack();
  PetscErrorCode UpdateSet(int *changed);
  PetscErrorCode SolveByRowSums();
  PetscErrorCode Settle(std::vector<double> *lambda, ActiveSetReport *report);

  // With friction (friction.cpp).
  bool IsPressure(PetscInt row) const { return row % (1 + tractions_) == 0; }
  PetscErrorCode StartFriction();
  PetscErrorCode SetFrictionPart();
  PetscErrorCode AddRow(PetscInt from, PetscInt to, double factor);
  PetscErrorCode ProjectSlips(Vec right_side, Vec projected);
  PetscErrorCode UpdateFriction(int *changed);
  PetscErrorCode SettleFriction(ActiveSetReport *report);

  // Under load control (load_control.cpp).
  PetscErrorCode SetLoad(const ComplementarityProblem &problem);
  PetscErrorCode FindSetByLoad(double most_travel, ActiveSetReport *report);
  PetscErrorCode FindTouch();
  PetscErrorCode MoveTo(double travel);
  PetscErrorCode SolveActiveByLoad(ActiveSetReport *report);
  PetscErrorCode SolveByRowSumsAndLoad();

  MPI_Comm comm_ = MPI_COMM_NULL;
  KSPHandle ksp_, direct_; ///< the second, with friction, for what the first does not solve
  MatHandle A_, active_part_;
  VecHandle diagonal_, r_, lambda_, active_, work_; ///< active: 1 or 0
  std::vector<PetscInt> rows_, columns_;            ///< of the entries that the matrices were made for
  PetscInt size_ = -1;                              ///< rows of this rank
  double scale_ = 1;                                ///< of A and r

  bool travels_ = false;         ///< u is unknown
  double load_ = 0, travel_ = 0; ///< P; u times the scale
  VecHandle c_, r_at_rest_;      ///< r with u = 0
  VecHandle x1_, x2_;            ///< solutions of the active rows for r with u = 0 and for c

  int tractions_ = 0;            ///< rows of tractions behind each of a pressure
  double friction_ = 0;          ///< mu
  std::vector<SlipState> slips_; ///< [pressures of this rank]
};

} // namespace mlgimp
