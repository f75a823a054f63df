// Indenters and histories by their properties.
#include "physics/geometry.hpp"
#include "physics/tips/half_spaces.hpp"
#include "physics/tips/profiles.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// Height of a surface above a place, by bisection of the gap along the vertical axis.
double Height(const IndenterSurface &surface, Vec3 x, int up, double upper)
{
  double below = -1e-3, above = upper;
  for (int n = 0; n < 200; ++n) {
    x[up] = 0.5 * (below + above);
    (surface.Gap(x).distance > 0 ? below : above) = x[up];
  }
  return x[up];
}
double Height(const IndenterSurface &surface, double x, double upper) { return Height(surface, {x, 0, 0}, 1, upper); }

/// Slope of the gap along an axis.
double Slope(const IndenterSurface &surface, Vec3 x, int axis)
{
  constexpr double kStep = 1e-6;
  Vec3 above = x, below = x;
  above[axis] += kStep, below[axis] -= kStep;
  return (surface.Gap(above).distance - surface.Gap(below).distance) / (2 * kStep);
}

/// width: of the part of the surface that is looked at, whose height is below `height`. edges: of planes, where the gap has
/// a kink; few places lie at one.
void CheckSurface(const std::string &name, const IndenterSurface &surface, double width, double height, int up = 1,
                  bool edges = false)
{
  double unit = 0, gradient = 0, lowest = HUGE_VAL;
  int kinks = 0;
  bool signs = true;
  for (int n = 0; n < 200; ++n) {
    Vec3 x = {Random(-width, width), up == 2 ? Random(-width, width) : 0, 0};
    x[up] = Height(surface, x, up, height);
    const Vec3 normal = surface.Gap(x).normal;
    unit = Largest({unit, std::abs(Norm(normal) - 1)});
    double off = 0;
    for (int axis = 0; axis <= up && std::abs(x[0]) > 1e-4; ++axis)
      off = Largest({off, std::abs(Slope(surface, x, axis) - normal[axis])});
    if (edges && off > 1e-6)
      ++kinks;
    else
      gradient = Largest({gradient, off});
    signs &= surface.Gap(x + 1e-3 * normal).distance > 0 && surface.Gap(x + -1e-3 * normal).distance < 0;
    lowest = std::min(lowest, x[up]);
  }
  const Vec3 below = {0, up == 1 ? -0.01 : 0, up == 2 ? -0.01 : 0};
  EXPECT_LE(unit, 1e-14) << name + ": length of the normal less one";
  EXPECT_LE(gradient, 1e-6) << name + ": normal less gradient of the gap, on the surface";
  EXPECT_LE(kinks, 2) << name + ": places where the gap has no gradient";
  EXPECT_TRUE(signs) << name + ": gap is positive outside and negative inside";
  EXPECT_GT(lowest, -1e-12) << name + ": nothing lies below the tip";
  EXPECT_LE(std::abs(surface.Gap({0, 0}).distance), 1e-15) << name + ": gap at the tip";
  EXPECT_LE(surface.Gap(below).distance, 0.01 + 1e-15) << name + ": gap below the tip";
  EXPECT_GE(surface.Gap(below).distance, 0.01 * 0.57) << name + ": gap below the tip"; // the sine of the steepest face
}

/// Area of the section at a height above the tip: the area within the curve of zero gap, which is a graph over the angle.
double SectionArea(const IndenterSurface &surface, double height)
{
  constexpr int kAngles = 7200;
  double area = 0;
  for (int n = 0; n < kAngles; ++n) {
    const double angle = 2 * M_PI * (n + 0.5) / kAngles;
    double inside = 0, outside = 100 * height;
    for (int halving = 0; halving < 60; ++halving) {
      const double r = 0.5 * (inside + outside);
      (surface.Gap({r * std::cos(angle), r * std::sin(angle), height}).distance > 0 ? outside : inside) = r;
    }
    area += M_PI / kAngles * inside * inside;
  }
  return area;
}

constexpr GeometryKind kPlane = GeometryKind::kPlaneStrain, kSpace = GeometryKind::kSpatial;

