// What contact makes of faces: their segments, and the columns of the grid under them.
#include "points/face.hpp"
#include "surface/pieces.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace mlgimp;

namespace
{

constexpr double kH = 0.25; // m

RandomNumbers Random(20240607);

constexpr GeometryKind kKinds[] = {GeometryKind::kPlaneStrain, GeometryKind::kAxisymmetric, GeometryKind::kSpatial};

/// One point somewhere off the axis, with all faces outer ones.
struct OnePoint {
  double position[3], half_size[3], F[9];
  int faces = 63;
  PointArrays arrays{};

  explicit OnePoint(int dim)
  {
    for (int a = 0; a < dim; ++a) position[a] = Random(4 * kH, 12 * kH), half_size[a] = kH * Random(0.05, 0.4);
    for (int c = 0; c < dim * dim; ++c) F[c] = (c % (dim + 1) == 0) + Random(-0.2, 0.2);
    arrays.count = 1;
    arrays.dim = dim;
    arrays.position = position;
    arrays.half_size = half_size;
    arrays.F = F;
    arrays.faces = &faces;
  }
};

} // namespace

/// In three dimensions faces enclose the point, too.
TEST(ContactSurface, FacesEncloseThePointInSpace)
{
  for (int n = 0; n < 20; ++n) {
    OnePoint point(3);
    const double *F = point.F, *l = point.half_size;
    const double J = F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
    Vec3 sum{};
    double volume = 0;
    for (int s = 0; s < 6; ++s) {
      const Face face = PointFace(point.arrays, 0, static_cast<Side>(s));
      for (const Vec3 &edge : face.half_edge) EXPECT_NEAR(Dot(face.area_normal, edge), 0, 1e-16);
      sum = sum + face.area_normal;
      volume += Dot(face.area_normal, face.center - point.arrays.Position(0)) / 3;
    }
    EXPECT_LE(Norm(sum), 1e-16);
    EXPECT_NEAR(volume, 8 * J * l[0] * l[1] * l[2], 1e-16);
  }
}

/// Segments of a face add up to its area, with the radius of its centre, and lie about it, however long they may be.
TEST(ContactSurface, SegmentsAreTheFaces)
{
  for (GeometryKind kind : kKinds)
    for (int n = 0; n < 20; ++n) {
      const double longest = n % 2 ? 0.3 * kH : 0;
      const Geometry geometry = {kind, 0.7};
      const int dim = geometry.Dim();
      OnePoint point(dim);
      std::vector<SurfaceSegment> segments;
      ForEachSegment(point.arrays, 0, geometry, longest, [&](const SurfaceSegment &segment) { segments.push_back(segment); });
      std::size_t k = 0;
      for (int s = 0; s < 2 * dim; ++s) {
        const Face face = PointFace(point.arrays, 0, static_cast<Side>(s));
        std::size_t each = 1;
        for (int e = 0; e < dim - 1; ++e) {
          const double length = 2 * Norm(face.half_edge[e]);
          each *= longest == 0 ? 4 : length <= longest ? 1 : length <= 2 * longest ? 2 : length <= 3 * longest ? 3 : 4;
        }
        ASSERT_LE(k + each, segments.size());
        double area = 0;
        Vec3 moment{};
        for (const std::size_t end = k + each; k < end; ++k) {
          area += segments[k].area;
          moment = moment + segments[k].area * (segments[k].x - face.center);
          EXPECT_NEAR(Dot(segments[k].normal, face.area_normal), Norm(face.area_normal), 1e-15);
        }
        const double r = face.center[0], out_of_plane = dim == 3 ? 1 : kind == GeometryKind::kPlaneStrain ? 0.7 : 2 * M_PI * r;
        EXPECT_NEAR(area, Norm(face.area_normal) * out_of_plane, 1e-14);
        EXPECT_LE(Norm(moment), 1e-15);
      }
      EXPECT_EQ(k, segments.size());
    }
}
