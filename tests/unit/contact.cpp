// Parts of contact: segments of faces, columns of the grid under them, and the equations on any number of ranks.
#include "level/contact/columns.hpp"
#include "level/contact/system.hpp"
#include "level/face.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <random>

using namespace mlgimp;

namespace
{

std::mt19937 generator(20240607);
double Random(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(generator); }

constexpr double kH = 0.25; // m
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

/// A grid of 16 x 16 cells on all ranks of a communicator, in columns of blocks, and what contact sees of it.
struct Body {
  Grid grid;
  ContactGroup group;
  Points points;
  BodyTable bodies;
  BoundaryConditions sides;
  Indenter indenter;
  Geometry geometry;

  PetscErrorCode Create(MPI_Comm comm)
  {
    PetscMPIInt size;
    const GridGeometry shape = {{0, 0, 0}, kH, {16, 16}, 1};
    GridLayout layout;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_size(comm, &size));
    layout.widths[1] = {shape.Nodes(1)};
    for (int rank = 0; rank < size; ++rank) {
      layout.widths[0].push_back(shape.Nodes(0) * (rank + 1) / size - shape.Nodes(0) * rank / size);
      layout.ranks.push_back(rank);
    }
    PetscCall(grid.Create(comm, shape, layout));
    PetscCall(group.Create(grid, kAllNodes));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ContactView View() { return {grid, group, points, bodies, sides, indenter, geometry, 0, 0, 1e-3}; }
};

/// Segments that cover a level surface up to the fifth column along each axis, from the first one or from minus the fifth.
std::vector<PressedSegment> LevelSurface(const Body &body, double start, Vec3 normal, double gap, Vec3 slope)
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
                          gap + Dot(slope, x), x[0] - 0.5 * size, x[0] + 0.5 * size, false});
    }
  return segments;
}

