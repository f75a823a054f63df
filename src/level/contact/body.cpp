// Pieces of faces, and impulses on nodes.
#include "level/contact/body.hpp"

#include "level/face.hpp"

namespace mlgimp
{

void AddPointSegments(const PointArrays &points, int p, const Geometry &geometry, std::vector<SurfaceSegment> *segments)
{
  const int dim = geometry.Dim();
  for (int s = 0; s < 2 * dim; ++s) {
    const Side side = static_cast<Side>(s);
    if (!(points.faces[p] & OuterFaceBit(side))) continue;
    const Face face = PointFace(points, p, side, dim);
    const double area = Norm(face.area_normal);
    int count = 1;
    for (int e = 1; e < dim; ++e) count *= kSegmentsPerEdge;
    for (int k = 0; k < count; ++k) {
      Vec3 x = face.center;
      for (int e = 0, place = k; e < dim - 1; ++e, place /= kSegmentsPerEdge)
        x = x + ((2 * (place % kSegmentsPerEdge) + 1.0) / kSegmentsPerEdge - 1) * face.half_edge[e];
      segments->push_back({x, (1 / area) * face.area_normal, area * geometry.OutOfPlane(face.center[0]) / count,
                           Norm(face.half_edge[0]) / kSegmentsPerEdge});
    }
  }
}

bool FarFromIndenter(const ContactView &view, const PointArrays &points, int p)
{
  const double h = view.grid.Geometry().spacing;
  return view.indenter.Gap(PointPosition(points, p, view.geometry.Dim()), view.time + view.dt).distance > kPointRange * h;
}

static std::ptrdiff_t Place(const Grid &grid, Index node) { return grid.Index(node[0], node[1]); }

double NodeMass(const Grid &grid, Index node) { return grid.Arrays().sums[NodeArrays::kSums * Place(grid, node)]; }

Vec3 NodeVelocity(const Grid &grid, Index node)
{
  const double *velocity = grid.Arrays().velocity + NodeArrays::kVelocity * Place(grid, node);
  return {velocity[0], velocity[1]};
}

Vec3 FreePart(const ContactView &view, Index node, Vec3 change)
{
  for (int d = 0; d < view.geometry.Dim(); ++d)
    if (view.sides.Constrains(node[0], node[1], d)) change[d] = 0;
  return change;
}

void PushNode(const ContactView &view, Index node, Vec3 impulse, ContactReport *report)
{
  const double mass = NodeMass(view.grid, node);
  const Vec3 taken = FreePart(view, node, impulse), change = (1 / mass) * taken;
  double *velocity = view.grid.Arrays().velocity + NodeArrays::kVelocity * Place(view.grid, node);
  for (int d = 0; d < 2; ++d) {
    velocity[d] += change[d];
    velocity[2 + d] += change[d];
    report->work += mass * change[d] * (velocity[d] - 0.5 * velocity[2 + d]);
  }
  report->impulse = report->impulse + impulse;
  report->side_impulse = report->side_impulse + taken - impulse;
}

} // namespace mlgimp
