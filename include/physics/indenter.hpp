// The rigid indenter: its surface as a signed distance, and its motion or the load that moves it.
#pragma once

#include "base/piecewise_linear.hpp"
#include "base/tensor.hpp"
#include "physics/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

namespace mlgimp
{

/// Distance of a point from the indenter's surface and the normal out of the indenter there.
struct SurfaceGap {
  double distance; ///< m, negative inside the indenter
  Vec3 normal;     ///< gradient of the distance; on an edge between faces the mean of theirs, shorter than 1
};

/// The surface of an indenter, in coordinates relative to its tip (its lowest point).
class IndenterSurface
{
public:
  virtual ~IndenterSurface() = default;
  virtual SurfaceGap Gap(Vec3 x) const = 0;
  /// Width of the part below a height above the tip, which may be infinite, m: the largest extent along x, of a pyramid the
  /// diameter of the inscribed circle.
  virtual double Width(double height) const = 0;
  /// Whether the plane through the tip that is normal to a horizontal axis may be one of symmetry: it is its own mirror image
  /// there, or ends there.
  virtual bool MayBeMirrored(int axis) const = 0;
};

// Profiles over the distance rho from the axis: prismatic in plane strain, of revolution otherwise.

/// A cone or wedge with half_angle, in degrees from the axis. With a tip radius R it ends in a ball (a cylinder) that the flanks
/// are tangent to, the conosphere of catalogues: they meet at the height R (1 - sin a), and a sharp cone with the same flanks
/// reaches R (1/sin a - 1) deeper.
std::unique_ptr<IndenterSurface> CreateCone(GeometryKind geometry, double half_angle, double tip_radius);
std::unique_ptr<IndenterSurface> CreateSphere(GeometryKind geometry, double radius);
/// radius: half its width in plane strain.
std::unique_ptr<IndenterSurface> CreateFlatPunch(GeometryKind geometry, double radius);

// Intersections of half spaces.

/// Of plane strain. Moved so that its lowest vertex (or the middle of its lowest edge) becomes the tip. Vertices either way
/// round.
std::unique_ptr<IndenterSurface> CreatePolygonIndenter(std::vector<Vec3> vertices);
bool IsConvex(const std::vector<Vec3> &vertices);

/// Vertices of a polygon without those that lie, to rounding, on the line between their neighbours.
std::vector<Vec3> CornersOf(const std::vector<Vec3> &vertices);
/// Of space, the tip down: faces at half_angle from the axis, the first with its normal at the angle `turn` from x about
/// the axis, all in degrees. With a tip radius: all within that radius of such a pyramid, so that edges are round as well.
std::unique_ptr<IndenterSurface> CreatePyramid(double half_angle, int faces, double turn, double tip_radius);

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

/// Load control: what the indenter, which has no mass, carries; it goes where the contact lets it.
struct IndenterLoad {
  PiecewiseLinear force;    ///< N, as simulated, not negative
  double largest_speed = 0; ///< of the tip, up or down, m/s
};

/// What contact must carry in a step under load control.
struct LoadInStep {
  double force;       ///< N
  double most_travel; ///< of the tip, up or down, m
  /// How far the tip comes down where nothing is near, m.
  double FreeTravel() const { return force > 0 ? most_travel : 0; }
};

/// The tip in a step. Under load control it keeps its height, and contact finds how far it comes down.
struct TipStep {
  Vec3 start{}, end{}; ///< m
  std::optional<LoadInStep> by_load{};
  /// How far it comes down where nothing is near, m.
  double FreeTravel() const { return by_load ? by_load->FreeTravel() : 0; }
};

/// A moving rigid indenter.
struct Indenter {
  std::unique_ptr<IndenterSurface> surface;
  IndenterMotion motion;      ///< without a load
  Vec3 tip{};                 ///< at t = 0, m
  double initial_surface = 0; ///< height of the undeformed body below the tip, m
  int up = 1;                 ///< axis, the last of the geometry
  std::optional<IndenterLoad> by_load{};
  std::array<PiecewiseLinear, 2> sideways{}; ///< speed along the horizontal axes, m/s

  Vec3 Up(double length) const { return {0, up == 1 ? length : 0, up == 2 ? length : 0}; }
  /// How far it has come sideways since t = 0, m.
  Vec3 Sideways(double t) const { return {sideways[0].Integral(t), sideways[1].Integral(t), 0}; }
  // Its motion where there is no load.
  Vec3 Tip(double t) const { return tip - Up(motion.Travel(t)) + Sideways(t); }
  Vec3 Velocity(double t) const { return Up(-motion.Speed(t)) + Vec3{sideways[0].Value(t), sideways[1].Value(t), 0}; }

  /// Bound of its speed between two times; exact where it moves along one axis and not by a load.
  double Fastest(double from, double to) const
  {
    const double x = sideways[0].LargestMagnitude(from, to), y = sideways[1].LargestMagnitude(from, to);
    return std::hypot(by_load ? by_load->largest_speed : motion.Fastest(from, to), std::hypot(x, y));
  }
  double Depth(Vec3 tip_now) const { return initial_surface - tip_now[up]; }
  /// Half the width of the part below the undeformed surface where the tip is so deep; nothing above it, m.
  double HalfWidth(double depth) const { return depth > 0 ? 0.5 * surface->Width(depth) : 0; }
  SurfaceGap Gap(Vec3 x, Vec3 tip_now) const { return surface->Gap(x - tip_now); }
};

} // namespace mlgimp
