// Consistent nodal forces of pressures on faces.
#include "level/loads.hpp"

#include "grid/nodes.hpp"

#include <algorithm>

namespace mlgimp
{

/// Weights of a face on the three nodes around its centre along one axis.
static AxisWeights<double> FaceWeights(double d, double l)
{
  return l < kMinHalfSize ? Linear::Evaluate(d, l) : UniformGimp::Evaluate(d, std::min(l, kMaxHalfSize));
}

/// Calls work(place, weight) for the nodes around a face.
template <class Work> static void ForEachNodeOf(const Grid &grid, const FaceForce &face, Work work)
{
  const bool spatial = grid.Geometry().dim == 3;
  ForEach({{0, 0, 0}, {3, 3, spatial ? 3 : 1}}, [&](Index k) {
    const double weight = face.at[0].w[k[0]] * face.at[1].w[k[1]] * (spatial ? face.at[2].w[k[2]] : 1);
    work(grid.Place(face.nearest + k - Index{1, 1, spatial ? 1 : 0}), weight);
  });
}

/// False where the face has left the nodes that this rank holds.
static bool PlaceFace(const Grid &grid, const Face &face, FaceForce *placed)
{
  const IndexBox &local = grid.Ghosted();
  placed->nearest = grid.Geometry().Nearest(face.center);
  for (int axis = 0; axis < grid.Geometry().dim; ++axis) {
    const double inverse_h = grid.IndexSpace().inverse_spacing;
    const int nearest = placed->nearest[axis];
    if (nearest <= local.lower[axis] || nearest >= local.upper[axis] - 1) return false;
    const double d = (face.center[axis] - grid.Geometry().Coordinate(axis, nearest)) * inverse_h;
    double extent = 0;
    for (const Vec3 &half_edge : face.half_edge) extent += std::abs(half_edge[axis]);
    placed->at[axis] = FaceWeights(d, extent * inverse_h);
  }
  return true;
}

void AddLoads(const Grid &grid, Points &points, bool owned, const std::vector<Load> &loads, const Geometry &geometry, double time,
              std::vector<FaceForce> &applied, PointFailure &failure)
{
  const int dim = grid.Geometry().dim;
  std::vector<double> pressure;
  if (loads.empty()) return;
  for (const Load &load : loads) pressure.push_back(load.pressure.Value(time));
  const PointArrays arrays = points.Arrays();
  const std::vector<int> &surface = points.SurfacePoints();
  for (int p : surface)
    for (int k = 0; k < arrays.loads; ++k) {
      const double share = arrays.load_share[PointArrays::At(p, arrays.loads) + k];
      if (share == 0) continue;
      const Face face = PointFace(arrays, p, loads[k].side);
      FaceForce placed{};
      placed.force = -pressure[k] * share * geometry.OutOfPlane(face.center[0]) * face.area_normal;
      if (!PlaceFace(grid, face, &placed)) {
        if (failure.kind == PointFailure::kNone) failure = {PointFailure::kLeftGrid, arrays.id[p], face.center};
        continue;
      }
      ForEachNodeOf(grid, placed, [&](std::ptrdiff_t place, double weight) {
        for (int axis = 0; axis < dim; ++axis) grid.Sums()[place].force[axis] += weight * placed.force[axis];
      });
      if (owned) applied.push_back(placed);
    }
}

void AddLoadImpulse(const Grid &grid, const std::vector<FaceForce> &applied, double mass_cutoff, double dt, Budgets &budgets)
{
  for (const FaceForce &face : applied)
    ForEachNodeOf(grid, face, [&](std::ptrdiff_t place, double weight) {
      if (grid.Sums()[place].mass <= mass_cutoff) return;
      for (int axis = 0; axis < grid.Geometry().dim; ++axis) budgets.load_impulse[axis] += dt * weight * face.force[axis];
    });
}

std::vector<double> MeanMotion(const Grid &grid, double mass_cutoff, bool spread)
{
  const int dim = grid.Geometry().dim;
  std::vector<double> motion(dim * grid.Ghosted().Count());
  ForEach(grid.Ghosted(), [&](Index at) {
    const std::ptrdiff_t place = grid.Place(at);
    const NodeSums &node = grid.Sums()[place];
    if (node.mass <= mass_cutoff) return;
    const Vec3 after = MomentumAfter(grid, place, spread);
    for (int axis = 0; axis < dim; ++axis) motion[dim * place + axis] = 0.5 / node.mass * (node.momentum[axis] + after[axis]);
  });
  return motion;
}

void AddLoadWork(const Grid &grid, const std::vector<FaceForce> &applied, const std::vector<double> &motion, double dt,
                 Budgets &budgets)
{
  const int dim = grid.Geometry().dim;
  for (const FaceForce &face : applied)
    ForEachNodeOf(grid, face, [&](std::ptrdiff_t place, double weight) {
      for (int axis = 0; axis < dim; ++axis) budgets.external_work += dt * weight * face.force[axis] * motion[dim * place + axis];
    });
}

} // namespace mlgimp
