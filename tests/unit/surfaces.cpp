// Indenters, histories and tilings by their properties.
#include "pointwise/indenter.hpp"
#include "pointwise/region.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

using namespace mlgimp;

namespace
{

std::mt19937 generator(20240607);
double Random(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(generator); }

/// Height of a surface at x, by bisection of the gap along the vertical.
double Height(const IndenterSurface &surface, double x, double upper)
{
  double below = -1e-3, above = upper;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (below + above);
    (surface.Gap({x, middle}).distance > 0 ? below : above) = middle;
  }
  return 0.5 * (below + above);
}

/// width: of the part of the surface that is looked at, whose height is below `height`.
void CheckSurface(const std::string &name, const IndenterSurface &surface, double width, double height)
{
  double unit = 0, gradient = 0, lowest = HUGE_VAL;
  bool signs = true;
  for (int n = 0; n < 200; ++n) {
    constexpr double kStep = 1e-6;
    const double x = Random(-width, width), y = Height(surface, x, height);
    const Vec3 normal = surface.Gap({x, y}).normal;
    unit = std::max(unit, std::abs(Norm(normal) - 1));
    for (int a = 0; a < 2 && std::abs(x) > 1e-4; ++a) {
      Vec3 above = {x, y}, below = {x, y};
      above[a] += kStep, below[a] -= kStep;
      const double slope = (surface.Gap(above).distance - surface.Gap(below).distance) / (2 * kStep);
      gradient = std::max(gradient, std::abs(slope - normal[a]));
    }
    signs &= surface.Gap(Vec3{x, y} + 1e-3 * normal).distance > 0 && surface.Gap(Vec3{x, y} + -1e-3 * normal).distance < 0;
    lowest = std::min(lowest, y);
  }
  EXPECT_LE(unit, 1e-14) << name + ": length of the normal less one";
  EXPECT_LE(gradient, 1e-6) << name + ": normal less gradient of the gap, on the surface";
  EXPECT_TRUE(signs) << name + ": gap is positive outside and negative inside";
  EXPECT_GT(lowest, -1e-12) << name + ": nothing lies below the tip";
  EXPECT_LE(std::abs(surface.Gap({0, 0}).distance), 1e-15) << name + ": gap at the tip";
  EXPECT_LE(std::abs(surface.Gap({0, -0.01}).distance - 0.01), 0.01 * 0.07) << name + ": gap below the tip"; // 1 - cos 19.7
}

