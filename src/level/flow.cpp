// Boxes of points that flow has sheared, and points that it has brought to the surface.
#include "level/flow.hpp"

#include "points/face.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

constexpr double kMaxShear = 2; ///< shift of an edge over the height that it leaves to a box

bool Flows(const Model &model, const PointArrays &a, int p)
{
  const Material &material = model.MaterialOf(a.body[p]);
  return material.Traits().flows && material.SplitsStretched();
}

int FacesAcross(const PointArrays &a, int p, int axis)
{
  return a.faces[p] & (OuterFaceBit(static_cast<Side>(2 * axis)) | OuterFaceBit(static_cast<Side>(2 * axis + 1)));
}

/// The axes of a point's box, the longest edge first, that across outer faces last.
std::array<int, 3> OrderOfEdges(const PointArrays &a, int p)
{
  std::array<int, 3> order = {0, 1, 2};
  double length[3];
  for (int axis = 0; axis < a.dim; ++axis) length[axis] = FacesAcross(a, p, axis) ? 0 : Norm(a.HalfEdge(p, axis));
  std::stable_sort(order.begin(), order.begin() + a.dim, [&](int i, int j) { return length[i] > length[j]; });
  return order;
}

/// At an edge of the body, where faces across two axes could not both keep their planes.
bool IsAtEdge(const PointArrays &a, int p)
{
  int count = 0;
  for (int axis = 0; axis < a.dim; ++axis) count += FacesAcross(a, p, axis) != 0;
  return count > 1;
}

/// Shortens an edge of a box that reaches beyond the axis, so that it ends there; the other one grows by as much, but not beyond
/// the axis.
void EndAtAxis(const PointArrays &a, int p)
{
  const double r = a.Position(p)[0], reach[2] = {std::abs(a.HalfEdge(p, 0)[0]), std::abs(a.HalfEdge(p, 1)[0])};
  const int far = reach[1] > reach[0];
  const double shrink = std::max(r / reach[far], reach[1 - far] / r);
  if (!(shrink < 1)) return;
  for (int i = 0; i < a.dim; ++i)
    for (int k = 0; k < a.dim; ++k) a.F[a.dim * (a.dim * p + i) + k] *= k == far ? shrink : 1 / shrink;
}

/// Whether a box may be sheared by more than kMaxShear, which is quick: |F| over the product of the |F e_i| is the sine of the
/// angle between two edges times, in space, that of the third with their plane.
bool MayBeSheared(const PointArrays &a, int p)
{
  const double *const F = a.F + PointArrays::At(p, a.dim * a.dim);
  double lengths2 = 1;
  for (int j = 0; j < a.dim; ++j) {
    double length2 = 0;
    for (int i = 0; i < a.dim; ++i) length2 += F[a.dim * i + j] * F[a.dim * i + j];
    lengths2 *= length2;
  }
  const double volume = Determinant(F, a.dim);
  return volume * volume * (1 + kMaxShear * kMaxShear) < lengths2;
}

/// Makes the edges of a box perpendicular where one is shifted too far, the longest first; volume stays.
void Straighten(const PointArrays &a, int p)
{
  const auto order = OrderOfEdges(a, p);
  Vec3 edge[3];
  bool sheared = false;
  for (int k = 0; k < a.dim; ++k) {
    Vec3 shift{};
    const Vec3 whole = a.HalfEdge(p, order[k]);
    for (int i = 0; i < k; ++i) shift = shift + Dot(whole, edge[i]) / Dot(edge[i], edge[i]) * edge[i];
    edge[k] = whole - shift;
    sheared = sheared || Norm(shift) > kMaxShear * Norm(edge[k]);
  }
  for (int k = 0; sheared && k < a.dim; ++k)
    for (int i = 0; i < a.dim; ++i) a.F[a.dim * (a.dim * p + i) + order[k]] = edge[k][i] / a.HalfSize(p)[order[k]];
}

/// Whether the face of a point on a side lies on that side of the domain, which is not free: the axis, a plane of symmetry.
bool IsHeld(const LevelGeometry &geometry, const PointArrays &a, int p, Side side)
{
  constexpr double kHeldRange = 1.5; // half edges; the next point is 3 away
  if (geometry.sides.kind[side] == BoundaryKind::kFree) return false;
  const int axis = AxisOf(side);
  const double place = geometry.grid.lower[axis] + geometry.sides.node[side] * geometry.grid.spacing;
  return std::abs(a.Position(p)[axis] - place) < kHeldRange * std::abs(a.HalfEdge(p, axis)[axis]);
}

} // namespace

void StraightenBoxes(const Model &model, const PointArrays &a)
{
  for (int p = 0; p < a.count; ++p) {
    if (!Flows(model, a, p) || IsAtEdge(a, p)) continue;
    if (a.initial_radius) EndAtAxis(a, p);
    if (a.faces[p] && MayBeSheared(a, p)) Straighten(a, p);
  }
}

void ExposePoints(const Model &model, const LevelGeometry &geometry, Points &points, Vec3 tip)
{
  const PointArrays a = points.Arrays();
  bool any = false;
  for (int p = 0; p < a.count; ++p) {
    if (a.faces[p] || !Flows(model, a, p)) continue;
    const SurfaceGap gap = model.indenter->Gap(a.Position(p), tip);
    double reach = 0, most = 0;
    for (int axis = 0; axis < a.dim; ++axis) reach = std::max(reach, Norm(a.HalfEdge(p, axis)));
    if (gap.distance >= reach) continue;
    double outermost = gap.distance;
    int bit = 0;
    for (const Side side : SidesOf{a.dim}) {
      if (IsHeld(geometry, a, p, side)) continue;
      const Face face = PointFace(a, p, side);
      const double facing = -Dot(face.area_normal, gap.normal) / Norm(face.area_normal);
      if (facing > most) most = facing, outermost = model.indenter->Gap(face.center, tip).distance, bit = OuterFaceBit(side);
    }
    if (outermost >= 0) continue;
    a.faces[p] = bit;
    any = true;
  }
  if (any) points.RecordSurface();
}

} // namespace mlgimp
