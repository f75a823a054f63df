// The rigid indenter: its surface as a signed distance, and its motion.
#pragma once

#include "base/tensor.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace mlgimp
{

/// Distance of a point from the indenter's surface and the unit normal out of the indenter there.
struct SurfaceGap {
  double distance; ///< m, negative inside the indenter
  Vec3 normal;     ///< gradient of the distance
};

/// The surface of an indenter, in coordinates relative to its tip (its lowest point).
class IndenterSurface
{
public:
  virtual ~IndenterSurface() = default;
  virtual SurfaceGap Gap(Vec3 x) const = 0;
  /// Largest extent along x up to a height above the tip, which may be infinite, m.
  virtual double Width(double height) const = 0;
};

/// y = tan(b) (sqrt(x^2 + r^2) - r), b = 90 degrees - half_angle, r = tip_radius tan(b), half_angle in degrees from
/// the axis: a wedge whose tip has the radius of curvature tip_radius.
std::unique_ptr<IndenterSurface> CreateWedge(double half_angle, double tip_radius);
std::unique_ptr<IndenterSurface> CreateCylinder(double radius);
std::unique_ptr<IndenterSurface> CreateFlatPunch(double width);
/// Moved so that its lowest vertex (or the middle of its lowest edge) becomes the tip. Vertices either way round.
std::unique_ptr<IndenterSurface> CreatePolygonIndenter(std::vector<Vec3> vertices);
bool IsConvex(const std::vector<Vec3> &vertices);

/// Piecewise-linear history of a quantity, constant before the first and after the last time; zero without any.
class PiecewiseLinear
{
public:
  PiecewiseLinear() = default;
  PiecewiseLinear(std::vector<double> times, std::vector<double> values) : times_(std::move(times)), values_(std::move(values)) {}
  double Value(double t) const;
  double Integral(double t) const; ///< from 0 to t
  double LargestMagnitude(double from, double to) const;
  /// First t in (0, end] where the integral reaches `target` > 0; infinity where it does not.
  double TimeOfIntegral(double target, double end) const;

private:
  std::vector<double> times_, values_;
};

/// The downward motion: a speed history, and from `turning_time` on a constant retraction.
struct IndenterMotion {
  PiecewiseLinear speed;          ///< downward, m/s
  double turning_time = HUGE_VAL; ///< s
  double unload_speed = 0;        ///< upward from turning_time on, m/s

  /// Largest speed, up or down, between two times.
  double Fastest(double from, double to) const
  {
    const double before = from < turning_time ? speed.LargestMagnitude(from, std::min(to, turning_time)) : 0;
    return to < turning_time ? before : std::max(before, unload_speed);
  }
  double Speed(double t) const { return t < turning_time ? speed.Value(t) : -unload_speed; }
  double Travel(double t) const
  {
    return t < turning_time ? speed.Integral(t) : speed.Integral(turning_time) - unload_speed * (t - turning_time);
  }
};

/// A moving rigid indenter.
struct Indenter {
  std::unique_ptr<IndenterSurface> surface;
  IndenterMotion motion;
  Vec3 tip{};                 ///< at t = 0, m
  double initial_surface = 0; ///< height of the undeformed body below the tip, m

  Vec3 Tip(double t) const { return {tip[0], tip[1] - motion.Travel(t)}; }
  Vec3 Velocity(double t) const { return {0, -motion.Speed(t)}; }
  double Depth(double t) const { return initial_surface - Tip(t)[1]; }
  SurfaceGap Gap(Vec3 x, double t) const { return surface->Gap(x - Tip(t)); }
};

} // namespace mlgimp
