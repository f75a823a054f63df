// Polygons and pyramids.
#include "physics/tips/half_spaces.hpp"

#include "physics/tips/profiles.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// An intersection of half spaces; the distance is that to the plane farthest away.
class HalfSpaces : public IndenterSurface
{
public:
  SurfaceGap Gap(Vec3 x) const override
  {
    constexpr double kEdge = 1e-6; // rounding; of the way to the plane's point
    SurfaceGap gap{-HUGE_VAL, {}};
    int faces = 0;
    for (const Plane &plane : planes_) gap.distance = std::max(gap.distance, Dot(plane.normal, x - plane.point));
    for (const Plane &plane : planes_)
      if (Dot(plane.normal, x - plane.point) >= gap.distance - kEdge * Norm(x - plane.point))
        gap.normal = gap.normal + plane.normal, ++faces;
    gap.normal = (1.0 / faces) * gap.normal;
    return gap;
  }
  bool MayBeMirrored(int axis) const final
  {
    constexpr double kRounding = 1e-6; // rounding: of typed angles and of lengths
    const auto ends_there = [axis](const Plane &plane) {
      return std::abs(plane.normal[axis]) > 1 - kRounding && std::abs(plane.point[axis]) <= kRounding * Norm(plane.point);
    };
    if (std::any_of(planes_.begin(), planes_.end(), ends_there)) return true;
    const auto mirror = [axis](Vec3 x) {
      x[axis] = -x[axis];
      return x;
    };
    return std::all_of(planes_.begin(), planes_.end(), [&](const Plane &plane) {
      const Vec3 point = mirror(plane.point), normal = mirror(plane.normal);
      return std::any_of(planes_.begin(), planes_.end(), [&](const Plane &other) {
        const double apart = Dot(other.normal, point - other.point), size = Norm(point) + Norm(other.point);
        return Norm(other.normal - normal) < kRounding && std::abs(apart) <= kRounding * size;
      });
    });
  }

protected:
  struct Plane {
    Vec3 point, normal;
  };
  std::vector<Plane> planes_;
};

class ConvexPolygon : public HalfSpaces
{
public:
  explicit ConvexPolygon(const std::vector<Vec3> &vertices)
  {
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const Vec3 start = vertices[k], edge = vertices[(k + 1) % vertices.size()] - start;
      planes_.push_back({start, (1 / Norm(edge)) * TurnRight(edge)});
    }
  }
  double Width(double height) const override
  {
    double left = HUGE_VAL, right = -HUGE_VAL;
    for (std::size_t k = 0; k < planes_.size(); ++k) { // the edge from one vertex to the next, below the height
      const Vec3 a = planes_[k].point, b = planes_[(k + 1) % planes_.size()].point;
      if (std::min(a[1], b[1]) > height) continue;
      const double part = std::abs(b[1] - a[1]) > 0 ? std::clamp((height - a[1]) / (b[1] - a[1]), 0.0, 1.0) : 1;
      for (const double x : {a[1] <= height ? a[0] : b[0], a[0] + part * (b[0] - a[0])})
        left = std::min(left, x), right = std::max(right, x);
    }
    return right - left;
  }
  Vec3 Farthest(Vec3 direction) const override
  {
    const auto before = [&](const Plane &a, const Plane &b) { return Dot(a.point, direction) < Dot(b.point, direction); };
    return std::max_element(planes_.begin(), planes_.end(), before)->point;
  }
};

