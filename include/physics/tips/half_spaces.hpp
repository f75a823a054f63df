// Indenters that are intersections of half spaces: polygons of plane strain, pyramids of space.
#pragma once

#include "physics/indenter.hpp"

namespace mlgimp
{

/// Of plane strain. Moved so that its lowest vertex (or the middle of its lowest edge) becomes the tip. Vertices either way
/// round.
std::unique_ptr<IndenterSurface> CreatePolygonIndenter(std::vector<Vec3> vertices);
bool IsConvex(const std::vector<Vec3> &vertices);

/// Vertices of a polygon without those that lie, to rounding, on the line between their neighbours.
std::vector<Vec3> CornersOf(const std::vector<Vec3> &vertices);
/// Of space, the tip down: faces at half_angle from the axis, the first with its normal at the angle `turn` from x about
/// the axis, all in degrees. With a tip radius: all within that radius of such a pyramid, so that edges are round as well.
std::unique_ptr<IndenterSurface> CreatePyramid(double half_angle, int faces, double turn, double tip_radius);
/// A pyramid of four like faces over a rhombus, as Knoop's: the angles between its long and its short edges, which are opposite
/// each other, and that of the long diagonal from x about the axis, all in degrees.
std::unique_ptr<IndenterSurface> CreateRhombicPyramid(double long_edges, double short_edges, double turn, double tip_radius);

} // namespace mlgimp
