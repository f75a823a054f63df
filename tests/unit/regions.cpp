// Shapes of bodies and their tilings by their properties.
#include "physics/region.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

Vec3 RandomPlace(const Box &box)
{
  Vec3 x;
  for (int axis = 0; axis < 3; ++axis) x[axis] = Random(box.lower[axis], std::nextafter(box.upper[axis], HUGE_VAL));
  return x;
}

/// Product of the edges, of the first `dim`.
double Volume(const Box &box, int dim)
{
  double volume = 1;
  for (int axis = 0; axis < dim; ++axis) volume *= box.upper[axis] - box.lower[axis];
  return volume;
}

constexpr GeometryKind kPlane = GeometryKind::kPlaneStrain, kSpace = GeometryKind::kSpatial;

/// The part of the bounds that a region fills, by random places, against its volume; nothing lies outside the bounds.
void CheckRegion(const std::string &name, const Region &region, int dim, double volume)
{
  constexpr int kPlaces = 50000;
  const Box bounds = region.Bounds();
  Box around = bounds;
  for (int axis = 0; axis < dim; ++axis) around.lower[axis] -= 0.1, around.upper[axis] += 0.1;
  int inside = 0, wider = 0, narrower = 0;
  bool outside = false;
  for (int n = 0; n < kPlaces; ++n) {
    const Vec3 x = RandomPlace(around);
    inside += region.Contains(x);
    wider += region.Contains(x, 0.05), narrower += region.Contains(x, -0.05);
    outside |= region.Contains(x) && !bounds.Contains(x);
  }
  EXPECT_FALSE(outside) << name + ": a place outside the bounds";
  EXPECT_NEAR(Volume(around, dim) * inside / kPlaces / volume, 1, 0.02) << name + ": volume"; // four standard deviations
  EXPECT_GT(wider, inside) << name + ": a tolerance adds places";
  EXPECT_LT(narrower, inside) << name + ": a negative tolerance takes places away";
}

TEST(Regions, Volumes)
{
  const Vec3 center = {0.3, -0.2, 0.7};
  CheckRegion("box in the plane", *CreateBoxRegion({{0, 1, 0}, {2, 2.5, 0}}), 2, 3);
  CheckRegion("box", *CreateBoxRegion({{0, 1, -1}, {2, 2.5, 1}}), 3, 6);
  CheckRegion("disk", *CreateBallRegion(kPlane, {0.3, -0.2, 0}, 1.1), 2, M_PI * 1.21);
  CheckRegion("ball", *CreateBallRegion(kSpace, center, 1.1), 3, 4 * M_PI / 3 * 1.331);
  CheckRegion("cylinder", *CreateCylinderRegion(center, 1.1, 0.8), 3, M_PI * 1.21 * 0.8);
  CheckRegion("polygon", *CreatePolygonRegion({{0, 0}, {2, 0}, {2, 2}, {1, 1}, {0, 2}}), 2, 3);
}

