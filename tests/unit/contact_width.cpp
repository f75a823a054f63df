// Half widths of contacts from given pressures: unknowns that do not act on each other get the pressure that is asked for.
#include "level/contact_system.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

using namespace mlgimp;

namespace
{

constexpr double kH = 0.5;   // m
constexpr int kColumns = 40; // the tip is above the middle one
constexpr double kTip = 0.5 * kColumns * kH;

/// Mean of a pressure by the hat function of the column at the distance x from the tip: what an unknown stands for.
double HatMean(const std::function<double(double)> &pressure, double x)
{
  constexpr int kParts = 400;
  double sum = 0;
  for (int k = 0; k < kParts; ++k) {
    const double part = (2 * k + 1.0) / kParts - 1;
    sum += (1 - std::abs(part)) * pressure(x + part * kH) * 2 / kParts;
  }
  return sum;
}

/// The half width that is found for a pressure over the distance from the tip, on a surface from `start` to `end`.
double HalfWidth(const std::function<double(double)> &pressure, double start, double end)
{
  const GridGeometry geometry = {{0, 0}, kH, {kColumns, 4}, 1};
  Grid grid;
  Points points;
  ContactSystem system;
  ContactReport report;
  std::vector<ContactRow> rows;
  std::vector<ContactEntry> entries;
  const Indenter indenter = {CreateSphere(GeometryKind::kPlaneStrain, 1), {PiecewiseLinear({0}, {0})}, {kTip, 0}, 0};
  const BoundaryConditions sides;
  EXPECT_EQ(grid.Create(PETSC_COMM_SELF, geometry, {{{{geometry.Nodes(0)}, {geometry.Nodes(1)}, {1}}}, {0}}), PETSC_SUCCESS);
  EXPECT_EQ(system.Create(true, 0, false), PETSC_SUCCESS);
  for (int i = 0; i <= kColumns; ++i) {
    const double x = i * kH, from_tip = x - kTip;
    grid.Sums()[grid.Place({i, 0, 0})].mass = 1;
    // With unit time step, mass and force the condition reads gap + lambda >= 0.
    rows.push_back({i, 1, -HatMean(pressure, from_tip), x, std::max(x - kH, kTip + start), std::min(x + kH, kTip + end)});
    entries.push_back({i, i, 0, {0, 1}, {0, 1}});
  }
  const ContactView view = {grid, points, sides, indenter, 1, 0, 0, 1};
  EXPECT_EQ(system.Solve(view, rows, entries, 0, &report), PETSC_SUCCESS);
  EXPECT_TRUE(report.solved);
  for (int i = 0; i <= kColumns; ++i) {
    const double asked = HatMean(pressure, i * kH - kTip);
    const auto found = system.Pressures().find(i);
    EXPECT_NEAR(found == system.Pressures().end() ? 0 : found->second, std::max(asked, 0.0), 1e-9);
  }
  return report.half_width;
}

} // namespace

/// p = sqrt(1 - (x/a)^2) and arcosh(a/|x|): the edge is found to a part of a cell, wherever it lies between nodes.
TEST(ContactWidth, CylinderAndWedge)
{
  for (double a = 10 * kH; a < 11 * kH; a += 0.09 * kH) {
    const auto cylinder = [a](double x) { return std::abs(x) < a ? std::sqrt(1 - x * x / (a * a)) : 0; };
    const auto wedge = [a](double x) { return std::abs(x) < a ? std::acosh(a / std::abs(x)) : 0; };
    EXPECT_NEAR(HalfWidth(cylinder, -15 * kH, 15 * kH), a, 0.15 * kH);
    EXPECT_NEAR(HalfWidth(wedge, -15 * kH, 15 * kH), a, 0.15 * kH);
    EXPECT_NEAR(HalfWidth(wedge, 0, 15 * kH), a, 0.15 * kH) << "half of a symmetric case";
  }
}

/// Where the pressure does not fall to the edge, the end of the surface is the end of the contact.
TEST(ContactWidth, FlatPunch)
{
  constexpr double kReach = 6.3 * kH;
  const auto punch = [](double x) { return std::abs(x) < kReach ? 1 / std::sqrt(1 - x * x / (6.6 * 6.6 * kH * kH)) : 0; };
  EXPECT_NEAR(HalfWidth(punch, -kReach, kReach), kReach, 1e-12);
}

TEST(ContactWidth, NoContact)
{
  EXPECT_EQ(HalfWidth([](double) { return -1.0; }, -15 * kH, 15 * kH), 0);
}
