// The equations of contact on any number of ranks.
#include "contact_body.hpp"
#include "level/contact/system.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(11);

/// Random couplings of 12 unknowns with nodes of the grid, the same on all ranks.
std::vector<ContactCoupling> RandomCouplings()
{
  std::vector<ContactCoupling> couplings;
  for (int n = 0; n < 400; ++n) {
    const int unknown = n % 12;
    const Vec3 B = {Random(-0.1, 0.1), -Random(0.2, 1)};
    couplings.push_back({{unknown + static_cast<int>(Random(0, 3)), 5 + static_cast<int>(Random(0, 2)), 0}, unknown, B, B});
  }
  return couplings;
}

/// lambda by projected Gauss-Seidel on the whole matrix, which is formed node by node as the equations say.
std::vector<double> BySweeps(const std::vector<ContactCoupling> &couplings, const std::vector<ContactUnknown> &unknowns,
                             double dt, double (*mass)(Index), Vec3 (*velocity)(Index))
{
  const std::size_t n = unknowns.size();
  std::vector<double> A(n * n), lambda(n);
  for (const ContactCoupling &a : couplings)
    for (const ContactCoupling &b : couplings)
      if (a.node == b.node) A[n * a.unknown + b.unknown] += dt * dt * Dot(a.constraint, b.traction) / mass(a.node);
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(A[n * j + k], A[n * k + j], 1e-15 * A[n * j + j]) << "symmetric";
  for (int sweep = 0; sweep < 5000; ++sweep)
    for (std::size_t j = 0; j < n; ++j) {
      double rest = -unknowns[j].gap;
      for (const ContactCoupling &c : couplings)
        if (c.unknown == static_cast<int>(j)) rest -= dt * Dot(c.constraint, velocity(c.node));
      for (std::size_t k = 0; k < n; ++k) rest -= k == j ? 0 : A[n * j + k] * lambda[k];
      lambda[j] = std::max(0.0, rest / A[n * j + j]);
    }
  return lambda;
}

double MassOf(Index node) { return 1 + 0.3 * std::sin(node[0] + 7.0 * node[1]); }
Vec3 VelocityOf(Index node) { return {0.2 * std::cos(3.0 * node[0]), 1 + std::sin(2.0 * node[0] + node[1])}; }

} // namespace

/// One unknown is on one of three ranks, and none on the others.
TEST(ContactSystemOnRanks, FewerUnknownsThanRanks)
{
  PressedBody body;
  ContactReport report;
  ContactSettings settings;
  ContactSystem system;
  settings.serial_unknowns = 1;
  ASSERT_EQ(body.Create(PETSC_COMM_WORLD), PETSC_SUCCESS);
  std::fill_n(body.grid.Sums(), body.grid.GhostedNodes(), NodeSums{1, 1, {1, 1, 1}, {1, 1, 1}});
  ASSERT_EQ(system.Create(true, 0, settings), PETSC_SUCCESS);
  const std::vector<ContactCoupling> couplings = {{{8, 8, 0}, 0, {0, -1}, {0, -1}}}; // each rank's
  PetscMPIInt ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  ASSERT_EQ(system.Solve(body.View(), {{0, -1e-6 * ranks}}, couplings, kAnyToAny, &report), PETSC_SUCCESS);
  EXPECT_NEAR(system.Lambda()[0], 1.0 / ranks, 1e-12) << "A = (dt ranks)^2, r = dt^2 ranks";
}