/// The parts of a lattice's tiles in a region have its volume, its first and its second moments about its centre.
void CheckParts(const std::string &name, const Region &region, int dim, double volume, double squares)
{
  constexpr double kHalf = 0.06;
  const Box bounds = region.Bounds();
  const Vec3 center = 0.5 * (bounds.lower + bounds.upper), half = {kHalf, kHalf, dim == 3 ? kHalf : 0};
  const double whole = std::pow(2 * kHalf, dim);
  IndexBox tiles{{}, {1, 1, 1}};
  for (int a = 0; a < dim; ++a) tiles.upper[a] = static_cast<int>(std::ceil((bounds.upper[a] - bounds.lower[a]) / (2 * kHalf)));
  PartOfTile sum;
  double off = 0, alike = 0;
  ForEach(tiles, [&](Index k) {
    Tile tile{bounds.lower, half};
    for (int a = 0; a < dim; ++a) tile.center[a] += (2 * k[a] + 1) * kHalf;
    const PartOfTile part = PartInside(region, tile, center, dim);
    sum.Add(part, whole);
    if (part.share == 0) return;
    const Tile same = TileOf(PartInside(region, tile, tile.center, dim), tile, dim);
    double of_same = 1;
    for (int a = 0; a < dim; ++a)
      of_same *= same.half_size[a] / kHalf, off = std::max(off, std::abs(same.center[a] - tile.center[a]));
    alike = std::max(alike, std::abs(of_same - part.share));
  });
  EXPECT_NEAR(sum.share / volume, 1, 1e-3) << name + ": volume";
  EXPECT_LT(LargestComponent({std::abs(sum.sum[0]), std::abs(sum.sum[1]), std::abs(sum.sum[2])}) / volume, 1e-3) << name;
  EXPECT_NEAR(sum.squares[0] / squares, 1, 2e-3) << name + ": second moment";
  EXPECT_LT(off, kHalf) << name + ": centres lie within their tiles";
  EXPECT_LT(alike, 1e-12) << name + ": volumes of what stands for them";
}

TEST(Regions, PartsOfTiles)
{
  CheckParts("disk", *CreateBallRegion(kPlane, {0.3, -0.2, 0}, 1.1), 2, M_PI * 1.21, M_PI * std::pow(1.1, 4) / 4);
  CheckParts("ball", *CreateBallRegion(kSpace, {0.3, -0.2, 0.7}, 1.1), 3, 4 * M_PI / 3 * 1.331, 4 * M_PI / 15 * std::pow(1.1, 5));
  CheckParts("cylinder", *CreateCylinderRegion({0.3, -0.2, 0.7}, 1.1, 0.96), 3, M_PI * 1.21 * 0.96,
             M_PI * std::pow(1.1, 4) / 4 * 0.96);
  const double side = std::sqrt(2.0); // of a square on its corner
  CheckParts("polygon", *CreatePolygonRegion({{1, 0}, {0, 1}, {-1, 0}, {0, -1}}), 2, side * side, std::pow(side, 4) / 12);
}

TEST(Regions, Outlines)
{
  const Vec3 center = {0.3, -0.2, 0.7};
  const auto ball = CreateBallRegion(kSpace, center, 1.1), cylinder = CreateCylinderRegion(center, 1.1, 0.8),
             polygon = CreatePolygonRegion({{0, 0}, {2, 0}, {2, 2}, {1, 1}, {0, 2}});
  for (int n = 0; n < 100; ++n) {
    const Vec3 x = RandomPlace(ball->Bounds()), on = ball->OnOutline(x, 0, false), at = polygon->OnOutline(x, 0, false),
               side = cylinder->OnOutline(x, 0, false), cap = cylinder->OnOutline(x, 2, false),
               rim = cylinder->OnOutline(x, 2, true);
    EXPECT_NEAR(Norm(on - center), 1.1, 1e-12);
    EXPECT_NEAR(std::abs(ball->Distance(x)), Norm(x - on), 1e-12);
    EXPECT_NEAR(polygon->Distance(at), 0, 1e-12);
    for (const Vec3 &round : {side, rim}) EXPECT_NEAR(std::hypot(round[0] - center[0], round[1] - center[1]), 1.1, 1e-12);
    for (const Vec3 &level : {side, cap, rim}) EXPECT_EQ(level[2], x[2]);
    EXPECT_LE(std::hypot(cap[0] - center[0], cap[1] - center[1]), 1.1 + 1e-12);
  }
  const std::vector<Vec3> between = polygon->Between({1.9, 0}, {2, 0.1}), back = polygon->Between({0.1, 1.9}, {0, 1.8});
  ASSERT_EQ(between.size(), 1U);
  EXPECT_EQ(between[0], (Vec3{2, 0, 0}));
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0], (Vec3{0, 2, 0}));
  EXPECT_TRUE(polygon->Between({0.5, 0}, {0.7, 0}).empty());
}