/// A pyramid widened by a radius. Its apex is that radius above the tip.
class Pyramid : public HalfSpaces
{
public:
  /// azimuths: of the normals of its faces about the axis, in order, radian; less than a half turn apart.
  Pyramid(double half_angle, const std::vector<double> &azimuths, double radius) : half_angle_(half_angle), radius_(radius)
  {
    for (std::size_t k = 0; k < azimuths.size(); ++k) {
      const double angle = azimuths[k], next = k + 1 < azimuths.size() ? azimuths[k + 1] : azimuths[0] + 2 * M_PI;
      const double horizontal = std::cos(half_angle), corner = (angle + next) / 2;
      planes_.push_back({{0, 0, radius}, {horizontal * std::cos(angle), horizontal * std::sin(angle), -std::sin(half_angle)}});
      const double reach = std::tan(half_angle) / std::cos((next - angle) / 2);
      const Vec3 edge = {reach * std::cos(corner), reach * std::sin(corner), 1};
      edges_.push_back((1 / Norm(edge)) * edge);
    }
  }
  SurfaceGap Gap(Vec3 x) const override
  {
    const SurfaceGap sharp = HalfSpaces::Gap(x);
    if (sharp.distance <= 1e-9 * radius_ || radius_ == 0) return {sharp.distance - radius_, sharp.normal};
    const Vec3 from = FromNearest(x - planes_[0].point);
    const double distance = Norm(from);
    return {distance - radius_, (1 / distance) * from};
  }
  double Width(double height) const override { return 2 * RoundedRadius(height, half_angle_, radius_); }
  Vec3 Farthest(Vec3 direction) const override
  {
    for (const Vec3 &edge : edges_)
      if (Dot(edge, direction) > 0) return {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    return radius_ * direction + Vec3{0, 0, radius_};
  }

private:
  /// The vector to x, outside, from the nearest place of the pyramid: its apex, or on an edge or a face. x from the apex.
  Vec3 FromNearest(Vec3 x) const
  {
    Vec3 nearest = x;
    const auto consider = [&](Vec3 from) {
      if (Dot(from, from) < Dot(nearest, nearest)) nearest = from;
    };
    for (const Vec3 &edge : edges_) consider(x - std::max(Dot(edge, x), 0.0) * edge);
    for (const Plane &plane : planes_) {
      const Vec3 from = Dot(plane.normal, x) * plane.normal, foot = x - from;
      bool on_face = true;
      for (const Plane &other : planes_) on_face = on_face && (&other == &plane || Dot(other.normal, foot) <= 0);
      if (on_face) consider(from);
    }
    return nearest;
  }

  double half_angle_, radius_;
  std::vector<Vec3> edges_; ///< directions, from the apex
};

double TwiceArea(const std::vector<Vec3> &v)
{
  double area = 0;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const Vec3 a = v[k], b = v[(k + 1) % v.size()];
    area += a[0] * b[1] - a[1] * b[0];
  }
  return area;
}

/// Azimuths of the normals of a regular pyramid's faces, radian.
std::vector<double> RegularAzimuths(int faces, double turn)
{
  std::vector<double> azimuths;
  for (int k = 0; k < faces; ++k) azimuths.push_back(turn + 2 * M_PI * k / faces);
  return azimuths;
}

} // namespace

std::unique_ptr<IndenterSurface> CreatePyramid(double half_angle, int faces, double turn, double tip_radius)
{
  return std::make_unique<Pyramid>(half_angle * M_PI / 180, RegularAzimuths(faces, turn * M_PI / 180), tip_radius);
}

std::unique_ptr<IndenterSurface> CreateRhombicPyramid(double long_edges, double short_edges, double turn, double tip_radius)
{
  const double a = std::tan(long_edges * M_PI / 360), b = std::tan(short_edges * M_PI / 360); // half diagonals at the height 1
  const double face = std::atan2(1 / b, 1 / a), half_angle = std::atan(1 / std::hypot(1 / a, 1 / b)), at = turn * M_PI / 180;
  return std::make_unique<Pyramid>(
      half_angle, std::vector<double>{at + face, at + M_PI - face, at + M_PI + face, at - face + 2 * M_PI}, tip_radius);
}

std::unique_ptr<IndenterSurface> CreatePolygonIndenter(std::vector<Vec3> vertices)
{
  if (TwiceArea(vertices) < 0) std::reverse(vertices.begin(), vertices.end());
  double lowest = HUGE_VAL, size = 0;
  for (const Vec3 &v : vertices) lowest = std::min(lowest, v[1]);
  for (const Vec3 &v : vertices) size = std::max(size, Norm(v - vertices[0]));
  double x = 0;
  int count = 0;
  for (const Vec3 &v : vertices)
    if (v[1] - lowest < 1e-9 * size) x += v[0], ++count;
  for (Vec3 &v : vertices) v = v - Vec3{x / count, lowest};
  return std::make_unique<ConvexPolygon>(vertices);
}

std::vector<Vec3> CornersOf(const std::vector<Vec3> &v)
{
  constexpr double kFlat = 1e-9; // rounding: sine of the angle
  std::vector<Vec3> corners;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const Vec3 a = v[k] - v[(k + v.size() - 1) % v.size()], b = v[(k + 1) % v.size()] - v[k];
    const bool between = Dot(a, b) > 0 && std::abs(a[0] * b[1] - a[1] * b[0]) <= kFlat * Norm(a) * Norm(b);
    if (!between) corners.push_back(v[k]);
  }
  return corners;
}

bool IsConvex(const std::vector<Vec3> &v)
{
  const double sign = TwiceArea(v);
  double turning = 0;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const Vec3 a = v[(k + 1) % v.size()] - v[k], b = v[(k + 2) % v.size()] - v[(k + 1) % v.size()];
    const double cross = a[0] * b[1] - a[1] * b[0];
    if (cross * sign <= 0) return false;
    turning += std::atan2(cross, Dot(a, b));
  }
  return std::abs(std::abs(turning) - 2 * M_PI) < 1e-6; // once round, not a star
}

} // namespace mlgimp
