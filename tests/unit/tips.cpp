// Tips by area functions, tables and maps, and tilted ones, against the closed formulas that they stand for.
#include "physics/tips/area_function.hpp"
#include "physics/tips/half_spaces.hpp"
#include "physics/tips/height_map.hpp"
#include "physics/tips/profiles.hpp"
#include "physics/tips/tilted.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20261129);

constexpr GeometryKind kSpace = GeometryKind::kSpatial;
constexpr double kDegree = M_PI / 180;

/// Largest differences of distances and normals of two surfaces near them, at some thousand places up to a height.
struct Difference {
  double distance = 0, normal = 0;
};
Difference Compare(const IndenterSurface &a, const IndenterSurface &b, double size, double near)
{
  Difference largest;
  for (int n = 0; n < 4000; ++n) {
    const Vec3 x = {Random(-size, size), Random(-size, size), Random(-0.1 * size, 0.4 * size)};
    const SurfaceGap one = a.Gap(x), other = b.Gap(x);
    if (std::abs(one.distance) > near) continue;
    largest.distance = Largest({largest.distance, std::abs(one.distance - other.distance)});
    largest.normal = Largest({largest.normal, Norm(one.normal - other.normal)});
  }
  return largest;
}

/// Coefficients in m of those in nm: A = sum C_k h^(2^(1-k)).
std::vector<double> FromNanometres(const std::vector<double> &in_nm)
{
  std::vector<double> in_m;
  for (std::size_t k = 0; k < in_nm.size(); ++k) in_m.push_back(in_nm[k] * std::pow(10, 9 * (std::pow(2, 1.0 - k) - 2)));
  return in_m;
}
const std::vector<double> kVendor = {32.9049, -6418.303798, 288484.8518, -989287.0625, 103588.5588, 675977.3345};

/// Half angle of the cone with the same area, degrees.
double ConeAngle(const AreaFunction &area, double depth)
{
  return std::atan(std::sqrt(area.Area(depth) / M_PI) / depth) / kDegree;
}

TEST(Tips, AreaFunctionOfAVendor)
{
  const auto area = AreaFunction::Create(FromNanometres(kVendor), 0, 5e-6);
  ASSERT_TRUE(area);
  const double depths[] = {50e-9, 100e-9, 150e-9, 300e-9, 1e-6},
               angles[] = {78.865, 76.308, 74.871, 73.176, 72.430}; // by hand in nm
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(ConeAngle(*area, depths[k]), angles[k], 1e-3) << depths[k];
  const double begin = area->Begin(), little = 1e-6 * begin;
  EXPECT_GT(begin, 16e-9);
  EXPECT_LT(begin, 17e-9);
  EXPECT_NEAR(area->Area(begin - little) / area->Area(begin + little), 1, 1e-5) << "areas meet";
  EXPECT_NEAR(area->Slope(begin - little) / area->Slope(begin + little), 1, 1e-5) << "slopes meet";
  double grows = 1;
  for (double depth = 1e-11; depth < 5e-6; depth *= 1.01) grows = std::min(grows, area->Slope(depth));
  EXPECT_GT(grows, 0);
  EXPECT_FALSE(AreaFunction::Create(FromNanometres({24.5, -1e5}), 0, 1e-6)) << "it has no area below 4 um";
  EXPECT_NEAR(AreaFunction::Create(FromNanometres({24.5, -50}), 0, 1e-6)->Begin() / (50 / 24.5 * 21e-9), 1, 1e-2)
      << "p is 2.05 there";
  EXPECT_FALSE(AreaFunction::Create({-24.5}, 0, 1e-6));
}

/// The factors between the units, by themselves: 10^(9 (2 - 1/2^(k - 1))) for C_k.
TEST(Tips, AreaFunctionInOtherUnits)
{
  const double factors[] = {1, 1e9, std::pow(10, 13.5), std::pow(10, 15.75), std::pow(10, 16.875)};
  for (int k = 0; k < 5; ++k) {
    std::vector<double> in_nm(5, 0.0);
    in_nm[0] = 24.5, in_nm[k] = k == 0 ? 24.5 : 1000;
    std::vector<double> in_m(5, 0.0);
    in_m[0] = 24.5, in_m[k] = in_nm[k] / factors[k];
    const double nm = 200, root = std::pow(nm, std::pow(2, 1 - k)), expected = 24.5 * nm * nm + (k == 0 ? 0 : 1000 * root);
    EXPECT_NEAR(AreaFunction::Create(in_m, 0, 1e-6)->Area(200e-9) / (1e-18 * expected), 1, 1e-12) << "C" << k;
  }
}