TEST(Regions, HalfDiskOnTheAxis)
{
  const auto on_axis = CreateBallRegion(GeometryKind::kAxisymmetric, {0, 3, 0}, 1),
             off_axis = CreateBallRegion(GeometryKind::kAxisymmetric, {2, 3, 0}, 1);
  EXPECT_EQ(on_axis->Bounds().lower, (Vec3{0, 2, 0}));
  EXPECT_EQ(on_axis->Bounds().upper, (Vec3{1, 4, 0}));
  EXPECT_EQ(off_axis->Bounds().lower, (Vec3{1, 2, 0}));
}

/// What a tiling gets wrong, at most.
struct TilingErrors {
  double volume = 0;  ///< of its tiles less that of the box, relative
  double outside = 0; ///< how far tiles reach beyond the box, m
  double other = 0;   ///< distance of a tile's centre from that of the tile found there, m
  double miss = 0;    ///< how far a place of the box is outside the tile found for it, m
};

void CheckTiling(const Box &box, Vec3 origin, double h, int per_cell, int dim, TilingErrors *errors)
{
  const Tiling tiling(box, true, origin, h, per_cell);
  double sum = 0;
  IndexBox cells{{-1, -1, dim == 3 ? -1 : 0}, {1, 1, 1}};
  for (int axis = 0; axis < dim; ++axis) cells.upper[axis] = static_cast<int>((box.upper[axis] - origin[axis]) / h) + 2;
  ForEach(cells, [&](Index cell) {
    for (const Tile &tile : tiling.InCell(cell)) {
      Tile found;
      double volume = 1;
      errors->other = Largest({errors->other, tiling.At(tile.center, found) ? Norm(found.center - tile.center) : HUGE_VAL});
      for (int axis = 0; axis < dim; ++axis) {
        errors->outside = Largest({errors->outside, box.lower[axis] - tile.center[axis] + tile.half_size[axis],
                                   tile.center[axis] + tile.half_size[axis] - box.upper[axis]});
        volume *= 2 * tile.half_size[axis];
      }
      sum += volume;
    }
  });
  errors->volume = Largest({errors->volume, std::abs(sum / Volume(box, dim) - 1)});
  for (int k = 0; k < 20; ++k) {
    const Vec3 x = RandomPlace(box);
    Tile tile;
    const bool found = tiling.At(x, tile);
    for (int axis = 0; axis < dim; ++axis)
      errors->miss = Largest({errors->miss, found ? std::abs(x[axis] - tile.center[axis]) - tile.half_size[axis] : HUGE_VAL});
  }
}

TEST(Regions, Tilings)
{
  for (const int dim : {2, 3}) {
    TilingErrors errors;
    for (int n = 0; n < 200; ++n) {
      const double h = dim == 3 ? Random(0.4, 2) : Random(0.1, 2);
      Vec3 origin{};
      Box box; // no edge is a sliver
      for (int axis = 0; axis < dim; ++axis) {
        origin[axis] = Random(-3, 3);
        box.lower[axis] = origin[axis] + Random(0, 3);
        box.upper[axis] = box.lower[axis] + Random(0.25, dim == 3 ? 3 : 6);
      }
      if (n % 4 == 0) // sides on nodes but for round-off
        for (int axis = 0; axis < dim; axis += 2)
          box.lower[axis] = origin[axis] + h, box.upper[axis] = origin[axis] + h + (0.1 + 0.2) / 0.1 * h;
      CheckTiling(box, origin, h, 1 + n % 4, dim, &errors);
    }
    EXPECT_LE(errors.volume, 1e-12) << dim;
    EXPECT_LE(errors.outside, 1e-12) << dim;
    EXPECT_LE(errors.other, 1e-12) << dim;
    EXPECT_LE(errors.miss, 1e-12) << dim;
  }
}

} // namespace
