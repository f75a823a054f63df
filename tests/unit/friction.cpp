// Friction: the tangents of an indenter's surface, and Coulomb's conditions on what the solver finds.
#include "level/contact/active_set.hpp"
#include "level/contact/columns.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

constexpr int kColumns = 15;

/// Columns that act on their neighbours, with pressures and tractions that act on each other a little.
ComplementarityProblem RandomProblem(int tractions, double friction, double scale)
{
  constexpr double kCoupling[3][3] = {{1, 0.1, 0.05}, {0.1, 0.8, 0.1}, {0.05, 0.1, 0.7}};
  const int per_column = 1 + tractions;
  std::vector<double> size(kColumns);
  ComplementarityProblem problem;
  for (double &s : size) s = Random(0.5, 1.5);
  problem.tractions = tractions;
  problem.friction = friction;
  for (int row = 0; row < kColumns * per_column; ++row) {
    const int j = row / per_column, a = row % per_column;
    problem.r.push_back(scale * size[j] * (a == 0 ? Random(-0.3, 1) : Random(-0.6, 0.6)));
    for (int k = std::max(0, j - 1); k <= std::min(kColumns - 1, j + 1); ++k)
      for (int b = 0; b < per_column; ++b) {
        problem.rows.push_back(row);
        problem.columns.push_back(k * per_column + b);
        problem.values.push_back(scale * size[j] * size[k] * (j == k ? 1 : 0.25) * kCoupling[a][b]);
      }
  }
  return problem;
}

/// A x - r - u c.
std::vector<double> Slack(const ComplementarityProblem &problem, const std::vector<double> &x, double travel)
{
  std::vector<double> slack(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) slack[k] = -problem.r[k] - (problem.by_load ? travel * problem.c[k] : 0);
  for (std::size_t e = 0; e < problem.rows.size(); ++e) slack[problem.rows[e]] += problem.values[e] * x[problem.columns[e]];
  return slack;
}

/// How many columns are open, stick and slip, once each has been found to be in order.
struct Counts {
  int open = 0, stick = 0, slip = 0;
};

Counts ExpectCoulomb(const ComplementarityProblem &problem, const std::vector<double> &x, const ActiveSetReport &report,
                     double scale)
{
  const double small = 1e-8;
  const std::vector<double> slack = Slack(problem, x, report.travel);
  const std::size_t per_column = 1 + problem.tractions;
  double heat = 0;
  Counts counts;
  for (std::size_t k = 0; k < x.size(); k += per_column) {
    double tau = 0, slip = 0, along = 0;
    for (std::size_t a = 1; a < per_column; ++a)
      tau += x[k + a] * x[k + a], slip += slack[k + a] * slack[k + a], along += x[k + a] * slack[k + a];
    tau = std::sqrt(tau), slip = std::sqrt(slip) / scale;
    heat -= along;
    EXPECT_GE(x[k], 0);
    EXPECT_GE(slack[k] / scale, -small);
    EXPECT_LE(x[k] * slack[k] / scale, small);
    EXPECT_LE(tau, problem.friction * x[k] * (1 + small) + small);
    if (x[k] == 0) {
      ++counts.open;
    } else if (slip < small) {
      ++counts.stick;
    } else {
      ++counts.slip;
      EXPECT_NEAR(tau, problem.friction * x[k], small) << "what slips is at its bound";
      EXPECT_NEAR(along / scale, -tau * slip, small) << "and pulls against the slip";
    }
  }
  EXPECT_NEAR(report.heat / scale, heat / scale, small);
  return counts;
}

void SolveRandom(int tractions, bool by_load)
{
  constexpr double kScale = 1e-20;
  ActiveSetSolver solver;
  Counts sum;
  ASSERT_EQ(solver.Create(PETSC_COMM_SELF, false), PETSC_SUCCESS);
  for (int trial = 0; trial < 50; ++trial) {
    ComplementarityProblem problem = RandomProblem(tractions, 0.4, kScale);
    std::vector<double> x(problem.r.size());
    ActiveSetReport report;
    if (by_load) {
      problem.by_load = true;
      problem.load = 3;
      problem.most_travel = 1e9 * kScale;
      for (std::size_t k = 0; k < x.size(); ++k)
        problem.c.push_back(k % (1 + tractions) == 0 ? Random(0.5, 1) : Random(-0.5, 0.5));
    }
    ASSERT_EQ(solver.Solve(problem, &x, &report), PETSC_SUCCESS);
    ASSERT_TRUE(report.solved && !report.fallback) << "trial " << trial;
    const Counts counts = ExpectCoulomb(problem, x, report, kScale);
    sum = {sum.open + counts.open, sum.stick + counts.stick, sum.slip + counts.slip};
    double load = 0;
    for (std::size_t k = 0; by_load && k < x.size(); ++k) load += problem.c[k] * x[k];
    if (by_load) { EXPECT_NEAR(load, problem.load, 1e-8); }
  }
  EXPECT_GE(std::min({sum.open, sum.stick, sum.slip}), 10) << "all states occur";
}

} // namespace

/// The tangents and the normal are a basis like that of the axes; under a level face they are the axes.
TEST(Friction, TangentsAreABasis)
{
  for (int up : {1, 2})
    for (int trial = 0; trial < 50; ++trial) {
      Vec3 n = {Random(-1, 1), up == 1 ? 0 : Random(-1, 1), 0};
      n[up] = -Random(0.05, 1);
      n = (1 / Norm(n)) * n;
      for (int a = 0; a < up; ++a) {
        const Vec3 t = SurfaceTangent(n, a, up);
        EXPECT_NEAR(Norm(t), 1, 1e-14);
        EXPECT_NEAR(Dot(t, n), 0, 1e-14);
        EXPECT_GT(t[a], 0) << "it leans the way of its axis";
        for (int b = 0; b < a; ++b) EXPECT_NEAR(Dot(t, SurfaceTangent(n, b, up)), 0, 1e-14);
      }
    }
  EXPECT_EQ(SurfaceTangent({0, 0, -1}, 1, 2), (Vec3{0, 1, 0}));
}

TEST(Friction, ConditionsHoldInThePlane)
{
  SolveRandom(1, false);
  SolveRandom(1, true);
}

TEST(Friction, ConditionsHoldInSpace)
{
  SolveRandom(2, false);
  SolveRandom(2, true);
}
