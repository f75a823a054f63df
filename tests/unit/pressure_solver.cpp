// The solver of pressures with bounds: against the solution found by trying every set, and with a tip that travels under a load.
#include "contact/pressure_solver.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// A small problem with all the entries of its matrix.
struct SmallProblem : PressureProblem {
  std::vector<double> matrix; ///< [rows][rows]

  int Size() const override { return static_cast<int>(gaps_.size()); }
  double At(int row, int column) const { return matrix[static_cast<std::size_t>(row) * Size() + column]; }
  void Multiply(const double *q, double *y) const override
  {
    for (int j = 0; j < Size(); ++j) {
      y[j] = 0;
      for (int k = 0; k < Size(); ++k) y[j] += At(j, k) * q[k];
    }
  }
  void Diagonal(double *diagonal) const override
  {
    for (int j = 0; j < Size(); ++j) diagonal[j] = At(j, j);
  }

  /// B^T B + a diagonal, of size `scale`, with gaps that suit pressures of order 1.
  SmallProblem(int size, double scale)
  {
    std::vector<double> B(static_cast<std::size_t>(size) * size);
    for (double &b : B) b = Random(-0.3, 1);
    for (int j = 0; j < size; ++j) {
      gaps_.push_back(scale * Random(-1, 1));
      closing_.push_back(scale * Random(0.5, 1));
      for (int k = 0; k < size; ++k) {
        matrix.push_back(scale * (j == k ? 0.3 : 0));
        for (int m = 0; m < size; ++m) matrix.back() += scale * B[m * size + j] * B[m * size + k];
      }
    }
  }
  /// Of a body that yields to few shapes of pressures, by far less to others: rows are nearly alike.
  static SmallProblem Stiff(int size, int shapes, double other)
  {
    SmallProblem problem(0, 1);
    std::vector<double> B(static_cast<std::size_t>(shapes) * size);
    for (double &b : B) b = Random(-0.3, 1);
    for (int j = 0; j < size; ++j) {
      problem.gaps_.push_back(Random(-1, 0.5)), problem.closing_.push_back(1);
      for (int k = 0; k < size; ++k) {
        problem.matrix.push_back(j == k ? other : 0);
        for (int m = 0; m < shapes; ++m) problem.matrix.back() += B[m * size + j] * B[m * size + k];
      }
    }
    return problem;
  }
  /// A q + gaps - u closing.
  std::vector<double> Slack(const std::vector<double> &q, double travel) const
  {
    std::vector<double> slack(q.size());
    Multiply(q.data(), slack.data());
    for (int k = 0; k < Size(); ++k) slack[k] += gaps_[k] - travel * closing_[k];
    return slack;
  }
  double LoadOf(const std::vector<double> &q) const
  {
    double load = 0;
    for (int k = 0; k < Size(); ++k) load += closing_[k] * q[k];
    return load;
  }
};

/// Solves the equations of the chosen rows by Gauss elimination, the others being zero.
std::vector<double> SolveChosen(const SmallProblem &A, unsigned chosen)
{
  const int n = A.Size();
  std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1, 0.0));
  for (int j = 0; j < n; ++j) {
    rows[j][j] = 1;
    if (!(chosen >> j & 1)) continue;
    for (int k = 0; k < n; ++k) rows[j][k] = chosen >> k & 1 ? A.At(j, k) : 0;
    rows[j][n] = -A.Gaps()[j];
  }
  for (int pivot = 0; pivot < n; ++pivot)
    for (int j = 0; j < n; ++j) {
      if (j == pivot) continue;
      const double factor = rows[j][pivot] / rows[pivot][pivot];
      for (int k = 0; k <= n; ++k) rows[j][k] -= factor * rows[pivot][k];
    }
  std::vector<double> q(n);
  for (int j = 0; j < n; ++j) q[j] = rows[j][n] / rows[j][j];
  return q;
}

/// The q of the one set of rows that leaves no negative q and no negative slack.
std::vector<double> ByEnumeration(const SmallProblem &A)
{
  for (unsigned chosen = 0; chosen < 1U << A.Size(); ++chosen) {
    const std::vector<double> q = SolveChosen(A, chosen), slack = A.Slack(q, 0);
    bool good = true;
    for (int j = 0; j < A.Size(); ++j) good = good && q[j] >= -1e-12 && slack[j] >= -1e-12 * A.At(j, j);
    if (good) return q;
  }
  return {};
}

