// The pressures of segments: the operator, what it makes of even and uneven pressures, and Coulomb's conditions beside them.
#include "contact/friction.hpp"
#include "contact/pressure_solver.hpp"
#include "physics/tips/profiles.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(11);

/// A flat surface under segments of random length, and what lies under it, on a grid of 16 cells along each axis.
struct PressedBody {
  static constexpr double kH = 0.25; // m
  Grid grid;
  ContactGroup group;
  BoundaryConditions sides;
  LightNodes light;
  Geometry geometry;
  std::vector<Segment> segments;
  ContactNodes nodes;
  SegmentProblem problem;

  static constexpr double kDt = 1e-3;     // s
  static constexpr Vec3 kTip = {2, 2, 2}; // m

  void Build(const ColumnNumbers &before) { problem.Build(grid.Geometry(), geometry.kind, kDt, nodes, segments, before, {}, {}); }

  /// Segments across the whole width, with pressures of the last step by columns.
  PetscErrorCode Create(GeometryKind kind, const ColumnNumbers &before = {})
  {
    PetscFunctionBeginUser;
    geometry.kind = kind;
    const int dim = geometry.Dim(), up = dim - 1;
    const GridGeometry shape = {{0, 0, 0}, kH, {16, 16, dim == 3 ? 16 : 1}, 1, dim};
    GridLayout layout;
    for (int a = 0; a < 3; ++a) layout.widths[a] = {shape.Nodes(a)};
    layout.ranks = {0};
    PetscCall(grid.Create(PETSC_COMM_SELF, shape, layout));
    PetscCall(group.Create(grid.Nodes(), kAllNodes));
    light.Create(grid, sides, {}, false, std::vector<double>(grid.Ghosted().Count(), 1.0));
    ForEach(grid.Owned(), [&](Index node) {
      const std::ptrdiff_t place = grid.Place(node);
      grid.Sums()[place].mass = 1 + 0.3 * std::sin(node[0] + 7.0 * node[up]);
      for (int d = 0; d < dim; ++d) grid.Velocity(place).velocity[d] = Random(-1, 1);
    });
    for (int n = 0; n < (dim == 3 ? 200 : 30); ++n) {
      Segment one{};
      one.patch = n, one.path = 1;
      one.area = one.pressed = Random(0.5, 1), one.ring = 1, one.gap = Random(-2e-3, 1e-3), one.modulus = 2e5,
      one.flow = HUGE_VAL;
      const std::array<double, 4> part = CornerWeights(Random(0, 1), Random(0, 1), dim);
      Vec3 first{}, x{};
      for (int a = 0; a < up; ++a) first[a] = Random(1, 3), one.normal[a] = Random(-0.3, 0.3);
      first[up] = 2.1, one.normal[up] = -1;
      one.normal = (1 / Norm(one.normal)) * one.normal;
      for (int c = 0; c < 1 << up; ++c) {
        one.corner[c] = first;
        one.corner[c][0] += 0.4 * kH * (c == 1 || c == 2);
        if (dim == 3) one.corner[c][1] += 0.4 * kH * (c >= 2);
        one.corner_part[c] = part[c];
        x = x + part[c] * one.corner[c];
      }
      one.place = Locate(grid.Geometry(), x);
      segments.push_back(one);
    }
    const NodeMotion motion(grid, sides, light, 0, group, nullptr, nullptr);
    PetscCall(nodes.Gather(motion, NodesOf(grid, segments)));
    Build(before);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

constexpr GeometryKind kKinds[] = {GeometryKind::kPlaneStrain, GeometryKind::kAxisymmetric, GeometryKind::kSpatial};

double Product(const std::vector<double> &a, const std::vector<double> &b)
{
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

} // namespace

TEST(Segments, OperatorIsSymmetricAndPositive)
{
  for (const GeometryKind kind : kKinds) {
    PressedBody body;
    ASSERT_EQ(body.Create(kind), PETSC_SUCCESS);
    const int size = body.problem.Size();
    ASSERT_GE(size, 30);
    std::vector<double> diagonal(size), unit(size, 0.0), column(size), a(size), b(size), Aa(size), Ab(size);
    body.problem.Diagonal(diagonal.data());
    for (int k = 0; k < size; ++k) {
      unit[k] = 1;
      body.problem.Multiply(unit.data(), column.data());
      EXPECT_NEAR(column[k], diagonal[k], 1e-13 * diagonal[k]);
      unit[k] = 0;
    }
    for (int n = 0; n < 20; ++n) {
      for (int k = 0; k < size; ++k) a[k] = Random(-1, 1), b[k] = Random(-1, 1);
      body.problem.Multiply(a.data(), Aa.data());
      body.problem.Multiply(b.data(), Ab.data());
      EXPECT_NEAR(Product(a, Ab), Product(b, Aa), 1e-13 * (Product(a, Aa) + Product(b, Ab)));
      EXPECT_GT(Product(a, Aa), 0);
    }
  }
}

/// An even pressure moves nothing but nodes: the compliance keeps what columns can show. The last step's pressures are such.
TEST(Segments, EvenPressuresMoveNodesAlone)
{
  for (const GeometryKind kind : kKinds) {
    PressedBody body;
    ASSERT_EQ(body.Create(kind), PETSC_SUCCESS);
    std::unordered_map<std::int64_t, double> even;
    for (const SurfaceColumn &column : body.problem.Columns()) even[column.key] = 3;
    body.Build(even);
    const std::vector<double> &q = body.problem.Start();
    std::vector<double> Aq(q.size());
    body.problem.Multiply(q.data(), Aq.data());
    std::vector<Vec3> forces, moved;
    for (int k = 0; k < body.problem.Size(); ++k)
      forces.push_back(body.problem.CandidateAt(k).Force(q[k]) * body.problem.CandidateAt(k).normal);
    body.problem.Spread(forces, &moved);
    body.problem.Move(&moved);
    const std::vector<Vec3> motion = body.problem.MotionOf(moved);
    for (int k = 0; k < body.problem.Size(); ++k) {
      const double root_area = body.problem.CandidateAt(k).Force(q[k]) / q[k];
      EXPECT_NEAR(q[k] / root_area, 3, 1e-13);
      EXPECT_NEAR(Aq[k], root_area * Dot(motion[k], body.problem.CandidateAt(k).normal), 1e-12 * std::abs(Aq[k]));
    }
    EXPECT_NEAR(body.problem.SolutionOf(q, nullptr, PressedBody::kTip, 0).shape.stored, 0, 1e-12);
  }
}

/// The impulses carry the pressures' momentum, and the energy of uneven pressures is that of the compliance.
TEST(Segments, TakesTheSolution)
{
  for (const GeometryKind kind : kKinds) {
    PressedBody body;
    PressureSolver solver;
    PressureReport report;
    ASSERT_EQ(body.Create(kind), PETSC_SUCCESS);
    ASSERT_EQ(solver.Create(), PETSC_SUCCESS);
    std::vector<double> q = body.problem.Start();
    ASSERT_EQ(solver.Solve(body.problem, {}, 0, &q, &report), PETSC_SUCCESS);
    EXPECT_TRUE(report.solved && report.pressing > 3 && report.pressing < body.problem.Size());
    const SegmentSolution solution = body.problem.SolutionOf(q, nullptr, PressedBody::kTip, 0);
    Vec3 given{}, taken{};
    for (int k = 0; k < body.problem.Size(); ++k)
      given = given + (1e-3 * body.problem.CandidateAt(k).Force(q[k])) * body.problem.CandidateAt(k).normal;
    for (const Vec3 &impulse : solution.impulses) taken = taken + impulse;
    EXPECT_LE(Norm(given - taken), 1e-13 * Norm(given));
    std::vector<double> Aq(q.size());
    std::vector<Vec3> forces, moved;
    body.problem.Multiply(q.data(), Aq.data());
    for (int k = 0; k < body.problem.Size(); ++k)
      forces.push_back(body.problem.CandidateAt(k).Force(q[k]) * body.problem.CandidateAt(k).normal);
    body.problem.Spread(forces, &moved);
    body.problem.Move(&moved);
    const std::vector<Vec3> motion = body.problem.MotionOf(moved);
    double kinetic = 0;
    for (std::size_t k = 0; k < motion.size(); ++k) kinetic += 0.5 * Dot(forces[k], motion[k]);
    const double stored = 0.5 * Product(q, Aq) - kinetic;
    EXPECT_GT(stored, 0);
    EXPECT_NEAR(solution.shape.stored, stored, 1e-9 * stored);
  }
}

/// Halves of a tilted patch whose middle touches touch as it does, by their flow; those of one above the indenter keep none.
TEST(Surface, HalvesTouchAsTheWhole)
{
  constexpr double kH = 1;
  const Geometry plane;
  const Indenter cone{CreateCone(GeometryKind::kPlaneStrain, 70.3, 0), {}, {0, 0, 0}};
  for (const double height : {0.5, -0.1}) { // of the face above its middle
    Surface surface;
    const double middle = 2 / std::tan(70.3 * M_PI / 180) - height;
    surface.Add({1, 1, 0, {{2.5, middle - 0.2, 0}, {1.5, middle + 0.2, 0}}, 1, 0});
    surface.NumberCorners(2);
    const double whole = cone.Gap(surface.Patches()[0].Center(2), cone.tip).distance;
    surface.Split(plane, cone, cone.tip, kH);
    ASSERT_GE(surface.Patches().size(), 4u);
    for (const SurfacePatch &part : surface.Patches()) {
      const double gap = cone.Gap(part.Center(2), cone.tip).distance;
      if (whole < 0)
        EXPECT_NEAR(gap + part.flow, whole, 1e-14);
      else
        EXPECT_EQ(part.flow, 0);
    }
  }
}

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

/// A segment sticks with less than mu of its pressure, or slips against a traction of mu times it; that makes the heat.
TEST(Friction, CoulombsConditionsHold)
{
  constexpr double kMu = 0.3;
  for (const GeometryKind kind : kKinds) {
    PressedBody body;
    ASSERT_EQ(body.Create(kind), PETSC_SUCCESS);
    const SegmentProblem &problem = body.problem;
    const int axes = body.geometry.Dim() - 1;
    const Vec3 way = {1e-3, 0, 0};
    std::vector<double> q(problem.Size());
    for (double &one : q) one = std::pow(10, Random(0, 5));
    Friction friction(kMu);
    friction.Begin(body.sides, body.geometry.Dim(), problem);
    friction.Solve(problem, q, way);
    // Slips of segments: of the nodes, and of what yields between them.
    std::vector<Vec3> forces, moved;
    for (int k = 0; k < problem.Size(); ++k) forces.push_back(problem.CandidateAt(k).Force(q[k]) * problem.CandidateAt(k).normal);
    problem.Spread(forces, &moved);
    problem.Move(&moved);
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = moved[i] + friction.Motion()[i];
    const std::vector<Vec3> motion = problem.MotionOf(moved), before = problem.MotionBefore();
    std::vector<Friction::Along> slips(problem.Size());
    for (int a = 0; a < axes; ++a) {
      std::vector<char> odd;
      for (const SurfaceColumn &column : problem.Columns()) {
        odd.push_back(0);
        for (const Side side : SidesAcross(a))
          odd.back() |= body.sides.kind[side] != BoundaryKind::kFree && body.sides.Reaches(side, column.at);
      }
      std::vector<double> tractions(problem.Size());
      for (int k = 0; k < problem.Size(); ++k) tractions[k] = problem.CandidateAt(k).root_area * friction.Traction(problem, k)[a];
      const std::vector<double> yields = problem.YieldTo(tractions, odd);
      for (int k = 0; k < problem.Size(); ++k)
        slips[k][a] = Dot(SurfaceTangent(problem.CandidateAt(k).normal, a, axes), motion[k] + before[k] - way) +
                      yields[k] / problem.CandidateAt(k).root_area;
    }
    double largest = 0, heat = 0;
    for (const Friction::Along &slip : slips) largest = std::max(largest, std::hypot(slip[0], slip[1]));
    int sticking = 0, slipping = 0;
    for (int k = 0; k < problem.Size(); ++k) {
      const Friction::Along t = friction.Traction(problem, k), &s = slips[k];
      const double area = problem.CandidateAt(k).Area(), most = kMu * problem.CandidateAt(k).Force(q[k]) / area;
      const double size = std::hypot(t[0], t[1]), slip = std::hypot(s[0], s[1]), along = t[0] * s[0] + t[1] * s[1];
      EXPECT_LE(size, most * (1 + 1e-14));
      if (size < most * (1 - 1e-6)) {
        EXPECT_LE(slip, 1e-7 * largest) << "sticks";
        ++sticking;
      } else {
        EXPECT_LE(along + most * slip, 1e-7 * most * largest) << "pulls against the slip";
        ++slipping;
      }
      heat -= area * along;
    }
    EXPECT_GT(std::min(sticking, slipping), 0);
    EXPECT_NEAR(friction.Heat(), heat, 1e-7 * heat);
  }
}
