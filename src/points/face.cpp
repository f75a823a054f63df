// Faces of points from their deformation.
#include "points/face.hpp"

namespace mlgimp
{

Face PointFace(const PointArrays &points, int p, Side side)
{
  const int dim = points.dim;
  const int axis = AxisOf(side);
  Vec3 edge[3] = {{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}; // half edges of the deformed point
  Face face;
  for (int b = 0; b < dim; ++b) edge[b] = points.HalfEdge(p, b);
  face.center = points.Position(p) + SignOf(side) * edge[axis];
  face.area_normal = 4.0 * SignOf(side) * Cross(edge[(axis + 1) % 3], edge[(axis + 2) % 3]);
  for (int b = 0, k = 0; b < dim; ++b)
    if (b != axis) face.half_edge[k++] = edge[b];
  return face;
}

} // namespace mlgimp