TEST(Surfaces, Indenters)
{
  constexpr double kHalfAngle = 70.3, kTipRadius = 0.2;
  const double slope = 1 / std::tan(kHalfAngle * M_PI / 180);
  CheckSurface("wedge", *CreateWedge(kHalfAngle, 0), 1, 1);
  const auto rounded = CreateWedge(kHalfAngle, kTipRadius);
  CheckSurface("rounded wedge", *rounded, 1, 1);
  CheckSurface("cylinder", *CreateCylinder(2), 1.5, 2);
  CheckSurface("flat punch", *CreateFlatPunch(2), 0.99, 1);
  CheckSurface("polygon", *CreatePolygonIndenter({{3, 7}, {5, 7.6}, {5, 10}, {1, 10}, {1, 7.5}}), 1.9, 1);
  const double x = 1e-3 * kTipRadius, height = Height(*rounded, x, 1);
  EXPECT_LE(std::abs(x * x / (2 * height) / kTipRadius - 1), 1e-5) << "rounded wedge: radius of curvature at the tip";
  EXPECT_LE(std::abs((Height(*rounded, 1001, 1000) - Height(*rounded, 1000, 1000)) / slope - 1), 1e-6)
      << "rounded wedge: slope far from the tip";
  EXPECT_LE(std::abs(Height(*CreateWedge(kHalfAngle, 0), 1, 1) / slope - 1), 1e-12) << "wedge: slope";
  EXPECT_LE(std::abs(Height(*CreateCylinder(2), 1, 2) - (2 - std::sqrt(3))), 1e-12) << "cylinder: height";
  EXPECT_LE(std::abs(CreateCylinder(2)->Gap({3, -2}).distance - 3), 1e-14) << "cylinder: gap at a distance";
  EXPECT_TRUE(IsConvex({{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_TRUE(IsConvex({{0, 1}, {1, 0}, {0, 0}}));
  EXPECT_FALSE(IsConvex({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}));
}

TEST(Surfaces, Histories)
{
  const PiecewiseLinear speed({0.5, 1, 3, 4}, {0, 2, 2, -1});
  EXPECT_EQ(speed.Value(0), 0);
  EXPECT_EQ(speed.Value(0.75), 1);
  EXPECT_EQ(speed.Value(2), 2);
  EXPECT_EQ(speed.Value(3.5), 0.5);
  EXPECT_EQ(speed.Value(9), -1);
  double worst = 0, sum = 0;
  constexpr int kParts = 5000;
  for (int n = 0; n < kParts; ++n) { // knots fall on ends of parts, where the trapezium rule is exact
    const double t = 5.0 * n / kParts, next = 5.0 * (n + 1) / kParts;
    sum += 0.5 * (speed.Value(t) + speed.Value(next)) * (next - t);
    worst = std::max(worst, std::abs(speed.Integral(next) - sum));
  }
  EXPECT_LE(worst, 1e-12) << "history: integral";
  EXPECT_LE(std::abs(PiecewiseLinear({2}, {3}).Integral(1.5) - 4.5), 1e-15) << "history: constant one";
  EXPECT_EQ(PiecewiseLinear().Value(1), 0) << "a history of nothing";
  EXPECT_EQ(PiecewiseLinear().Integral(1), 0);
  EXPECT_TRUE(std::isinf(PiecewiseLinear().TimeOfIntegral(1, 10)));
  // The integral grows to 0.5 + 4 + 2/3 at t = 3 + 2/3 and falls again.
  worst = 0;
  for (double target : {1e-9, 0.1, 0.5, 2.0, 4.5, 5.0, 5.16})
    worst = std::max(worst, std::abs(speed.Integral(speed.TimeOfIntegral(target, 10)) - target) +
                                (speed.TimeOfIntegral(target, 10) < 3.667 ? 0 : 1));
  EXPECT_LE(worst, 1e-12) << "history: first time of an integral";
  EXPECT_TRUE(std::isinf(speed.TimeOfIntegral(5.17, 10))) << "never reached";
  EXPECT_TRUE(std::isinf(speed.TimeOfIntegral(2, 1.5))) << "not reached in time";

  const Indenter indenter = {CreateCylinder(1), {speed, 2, 0.5}, {3, 7}, 6};
  EXPECT_LE(std::abs(indenter.Depth(1.5) - (0.5 + 1 - 1)), 1e-14) << "motion: depth before turning";
  EXPECT_LE(std::abs(indenter.Depth(3) - (2.5 - 0.5 - 1)), 1e-14) << "motion: depth after turning";
  EXPECT_EQ(indenter.Velocity(1.5)[1], -2);
  EXPECT_EQ(indenter.Velocity(3)[1], 0.5);
  EXPECT_EQ(indenter.Velocity(3)[0], 0);
  EXPECT_LE(std::abs(indenter.Gap(indenter.Tip(1.7), 1.7).distance), 1e-14) << "motion: gap moves with the tip";
}

TEST(Surfaces, Tilings)
{
  double area = 0, outside = 0, other = 0, miss = 0;
  for (int n = 0; n < 200; ++n) {
    const double h = Random(0.1, 2);
    const Vec3 origin = {Random(-3, 3), Random(-3, 3)};
    Box box = {{origin[0] + Random(0, 3), origin[1] + Random(0, 3)}, {}};
    box.upper = {box.lower[0] + Random(0.05, 6), box.lower[1] + Random(0.05, 6)};
    if (n % 4 == 0)
      box.lower[0] = origin[0] + h, box.upper[0] = origin[0] + h + (0.1 + 0.2) / 0.1 * h; // sides on nodes but for round-off
    const Tiling tiling(box, origin, h, 1 + n % 4);
    double sum = 0;
    const int last[2] = {static_cast<int>((box.upper[0] - origin[0]) / h) + 1,
                         static_cast<int>((box.upper[1] - origin[1]) / h) + 1};
    for (int j = -1; j <= last[1]; ++j)
      for (int i = -1; i <= last[0]; ++i)
        for (const Tile &tile : tiling.InCell({i, j, 0})) {
          Tile found;
          other = std::max(other, tiling.At(tile.center, found) ? Norm(found.center - tile.center) : HUGE_VAL);
          for (int a = 0; a < 2; ++a)
            outside = std::max(
                {outside, box.lower[a] - tile.center[a] + tile.half_size[a], tile.center[a] + tile.half_size[a] - box.upper[a]});
          sum += 4 * tile.half_size[0] * tile.half_size[1];
        }
    area = std::max(area, std::abs(sum / ((box.upper[0] - box.lower[0]) * (box.upper[1] - box.lower[1])) - 1));
    for (int k = 0; k < 20; ++k) {
      const Vec3 x = {Random(box.lower[0], box.upper[0]), Random(box.lower[1], box.upper[1])};
      Tile tile;
      const bool found = tiling.At(x, tile);
      for (int a = 0; a < 2; ++a) miss = std::max(miss, found ? std::abs(x[a] - tile.center[a]) - tile.half_size[a] : HUGE_VAL);
    }
  }
  EXPECT_LE(area, 1e-12) << "tiling: area less the box's, relative";
  EXPECT_LE(outside, 1e-12) << "tiling: tiles beyond the box by";
  EXPECT_LE(other, 1e-12) << "tiling: the tile at a tile's centre is another by";
  EXPECT_LE(miss, 1e-12) << "tiling: places outside the tile found for them by";
}

} // namespace
