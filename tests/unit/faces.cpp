// Faces of points, the nodal forces of pressures on them, and which faces are outer ones.
#include "level/seeding.hpp"
#include "simulation/setup.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

constexpr double kH = 0.25; // m

/// One point somewhere on a grid of 16 x 16 cells, with the share of its face that each load acts on.
void MakePoint(const std::vector<double> &shares, Points &points, PointArrays *a)
{
  ASSERT_EQ(points.Create(PETSC_COMM_SELF, GeometryKind::kPlaneStrain, static_cast<int>(shares.size()), 0), PETSC_SUCCESS);
  ASSERT_EQ(points.Resize(1), PETSC_SUCCESS);
  *a = points.Arrays();
  for (int d = 0; d < 2; ++d) a->position[d] = Random(4 * kH, 12 * kH), a->half_size[d] = kH * Random(0.05, 0.4);
  for (int c = 0; c < 4; ++c) a->F[c] = (c % 3 == 0) + Random(-0.2, 0.2);
  a->body[0] = 0;
  std::copy(shares.begin(), shares.end(), a->load_share);
}

Model TwoBlocks()
{
  Model model;
  const MaterialConstants constants = {1e7, 0.3, 1000, NAN, NAN};
  AddBody(model, CreateBoxRegion({{0, 0}, {3 * kH, 4 * kH}}), "neo_hookean", constants);
  AddBody(model, CreateBoxRegion({{3 * kH, 0}, {5 * kH, 2 * kH}}), "neo_hookean", constants, {0, 0}, 3);
  return model;
}

} // namespace

TEST(Faces, EncloseThePoint)
{
  for (int n = 0; n < 50; ++n) {
    Points points;
    PointArrays a;
    MakePoint({}, points, &a);
    const Vec3 x = {a.position[0], a.position[1]};
    Vec3 sum{};
    double area = 0;
    for (int s = 0; s < 4; ++s) {
      const Side side = static_cast<Side>(s);
      const Face face = PointFace(a, 0, side);
      Vec3 middle{};
      middle[AxisOf(side)] = SignOf(side) * a.half_size[AxisOf(side)];
      EXPECT_LE(Norm(face.center - x - Multiply(a.F, middle)), 1e-15);
      EXPECT_NEAR(Dot(face.area_normal, face.half_edge[0]), 0, 1e-15);
      EXPECT_NEAR(Norm(face.area_normal), 2 * Norm(face.half_edge[0]), 1e-15);
      EXPECT_GT(Dot(face.area_normal, face.center - x), 0) << "outward";
      sum = sum + face.area_normal;
      area += 0.5 * Dot(face.area_normal, face.center - x); // the divergence theorem
    }
    EXPECT_LE(Norm(sum), 1e-15);
    const double J = a.F[0] * a.F[3] - a.F[1] * a.F[2];
    EXPECT_NEAR(area, 4 * a.half_size[0] * a.half_size[1] * J, 1e-15);
  }
}

/// The nodal forces of a pressure add up to -p t n, and their moment is that of a force at the middle of the face.
TEST(Faces, ForcesOfAPressure)
{
  constexpr double kPressure = 3e5, kThickness = 0.7;
  const GridGeometry geometry = {{0, 0}, kH, {16, 16}, 1};
  Grid grid;
  ASSERT_EQ(grid.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry)), PETSC_SUCCESS);
  for (int n = 0; n < 40; ++n) {
    const Side side = static_cast<Side>(n % 4);
    Points points;
    PointArrays a;
    const double share = n % 3 ? 1 : 0.3;
    MakePoint({0, share}, points, &a);
    a.faces[0] = OuterFaceBit(side);
    const std::vector<Load> loads = {{0, side, {}, PiecewiseLinear({0}, {1e9})}, // this one is on other points
                                     {0, side, {}, PiecewiseLinear({0, 2}, {0, 2 * kPressure})}};
    std::vector<FaceForce> applied;
    grid.Arrays().ClearSums();
    PointFailure failure;
    AddLoads(grid, points, n % 2 == 0, loads, {GeometryKind::kPlaneStrain, kThickness}, 1.0, applied, failure);
    EXPECT_EQ(failure.kind, PointFailure::kNone);
    const Face face = PointFace(a, 0, side);
    const Vec3 force = -kPressure * share * kThickness * face.area_normal;
    const double scale = kPressure * kThickness * kH;
    Vec3 sum{};
    double moments[2][2] = {};
    for (int j = 0; j <= 16; ++j)
      for (int i = 0; i <= 16; ++i) {
        const double *node = grid.Sums()[grid.Place({i, j, 0})].force;
        const double x[2] = {grid.Geometry().Coordinate(0, i), grid.Geometry().Coordinate(1, j)};
        sum = sum + Vec3{node[0], node[1]};
        for (int d = 0; d < 2; ++d)
          for (int k = 0; k < 2; ++k) moments[d][k] += node[d] * x[k];
      }
    EXPECT_LE(Norm(sum - force), 1e-13 * scale);
    Budgets totals;
    ForEach(grid.Owned(), [&](Index node) {
      NodeSums &sums = grid.Sums()[grid.Place(node)];
      sums.mass = 2;
      for (int d = 0; d < 2; ++d) sums.momentum[d] = 2, grid.Rates(grid.Place(node))[d] = 2;
    });
    AddLoadImpulse(grid, applied, 0, 2, totals);
    AddLoadWork(grid, applied, MeanMotion(grid, 0, true), 2, totals);
    EXPECT_NEAR(totals.external_work, 1.5 * (totals.load_impulse[0] + totals.load_impulse[1]), 1e-12 * scale);
    EXPECT_LE(Norm(totals.load_impulse - (n % 2 == 0 ? 2.0 : 0.0) * force), 1e-13 * scale) << "of owned points alone";
    for (int d = 0; d < 2; ++d)
      for (int k = 0; k < 2; ++k) EXPECT_NEAR(moments[d][k], force[d] * face.center[k], 1e-12 * scale);
  }
}

