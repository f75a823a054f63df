// What contact makes of faces: their segments, and the columns of the grid under them.
#include "contact_body.hpp"
#include "level/contact/footprint.hpp"
#include "level/face.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

constexpr GeometryKind kKinds[] = {GeometryKind::kPlaneStrain, GeometryKind::kAxisymmetric, GeometryKind::kSpatial};

/// One point somewhere off the axis, with all faces outer ones.
struct OnePoint {
  double position[3], half_size[3], F[9];
  int faces = 63;
  PointArrays arrays{};

  explicit OnePoint(int dim)
  {
    for (int a = 0; a < dim; ++a) position[a] = Random(4 * kH, 12 * kH), half_size[a] = kH * Random(0.05, 0.4);
    for (int c = 0; c < dim * dim; ++c) F[c] = (c % (dim + 1) == 0) + Random(-0.2, 0.2);
    arrays.count = 1;
    arrays.dim = dim;
    arrays.position = position;
    arrays.half_size = half_size;
    arrays.F = F;
    arrays.faces = &faces;
  }
};

/// Segments that cover a level surface up to the fifth column along each axis, from the first one or from minus the fifth.
std::vector<PressedSegment> LevelSurface(const PressedBody &body, double start, Vec3 normal, double gap, Vec3 slope)
{
  constexpr int kParts = 40; // of a cell
  const int dim = body.geometry.Dim();
  const double size = kH / kParts, end = 5 * kH;
  std::vector<PressedSegment> segments;
  const int count = static_cast<int>(std::lround((end - start) / size)), layers = dim == 3 ? count : 1;
  for (int j = 0; j < layers; ++j)
    for (int i = 0; i < count; ++i) {
      const Vec3 x = {start + (i + 0.5) * size, dim == 3 ? start + (j + 0.5) * size : 6.3 * kH, dim == 3 ? 6.3 * kH : 0};
      segments.push_back({Locate(body.grid, x, dim), normal, (dim == 3 ? size : body.geometry.OutOfPlane(x[0])) * size,
                          gap + Dot(slope, x), x[0] - 0.5 * size, x[0] + 0.5 * size});
    }
  return segments;
}

PressedSurface SumCells(PressedBody &body, double width, const std::vector<PressedSegment> &segments)
{
  ContactSettings settings;
  PressedSurface surface;
  settings.width = width;
  surface.Clear(body.View(), settings);
  for (const PressedSegment &segment : segments) surface.Add(body.View(), 0, segment);
  return surface;
}

/// Sums up the columns under segments of this rank alone.
PetscErrorCode SumColumns(PressedBody &body, double width, const std::vector<PressedSegment> &segments, ContactColumns *columns)
{
  SendPattern pattern = 0;
  bool at_border = false;
  double least_gap = HUGE_VAL;
  return columns->Sum(body.View(), SumCells(body, width, segments), &least_gap, &pattern, &at_border);
}

} // namespace

/// In three dimensions faces enclose the point, too.
TEST(ContactSurface, FacesEncloseThePointInSpace)
{
  for (int n = 0; n < 20; ++n) {
    OnePoint point(3);
    const double *F = point.F, *l = point.half_size;
    const double J = F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
    Vec3 sum{};
    double volume = 0;
    for (int s = 0; s < 6; ++s) {
      const Face face = PointFace(point.arrays, 0, static_cast<Side>(s));
      for (const Vec3 &edge : face.half_edge) EXPECT_NEAR(Dot(face.area_normal, edge), 0, 1e-16);
      sum = sum + face.area_normal;
      volume += Dot(face.area_normal, face.center - point.arrays.Position(0)) / 3;
    }
    EXPECT_LE(Norm(sum), 1e-16);
    EXPECT_NEAR(volume, 8 * J * l[0] * l[1] * l[2], 1e-16);
  }
}

/// Segments of a face add up to its area, with the radius of its centre, and lie about it, however long they may be.
TEST(ContactSurface, SegmentsAreTheFaces)
{
  for (GeometryKind kind : kKinds)
    for (int n = 0; n < 20; ++n) {
      const double longest = n % 2 ? 0.3 * kH : 0;
      const Geometry geometry = {kind, 0.7};
      const int dim = geometry.Dim();
      OnePoint point(dim);
      std::vector<SurfaceSegment> segments;
      ForEachSegment(point.arrays, 0, geometry, longest, [&](const SurfaceSegment &segment) { segments.push_back(segment); });
      std::size_t k = 0;
      for (int s = 0; s < 2 * dim; ++s) {
        const Face face = PointFace(point.arrays, 0, static_cast<Side>(s));
        std::size_t each = 1;
        for (int e = 0; e < dim - 1; ++e) {
          const double length = 2 * Norm(face.half_edge[e]);
          each *= longest == 0 ? 4 : length <= longest ? 1 : length <= 2 * longest ? 2 : length <= 3 * longest ? 3 : 4;
        }
        ASSERT_LE(k + each, segments.size());
        double area = 0;
        Vec3 moment{};
        for (const std::size_t end = k + each; k < end; ++k) {
          area += segments[k].area;
          moment = moment + segments[k].area * (segments[k].x - face.center);
          EXPECT_NEAR(Dot(segments[k].normal, face.area_normal), Norm(face.area_normal), 1e-15);
        }
        const double r = face.center[0], out_of_plane = dim == 3 ? 1 : kind == GeometryKind::kPlaneStrain ? 0.7 : 2 * M_PI * r;
        EXPECT_NEAR(area, Norm(face.area_normal) * out_of_plane, 1e-14);
        EXPECT_LE(Norm(moment), 1e-15);
      }
      EXPECT_EQ(k, segments.size());
    }
}

