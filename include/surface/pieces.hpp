// Pieces of the surface: of a point's faces, or of a patch.
#pragma once

#include "base/index.hpp"
#include "physics/body_table.hpp"
#include "points/face.hpp"
#include "surface/surface.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// Nearness to the indenter, in cells, from which on surface segments take part in the contact problem.
inline constexpr double kContactRange = 2.5;
/// Distance of a point's centre from the indenter, in cells, beyond which its faces take no part.
inline constexpr double kPointRange = kContactRange + 1.5;
/// Gap of a segment, in cells, beyond which it cannot touch in a step.
inline constexpr double kCandidateGap = 0.5;
/// Cosine of the angle between the indenter's normal and that into the body, from which on the indenter presses on a face.
inline constexpr double kMinFacing = 0.1;

/// The surface of the bodies beside the indenter, and the grid whose nodes move it.
struct SurfaceInputs {
  const Grid &grid;
  const Geometry &geometry;
  const Surface &patches;
  Points &points;
  const BodyTable &bodies;
  const Indenter &indenter;
};

/// A piece of the surface.
struct SurfaceSegment {
  Vec3 x, normal;    ///< place, m; outward normal
  double area;       ///< of the body's surface: out of the plane times thickness or circumference at the face's centre, m2
  double half_width; ///< half its length in the plane, m
};

inline constexpr int kMaxParts = 4; ///< size: of an edge of a face
/// Calls work(segment) for those of all outer faces of a point: midpoints of parts along each edge, of which there are so many
/// that none is longer than `longest`, m, but at most kMaxParts.
template <class Work> void ForEachSegment(const PointArrays &points, int p, const Geometry &geometry, double longest, Work work)
{
  const auto parts = [longest](Vec3 half_edge) {
    return static_cast<int>(std::clamp<double>(std::ceil(2 * Norm(half_edge) / longest), 1, kMaxParts));
  };
  const auto along = [](int k, int count) { return (2 * k + 1.0) / count - 1; }; // the half edge
  for (const Side side : SidesOf{geometry.Dim()}) {
    if (!(points.faces[p] & OuterFaceBit(side))) continue;
    const Face face = PointFace(points, p, side);
    const int columns = parts(face.half_edge[0]), rows = geometry.Dim() == 3 ? parts(face.half_edge[1]) : 1;
    const double area = Norm(face.area_normal), part = area * geometry.OutOfPlane(face.center[0]) / (rows * columns);
    const Vec3 normal = (1 / area) * face.area_normal;
    for (int j = 0; j < rows; ++j) {
      const Vec3 row = face.center + along(j, rows) * face.half_edge[1];
      for (int i = 0; i < columns; ++i)
        work(SurfaceSegment{row + along(i, columns) * face.half_edge[0], normal, part, Norm(face.half_edge[0]) / columns});
    }
  }
}

/// The surface of a patch, taken at a place along its edges, from 0 to 1 each.
SurfaceSegment SegmentOf(const SurfacePatch &patch, double s, double t, const Geometry &geometry);

/// True where a segment faces the indenter, so that it can be pressed by it.
inline bool Faces(const SurfaceSegment &segment, Vec3 indenter_normal)
{
  return Dot(segment.normal, indenter_normal) < -kMinFacing;
}

/// True where a point or a patch is far enough from the indenter with its tip there to be left out without looking at its faces.
bool FarFromIndenter(const SurfaceInputs &surface, Vec3 tip, Vec3 x);

} // namespace mlgimp
