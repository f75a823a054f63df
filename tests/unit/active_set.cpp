// The active-set solver of contact pressures: against the solution found by trying every set, against PETSc's solver of
// variational inequalities, and where it gives up.
#include "level/contact/active_set.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>
#include <petscsnes.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// A small matrix with all its entries.
struct Matrix {
  int size;
  std::vector<double> values = std::vector<double>(std::size_t(size) * size);
  double &At(int row, int column) { return values[std::size_t(row) * size + column]; }
  double At(int row, int column) const { return values[std::size_t(row) * size + column]; }
};

/// The rows from first to end of a problem, without zeros but on the diagonal.
ComplementarityProblem Rows(const Matrix &A, const std::vector<double> &r, int first, int end)
{
  ComplementarityProblem problem;
  for (int j = first; j < end; ++j) {
    problem.r.push_back(r[j]);
    for (int k = 0; k < A.size; ++k) {
      if (A.At(j, k) == 0 && j != k) continue;
      problem.rows.push_back(j);
      problem.columns.push_back(k);
      problem.values.push_back(A.At(j, k));
    }
  }
  return problem;
}

/// Solves on this rank alone.
PetscErrorCode SolveAlone(ActiveSetSolver &solver, const Matrix &A, const std::vector<double> &r, std::vector<double> &lambda,
                          ActiveSetReport *report)
{
  return solver.Solve(Rows(A, r, 0, A.size), &lambda, report);
}

/// Solves the equations of the chosen unknowns by Gauss elimination, the others being zero.
std::vector<double> SolveChosen(const Matrix &A, const std::vector<double> &r, unsigned chosen)
{
  const int n = A.size;
  std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1, 0.0));
  for (int j = 0; j < n; ++j) {
    rows[j][j] = 1;
    if (!(chosen >> j & 1)) continue;
    for (int k = 0; k < A.size; ++k) rows[j][k] = chosen >> k & 1 ? A.At(j, k) : 0;
    rows[j][n] = r[j];
  }
  for (int pivot = 0; pivot < n; ++pivot)
    for (int j = 0; j < n; ++j) {
      if (j == pivot) continue;
      const double factor = rows[j][pivot] / rows[pivot][pivot];
      for (int k = 0; k <= n; ++k) rows[j][k] -= factor * rows[pivot][k];
    }
  std::vector<double> lambda(n);
  for (int j = 0; j < n; ++j) lambda[j] = rows[j][n] / rows[j][j];
  return lambda;
}

/// The lambda of the one set of unknowns that leaves no negative lambda and no negative slack.
std::vector<double> ByEnumeration(const Matrix &A, const std::vector<double> &r)
{
  for (unsigned chosen = 0; chosen < 1U << A.size; ++chosen) {
    const std::vector<double> lambda = SolveChosen(A, r, chosen);
    bool good = true;
    for (int j = 0; j < A.size; ++j) {
      double slack = -r[j];
      for (int k = 0; k < A.size; ++k) slack += A.At(j, k) * lambda[k];
      good = good && lambda[j] >= -1e-12 && slack >= -1e-12 * A.At(j, j);
    }
    if (good) return lambda;
  }
  return {};
}

/// B^T B + a diagonal, with entries of the size of `scale` up to `reach` places from it; `skew` makes it unsymmetric. All such
/// problems have one solution.
Matrix RandomMatrix(int size, int reach, double scale, double skew)
{
  Matrix B{size}, A{size};
  for (int j = 0; j < size; ++j)
    for (int k = 0; k < size; ++k)
      if (2 * std::abs(j - k) <= reach) B.At(j, k) = Random(0, 1);
  for (int j = 0; j < size; ++j)
    for (int k = std::max(0, j - reach); k <= std::min(size - 1, j + reach); ++k) {
      for (int m = 0; m < size; ++m) A.At(j, k) += scale * B.At(m, j) * B.At(m, k);
      A.At(j, k) += scale * (j == k ? 0.3 : j < k ? skew : -skew);
    }
  return A;
}

void ExpectSolution(bool symmetric, double scale)
{
  ActiveSetSolver solver;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, symmetric), PETSC_SUCCESS);
  int some = 0;
  for (int n = 0; n < 40; ++n) {
    const int size = n % 2 ? 7 : 9; // the solver changes its size
    const Matrix A = RandomMatrix(size, 4, scale, symmetric ? 0 : 0.2);
    std::vector<double> r(size), lambda(size);
    for (double &value : r) value = scale * Random(-1, 1);
    for (double &value : lambda) value = n % 3 ? Random(-1, 1) : 0; // warm and cold starts
    const std::vector<double> exact = ByEnumeration(A, r);
    ASSERT_EQ(exact.size(), lambda.size());
    ActiveSetReport report;
    ASSERT_EQ(SolveAlone(solver, A, r, lambda, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved);
    EXPECT_FALSE(report.fallback);
    int active = 0;
    for (int j = 0; j < size; ++j) {
      EXPECT_NEAR(lambda[j], std::max(exact[j], 0.0), 1e-8);
      active += exact[j] > 1e-12;
    }
    EXPECT_EQ(report.active, active);
    some += active > 0 && active < size;
  }
  EXPECT_GE(some, 20) << "problems with a set of some but not all";
}

} // namespace