/// Couplings of one node on several ranks, solved on one rank and on all: the solution of the whole problem.
TEST(ContactSystemOnRanks, SolvesTheWholeProblem)
{
  PetscMPIInt rank, ranks;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Random.seed(11);
  std::vector<ContactUnknown> unknowns;
  for (int j = 0; j < 12; ++j) unknowns.push_back({1000 + 3 * j, 0.02 * std::sin(0.9 * j) - 0.01});
  const std::vector<ContactCoupling> all = RandomCouplings();
  std::vector<ContactCoupling> own;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (static_cast<int>(k * 7 / 5 % ranks) == rank) own.push_back(all[k]);
  std::vector<double> before;
  for (int serial_unknowns : {1000, 1, 1}) {
    PressedBody body;
    ContactReport report;
    ContactSettings settings;
    ContactSystem system;
    settings.serial_unknowns = serial_unknowns;
    ASSERT_EQ(body.Create(PETSC_COMM_WORLD), PETSC_SUCCESS);
    const Grid &grid = body.grid;
    ForEach(grid.Owned(), [&](Index node) {
      const std::ptrdiff_t place = grid.Place(node);
      grid.Sums()[place].mass = MassOf(node);
      for (int d = 0; d < 2; ++d) grid.Velocity(place).velocity[d] = VelocityOf(node)[d];
    });
    ASSERT_EQ(system.Create(true, 0, settings), PETSC_SUCCESS);
    const ContactView view = body.View();
    ASSERT_EQ(system.Solve(view, unknowns, own, kAnyToAny, &report), PETSC_SUCCESS);
    const std::vector<double> lambda = BySweeps(all, unknowns, view.dt, MassOf, VelocityOf);
    const double largest = *std::max_element(lambda.begin(), lambda.end());
    int loaded = 0;
    for (int j = 0; j < 12; ++j) {
      EXPECT_NEAR(system.Lambda()[j], lambda[j], 1e-8 * largest);
      EXPECT_EQ(system.Pressures().count(unknowns[j].key), lambda[j] > 0 ? 1U : 0U);
      loaded += lambda[j] > 0;
    }
    EXPECT_TRUE(loaded > 2 && loaded < 12) << loaded;
    Vec3 impulse{};
    for (const ContactCoupling &c : all) impulse = impulse + view.dt * lambda[c.unknown] * c.traction;
    MPI_Allreduce(MPI_IN_PLACE, report.impulse.data(), 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_LE(Norm(report.impulse - impulse), 1e-8 * Norm(impulse));
    EXPECT_EQ(report.set_updates > 0, rank == 0);
    if (!before.empty()) { EXPECT_EQ(system.Lambda(), before) << "the same to the last digit"; }
    if (serial_unknowns == 1) before = system.Lambda();
  }
}

/// Contact closes the gap with the motion of light nodes, which lacks a part of what their momentum gets.
TEST(ContactSystem, ReckonsWithLeastMasses)
{
  PressedBody body;
  ContactReport report;
  ContactSystem system;
  ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
  const Grid &grid = body.grid;
  const double mass = 1e-3, least = 0.25, p = 0.002, force = 0.03; // kg, m/s, N s
  std::vector<double> least_masses(grid.GhostedNodes(), least);
  for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(grid.GhostedNodes()); ++k) {
    grid.Sums()[k] = {};
    grid.Sums()[k].mass = mass, grid.Sums()[k].momentum[1] = p;
    grid.Velocity(k).change[1] = force / mass, grid.Velocity(k).velocity[1] = (p + force) / mass;
  }
  ContactView view = body.View();
  view.least_masses = view.later_masses = least_masses.data();
  ASSERT_EQ(system.Create(true, 0, {}), PETSC_SUCCESS);
  const std::vector<ContactCoupling> couplings = {{{8, 8, 0}, 0, {0, -0.7}, {0, -0.7}}, {{8, 9, 0}, 0, {0, -0.3}, {0, -0.3}}};
  const double gap = -1e-3;
  ASSERT_EQ(system.Solve(view, {{0, gap}}, couplings, kAnyToAny, &report), PETSC_SUCCESS);
  RestrainLightNodes(grid, body.sides, NodalSettings(), 0, least_masses);
  const double approach =
      -0.7 * grid.Velocity(grid.Place({8, 8, 0})).velocity[1] - 0.3 * grid.Velocity(grid.Place({8, 9, 0})).velocity[1];
  EXPECT_NEAR(gap + view.dt * approach, 0, 1e-12);
  const double free = gap - view.dt * (p / mass + force / least); // as both nodes move alike before
  EXPECT_NEAR(report.impulse[1], free / view.dt * least / (0.49 + 0.09), 1e-9) << "with which momentum grows";
  double momentum = 0;
  for (int j : {8, 9}) momentum += mass * (grid.Velocity(grid.Place({8, j, 0})).change[1] - force / mass);
  EXPECT_NEAR(momentum, report.impulse[1], 1e-12);
}