/// Faces of points that are drawn out reach over the side beside which they lie: there is no surface, and no width of a contact.
TEST(ContactColumns, SurfaceEndsAtHeldSides)
{
  for (const bool held : {true, false}) {
    PressedBody body;
    ContactColumns columns;
    ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
    body.sides.kind[kXLower] = body.sides.kind[kXUpper] = held ? BoundaryKind::kSymmetry : BoundaryKind::kFree;
    body.sides.node[kXLower] = 1, body.sides.node[kXUpper] = 5;
    std::vector<PressedSegment> segments = LevelSurface(body, kH, {0, -1, 0}, 0, {});
    segments.front().left = 0.3 * kH, segments.back().right = 5.6 * kH;
    ASSERT_EQ(SumColumns(body, 1, segments, &columns), PETSC_SUCCESS);
    EXPECT_NEAR(columns.At({1, 0, 0}).left, (held ? 1 : 0.3) * kH, 1e-12);
    EXPECT_NEAR(columns.At({5, 0, 0}).right, (held ? 5 : 5.6) * kH, 1e-12);
  }
}

/// Hats add up to one, so that columns share the whole surface and, under equal pressures, all have the same.
TEST(ContactColumns, PartitionOfUnity)
{
  for (GeometryKind kind : kKinds)
    for (double width : {1.0, 0.6}) {
      PressedBody body;
      body.geometry = {kind, 0.7};
      const int dim = body.geometry.Dim();
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      std::vector<PressedSegment> segments;
      double area = 0, kernels = 0, loads = 0, sum = 0;
      for (int n = 0; n < 500; ++n) {
        Vec3 x{}, normal{};
        for (int a = 0; a < dim; ++a) x[a] = Random(2 * kH, 6 * kH), normal[a] = a < dim - 1 ? Random(-0.3, 0.3) : -1;
        normal = (1 / Norm(normal)) * normal;
        segments.push_back({Locate(body.grid, x, dim), normal, Random(0, 1), 0, x[0], x[0]});
        area -= segments.back().area * normal[dim - 1];
      }
      ContactColumns columns;
      ASSERT_EQ(SumColumns(body, width, segments, &columns), PETSC_SUCCESS);
      ForEach(columns.Box(), [&](Index at) {
        const ContactColumn &column = columns.At(at);
        sum += column.area;
        kernels += column.kernel_area;
        loads += std::accumulate(column.share, column.share + 9, 0.0);
      });
      EXPECT_NEAR(sum, area, 1e-11);
      if (width < 1) continue;
      EXPECT_NEAR(loads, area, 1e-11);
      EXPECT_GT(kernels, area);
      for (const double pressure : columns.Pressures(std::vector<double>(columns.Box().Count(), 3.0)))
        EXPECT_NEAR(pressure, pressure > 0 ? 3 : 0, 1e-12);
    }
}

/// The mean gap of a column is that at its node, for any kernel, where gaps are linear.
TEST(ContactColumns, MeanOfALinearGap)
{
  for (GeometryKind kind : {GeometryKind::kPlaneStrain, GeometryKind::kSpatial})
    for (double width : {1.0, 0.5, 0.25}) {
      PressedBody body;
      body.geometry = {kind, 0.7};
      const int dim = body.geometry.Dim();
      const Vec3 slope = {0.3, dim == 3 ? -0.2 : 0.0, 0};
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      ContactColumns columns;
      const auto segments = LevelSurface(body, 2 * kH, dim == 3 ? Vec3{0, 0, -1} : Vec3{0, -1, 0}, 0.1, slope);
      ASSERT_EQ(SumColumns(body, width, segments, &columns), PETSC_SUCCESS);
      for (int i = 3; i < 5; ++i)
        for (int j = dim == 3 ? 3 : 0; j < (dim == 3 ? 5 : 1); ++j) {
          const ContactColumn &column = columns.At({i, j, 0});
          EXPECT_NEAR(column.gap / column.kernel_area, 0.1 + Dot(slope, {i * kH, j * kH, 0}), 1e-13);
          EXPECT_NEAR(column.area, dim == 3 ? kH * kH : 0.7 * kH, 1e-13);
        }
    }
}

