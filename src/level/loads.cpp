// Consistent nodal forces of pressures on faces.
#include "level/loads.hpp"

#include <algorithm>

namespace mlgimp
{

/// Weights of a face on the three nodes around its centre along one axis.
static AxisWeights FaceWeights(double d, double l)
{
  return l < kMinHalfSize ? Linear::Evaluate(d, l) : UniformGimp::Evaluate(d, std::min(l, kMaxHalfSize));
}

/// False where the face has left the nodes that this rank holds.
static bool AddFaceForce(const Grid &grid, bool owned, const Face &face, Vec3 force)
{
  AxisWeights at[2];
  int nearest[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double inverse_h = grid.IndexSpace().inverse_spacing;
    const int first = grid.GhostLower(axis) + 1, last = grid.GhostLower(axis) + grid.GhostSize(axis) - 2;
    nearest[axis] = grid.Nearest(axis, face.center[axis]);
    if (nearest[axis] < first || nearest[axis] > last) return false;
    const double d = (face.center[axis] - grid.Coordinate(axis, nearest[axis])) * inverse_h;
    at[axis] = FaceWeights(d, std::abs(face.half_edge[0][axis]) * inverse_h);
  }
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const int index = grid.Index(nearest[0] + i - 1, nearest[1] + j - 1);
      double *sums = grid.Arrays().sums + NodeArrays::kSums * static_cast<std::ptrdiff_t>(index);
      for (int axis = 0; axis < 2; ++axis) {
        const double part = at[0].w[i] * at[1].w[j] * force[axis];
        sums[4 + axis] += part;
        if (owned) sums[6 + axis] += part;
      }
    }
  return true;
}

PetscErrorCode AddLoads(const Grid &grid, Points &points, bool owned, const std::vector<Load> &loads, double thickness,
                        double time, PointFailure &failure)
{
  const std::vector<int> *surface = nullptr;
  PointArrays arrays;
  std::vector<double> pressure;
  PetscFunctionBeginUser;
  if (loads.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Load &load : loads) pressure.push_back(load.pressure.Value(time));
  PetscCall(points.Arrays(&arrays));
  PetscCall(points.SurfacePoints(&surface));
  for (int p : *surface)
    for (std::size_t k = 0; k < loads.size(); ++k) {
      const double share = arrays.load_share[loads.size() * p + k];
      if (share == 0) continue;
      const Face face = PointFace(arrays, p, loads[k].side, 2);
      if (AddFaceForce(grid, owned, face, -pressure[k] * share * thickness * face.area_normal)) continue;
      if (failure.kind == PointFailure::kNone) failure = {PointFailure::kLeftGrid, arrays.id[p], face.center};
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
