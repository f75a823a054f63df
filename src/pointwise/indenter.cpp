// Surfaces of indenters and the integrals of their motion.
#include "pointwise/indenter.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

class Wedge : public IndenterSurface
{
public:
  Wedge(double half_angle, double tip_radius) : slope_(1 / std::tan(half_angle * M_PI / 180)), rounding_(tip_radius * slope_) {}
  SurfaceGap Gap(Vec3 x) const override
  {
    const double root = std::hypot(x[0], rounding_);
    const double slope = rounding_ > 0 ? slope_ * x[0] / root : std::copysign(slope_, x[0]);
    const double scale = 1 / std::hypot(slope, 1.0);
    return {scale * (slope_ * (root - rounding_) - x[1]), {scale * slope, -scale}};
  }
  double Width(double height) const override
  {
    const double root = height / slope_ + rounding_;
    return 2 * std::sqrt((root - rounding_) * (root + rounding_));
  }

private:
  double slope_, rounding_;
};

class Cylinder : public IndenterSurface
{
public:
  explicit Cylinder(double radius) : radius_(radius) {}
  SurfaceGap Gap(Vec3 x) const override
  {
    const Vec3 r = x - Vec3{0, radius_};
    const double distance = Norm(r);
    return {distance - radius_, distance > 0 ? (1 / distance) * r : Vec3{0, -1}};
  }
  double Width(double height) const override
  {
    return height < radius_ ? 2 * std::sqrt(height * (2 * radius_ - height)) : 2 * radius_;
  }

private:
  double radius_;
};

/// An intersection of half planes; the distance is that to the plane farthest away.
class ConvexPolygon : public IndenterSurface
{
public:
  explicit ConvexPolygon(const std::vector<Vec3> &vertices)
  {
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const Vec3 start = vertices[k], edge = vertices[(k + 1) % vertices.size()] - start;
      planes_.push_back({start, (1 / Norm(edge)) * TurnRight(edge)});
    }
  }
  SurfaceGap Gap(Vec3 x) const override
  {
    SurfaceGap gap{-HUGE_VAL, {}};
    for (const Plane &plane : planes_) {
      const double distance = Dot(plane.normal, x - plane.point);
      if (distance > gap.distance) gap = {distance, plane.normal};
    }
    return gap;
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

private:
  struct Plane {
    Vec3 point, normal;
  };
  std::vector<Plane> planes_;
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

} // namespace

std::unique_ptr<IndenterSurface> CreateWedge(double half_angle, double tip_radius)
{
  return std::make_unique<Wedge>(half_angle, tip_radius);
}

std::unique_ptr<IndenterSurface> CreateCylinder(double radius) { return std::make_unique<Cylinder>(radius); }

std::unique_ptr<IndenterSurface> CreateFlatPunch(double width)
{
  const double half = 0.5 * width, height = 1e3 * width;
  return std::make_unique<ConvexPolygon>(std::vector<Vec3>{{-half, 0}, {half, 0}, {half, height}, {-half, height}});
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

double PiecewiseLinear::Value(double t) const
{
  if (times_.empty()) return 0;
  if (t <= times_.front()) return values_.front();
  for (std::size_t k = 1; k < times_.size(); ++k)
    if (t < times_[k]) return values_[k - 1] + (values_[k] - values_[k - 1]) * (t - times_[k - 1]) / (times_[k] - times_[k - 1]);
  return values_.back();
}

double PiecewiseLinear::Integral(double t) const
{
  double sum = 0, from = 0;
  for (double knot : times_)
    if (knot > from && knot < t) {
      sum += 0.5 * (Value(from) + Value(knot)) * (knot - from);
      from = knot;
    }
  return sum + 0.5 * (Value(from) + Value(t)) * (t - from);
}

double PiecewiseLinear::LargestMagnitude(double from, double to) const
{
  double largest = std::max(std::abs(Value(from)), std::abs(Value(to)));
  for (std::size_t k = 0; k < times_.size(); ++k)
    if (times_[k] > from && times_[k] < to) largest = std::max(largest, std::abs(values_[k]));
  return largest;
}

double PiecewiseLinear::TimeOfIntegral(double target, double end) const
{
  std::vector<double> knots;
  for (double knot : times_)
    if (knot > 0 && knot < end) knots.push_back(knot);
  knots.push_back(end);
  double from = 0;
  for (double to : knots) {
    // Within a piece the integral is I + v0 s + (v1 - v0) s^2/(2 T).
    const double v0 = Value(from), v1 = Value(to), T = to - from, need = target - Integral(from);
    const double a = 0.5 * (v1 - v0) / T, root2 = v0 * v0 + 4 * a * need;
    if (root2 >= 0) {
      const double s = 2 * need / (v0 + std::sqrt(root2)); // the smaller positive root, also where a = 0
      if (s >= 0 && s <= T * (1 + 1e-12)) return from + s;
    }
    from = to;
  }
  return HUGE_VAL;
}

} // namespace mlgimp