TEST(Tips, AreaFunctionsOfConesAndPyramids)
{
  const double slope = std::tan(70.3 * kDegree);
  const HeightProfile cone = AreaFunction::Create({M_PI * slope * slope}, 0, 10)->ProfileOf(M_PI);
  for (const GeometryKind geometry : {GeometryKind::kAxisymmetric, kSpace}) {
    const auto tip = CreateProfileTip(geometry, cone, {}), same = CreateCone(geometry, 70.3, 0);
    double error = 0;
    for (int n = 0; n < 1000; ++n) {
      const Vec3 x = {Random(-5, 5), Random(-2, 2), geometry == kSpace ? Random(-2, 2) : 0};
      error = Largest(
          {error, std::abs(tip->Gap(x).distance - same->Gap(x).distance), Norm(tip->Gap(x).normal - same->Gap(x).normal)});
    }
    EXPECT_LE(error, 1e-11);
    EXPECT_NEAR(tip->Width(1.5), same->Width(1.5), 1e-11);
  }
  const double tangent = std::tan(65.27 * kDegree), shape = 3 * std::tan(M_PI / 3);
  const auto area = AreaFunction::Create({shape * tangent * tangent}, 0, 10);
  const auto faces = CreateProfilePyramid(area->ProfileOf(shape), 3, 20, {}), berkovich = CreatePyramid(65.27, 3, 20, 0);
  const Difference difference = Compare(*faces, *berkovich, 4, HUGE_VAL);
  EXPECT_LE(difference.distance, 1e-11);
  EXPECT_LE(difference.normal, 1e-11);
  EXPECT_FALSE(faces->MayBeMirrored(1));
  EXPECT_TRUE(CreateProfilePyramid(area->ProfileOf(shape), 3, 0, {})->MayBeMirrored(1));
}

/// A ball by its heights; Fritsch and Carlson's cubics through 200 of them are of third order or better.
TEST(Tips, ProfileThroughHeights)
{
  std::vector<double> distances, heights;
  for (int k = 0; k <= 200; ++k) distances.push_back(0.01 * k), heights.push_back(4 - std::sqrt(16 - 1e-4 * k * k));
  const auto tip = CreateProfileTip(kSpace, ProfileThrough(distances, heights), {0, heights.back()});
  double error = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 x = {Random(-1.3, 1.3), Random(-1.3, 1.3), 0};
    const double rho = std::hypot(x[0], x[1]), height = 4 - std::sqrt(16 - rho * rho);
    error = Largest({error, std::abs(tip->Gap({x[0], x[1], height}).distance)});
  }
  EXPECT_LE(error, 1e-5);
  EXPECT_EQ(tip->KnownHeights().largest, heights.back());
  EXPECT_NEAR(tip->Gap({3, 0, 0}).distance, CreateSphere(kSpace, 4)->Gap({3, 0, 0}).distance, 0.15)
      << "straight on beyond its end";
}

TEST(Tips, PunchWithARoundEdge)
{
  const auto tip = CreateFlatPunch(kSpace, 5, 2);
  EXPECT_EQ(tip->Gap({1, 2, -0.5}).distance, 0.5);
  EXPECT_NEAR(tip->Gap({3 + 2 * std::sin(0.4), 0, 2 - 2 * std::cos(0.4)}).distance, 0, 1e-15);
  EXPECT_NEAR(tip->Gap({0, 3 + 3 * std::sin(0.4), 2 - 3 * std::cos(0.4)}).distance, 1, 1e-15);
  EXPECT_EQ(tip->Gap({7, 0, 3}).distance, 2);
  EXPECT_NEAR(tip->Width(1), 2 * (3 + std::sqrt(3)), 1e-14);
  EXPECT_EQ(tip->Width(4), 10);
}

/// Diagonals 1:7.114, depth a 30.5th of the long one, area of 65.44 h^2.
TEST(Tips, Knoop)
{
  const auto tip = CreateRhombicPyramid(172.5, 130, 0, 0);
  const double a = std::tan(86.25 * kDegree), b = std::tan(65 * kDegree);
  EXPECT_NEAR(a / b, 7.114, 2e-3);
  EXPECT_NEAR(tip->Gap({a, 0, 1}).distance, 0, 1e-13);
  EXPECT_NEAR(tip->Gap({0, b, 1}).distance, 0, 1e-13);
  EXPECT_NEAR(tip->Gap({0.3 * a, 0.7 * b, 1}).distance, 0, 1e-13);
  EXPECT_NEAR(CreateRhombicPyramid(172.5, 130, 90, 0)->Gap({-0.3 * b, 0.7 * a, 1}).distance, 0, 1e-13) << "turned";
  EXPECT_TRUE(tip->MayBeMirrored(0) && tip->MayBeMirrored(1));
  EXPECT_FALSE(CreateRhombicPyramid(172.5, 130, 10, 0)->MayBeMirrored(0));
}

/// Heights of a surface that is not its own mirror image.
HeightTable MapOf(const IndenterSurface &tip, int columns, int rows, double step)
{
  HeightTable table{columns, rows, step, step, std::vector<double>(static_cast<std::size_t>(columns) * rows)};
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      double low = -1, high = 4;
      for (int halved = 0; halved < 60; ++halved) {
        const double z = (low + high) / 2;
        (tip.Gap({(i - columns / 2) * step, (j - rows / 2) * step, z}).distance > 0 ? low : high) = z;
      }
      table.At(i, j) = 7 + low; // heights count from anywhere
    }
  return table;
}

