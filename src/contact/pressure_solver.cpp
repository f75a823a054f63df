// The loop of projections around a KSP.
#include "contact/pressure_solver.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

static constexpr int kMaxTurns = 100;  ///< rounding: some ten turns are usual
static constexpr double kOfGoal = 0.3; ///< rounding: of what the last turn may leave over, for the solve in each turn

static double Square(double x) { return x * x; }

PetscErrorCode PrintSolve(double time, int rows, const PressureReport &report)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "contact: time %.6e unknowns %d, pressing %d, turns %d iterations %d\n", time, rows,
                        report.pressing, report.turns, report.iterations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSolver::Create()
{
  PC pc;
  PetscReal rtol;
  PetscFunctionBeginUser;
  PetscCall(KSPCreate(PETSC_COMM_SELF, ksp_.Out()));
  PetscCall(KSPSetOptionsPrefix(ksp_, "contact_"));
  PetscCall(KSPSetType(ksp_, KSPCG));
  PetscCall(KSPGetPC(ksp_, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSetTolerances(ksp_, rtol_, PETSC_CURRENT, PETSC_MAX_REAL, PETSC_CURRENT));
  PetscCall(KSPSetFromOptions(ksp_));
  PetscCall(KSPMINRESSetRadius(ksp_, PETSC_MAX_REAL)); // solutions have the size of gaps, in m
  PetscCall(KSPGetTolerances(ksp_, &rtol, nullptr, nullptr, nullptr));
  rtol_ = rtol;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The operator on the rows that are free, the identity on the others; scaled to ones on its diagonal, so that all norms that a
/// KSP may stop by are one.
PetscErrorCode PressureSolver::MultiplyFree(Mat A, Vec x, Vec y)
{
  PressureSolver *solver;
  const PetscScalar *from;
  PetscScalar *to;
  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(A, &solver));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  for (int k = 0; k < solver->size_; ++k) solver->masked_[k] = solver->free_[k] ? from[k] / solver->roots_[k] : 0;
  solver->problem_->Multiply(solver->masked_.data(), to);
  for (int k = 0; k < solver->size_; ++k) to[k] = solver->free_[k] ? to[k] / solver->roots_[k] : from[k];
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(PetscLogFlops(60.0 * solver->size_)); // size
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSolver::GetDiagonal(Mat, Vec diagonal)
{
  PetscFunctionBeginUser;
  PetscCall(VecSet(diagonal, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSolver::Prepare(int size)
{
  PetscFunctionBeginUser;
  if (size == size_) PetscFunctionReturn(PETSC_SUCCESS);
  size_ = size;
  PetscCall(KSPReset(ksp_));
  PetscCall(MatCreateShell(PETSC_COMM_SELF, size, size, size, size, this, A_.Out()));
  PetscCall(MatShellSetOperation(A_, MATOP_MULT, reinterpret_cast<void (*)()>(MultiplyFree)));
  PetscCall(MatShellSetOperation(A_, MATOP_GET_DIAGONAL, reinterpret_cast<void (*)()>(GetDiagonal)));
  PetscCall(MatSetOption(A_, MAT_SPD, PETSC_TRUE));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, size, x_.Out()));
  PetscCall(VecDuplicate(x_, b_.Out()));
  gradient_.resize(size), masked_.resize(size), roots_.resize(size), free_.resize(size);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// x of A x = right_side on the free rows, 0 on the others, to `goal` in the norm of the diagonal's inverse; starts from x.
PetscErrorCode PressureSolver::SolveFree(const std::vector<double> &right_side, double goal, std::vector<double> *x,
                                         PressureReport *report)
{
  KSPConvergedReason reason;
  PetscInt iterations;
  bool starts = false;
  PetscFunctionBeginUser;
  PetscCall(WithNumbers({x_, b_}, [&](PetscScalar *start, PetscScalar *b) {
    for (int k = 0; k < size_; ++k) {
      b[k] = free_[k] ? right_side[k] / roots_[k] : 0;
      start[k] = free_[k] ? (*x)[k] * roots_[k] : 0;
      starts = starts || start[k] != 0;
    }
  }));
  PetscCall(KSPSetOperators(ksp_, A_, A_));
  PetscCall(KSPSetInitialGuessNonzero(ksp_, starts ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(KSPSetTolerances(ksp_, 1e-14, goal, PETSC_MAX_REAL, PETSC_CURRENT));
  PetscCall(KSPSolve(ksp_, b_, x_));
  PetscCall(KSPGetConvergedReason(ksp_, &reason));
  PetscCall(KSPGetIterationNumber(ksp_, &iterations));
  report->iterations += static_cast<int>(iterations);
  report->solved = report->solved && reason > 0;
  PetscCall(WithNumbers({x_}, [&](const PetscScalar *found) {
    for (int k = 0; k < size_; ++k) (*x)[k] = free_[k] ? found[k] / roots_[k] : 0;
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PressureSolver::FindGradient(const std::vector<double> &q, double travel)
{
  problem_->Multiply(q.data(), gradient_.data());
  for (int k = 0; k < size_; ++k) gradient_[k] += problem_->Gaps()[k] - travel * problem_->Closing()[k];
}

/// The segments that press, and those whose gap is below zero.
void PressureSolver::FindFree(const std::vector<double> &q)
{
  for (int k = 0; k < size_; ++k) free_[k] = q[k] > 0 || gradient_[k] < 0;
}

/// Norm of what the conditions are missed by.
double PressureSolver::Residual(const std::vector<double> &q) const
{
  double square = 0;
  for (int k = 0; k < size_; ++k)
    if (q[k] > 0 || gradient_[k] < 0) square += Square(gradient_[k] / roots_[k]);
  return std::sqrt(square);
}

/// What the conditions may be missed by: a part of the gaps that the pressures close, or are to close.
double PressureSolver::Goal(double travel) const
{
  double closed = 0, open = 0;
  for (int k = 0; k < size_; ++k) {
    const double gap = problem_->Gaps()[k] - travel * problem_->Closing()[k], by = gradient_[k] - gap;
    closed += Square(by / roots_[k]);
    if (gap < 0) open += Square(gap / roots_[k]);
  }
  return rtol_ * std::sqrt(std::max(closed, open));
}

/// By which the energy q . A q/2 + gaps . q changes, from the gradients at both places, J.
double PressureSolver::EnergyChange(const std::vector<double> &before, const std::vector<double> &gradient_before,
                                    const std::vector<double> &q) const
{
  double change = 0;
  for (int k = 0; k < size_; ++k) change += 0.5 * (q[k] - before[k]) * (gradient_before[k] + gradient_[k]);
  return change;
}

/// Goes as far along a way, cut off at zero, as leads downhill: all of it, a half, a quarter...; false where none does.
bool PressureSolver::GoDownhill(const std::vector<double> &way, const std::vector<double> &before,
                                const std::vector<double> &gradient_before, double travel, std::vector<double> *q)
{
  constexpr int kMaxHalvings = 20; // rounding
  double part = 1;
  for (int halved = 0; halved < kMaxHalvings; ++halved, part /= 2) {
    for (int k = 0; k < size_; ++k) (*q)[k] = std::max(0.0, before[k] + part * way[k]);
    FindGradient(*q, travel);
    if (EnergyChange(before, gradient_before, *q) < 0) return true;
  }
  return false;
}

/// With the tip's way given. Each turn goes toward the minimum over what presses, and what should, cut off at zero; where that
/// leads uphill, down the gradient.
PetscErrorCode PressureSolver::SolveAtRest(std::vector<double> *q, double travel, PressureReport *report)
{
  std::vector<double> right_side(size_), way(size_), before, old_gradient;
  PetscFunctionBeginUser;
  FindGradient(*q, travel);
  for (int turn = 0;; ++turn) {
    const double goal = Goal(travel);
    if (Residual(*q) <= goal) break;
    if (turn == kMaxTurns) {
      report->solved = false;
      break;
    }
    ++report->turns;
    FindFree(*q);
    for (int k = 0; k < size_; ++k) right_side[k] = -gradient_[k], way[k] = 0;
    PetscCall(SolveFree(right_side, kOfGoal * goal, &way, report));
    before = *q, old_gradient = gradient_;
    if (GoDownhill(way, before, old_gradient, travel, q)) continue;
    for (int k = 0; k < size_; ++k) way[k] = -old_gradient[k] / Square(roots_[k]);
    GoDownhill(way, before, old_gradient, travel, q);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The load that pressures carry, N.
double PressureSolver::LoadOf(const std::vector<double> &q) const
{
  double load = 0;
  for (int k = 0; k < size_; ++k) load += problem_->Closing()[k] * q[k];
  return load;
}

/// How far down the tip touches the first segment, m; the present way where none can.
double PressureSolver::FirstTouch(double travel) const
{
  double first = HUGE_VAL;
  for (int k = 0; k < size_; ++k)
    if (problem_->Closing()[k] > 0) first = std::min(first, problem_->Gaps()[k] / problem_->Closing()[k]);
  return std::isfinite(first) ? first : travel;
}

/// Newton's method for the tip's way u: what pressures carry rises with it, by closing . x with A x = closing on what presses,
/// and the load falls where something gives way behind the tip. The load is met exactly in the end, by all pressures alike.
PetscErrorCode PressureSolver::SolveByLoad(const LoadInStep &load, std::vector<double> *q, PressureReport *report)
{
  constexpr int kMaxPasses = 50;                                   // rounding
  constexpr double kLoad = 1e-7, kSlope = 1e-3, kPastTouch = 1e-9; // rounding: of the load; of the norm of closing; of `most`
  const double most = load.most_travel, free = load.FreeTravel();
  double &u = report->travel;
  bool held = false; // at the most that it may travel
  PetscFunctionBeginUser;
  slope_.assign(size_, 0.0);
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    PetscCall(SolveAtRest(q, u, report));
    const double carried = LoadOf(*q), left = load.At(u) - carried;
    report->limited = held && left * u > 0;
    if (report->limited || std::abs(left) <= kLoad * std::abs(load.At(u))) break;
    if (carried <= 0) {
      const double touch = FirstTouch(u);
      if (load.stiffness > 0 && free <= touch) { // it comes as far as what moves it
        u = free;
        break;
      }
      u = std::min(touch + kPastTouch * most, most);
      FindGradient(*q, u);
    }
    FindFree(*q);
    double size = 0;
    for (int k = 0; k < size_; ++k) size += free_[k] ? Square(problem_->Closing()[k] / roots_[k]) : 0;
    if (size == 0) { // nothing within reach
      report->limited = load.stiffness == 0, u = free;
      break;
    }
    PetscCall(SolveFree(problem_->Closing(), kSlope * std::sqrt(size), &slope_, report));
    const double du = (load.At(u) - LoadOf(*q)) / (LoadOf(slope_) + load.stiffness), before = u;
    u = std::clamp(u + du, -most, most);
    held = std::abs(u) == most;
    for (int k = 0; k < size_; ++k) (*q)[k] = std::max(0.0, (*q)[k] + (u - before) * slope_[k]);
  }
  if (const double now = LoadOf(*q); now > 0 && !report->limited)
    for (double &one : *q) one *= load.At(u) / now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSolver::Solve(const PressureProblem &problem, const TipStep &tip, double more_load, std::vector<double> *q,
                                     PressureReport *report)
{
  PetscFunctionBeginUser;
  const auto is_finite = [](double gap) { return std::isfinite(gap); };
  if (!std::all_of(problem.Gaps().begin(), problem.Gaps().end(), is_finite)) { // points have failed: their level reports it
    std::fill(q->begin(), q->end(), 0.0);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  problem_ = &problem;
  PetscCall(Prepare(problem.Size()));
  problem.Diagonal(roots_.data());
  for (double &root : roots_) root = std::sqrt(root);
  LoadInStep load = tip.by_load.value_or(LoadInStep{});
  load.force += more_load;
  if (!tip.by_load) {
    PetscCall(SolveAtRest(q, 0, report));
  } else if (load.force > 0 || load.stiffness > 0) {
    PetscCall(SolveByLoad(load, q, report));
  } else { // lifted where the surface comes up
    std::fill(q->begin(), q->end(), 0.0);
    for (int k = 0; k < size_; ++k)
      if (problem.Closing()[k] > 0) report->travel = std::min(report->travel, problem.Gaps()[k] / problem.Closing()[k]);
  }
  report->pressing = static_cast<int>(std::count_if(q->begin(), q->end(), [](double one) { return one > 0; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