/// The full area of kernels, halved at sides and on the axis; the loads of kernels on the columns are all of it.
TEST(ContactColumns, FullArea)
{
  for (GeometryKind kind : kKinds)
    for (double width : {1.0, 0.5}) {
      PressedBody body;
      body.geometry = {kind, 0.7};
      body.sides.kind[kXLower] = body.sides.kind[kYLower] = BoundaryKind::kSymmetry;
      const int dim = body.geometry.Dim();
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      ContactColumns columns;
      const auto segments = LevelSurface(body, 0, dim == 3 ? Vec3{0, 0, -1} : Vec3{0, -1, 0}, 0, {});
      ASSERT_EQ(SumColumns(body, width, segments, &columns), PETSC_SUCCESS);
      for (int i = 0; i < 5; ++i) {
        const Index at = {i, dim == 3 ? 2 : 0, 0};
        const ContactColumn &column = columns.At(at);
        const double full = FullKernelArea(body.View(), width, at);
        EXPECT_NEAR(column.kernel_area, full, 2e-3 * full) << "column " << i;
        EXPECT_NEAR(std::accumulate(column.share, column.share + 9, 0.0), column.kernel_area, 1e-14);
      }
    }
}

/// Columns that carry load in turns are in contact also where they nearly touch in between, and the half one at the body's end; a
/// surface apart is not.
TEST(ContactFootprint, ColumnsBetweenLoadedOnes)
{
  struct {
    double gap;
    bool flows;
    double columns_covered;
  } cases[] = {{0.2, true, 5}, {0.4, true, 2.5}, {0.2, false, 2.5}, {0.05, false, 5}};
  for (const auto &[gap, flows, columns_covered] : cases) {
    PressedBody body;
    body.geometry = {GeometryKind::kPlaneStrain, 0.7};
    ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
    ContactColumns columns;
    auto segments = LevelSurface(body, 0, {0, -1, 0}, gap * kH, {});
    for (PressedSegment &segment : segments) segment.flows = flows;
    ASSERT_EQ(SumColumns(body, 1, segments, &columns), PETSC_SUCCESS);
    ContactReport report;
    MeasureFootprint(body.View(), columns, {1, 0, 1, 0, 1, 0}, &report);
    EXPECT_NEAR(report.area, columns_covered * kH * 0.7, 1e-12) << gap << " cells, flows: " << flows;
    EXPECT_NEAR(report.peak_pressure, 2.0 / 3, 1e-3); // of a column: a sixth of its neighbours' and two thirds of its own
  }
}

/// A flow without growth or stretch along the axes, off the axis of rotation.
Vec3 Flow(Vec3 x, int dim)
{
  return {0.3 + 0.7 * x[1], -1.1 - 0.4 * x[0] + (dim == 3 ? 0.5 * x[2] : 0), dim == 3 ? 0.2 - 0.6 * x[0] : 0};
}

/// Segments of a surface that flows as v = a + L x, without stretch along the surface, against the plane face gap = n.(x - at).
std::vector<PressedSegment> FlowingSurface(const PressedBody &body, double time)
{
  const int dim = body.geometry.Dim();
  const Vec3 normal = dim == 3 ? Vec3{-0.36, 0.48, -0.8} : Vec3{-0.6, -0.8, 0},
             at = {3.1 * kH, 5.9 * kH, dim == 3 ? 4.2 * kH : 0};
  std::vector<PressedSegment> segments;
  for (int k = 0; k < 5; ++k) {
    Vec3 x = {kH * (3.07 + 0.29 * k), kH * (6.05 + 0.13 * k), dim == 3 ? kH * (4.33 - 0.1 * k) : 0};
    x = x + time * Flow(x, dim);
    const double area = 0.01 * (k + 1) * (body.geometry.HasHoop() ? x[0] : 1);
    segments.push_back({Locate(body.grid, x, dim), normal, area, Dot(normal, x - at), x[0], x[0], 0, true});
  }
  return segments;
}

/// The couplings are the rates of the columns' gaps, also as the surface flows past the columns.
TEST(ContactColumns, GapsFollowAFlowingSurface)
{
  constexpr double kTime = 1e-6;
  for (GeometryKind kind : kKinds)
    for (double width : {1.0, 0.8}) {
      PressedBody body;
      body.geometry.kind = kind;
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      const int dim = body.geometry.Dim();
      std::map<Index, double> gaps, rates;
      for (double time : {-kTime, kTime}) {
        ContactColumns columns;
        ASSERT_EQ(SumColumns(body, width, FlowingSurface(body, time), &columns), PETSC_SUCCESS);
        ForEach(columns.Box(), [&](Index at) { gaps[at] += columns.At(at).gap * time / (2 * kTime * kTime); });
      }
      const PressedSurface surface = SumCells(body, width, FlowingSurface(body, 0));
      for (std::size_t cell = 0; cell < surface.Cells().size(); ++cell)
        for (int c = 0; c < 1 << (dim - 1); ++c)
          for (int k = 0; k < 1 << dim; ++k) {
            const Index node = Corner(surface.Cells()[cell].cell, k);
            rates[Corner(surface.Cells()[cell].column, c)] +=
                Dot(surface.Coupling(cell, c, 0, k), Flow(kH * Vec3{double(node[0]), double(node[1]), double(node[2])}, dim));
          }
      EXPECT_GE(rates.size(), 3U);
      for (const auto &[column, rate] : rates)
        EXPECT_NEAR(rate, gaps[column], 1e-8) << "width " << width << ", column " << column[0];
    }
}