TEST(Tips, MapOfHeights)
{
  const auto ball = CreateSphere(kSpace, 8), turned = CreatePyramid(65.27, 3, 17, 0);
  const auto ball_map = CreateMapTip(MapOf(*ball, 101, 81, 0.05)), pyramid_map = CreateMapTip(MapOf(*turned, 101, 81, 0.05));
  double error = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 x = {Random(-2, 2), Random(-1.8, 1.8), 0};
    const double height = 8 - std::sqrt(64 - x[0] * x[0] - x[1] * x[1]);
    error = Largest({error, std::abs(ball_map->Gap({x[0], x[1], height}).distance)});
  }
  EXPECT_LE(error, 1e-6) << "ball";
  EXPECT_LE(Compare(*pyramid_map, *turned, 1.5, 0.02).distance, 0.012) << "a pyramid but for a cell at its edges";
  EXPECT_NEAR(ball_map->KnownHeights().largest, 8 - std::sqrt(60), 1e-9);
  EXPECT_TRUE(ball_map->MayBeMirrored(0) && ball_map->MayBeMirrored(1));
  EXPECT_FALSE(pyramid_map->MayBeMirrored(0) || pyramid_map->MayBeMirrored(1));
  EXPECT_NEAR(ball_map->Width(0.1), 2 * std::sqrt(0.1 * 15.9), 0.1);
  EXPECT_LE(RimHeight({4, 4, 1, 1, {0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}}), 0) << "lowest at its rim";
}

/// A tilted tip: its surface is that of the upright one, turned about its lowest point.
TEST(Tips, Tilted)
{
  const double angle = 3, toward = 40, t = angle * kDegree, u = toward * kDegree;
  const Vec3 axis = {std::sin(t) * std::cos(u), std::sin(t) * std::sin(u), std::cos(t)};
  const auto cone = CreateTilted(CreateCone(kSpace, 70.3, 0), angle, toward);
  double error = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 x = {Random(-3, 3), Random(-3, 3), Random(-1, 2)};
    const double along = Dot(x, axis), across = Norm(x - along * axis);
    const SurfaceGap gap = cone->Gap(x);
    error = Largest({error, std::abs(gap.distance - (across * std::cos(70.3 * kDegree) - along * std::sin(70.3 * kDegree)))});
    Vec3 moved = x + 1e-6 * gap.normal;
    error = Largest({error, std::abs(cone->Gap(moved).distance - gap.distance - 1e-6)});
  }
  EXPECT_LE(error, 1e-12) << "cone";
  const auto ball = CreateTilted(CreateSphere(kSpace, 2), 20, 77);
  for (const Vec3 x : {Vec3{0, 0, 0}, Vec3{1, 0, 2 - std::sqrt(3)}})
    EXPECT_NEAR(ball->Gap(x).distance, 0, 1e-14) << "a ball is a ball";
  // The lowest place of the surface is at the tip.
  std::vector<std::unique_ptr<IndenterSurface>> tips;
  tips.push_back(CreateTilted(CreateFlatPunch(kSpace, 2, 0), 2, 30));
  tips.push_back(CreateTilted(CreateFlatPunch(kSpace, 2, 0.5), 2, 30));
  tips.push_back(CreateTilted(CreatePyramid(65.27, 3, 0, 0.3), 5, 111));
  tips.push_back(CreateTilted(CreateProfileTip(kSpace, ProfileThrough({0, 1, 2}, {0, 0.3, 0.9}), {0, 0.9}), 5, 10));
  tips.push_back(CreateTilted(CreateMapTip(MapOf(*CreateSphere(kSpace, 8), 101, 101, 0.05)), 5, 10));
  for (std::size_t k = 0; k < tips.size(); ++k) {
    ASSERT_TRUE(tips[k]) << k;
    EXPECT_NEAR(tips[k]->Gap({0, 0, 0}).distance, 0, 2e-4) << k;
    double deepest = 0;
    for (int n = 0; n < 4000; ++n) deepest = std::min(deepest, tips[k]->Gap({Random(-2, 2), Random(-2, 2), -2e-4}).distance);
    EXPECT_GE(deepest, 0) << k;
  }
  EXPECT_FALSE(CreateTilted(CreateCone(kSpace, 70.3, 0), 20, 0)) << "its flank would be lower than its end";
  EXPECT_FALSE(CreateTilted(CreatePyramid(65.27, 3, 0, 0), 14, 180)) << "an edge is flatter than a face";
  EXPECT_TRUE(CreateTilted(CreatePyramid(65.27, 3, 0, 0), 14, 0));
  const auto leant = CreateTilted(CreatePyramid(65.27, 3, 0, 0), 3, 0);
  EXPECT_TRUE(leant->MayBeMirrored(1));
  EXPECT_FALSE(CreateTilted(CreatePyramid(65.27, 3, 0, 0), 3, 90)->MayBeMirrored(1));
}

} // namespace
