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

/// Heights above the tip between which a surface is known; below, it is a guess, m.
struct HeightRange {
  double least = 0, largest = HUGE_VAL;
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
  /// The place of the surface that is farthest in a direction, a unit vector that points downward; not finite where the surface
  /// goes on without end in it.
  virtual Vec3 Farthest(Vec3 direction) const = 0;
  virtual HeightRange KnownHeights() const { return {}; }
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

/// What is elastic between the place whose depth is prescribed and the tip, in series: it takes F (frame + tip/a) of the depth
/// under a force F with a contact of the radius a. In elastic bodies that is to first order the depth of both bodies, whose
/// moduli are in series, under every profile r^n: h ~ (F/E_r)^(n/(n + 1)), and F/(2 a E*) = n h/(n + 1). A metal's contact keeps
/// its width in the unloading, of which 1/S = 1/(2 a E*) + 1/(2 a E_i*): there a is the largest so far.
struct IndenterCompliance {
  double frame = 0;      ///< of frame or cantilever, m/N
  double tip = 0;        ///< (1 - nu^2)/(2 E) of the tip, m^2/N
  bool narrows = true;   ///< the radius may become smaller: no body flows
  double least = 0;      ///< radius of the narrowest contact that cells show, m
  double wave_speed = 0; ///< with which the tip's strain follows the contact's width, m/s
  bool Any() const { return frame > 0 || tip > 0; }
  double At(double radius) const { return frame + (tip > 0 ? tip / std::max(radius, least) : 0); }
};

/// What contact must carry in a step where the tip is free.
struct LoadInStep {
  double force;         ///< where the tip stays at its height, N
  double most_travel;   ///< of the tip, up or down, m
  double stiffness = 0; ///< by which the force falls while the tip comes down, N/m
  double At(double travel) const { return force - stiffness * travel; }
  /// How far the tip comes down where nothing is near, m.
  double FreeTravel() const
  {
    if (stiffness > 0) return std::clamp(force / stiffness, -most_travel, most_travel);
    return force > 0 ? most_travel : 0;
  }
};

/// The tip in a step. A free one keeps its height, and contact finds how far it comes down.
struct TipStep {
  Vec3 start{}, end{}; ///< m
  std::optional<LoadInStep> by_load{};
  /// How far it comes down where nothing is near, m.
  double FreeTravel() const { return by_load ? by_load->FreeTravel() : 0; }
};

/// A moving indenter, whose surface is rigid.
struct Indenter {
  std::unique_ptr<IndenterSurface> surface;
  IndenterMotion motion;                     ///< without a load
  Vec3 tip{};                                ///< at t = 0, m
  double initial_surface = 0;                ///< height of the undeformed body below the tip, m
  int up = 1;                                ///< axis, the last of the geometry
  std::optional<PiecewiseLinear> by_load{};  ///< load control, N as simulated, not negative: the tip goes where contact lets it
  std::array<PiecewiseLinear, 2> sideways{}; ///< speed along the horizontal axes, m/s
  IndenterCompliance compliance{};           ///< of the part that is simulated
  double largest_speed = 0;                  ///< of a free tip, up or down, m/s

  Vec3 Up(double length) const { return {0, up == 1 ? length : 0, up == 2 ? length : 0}; }
  /// How far it has come sideways since t = 0, m.
  Vec3 Sideways(double t) const { return {sideways[0].Integral(t), sideways[1].Integral(t), 0}; }
  /// Whether contact finds where the tip is: under load control, or where something gives way between it and what moves it.
  bool IsFree() const { return by_load || compliance.Any(); }
  // The motion that is prescribed where there is no load, of the tip, or of a rigid one at the end of what gives way.
  Vec3 Tip(double t) const { return tip - Up(motion.Travel(t)) + Sideways(t); }
  Vec3 Velocity(double t) const { return Up(-motion.Speed(t)) + Vec3{sideways[0].Value(t), sideways[1].Value(t), 0}; }

  /// Bound of its speed between two times; exact where it moves along one axis and not by a load.
  double Fastest(double from, double to) const
  {
    const double x = sideways[0].LargestMagnitude(from, to), y = sideways[1].LargestMagnitude(from, to);
    return std::hypot(IsFree() ? largest_speed : motion.Fastest(from, to), std::hypot(x, y));
  }
  double Depth(Vec3 tip_now) const { return initial_surface - tip_now[up]; }
  /// Half the width of the part below the undeformed surface where the tip is so deep; nothing above it, m.
  double HalfWidth(double depth) const { return depth > 0 ? 0.5 * surface->Width(depth) : 0; }
  SurfaceGap Gap(Vec3 x, Vec3 tip_now) const { return surface->Gap(x - tip_now); }
};

} // namespace mlgimp