TEST(ActiveSet, FindsTheOnlySolution)
{
  ExpectSolution(true, 1);
  ExpectSolution(true, 1e-30); // entries have the size of dt^2/m
  ExpectSolution(false, 1);
}

TEST(ActiveSet, SolutionIsAGoodStart)
{
  ActiveSetSolver solver;
  ActiveSetReport cold, warm;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, true), PETSC_SUCCESS);
  const Matrix A = RandomMatrix(9, 4, 1, 0);
  std::vector<double> r, lambda(9, 0.0);
  for (int j = 0; j < 9; ++j) r.push_back(1 - 0.1 * (j - 4) * (j - 4));
  ASSERT_EQ(SolveAlone(solver, A, r, lambda, &cold), PETSC_SUCCESS);
  const std::vector<double> before = lambda;
  ASSERT_EQ(SolveAlone(solver, A, r, lambda, &warm), PETSC_SUCCESS);
  EXPECT_EQ(warm.set_updates, 1);
  EXPECT_EQ(warm.linear_iterations, 0);
  EXPECT_EQ(lambda, before);
  EXPECT_EQ(warm.active, cold.active);
}

TEST(ActiveSet, PressuresOfBeforeAreFarTooLarge)
{
  const Matrix A = RandomMatrix(9, 4, 1, 0);
  for (const bool symmetric : {true, false}) {
    ActiveSetSolver solver;
    ActiveSetReport report;
    ASSERT_EQ(solver.Create(PETSC_COMM_SELF, symmetric), PETSC_SUCCESS);
    std::vector<double> r(9), lambda(9, 1.0); // of a tip that all but lets go
    for (int j = 0; j < 9; ++j) r[j] = 1e-8 * (1 - 0.1 * (j - 4) * (j - 4));
    const std::vector<double> exact = ByEnumeration(A, r);
    ASSERT_EQ(SolveAlone(solver, A, r, lambda, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved);
    for (int j = 0; j < 9; ++j) EXPECT_NEAR(lambda[j], std::max(exact[j], 0.0), 1e-14);
  }
}

TEST(ActiveSet, NothingTouches)
{
  ActiveSetSolver solver;
  ActiveSetReport report;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, true), PETSC_SUCCESS);
  std::vector<double> lambda = {0.5, 0, 2};
  ASSERT_EQ(SolveAlone(solver, RandomMatrix(3, 2, 1, 0), {-1, -2, -0.1}, lambda, &report), PETSC_SUCCESS);
  EXPECT_EQ(lambda, std::vector<double>(3, 0.0));
  EXPECT_EQ(report.active, 0);
}

namespace
{

/// Rows of a problem under load control; c differs from row to row.
ComplementarityProblem RowsByLoad(const Matrix &A, const std::vector<double> &r, int first, int end, double load, double most)
{
  ComplementarityProblem problem = Rows(A, r, first, end);
  problem.by_load = true;
  for (int j = first; j < end; ++j) problem.c.push_back(1 + 0.5 * std::sin(3.0 * j));
  problem.load = load;
  problem.most_travel = most;
  return problem;
}

/// A lambda - r - u c >= 0, lambda >= 0, one of them zero in each row, and c . lambda = P; there is only one such lambda.
void ExpectByLoad(const Matrix &A, const std::vector<double> &r, const std::vector<double> &c, const std::vector<double> &lambda,
                  double load, double travel, double scale)
{
  double carried = 0;
  for (int j = 0; j < A.size; ++j) {
    double slack = -r[j] - travel * c[j];
    for (int k = 0; k < A.size; ++k) slack += A.At(j, k) * lambda[k];
    carried += c[j] * lambda[j];
    EXPECT_GE(lambda[j], 0);
    EXPECT_GE(slack, -1e-8 * scale);
    EXPECT_LE(lambda[j] * slack, 1e-8 * scale);
  }
  EXPECT_NEAR(carried, load, 1e-12 * load + 1e-15) << "pressures have the size of one";
}

} // namespace

