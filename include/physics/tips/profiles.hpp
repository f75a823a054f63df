// Indenters that are the same all round their axis, by closed formulas: cones, balls, flat punches.
#pragma once

#include "physics/indenter.hpp"

namespace mlgimp
{

/// A cone or wedge with half_angle, in degrees from the axis. With a tip radius R it ends in a ball (a cylinder) that the flanks
/// are tangent to, the conosphere of catalogues: they meet at the height R (1 - sin a), and a sharp cone with the same flanks
/// reaches R (1/sin a - 1) deeper.
std::unique_ptr<IndenterSurface> CreateCone(GeometryKind geometry, double half_angle, double tip_radius);
std::unique_ptr<IndenterSurface> CreateSphere(GeometryKind geometry, double radius);
/// radius: half its width in plane strain; its edge is round with a radius of its own, at most that.
std::unique_ptr<IndenterSurface> CreateFlatPunch(GeometryKind geometry, double radius, double edge_radius);

/// Distance from the axis, at a height above its end, of a flank at an angle (radian) from the axis that is tangent to a ball of
/// some radius at the end: below the height radius (1 - sine) of the ball.
double RoundedRadius(double height, double half_angle, double radius);

} // namespace mlgimp