void ExpectConditions(const SmallProblem &problem, const std::vector<double> &q, double travel, double scale)
{
  const std::vector<double> slack = problem.Slack(q, travel);
  for (std::size_t k = 0; k < q.size(); ++k) {
    EXPECT_GE(q[k], 0);
    EXPECT_GE(slack[k] / scale, -1e-6);
    EXPECT_LE(q[k] * slack[k] / scale, 1e-6);
  }
}

TipStep FreeTip(double load, double most_travel) { return {{}, {}, LoadInStep{load, most_travel}}; }

} // namespace

TEST(PressureSolver, FindsTheOnlySolution)
{
  for (const double scale : {1.0, 1e-30}) { // entries have the size of dt^2/m
    PressureSolver solver;
    int some = 0;
    ASSERT_EQ(solver.Create(), PETSC_SUCCESS);
    for (int n = 0; n < 40; ++n) {
      const SmallProblem problem(n % 2 ? 7 : 9, scale); // the solver changes its size
      std::vector<double> q(problem.Size());
      for (double &value : q) value = n % 3 ? Random(0, 1) : 0; // warm and cold starts
      const std::vector<double> exact = ByEnumeration(problem);
      ASSERT_EQ(exact.size(), q.size());
      PressureReport report;
      ASSERT_EQ(solver.Solve(problem, {}, 0, &q, &report), PETSC_SUCCESS);
      EXPECT_TRUE(report.solved);
      int pressing = 0;
      for (std::size_t k = 0; k < q.size(); ++k) {
        EXPECT_NEAR(q[k], exact[k], 1e-8);
        pressing += exact[k] > 1e-12;
      }
      EXPECT_EQ(report.pressing, pressing);
      some += pressing > 0 && pressing < problem.Size();
    }
    EXPECT_GE(some, 20) << "problems with a set of some but not all";
  }
}

/// Where the minimum over a set, cut off at zero, lies uphill, it goes a part of the way.
TEST(PressureSolver, EndsWhereRowsAreNearlyAlike)
{
  PressureSolver solver;
  ASSERT_EQ(solver.Create(), PETSC_SUCCESS);
  for (int n = 0; n < 100; ++n) {
    const SmallProblem problem = SmallProblem::Stiff(60, 6 + n % 20, n % 2 ? 1e-2 : 1e-3);
    std::vector<double> q(problem.Size(), n % 3 ? 1.0 : 0.0);
    PressureReport report;
    ASSERT_EQ(solver.Solve(problem, {}, 0, &q, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved) << "problem " << n;
    const std::vector<double> slack = problem.Slack(q, 0);
    for (std::size_t k = 0; k < q.size(); ++k) {
      EXPECT_GE(slack[k], -1e-6);
      EXPECT_LE(std::min(q[k], slack[k]), 1e-6);
    }
  }
}

TEST(PressureSolver, CarriesALoad)
{
  constexpr double kScale = 1e-20;
  PressureSolver solver;
  ASSERT_EQ(solver.Create(), PETSC_SUCCESS);
  for (int n = 0; n < 40; ++n) {
    const SmallProblem problem(9, kScale);
    std::vector<double> q(problem.Size(), n % 2 ? 1.0 : 0.0);
    PressureReport report;
    const double load = kScale * Random(0.01, 5), more = n % 3 ? 0 : 0.2 * load;
    ASSERT_EQ(solver.Solve(problem, FreeTip(load - more, 1e3), more, &q, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved && !report.limited);
    EXPECT_NEAR(problem.LoadOf(q), load, 1e-14 * load);
    ExpectConditions(problem, q, report.travel, kScale);
  }
}

/// A load beyond what the tip may travel for: as far as it may, with what that gives.
TEST(PressureSolver, StopsAtTheMostTravel)
{
  PressureSolver solver;
  const SmallProblem problem(9, 1);
  std::vector<double> q(problem.Size());
  PressureReport report;
  ASSERT_EQ(solver.Create(), PETSC_SUCCESS);
  ASSERT_EQ(solver.Solve(problem, FreeTip(1e6, 0.5), 0, &q, &report), PETSC_SUCCESS);
  EXPECT_TRUE(report.solved && report.limited);
  EXPECT_EQ(report.travel, 0.5);
  ExpectConditions(problem, q, 0.5, 1);
}