TEST(Surfaces, Indenters)
{
  constexpr double kHalfAngle = 70.3, kTipRadius = 0.2;
  const double slope = 1 / std::tan(kHalfAngle * M_PI / 180);
  for (const GeometryKind geometry : {kPlane, GeometryKind::kAxisymmetric, kSpace}) {
    const int up = UpAxis(geometry);
    const std::string where = std::string(" in ") + kGeometryNames[static_cast<int>(geometry)];
    CheckSurface("cone" + where, *CreateCone(geometry, kHalfAngle, 0), 1, 1, up);
    CheckSurface("rounded cone" + where, *CreateCone(geometry, kHalfAngle, kTipRadius), 1, 1, up);
    CheckSurface("sphere" + where, *CreateSphere(geometry, 2), 1.4, 2, up);
    CheckSurface("flat punch" + where, *CreateFlatPunch(geometry, 1, 0), 0.7, 1, up);
  }
  CheckSurface("polygon", *CreatePolygonIndenter({{3, 7}, {5, 7.6}, {5, 10}, {1, 10}, {1, 7.5}}), 1.9, 1);
  EXPECT_LE(std::abs(Height(*CreateCone(kPlane, kHalfAngle, 0), 1, 1) / slope - 1), 1e-12) << "wedge: slope";
  EXPECT_LE(std::abs(Height(*CreateSphere(kPlane, 2), 1, 2) - (2 - std::sqrt(3))), 1e-12) << "cylinder: height";
  EXPECT_LE(std::abs(CreateSphere(kPlane, 2)->Gap({3, -2}).distance - 3), 1e-14) << "cylinder: gap at a distance";
  EXPECT_LE(std::abs(CreateSphere(kSpace, 2)->Gap({2, 2, 1}).distance - 1), 1e-14) << "sphere: gap at a distance";
  EXPECT_EQ(CreateFlatPunch(kPlane, 1, 0)->Width(HUGE_VAL), 2);
  EXPECT_TRUE(IsConvex({{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_TRUE(IsConvex({{0, 1}, {1, 0}, {0, 0}}));
  EXPECT_FALSE(IsConvex({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}));
}

/// Distance in the plane of the axis from a ball with a tangent flank, to the nearer of both where each is the outline: the arc
/// below the tangent point, and the half line above it.
double DistanceFromConosphere(double angle, double radius, double rho, double height)
{
  const Vec3 normal = {std::cos(angle), -std::sin(angle), 0}, along = {std::sin(angle), std::cos(angle), 0};
  const Vec3 centre = {0, radius, 0}, x = {rho, height, 0}, meet = centre + radius * normal;
  const Vec3 from_centre = x - centre, from_meet = x - meet, foot = meet + std::max(0.0, Dot(from_meet, along)) * along;
  const double arc = std::atan2(from_centre[0], -from_centre[1]); // from straight down
  const double to_flank = Norm(x - foot),
               to_ball = arc <= M_PI / 2 - angle ? std::abs(Norm(from_centre) - radius) : Norm(from_meet);
  const bool inside = Dot(from_meet, along) < 0 ? Norm(from_centre) < radius : Dot(from_meet, normal) < 0;
  return (inside ? -1 : 1) * std::min(to_flank, to_ball);
}

/// The conosphere of catalogues: what its distance, width, flank and the height where ball and flank meet are.
TEST(Surfaces, ConesWithABall)
{
  constexpr double kRadius = 3;
  for (const double degrees : {8.0, 30.0, 60.0, 70.3, 89.0}) {
    const double angle = degrees * M_PI / 180, sine = std::sin(angle), meet = kRadius * (1 - sine);
    for (const GeometryKind geometry : {kPlane, GeometryKind::kAxisymmetric, kSpace}) {
      const int up = UpAxis(geometry);
      const auto tip = CreateCone(geometry, degrees, kRadius);
      double error = 0, turn = 0;
      for (int n = 0; n < 1000; ++n) {
        Vec3 x = {Random(-3 * kRadius, 3 * kRadius), up == 2 ? Random(-3 * kRadius, 3 * kRadius) : 0, 0};
        x[up] = Random(-kRadius, 3 * kRadius);
        const double rho = std::hypot(x[0], up == 2 ? x[1] : 0);
        if (x[up] > kRadius && rho < (x[up] - kRadius) / std::tan(angle))
          continue; // deep inside the flank's far side may be nearer
        error = Largest({error, std::abs(tip->Gap(x).distance - DistanceFromConosphere(angle, kRadius, rho, x[up]))});
      }
      for (const double off : {-1e-9, 1e-9}) { // of the normal, across the circle where both meet
        Vec3 below = {kRadius * std::cos(angle), 0, 0};
        below[up] = meet + off;
        const Vec3 normal = tip->Gap(below).normal;
        turn = Largest({turn, std::abs(normal[0] - std::cos(angle)), std::abs(normal[up] + sine)});
      }
      EXPECT_LE(error, 1e-12 * kRadius) << degrees << " degrees: distance";
      EXPECT_LE(turn, 2e-9) << degrees << " degrees: normal where ball and flank meet";
      EXPECT_NEAR(tip->Width(0.5 * meet), 2 * std::sqrt(0.5 * meet * (2 * kRadius - 0.5 * meet)), 1e-12 * kRadius);
      EXPECT_NEAR(tip->Width(7 + meet) / (2 * std::tan(angle) * (7 + meet + kRadius * (1 / sine - 1))), 1, 1e-12);
      EXPECT_NEAR(tip->Width(meet * (1 + 1e-12)), tip->Width(meet * (1 - 1e-12)), 1e-9 * kRadius) << degrees << " degrees: width";
    }
  }
}

/// Vertices of a profile may lie on an edge, to rounding; spikes and vertices that are given twice stay, and are not convex.
TEST(Surfaces, CornersOfPolygons)
{
  EXPECT_EQ(CornersOf({{0, 0}, {1.5, 0.5}, {3, 1}, {1, 4}, {-2, 2}, {-1, 1}}).size(), 4U);
  EXPECT_EQ(CornersOf({{0, 0}, {1, 0.1}, {2, 0.2}, {3, 0.3 + 1e-13}, {1, 4}}).size(), 3U);
  EXPECT_EQ(CornersOf({{0, 0}, {1, 1e-6}, {2, 0}, {1, 1}}).size(), 4U);
  EXPECT_TRUE(IsConvex(CornersOf({{0, 0}, {1.5, 0.5}, {3, 1}, {1, 4}, {-2, 2}})));
  EXPECT_FALSE(IsConvex(CornersOf({{0, 0}, {3, 0}, {2, 0}, {1, 1}})));
  EXPECT_FALSE(IsConvex(CornersOf({{0, 0}, {0, 0}, {2, 0}, {1, 1}})));
}

/// Which indenters a side of symmetry through the tip may cut: across x, across y.
TEST(Surfaces, Mirrors)
{
  const auto across = [](const IndenterSurface &surface) {
    return std::pair<bool, bool>(surface.MayBeMirrored(0), surface.MayBeMirrored(1));
  };
  using Axes = std::pair<bool, bool>;
  EXPECT_EQ(across(*CreateCone(kSpace, 70.3, 0.1)), Axes(true, true)) << "cone";
  EXPECT_EQ(across(*CreatePyramid(65.27, 3, 0, 0)), Axes(false, true)) << "Berkovich";
  EXPECT_EQ(across(*CreatePyramid(65.27, 3, 90, 0.3)), Axes(true, false)) << "Berkovich, turned, rounded";
  EXPECT_EQ(across(*CreatePyramid(68, 4, 45, 0)), Axes(true, true)) << "Vickers on its edges";
  EXPECT_EQ(across(*CreatePyramid(68, 4, 44.99, 0)), Axes(false, false)) << "Vickers, turned";
  EXPECT_TRUE(CreatePolygonIndenter({{0, 0}, {3, 1}, {-3, 1}})->MayBeMirrored(0)) << "polygon";
  EXPECT_TRUE(CreatePolygonIndenter({{0, 0}, {3, 1}, {0, 1}})->MayBeMirrored(0)) << "half of a polygon";
  EXPECT_FALSE(CreatePolygonIndenter({{0, 0}, {3, 1}, {-1, 1}})->MayBeMirrored(0)) << "lopsided polygon";
  EXPECT_FALSE(CreatePolygonIndenter({{0, 0}, {3, 1}, {3, 4}, {-3, 1}})->MayBeMirrored(0)) << "lopsided above";
}

/// On an edge no face may be chosen by rounding: a Vickers tip in a whole model pushed sideways with 2 % of its load.
TEST(Surfaces, EdgesAreOfBothFaces)
{
  const auto pyramid = CreatePyramid(68, 4, 0, 0);
  for (const double x : {1e-9, 0.3, 0.7, 1 / 3.0, 1e3})
    for (const double rounding : {-1e-15, 0.0, 1e-15}) {
      const Vec3 normal = pyramid->Gap({x, x * (1 + rounding), 0.1 * x}).normal,
                 beside = pyramid->Gap({x, 0.9 * x, 0.1 * x}).normal;
      EXPECT_NEAR(normal[0], normal[1], 1e-14) << "on the edge at " << x;
      EXPECT_NEAR(normal[2], beside[2], 1e-14) << "as steep as its faces";
      EXPECT_NEAR(beside[1], 0, 1e-14) << "beside it, of one face";
    }
}

/// Sections of sharp tips: Berkovich and Vickers are made to have nearly the same.
TEST(Surfaces, SectionAreas)
{
  constexpr double kDepth = 0.7;
  const auto per_square = [](const IndenterSurface &surface) { return SectionArea(surface, kDepth) / (kDepth * kDepth); };
  EXPECT_NEAR(per_square(*CreatePyramid(65.27, 3, 0, 0)), 24.49, 0.01) << "Berkovich";
  EXPECT_NEAR(per_square(*CreatePyramid(68, 4, 0, 0)), 24.50, 0.01) << "Vickers";
  EXPECT_NEAR(per_square(*CreatePyramid(35.2644, 3, 0, 0)), 2.598, 0.001) << "cube corner";
  const double tangent = std::tan(70.3 * M_PI / 180);
  EXPECT_NEAR(per_square(*CreateCone(kSpace, 70.3, 0)) / (M_PI * tangent * tangent), 1, 1e-9) << "cone";
  EXPECT_NEAR(SectionArea(*CreateSphere(kSpace, 2), kDepth) / (M_PI * kDepth * (4 - kDepth)), 1, 1e-9) << "sphere";
}

TEST(Surfaces, Pyramids)
{
  constexpr double kHalfAngle = 65.27, kTurn = 25, kTipRadius = 0.3;
  for (int faces : {3, 4, 7})
    for (double radius : {0.0, kTipRadius}) {
      const std::string name = std::to_string(faces) + " faces, tip radius " + std::to_string(radius);
      const auto pyramid = CreatePyramid(kHalfAngle, faces, kTurn, radius),
                 unturned = CreatePyramid(kHalfAngle, faces, 0, radius);
      CheckSurface(name, *pyramid, 1, 2, 2, radius == 0);
      double turned = 0, repeated = 0, length = 0, gradient = 0;
      for (int n = 0; n < 500; ++n) { // also far from the surface
        const double r = Random(0, 2), z = Random(-0.5, 2), angle = Random(0, 2 * M_PI);
        const auto at = [&](double turn) { return Vec3{r * std::cos(angle + turn), r * std::sin(angle + turn), z}; };
        const SurfaceGap gap = unturned->Gap(at(0));
        turned = Largest({turned, std::abs(pyramid->Gap(at(kTurn * M_PI / 180)).distance - gap.distance)});
        repeated = Largest({repeated, std::abs(unturned->Gap(at(2 * M_PI / faces)).distance - gap.distance)});
        length = Largest({length, std::abs(Norm(gap.normal) - 1)});
        const bool smooth = radius > 0 && gap.distance > -0.9 * radius; // no kinks: the normal is the gradient, of length one
        for (int axis = 0; axis < 3 && smooth; ++axis)
          gradient = Largest({gradient, std::abs(Slope(*unturned, at(0), axis) - gap.normal[axis])});
      }
      EXPECT_LE(turned, 1e-14) << name + ": turned with -indenter_turn";
      EXPECT_LE(repeated, 1e-14) << name + ": the same from every face";
      EXPECT_LE(length, 1e-14) << name + ": length of the normal less one";
      EXPECT_LE(gradient, 1e-5) << name + ": normal less gradient of the gap";
      EXPECT_NEAR(pyramid->Gap({0.5 * std::cos(M_PI / 180 * kTurn), 0.5 * std::sin(M_PI / 180 * kTurn), 0}).normal[2],
                  -std::sin(M_PI / 180 * kHalfAngle), 1e-12)
          << name + ": the first face is at the angle of the turn";
    }
  const auto rounded = CreatePyramid(kHalfAngle, 3, 0, kTipRadius);
  EXPECT_NEAR(rounded->Gap({0.02, 0.03, kTipRadius}).distance, -kTipRadius, 0.02) << "the ball at the tip";
  EXPECT_NEAR(rounded->Gap({0.03, 0.04, -0.1}).distance, std::hypot(0.05, kTipRadius + 0.1) - kTipRadius, 1e-14);
  for (const double radius : {0.0, kTipRadius}) // the circle of a section that Width gives touches its sides
    for (const double height : {0.01, 0.02, 0.5}) {
      const auto pyramid = CreatePyramid(kHalfAngle, 3, 0, radius);
      EXPECT_NEAR(pyramid->Gap({0.5 * pyramid->Width(height), 0, height}).distance, 0, 1e-12) << radius << " " << height;
    }
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
    worst = Largest({worst, std::abs(speed.Integral(next) - sum)});
  }
  EXPECT_LE(worst, 1e-12) << "history: integral";
  EXPECT_LE(std::abs(PiecewiseLinear({2}, {3}).Integral(1.5) - 4.5), 1e-15) << "history: constant one";
  EXPECT_EQ(PiecewiseLinear().Value(1), 0) << "a history of nothing";
  EXPECT_EQ(PiecewiseLinear().Integral(1), 0);
  EXPECT_TRUE(std::isinf(PiecewiseLinear().TimeOfIntegral(1, 10)));
  // The integral grows to 0.5 + 4 + 2/3 at t = 3 + 2/3 and falls again.
  worst = 0;
  for (double target : {1e-9, 0.1, 0.5, 2.0, 4.5, 5.0, 5.16})
    worst = Largest({worst, std::abs(speed.Integral(speed.TimeOfIntegral(target, 10)) - target) +
                                (speed.TimeOfIntegral(target, 10) < 3.667 ? 0 : 1)});
  EXPECT_LE(worst, 1e-12) << "history: first time of an integral";
  EXPECT_TRUE(std::isinf(speed.TimeOfIntegral(5.17, 10))) << "never reached";
  EXPECT_TRUE(std::isinf(speed.TimeOfIntegral(2, 1.5))) << "not reached in time";

  const Indenter indenter = {CreateSphere(kPlane, 1), {speed, 2, 0.5}, {3, 7}, 6};
  EXPECT_LE(std::abs(indenter.Depth(indenter.Tip(1.5)) - (0.5 + 1 - 1)), 1e-14) << "motion: depth before turning";
  EXPECT_LE(std::abs(indenter.Depth(indenter.Tip(3)) - (2.5 - 0.5 - 1)), 1e-14) << "motion: depth after turning";
  EXPECT_EQ(indenter.Velocity(1.5)[1], -2);
  EXPECT_EQ(indenter.Velocity(3)[1], 0.5);
  EXPECT_EQ(indenter.Velocity(3)[0], 0);
  EXPECT_LE(std::abs(indenter.Gap(indenter.Tip(1.7), indenter.Tip(1.7)).distance), 1e-14) << "motion: gap moves with the tip";
  const Indenter deep = {CreateSphere(kSpace, 1), {speed, 2, 0.5}, {3, 7, 5}, 4, 2};
  EXPECT_LE(std::abs(deep.Depth(deep.Tip(1.5)) - (0.5 + 1 - 1)), 1e-14) << "motion: along z in space";
  EXPECT_LE(Norm(deep.Velocity(1.5) - Vec3{0, 0, -2}), 1e-14);
  EXPECT_LE(Norm(deep.Tip(1.5) - Vec3{3, 7, 3.5}), 1e-14);
}

} // namespace