TEST(LoadControl, CarriesTheLoad)
{
  ActiveSetSolver solver;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, true), PETSC_SUCCESS);
  int some = 0;
  for (int n = 0; n < 40; ++n) {
    const int size = n % 2 ? 7 : 12;
    const double scale = n % 4 > 1 ? 1e-30 : 1, load = n % 5 ? Random(0.1, 3) : 1e-6;
    const Matrix A = RandomMatrix(size, 4, scale, 0);
    std::vector<double> r(size), lambda(size);
    for (double &value : r) value = scale * Random(-2, n % 3 ? 1 : -0.5); // also where nothing touches the indenter at rest
    for (double &value : lambda) value = n % 3 ? Random(-1, 1) : 0;
    const ComplementarityProblem problem = RowsByLoad(A, r, 0, size, load, HUGE_VAL);
    ActiveSetReport report;
    ASSERT_EQ(solver.Solve(problem, &lambda, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved && !report.fallback && !report.limited);
    ExpectByLoad(A, r, problem.c, lambda, load, report.travel, scale);
    some += report.active > 1 && report.active < size;
  }
  EXPECT_GE(some, 20) << "problems with a set of some but not all";
}

/// Without a load the indenter stays, or is lifted as far as the surface comes up; it goes no farther than it may.
TEST(LoadControl, TravelsAsFarAsItMay)
{
  ActiveSetSolver solver;
  ActiveSetReport report;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, true), PETSC_SUCCESS);
  const Matrix A = RandomMatrix(4, 2, 1, 0);
  const auto solve = [&](const std::vector<double> &r, double load, double most, std::vector<double> *lambda) {
    lambda->assign(4, 0.3);
    EXPECT_EQ(solver.Solve(RowsByLoad(A, r, 0, 4, load, most), lambda, &report), PETSC_SUCCESS);
  };
  std::vector<double> lambda, c = RowsByLoad(A, {0, 0, 0, 0}, 0, 4, 0, 0).c;
  solve({-1, -2, -1, -3}, 0, 1, &lambda);
  EXPECT_EQ(report.travel, 0);
  EXPECT_EQ(lambda, std::vector<double>(4, 0.0));
  solve({-1, 0.2, 0.1, -3}, 0, 1, &lambda);
  EXPECT_DOUBLE_EQ(report.travel, -std::max(0.2 / c[1], 0.1 / c[2]));
  EXPECT_EQ(lambda, std::vector<double>(4, 0.0));
  solve({-1, 0.2, 0.1, -3}, 5, 0.01, &lambda);
  EXPECT_TRUE(report.limited);
  EXPECT_DOUBLE_EQ(report.travel, 0.01);
  double carried = 0;
  for (int j = 0; j < 4; ++j) carried += c[j] * lambda[j];
  EXPECT_LT(carried, 5);
  EXPECT_GT(carried, 0);
  solve({-1, -2, -1, -3}, 5, 0.01, &lambda); // out of reach
  EXPECT_TRUE(report.limited && report.active == 0);
}

/// A circulant with 1 and 2: from {2} the set goes round {2, 1}, {3, 1}, {3, 2} for ever (Ben Gharbia and Gilbert 2012).
TEST(ActiveSet, GivesUpWhereTheSetGoesRound)
{
  ActiveSetSolver solver;
  ActiveSetReport report;
  Matrix A{3};
  for (int j = 0; j < 3; ++j) A.At(j, j) = 1, A.At(j, (j + 2) % 3) = 2;
  const std::vector<double> r = {1, 1.1, 0.9};
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, false), PETSC_SUCCESS);
  std::vector<double> lambda = {0, 1, 0};
  ASSERT_EQ(SolveAlone(solver, A, r, lambda, &report), PETSC_SUCCESS);
  EXPECT_TRUE(report.fallback);
  EXPECT_GT(report.set_updates, 3);
  EXPECT_LE(report.set_updates, 100);
  for (int j = 0; j < 3; ++j) EXPECT_DOUBLE_EQ(lambda[j], r[j] / 3) << "each by itself, by the sum of its row";

  ComplementarityProblem problem = RowsByLoad(A, r, 0, 3, 2, HUGE_VAL);
  problem.c = {1, 1, 1};
  lambda = {0, 1, 0};
  ASSERT_EQ(solver.Solve(problem, &lambda, &report), PETSC_SUCCESS);
  EXPECT_NEAR(lambda[0] + lambda[1] + lambda[2], 2, 1e-14) << "the load is met all the same";
}

