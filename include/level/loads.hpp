// Pressure on the sides of bodies: it acts on the current faces of the points and follows them.
#pragma once

#include "level/face.hpp"
#include "level/grid.hpp"
#include "level/kernels.hpp"
#include "level/points.hpp"
#include "pointwise/indenter.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// A pressure history on one side of a body.
struct Load {
  int body;
  Side side;
  double span[2];           ///< start and end along the side, m
  PiecewiseLinear pressure; ///< positive pushes into the body, Pa
};

/// Adds the forces of the loads at `time` to the nodal forces and to the external forces in `sums`.
/// Loads on copies of another level's points (not `owned`) are no external forces here.
/// f_i = -p n int_face N_i ds: the hat function across the face and its mean along the face (paper's Eq. 10).
/// failure: a point whose face has left this rank's nodes.
PetscErrorCode AddLoads(const Grid &grid, Points &points, bool owned, const std::vector<Load> &loads, double thickness,
                        double time, PointFailure &failure);

} // namespace mlgimp
