// What keeps points of metals in shape where these flow far: boxes that shear draws out, and points that come to the surface.
#pragma once

#include "level/level_geometry.hpp"
#include "level/model.hpp"
#include "points/points.hpp"

namespace mlgimp
{

/// Takes the shear out of boxes with outer faces of metals that split (`SplitsStretched`) where it is more than kMaxShear: of
/// the edges of such a box, each becomes its part normal to those before it, the longest first, those across outer faces last.
/// Boxes keep their volumes, and faces their planes and areas: they are shifted along themselves. Of F a metal's stress takes det
/// F alone. Points at an edge of the body stay, and those within it. In axisymmetry edges end at the axis, and volumes stay: by
/// the velocity's slope at its centre a box beside the axis grows across it, without a place for its children, and contact would
/// take it for surface far away.
void StraightenBoxes(const Model &model, const PointArrays &points);

/// Gives points of such metals an outer face, that which faces the indenter most, where its centre comes into the indenter: flow
/// mixes the rows of points next to the surface, and those without a face would go through it. Were the point's own centre waited
/// for, its face would lie deep in the indenter at once, and contact would drive it out in one step. Faces at the axis, on planes
/// of symmetry and on held sides are none of the surface. tip: the indenter's, m.
void ExposePoints(const Model &model, const LevelGeometry &geometry, Points &points, Vec3 tip);

} // namespace mlgimp
