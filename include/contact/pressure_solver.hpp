// Pressures that are not negative: conjugate gradients on the segments that press, and projections between them.
#pragma once

#include "base/handle.hpp"
#include "contact/pressure_problem.hpp"
#include "physics/indenter.hpp"

#include <vector>

namespace mlgimp
{

struct PressureReport {
  int turns = 0, iterations = 0, pressing = 0; ///< projections; of the KSP; segments with a pressure
  bool solved = true;
  bool limited = false; ///< the load would need the tip to travel farther than it may
  double travel = 0;    ///< of a free tip, downward, m
};

/// The line of -contact_monitor. rows: of the problem.
PetscErrorCode PrintSolve(double time, int rows, const PressureReport &report);

/// Finds q >= 0 with A q + gaps - u closing >= 0, complementary, and where the tip is free u with closing . q = load.
class PressureSolver
{
public:
  /// Creates the KSP with the prefix -contact_ and reads its options: CG with the diagonal, to 1e-10 of the gaps' norm by
  /// default.
  PetscErrorCode Create();
  /// q: where to start, then the solution. load: that the tip must carry beside tip.load, as of friction, N. Collective on
  /// nothing.
  PetscErrorCode Solve(const PressureProblem &problem, const TipStep &tip, double more_load, std::vector<double> *q,
                       PressureReport *report);

private:
  PetscErrorCode Prepare(int size);
  PetscErrorCode SolveFree(const std::vector<double> &right_side, double goal, std::vector<double> *x, PressureReport *report);
  void FindGradient(const std::vector<double> &q, double travel);
  void FindFree(const std::vector<double> &q);
  PetscErrorCode SolveAtRest(std::vector<double> *q, double travel, PressureReport *report);
  PetscErrorCode SolveByLoad(const LoadInStep &load, std::vector<double> *q, PressureReport *report);
  double Goal(double travel) const;
  double EnergyChange(const std::vector<double> &before, const std::vector<double> &gradient_before,
                      const std::vector<double> &q) const;
  bool GoDownhill(const std::vector<double> &way, const std::vector<double> &before, const std::vector<double> &gradient_before,
                  double travel, std::vector<double> *q);
  double LoadOf(const std::vector<double> &q) const;
  double FirstTouch(double travel) const;
  double Residual(const std::vector<double> &q) const;
  static PetscErrorCode MultiplyFree(Mat A, Vec x, Vec y);
  static PetscErrorCode GetDiagonal(Mat, Vec diagonal);

  KSPHandle ksp_;
  MatHandle A_;
  VecHandle x_, b_;
  int size_ = -1;
  double rtol_ = 1e-10;
  const PressureProblem *problem_ = nullptr;
  std::vector<double> roots_, gradient_, masked_; ///< roots: of the diagonal
  std::vector<char> free_;
  std::vector<double> slope_; ///< d q/d u
};

} // namespace mlgimp