/// On a face along an axis each node gets the mean of its hat function.
TEST(Faces, ForcesAreMeansOfHats)
{
  const GridGeometry geometry = {{0, 0}, kH, {16, 16}, 1};
  Grid grid;
  ASSERT_EQ(grid.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry)), PETSC_SUCCESS);
  for (int n = 0; n < 20; ++n) {
    Points points;
    PointArrays a;
    const Side side = static_cast<Side>(n % 4);
    MakePoint({1}, points, &a);
    a.F[1] = a.F[2] = 0;
    a.faces[0] = OuterFaceBit(side);
    std::vector<FaceForce> applied;
    grid.Arrays().ClearSums();
    PointFailure failure;
    AddLoads(grid, points, true, {{0, side, {}, PiecewiseLinear({0}, {1})}}, {}, 0, applied, failure);
    const Face face = PointFace(a, 0, side);
    for (int j = 0; j <= 16; ++j)
      for (int i = 0; i <= 16; ++i) {
        constexpr int kParts = 2000;
        double mean = 0;
        for (int k = 0; k < kParts; ++k) {
          const Vec3 x = face.center + ((2 * k + 1.0) / kParts - 1) * face.half_edge[0];
          mean += std::max(0.0, 1 - std::abs(x[0] / kH - i)) * std::max(0.0, 1 - std::abs(x[1] / kH - j)) / kParts;
        }
        const double *node = grid.Sums()[grid.Place({i, j, 0})].force;
        for (int d = 0; d < 2; ++d) EXPECT_NEAR(node[d], -mean * face.area_normal[d], 1e-5 * kH);
      }
  }
}

/// Two blocks side by side on a roller at the left and the bottom: the outer sides are those that touch nothing.
TEST(Faces, OuterAndLoadedFaces)
{
  Model model = TwoBlocks();
  const GridGeometry geometry = {{0, 0}, kH, {8, 8}, 1};
  const BoundaryConditions sides = {{BoundaryKind::kSymmetry, BoundaryKind::kFree, BoundaryKind::kFixed, BoundaryKind::kFree},
                                    {0, 8, 0, 8, 0, 0}};
  model.loads.push_back({0, kXUpper, {{2.625 * kH, HUGE_VAL}, {}}, PiecewiseLinear({0}, {1})});
  model.loads.push_back({1, kYUpper, {{-HUGE_VAL, 4 * kH}, {}}, PiecewiseLinear({0}, {1})});
  Grid grid;
  Points points;
  ASSERT_EQ(grid.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry)), PETSC_SUCCESS);
  ASSERT_EQ(points.Create(PETSC_COMM_SELF, GeometryKind::kPlaneStrain, 2, 0), PETSC_SUCCESS);
  const Seeding seeding(model, {{geometry}, [](Vec3) { return 0; }, 2}, 0, sides, 0);
  ASSERT_EQ(seeding.Fill(grid.Nodes(), points), PETSC_SUCCESS);
  const PointArrays a = points.Arrays();
  ASSERT_EQ(a.count, 3 * 4 * 4 + 2 * 2 * 9);
  for (int p = 0; p < a.count; ++p) {
    const double x = a.position[2 * p] / kH, y = a.position[2 * p + 1] / kH;
    const bool first = a.body[p] == 0;
    int bits = 0;
    double shares[2] = {0, 0};
    if (first) {
      if (x > 2.5 && y > 2) bits |= OuterFaceBit(kXUpper); // below y = 2 is the other block
      if (x > 2.5 && y > 2.5) shares[0] = y > 3 ? 1 : 0.75;
      if (y > 3.5) bits |= OuterFaceBit(kYUpper);
    } else {
      if (x > 4.7) bits |= OuterFaceBit(kXUpper);
      if (y > 1.7) bits |= OuterFaceBit(kYUpper);
      if (y > 1.7 && x < 4) shares[1] = 1;
    }
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(a.load_share[2 * p + k], shares[k], 1e-12) << "at " << x << ", " << y << " cells";
    EXPECT_EQ(a.faces[p], bits) << "body " << a.body[p] << " at " << x << ", " << y << " cells";
  }
}