/// Sums up the columns under segments of this rank alone.
PetscErrorCode SumColumns(Body &body, double width, const std::vector<PressedSegment> &segments, ContactColumns *columns)
{
  SendPattern pattern = 0;
  bool at_border = false;
  double least_gap = HUGE_VAL;
  return columns->Sum(body.View(), width, segments, &least_gap, &pattern, &at_border);
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

/// Segments of a face add up to its area, with the radius of its centre, and lie about it.
TEST(ContactSurface, SegmentsAreTheFaces)
{
  for (GeometryKind kind : kKinds)
    for (int n = 0; n < 20; ++n) {
      const Geometry geometry = {kind, 0.7};
      const int dim = geometry.Dim(), each = dim == 3 ? 16 : 4;
      OnePoint point(dim);
      std::vector<SurfaceSegment> segments;
      AddPointSegments(point.arrays, 0, geometry, &segments);
      ASSERT_EQ(segments.size(), 2U * dim * each);
      for (int s = 0; s < 2 * dim; ++s) {
        const Face face = PointFace(point.arrays, 0, static_cast<Side>(s));
        double area = 0;
        Vec3 moment{};
        for (int k = s * each; k < (s + 1) * each; ++k) {
          area += segments[k].area;
          moment = moment + segments[k].area * (segments[k].x - face.center);
          EXPECT_NEAR(Dot(segments[k].normal, face.area_normal), Norm(face.area_normal), 1e-15);
        }
        const double r = face.center[0], out_of_plane = dim == 3 ? 1 : kind == GeometryKind::kPlaneStrain ? 0.7 : 2 * M_PI * r;
        EXPECT_NEAR(area, Norm(face.area_normal) * out_of_plane, 1e-14);
        EXPECT_LE(Norm(moment), 1e-15);
      }
    }
}

/// Faces of points that are drawn out reach over the side beside which they lie: there is no surface, and no width of a contact.
TEST(ContactColumns, SurfaceEndsAtHeldSides)
{
  for (const bool held : {true, false}) {
    Body body;
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
      Body body;
      body.geometry = {kind, 0.7};
      const int dim = body.geometry.Dim();
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      std::vector<PressedSegment> segments;
      double area = 0, kernels = 0, loads = 0, sum = 0;
      for (int n = 0; n < 500; ++n) {
        Vec3 x{}, normal{};
        for (int a = 0; a < dim; ++a) x[a] = Random(2 * kH, 6 * kH), normal[a] = a < dim - 1 ? Random(-0.3, 0.3) : -1;
        normal = (1 / Norm(normal)) * normal;
        segments.push_back({Locate(body.grid, x, dim), normal, Random(0, 1), 0, x[0], x[0], false});
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
      EXPECT_NEAR(columns.PeakPressure(std::vector<double>(columns.Box().Count(), 3.0)), 3, 1e-12);
    }
}

/// The mean gap of a column is that at its node, for any kernel, where gaps are linear.
TEST(ContactColumns, MeanOfALinearGap)
{
  for (GeometryKind kind : {GeometryKind::kPlaneStrain, GeometryKind::kSpatial})
    for (double width : {1.0, 0.5, 0.25}) {
      Body body;
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
      Body body;
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

namespace
{

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

/// A flow without growth or stretch along the axes, off the axis of rotation.
Vec3 Flow(Vec3 x, int dim)
{
  return {0.3 + 0.7 * x[1], -1.1 - 0.4 * x[0] + (dim == 3 ? 0.5 * x[2] : 0), dim == 3 ? 0.2 - 0.6 * x[0] : 0};
}

/// Segments of a surface that flows as v = a + L x, without stretch along the surface, against the plane face gap = n.(x - at).
std::vector<PressedSegment> FlowingSurface(const Body &body, double time)
{
  const int dim = body.geometry.Dim();
  const Vec3 normal = dim == 3 ? Vec3{-0.36, 0.48, -0.8} : Vec3{-0.6, -0.8, 0},
             at = {3.1 * kH, 5.9 * kH, dim == 3 ? 4.2 * kH : 0};
  std::vector<PressedSegment> segments;
  for (int k = 0; k < 5; ++k) {
    Vec3 x = {kH * (3.07 + 0.29 * k), kH * (6.05 + 0.13 * k), dim == 3 ? kH * (4.33 - 0.1 * k) : 0};
    x = x + time * Flow(x, dim);
    const double area = 0.01 * (k + 1) * (body.geometry.HasHoop() ? x[0] : 1);
    segments.push_back({Locate(body.grid, x, dim), normal, area, Dot(normal, x - at), x[0], x[0], true});
  }
  return segments;
}

/// The couplings are the rates of the columns' gaps, also as the surface flows past the columns.
TEST(ContactColumns, GapsFollowAFlowingSurface)
{
  constexpr double kTime = 1e-6;
  for (GeometryKind kind : kKinds)
    for (double width : {1.0, 0.8}) {
      Body body;
      body.geometry.kind = kind;
      ASSERT_EQ(body.Create(PETSC_COMM_SELF), PETSC_SUCCESS);
      const int dim = body.geometry.Dim();
      std::map<Index, double> gaps, rates;
      for (double time : {-kTime, kTime})
        for (const PressedSegment &s : FlowingSurface(body, time))
          for (int c = 0; c < 1 << (dim - 1); ++c)
            gaps[Corner(s.place.column, c)] +=
                s.area * s.gap * CornerHat(s.place.part, c, dim - 1, width) * time / (2 * kTime * kTime);
      for (const PressedSegment &s : FlowingSurface(body, 0))
        for (int c = 0; c < 1 << (dim - 1); ++c)
          for (int k = 0; k < 1 << dim; ++k) {
            const Index node = Corner(s.place.cell, k);
            rates[Corner(s.place.column, c)] +=
                CornerHat(s.place.part, k, dim) * Dot(GapGradient(body.View(), s, c, width),
                                                      Flow(kH * Vec3{double(node[0]), double(node[1]), double(node[2])}, dim));
          }
      EXPECT_GE(rates.size(), 3U);
      for (const auto &[column, rate] : rates)
        EXPECT_NEAR(rate, gaps[column], 1e-8) << "width " << width << ", column " << column[0];
    }
}

/// One unknown is on one of three ranks, and none on the others.
TEST(ContactSystemOnRanks, FewerUnknownsThanRanks)
{
  Body body;
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
  generator.seed(11);
  std::vector<ContactUnknown> unknowns;
  for (int j = 0; j < 12; ++j) unknowns.push_back({1000 + 3 * j, 0.02 * std::sin(0.9 * j) - 0.01});
  const std::vector<ContactCoupling> all = RandomCouplings();
  std::vector<ContactCoupling> own;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (static_cast<int>(k * 7 / 5 % ranks) == rank) own.push_back(all[k]);
  std::vector<double> before;
  for (int serial_unknowns : {1000, 1, 1}) {
    Body body;
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
