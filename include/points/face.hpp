// The faces of a point in the current configuration, on which loads and contact act.
#pragma once

#include "base/tensor.hpp"
#include "physics/point_fields.hpp"

namespace mlgimp
{

/// One face of a point: an edge in two dimensions, a parallelogram in three.
struct Face {
  Vec3 center;                     ///< m
  std::array<Vec3, 2> half_edge{}; ///< from the centre to the middle of a side of the face; the first dim - 1 are used, m
  Vec3 area_normal;                ///< outward normal times area, in two dimensions times length, m^(dim - 1)
};

/// The face of point p on `side`: centre x + F (+-l0_a e_a), half edges F (l0_b e_b), and with c the third axis
/// area normal +-4 F (l0_b e_b) x F (l0_c e_c), which is +-4 l0_b l0_c cof(F) e_a; in two dimensions 2 l0_c = 1 and e_c stays.
Face PointFace(const PointArrays &points, int p, Side side);

} // namespace mlgimp
