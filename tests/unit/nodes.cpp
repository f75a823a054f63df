// What is done to the velocities of nodes.
#include "level/nodes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

using namespace mlgimp;

namespace
{

constexpr double kFull = 2; // kg

/// A grid of 4 x 4 cells of 0.5 m whose nodes have a mass, a velocity (3, -4) and a change of it (1, 2), m/s.
PetscErrorCode Fill(Grid *grid, double mass)
{
  const GridGeometry shape = {{0, 0, 0}, 0.5, {4, 4}, 1};
  GridLayout layout;
  PetscFunctionBeginUser;
  for (int axis = 0; axis < 3; ++axis) layout.widths[axis] = {shape.Nodes(axis)};
  layout.ranks = {0};
  PetscCall(grid->Create(PETSC_COMM_SELF, shape, layout));
  ForEach(grid->Ghosted(), [&](Index node) {
    const std::ptrdiff_t place = grid->Place(node);
    const auto [velocity, change] = grid->Velocity(place);
    grid->Sums()[place].mass = mass;
    velocity[0] = 3, velocity[1] = -4, change[0] = 1, change[1] = 2;
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The velocity of a node when light nodes of such a mass have been restrained, with the left side held as a plane of symmetry.
/// held_back: its motion is so already.
std::array<double, 2> Restrained(double mass, Index node, bool hoop, bool held_back = false)
{
  BoundaryConditions sides;
  NodalSettings settings;
  sides.kind[0] = BoundaryKind::kSymmetry;
  settings.full_mass = kFull, settings.mass_cutoff = kEmptyNode * kFull;
  Grid grid;
  EXPECT_EQ(Fill(&grid, mass), PETSC_SUCCESS);
  std::vector<double> least_masses = LeastMasses(grid, settings, hoop);
  if (held_back) least_masses[grid.Place(node)] = 0;
  RestrainLightNodes(grid, sides, settings, 0, least_masses);
  const auto [velocity, change] = grid.Velocity(grid.Place(node));
  EXPECT_EQ(change[1], 2);
  return {velocity[0], velocity[1]};
}

TEST(LightNodes, KeepTheirVelocityBeforeTheStep)
{
  const double light = kLeastMass * kFull;
  EXPECT_NEAR(Restrained(0.5 * light, {1, 1, 0}, false)[1], -4 - 0.5 * 2, 1e-14);
  EXPECT_NEAR(Restrained(1e-9 * light, {1, 1, 0}, false)[1], -4 - 2, 1e-8);
  EXPECT_EQ(Restrained(1.01 * light, {1, 1, 0}, false)[1], -4);
  EXPECT_EQ(Restrained(0.5 * kEmptyNode * kFull, {1, 1, 0}, false)[1], -4) << "an empty node has no velocity";
}

TEST(LightNodes, AreLightForTheirRadius)
{
  const double light = kLeastMass * kFull;
  EXPECT_NEAR(Restrained(1.5 * light, {3, 1, 0}, true)[1], -4 - 0.5 * 2, 1e-14);
  EXPECT_NEAR(Restrained(light / 12, {0, 1, 0}, true)[1], -4 - 0.5 * 2, 1e-14);
}

TEST(LightNodes, StayAtSides)
{
  EXPECT_EQ(Restrained(1e-6, {0, 1, 0}, true)[0], 0);
  EXPECT_NE(Restrained(1e-6, {1, 1, 0}, true)[0], 0);
}

TEST(LightNodes, AreLeftAloneWhereAnotherLevelMovesThem)
{
  EXPECT_EQ(Restrained(1e-6, {2, 1, 0}, false, true)[1], -4);
  EXPECT_NE(Restrained(1e-6, {2, 1, 0}, false)[1], -4);
}

/// What steps of XPIC leave of a velocity that the projection has nothing of.
double LeftOfNoise(const XpicSchedule &xpic, int steps)
{
  double left = 1;
  for (long step = 0; step < steps; ++step) left *= 1 - xpic.InStep(step);
  return left;
}

TEST(Xpic, OfSeveralStepsTakesWhatItWouldStepByStep)
{
  constexpr int kSteps = 24;
  for (const double fraction : {0.0, 0.001, 0.02, 0.03, 0.05, 0.5})
    for (const double steps : {1.0, 2.0, 25.0})
      EXPECT_NEAR(LeftOfNoise({fraction, steps}, kSteps), std::pow(1 - fraction / steps, kSteps), 1e-13) << fraction;
  for (const auto &[fraction, interval] : {std::pair{0.02, 4}, {0.001, 4}, {0.021, 3}, {0.04, 2}, {0.05, 1}, {1.0, 1}}) {
    const XpicSchedule xpic(fraction, 2);
    for (int step = 0; step < kSteps; ++step)
      EXPECT_EQ(xpic.InStep(step) > 0, step % interval == interval - 1) << fraction << " in step " << step;
  }
}

} // namespace
