// The active-set solver of contact pressures: against the solution found by trying every set, and where it gives up.
#include "level/active_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace mlgimp;

namespace
{

std::mt19937 generator(20240607);
double Random(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(generator); }

/// Solves the equations of the chosen unknowns by Gauss elimination, the others being zero.
std::vector<double> SolveChosen(const BandMatrix &A, const std::vector<double> &r, unsigned chosen)
{
  const int n = A.size;
  std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1, 0.0));
  for (int j = 0; j < n; ++j) {
    rows[j][j] = 1;
    if (!(chosen >> j & 1)) continue;
    for (int k = A.First(j); k <= A.Last(j); ++k) rows[j][k] = chosen >> k & 1 ? A.At(j, k) : 0;
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
std::vector<double> ByEnumeration(const BandMatrix &A, const std::vector<double> &r)
{
  for (unsigned chosen = 0; chosen < 1U << A.size; ++chosen) {
    const std::vector<double> lambda = SolveChosen(A, r, chosen);
    bool good = true;
    for (int j = 0; j < A.size; ++j) {
      double slack = -r[j];
      for (int k = A.First(j); k <= A.Last(j); ++k) slack += A.At(j, k) * lambda[k];
      good = good && lambda[j] >= -1e-12 && slack >= -1e-12 * A.At(j, j);
    }
    if (good) return lambda;
  }
  return {};
}

/// B^T B + a diagonal, with entries of the size of `scale`; `skew` makes it unsymmetric. All such problems have one solution.
BandMatrix RandomMatrix(int size, int reach, double scale, double skew)
{
  BandMatrix B, A;
  B.Reset(size, reach / 2);
  A.Reset(size, reach);
  for (int j = 0; j < size; ++j)
    for (int k = B.First(j); k <= B.Last(j); ++k) B.At(j, k) = Random(0, 1);
  for (int j = 0; j < size; ++j)
    for (int k = A.First(j); k <= A.Last(j); ++k) {
      for (int m = std::max(B.First(j), B.First(k)); m <= std::min(B.Last(j), B.Last(k)); ++m)
        A.At(j, k) += scale * B.At(m, j) * B.At(m, k);
      if (j == k) A.At(j, j) += 0.3 * scale;
      if (j < k) A.At(j, k) += skew * scale;
      if (j > k) A.At(j, k) -= skew * scale;
    }
  return A;
}

void ExpectSolution(bool symmetric, double scale)
{
  ActiveSetSolver solver;
  ASSERT_EQ(solver.Create(symmetric), PETSC_SUCCESS);
  int some = 0;
  for (int n = 0; n < 40; ++n) {
    const int size = n % 2 ? 7 : 9; // the solver changes its size
    const BandMatrix A = RandomMatrix(size, 4, scale, symmetric ? 0 : 0.2);
    std::vector<double> r(size), lambda(size);
    for (double &value : r) value = scale * Random(-1, 1);
    for (double &value : lambda) value = n % 3 ? Random(-1, 1) : 0; // warm and cold starts
    const std::vector<double> exact = ByEnumeration(A, r);
    ASSERT_EQ(exact.size(), lambda.size());
    ActiveSetReport report;
    ASSERT_EQ(solver.Solve(A, r, lambda, &report), PETSC_SUCCESS);
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
  ASSERT_EQ(solver.Create(true), PETSC_SUCCESS);
  const BandMatrix A = RandomMatrix(9, 4, 1, 0);
  std::vector<double> r, lambda(9, 0.0);
  for (int j = 0; j < 9; ++j) r.push_back(1 - 0.1 * (j - 4) * (j - 4));
  ASSERT_EQ(solver.Solve(A, r, lambda, &cold), PETSC_SUCCESS);
  const std::vector<double> before = lambda;
  ASSERT_EQ(solver.Solve(A, r, lambda, &warm), PETSC_SUCCESS);
  EXPECT_EQ(warm.set_updates, 1);
  EXPECT_EQ(warm.linear_iterations, 0);
  EXPECT_EQ(lambda, before);
  EXPECT_EQ(warm.active, cold.active);
}

TEST(ActiveSet, NothingTouches)
{
  ActiveSetSolver solver;
  ActiveSetReport report;
  ASSERT_EQ(solver.Create(true), PETSC_SUCCESS);
  std::vector<double> lambda = {0.5, 0, 2}, none;
  BandMatrix empty;
  ASSERT_EQ(solver.Solve(RandomMatrix(3, 2, 1, 0), {-1, -2, -0.1}, lambda, &report), PETSC_SUCCESS);
  EXPECT_EQ(lambda, std::vector<double>(3, 0.0));
  EXPECT_EQ(report.active, 0);
  ASSERT_EQ(solver.Solve(empty, {}, none, &report), PETSC_SUCCESS);
  EXPECT_EQ(report.set_updates, 0);
}

/// A circulant with 1 and 2: from {2} the set goes round {2, 1}, {3, 1}, {3, 2} for ever (Ben Gharbia and Gilbert 2012).
TEST(ActiveSet, GivesUpWhereTheSetGoesRound)
{
  ActiveSetSolver solver;
  ActiveSetReport report;
  BandMatrix A;
  A.Reset(3, 2);
  for (int j = 0; j < 3; ++j) A.At(j, j) = 1, A.At(j, (j + 2) % 3) = 2;
  const std::vector<double> r = {1, 1.1, 0.9};
  ASSERT_EQ(solver.Create(false), PETSC_SUCCESS);
  std::vector<double> lambda = {0, 1, 0};
  ASSERT_EQ(solver.Solve(A, r, lambda, &report), PETSC_SUCCESS);
  EXPECT_TRUE(report.fallback);
  EXPECT_GT(report.set_updates, 3);
  EXPECT_LE(report.set_updates, 100);
  for (int j = 0; j < 3; ++j) EXPECT_DOUBLE_EQ(lambda[j], r[j] / 3) << "each by itself, by the sum of its row";
}