namespace
{

/// F(x) = A x - r for PETSc's solver.
struct Oracle {
  Mat A;
  Vec r;
};

PetscErrorCode Residual(SNES, Vec x, Vec f, void *context)
{
  const Oracle &oracle = *static_cast<Oracle *>(context);
  PetscFunctionBeginUser;
  PetscCall(MatMult(oracle.A, x, f));
  PetscCall(VecAXPY(f, -1, oracle.r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Jacobian(SNES, Vec, Mat, Mat, void *) { return PETSC_SUCCESS; }

/// Solves by SNESVINEWTONRSLS on all ranks. lambda [rows of this rank].
PetscErrorCode SolveByNewton(const ComplementarityProblem &problem, std::vector<double> *lambda)
{
  const PetscInt size = static_cast<PetscInt>(problem.r.size());
  Oracle oracle;
  SNES snes;
  KSP ksp;
  PC pc;
  Vec x, residual, lower, upper;
  SNESConvergedReason reason;
  const PetscScalar *values;
  std::vector<PetscInt> rows = problem.rows, columns = problem.columns;
  PetscFunctionBeginUser;
  PetscCall(MatCreate(PETSC_COMM_WORLD, &oracle.A));
  PetscCall(MatSetSizes(oracle.A, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(oracle.A, MATAIJ));
  PetscCall(MatSetPreallocationCOO(oracle.A, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
  PetscCall(MatSetValuesCOO(oracle.A, problem.values.data(), INSERT_VALUES));
  PetscCall(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, size, PETSC_DETERMINE, problem.r.data(), &oracle.r));
  for (Vec *vector : {&x, &residual, &lower, &upper}) PetscCall(VecDuplicate(oracle.r, vector));
  PetscCall(VecSet(upper, PETSC_INFINITY));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetType(snes, SNESVINEWTONRSLS));
  PetscCall(SNESSetFunction(snes, residual, Residual, &oracle));
  PetscCall(SNESSetJacobian(snes, oracle.A, oracle.A, Jacobian, nullptr));
  PetscCall(SNESVISetVariableBounds(snes, lower, upper));
  PetscCall(SNESSetTolerances(snes, 1e-13, 1e-13, 0, 100, 1000));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSetTolerances(ksp, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(SNESSolve(snes, nullptr, x));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  EXPECT_GT(reason, 0);
  PetscCall(VecGetArrayRead(x, &values));
  lambda->assign(values, values + size);
  PetscCall(VecRestoreArrayRead(x, &values));
  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&oracle.A));
  for (Vec *vector : {&x, &residual, &lower, &upper, &oracle.r}) PetscCall(VecDestroy(vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

/// Rows divided among ranks, unevenly; sizes up to what a contact in space has.
TEST(ActiveSetOnRanks, AgreesWithPetscsNewton)
{
  PetscMPIInt rank, ranks;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Random.seed(7); // the same problems on all ranks
  for (int n = 0; n < 12; ++n) {
    const int size = 5 + 20 * n, first = rank == 0 ? 0 : size * rank / ranks - 1,
              end = rank == ranks - 1 ? size : size * (rank + 1) / ranks - 1;
    const double scale = n % 2 ? 1e-28 : 1;
    const Matrix A = RandomMatrix(size, 6, scale, 0);
    std::vector<double> r(size), newton;
    for (int j = 0; j < size; ++j) r[j] = scale * (std::sin(0.3 * j) + Random(-0.5, 0.5));
    const ComplementarityProblem problem = Rows(A, r, first, end);
    ComplementarityProblem scaled = problem;
    for (double &value : scaled.values) value /= scale;
    for (double &value : scaled.r) value /= scale;
    std::vector<double> lambda(end - first), again(end - first);
    ActiveSetReport report;
    ActiveSetSolver solver;
    ASSERT_EQ(solver.Create(PETSC_COMM_WORLD, true), PETSC_SUCCESS);
    ASSERT_EQ(solver.Solve(problem, &lambda, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved && !report.fallback);
    ASSERT_EQ(SolveByNewton(scaled, &newton), PETSC_SUCCESS);
    for (int j = 0; j < end - first; ++j) EXPECT_NEAR(lambda[j], newton[j], 1e-8) << "row " << first + j << " of " << size;
    EXPECT_GT(report.active, size / 8);
    EXPECT_LT(report.active, size);
    ASSERT_EQ(solver.Solve(problem, &again, &report), PETSC_SUCCESS);
    EXPECT_EQ(again, lambda) << "the same to the last digit";

    ActiveSetSolver alone;
    ActiveSetReport whole;
    std::vector<double> all(size);
    ASSERT_EQ(alone.Create(PETSC_COMM_SELF, true), PETSC_SUCCESS);
    ASSERT_EQ(alone.Solve(RowsByLoad(A, r, 0, size, 0.5, HUGE_VAL), &all, &whole), PETSC_SUCCESS);
    again.assign(end - first, 0);
    ASSERT_EQ(solver.Solve(RowsByLoad(A, r, first, end, 0.5, HUGE_VAL), &again, &report), PETSC_SUCCESS);
    EXPECT_NEAR(report.travel, whole.travel, 1e-8 * scale) << "under load control";
    for (int j = 0; j < end - first; ++j) EXPECT_NEAR(again[j], all[first + j], 1e-8);
  }
}
