// The columns of the grid under the surface: where it lies, what it weighs in each, and how pressures act on it.
//
// A column is a line of nodes along the last axis, named by its horizontal node. In the plane columns are in a row, in space in a
// plane. Horizontal indices have zeros from the last axis on.
#pragma once

#include "base/exchange.hpp"
#include "base/handle.hpp"
#include "level/contact/body.hpp"

#include <algorithm>
#include <vector>

namespace mlgimp
{

/// Where a place lies in the grid.
struct CellPlace {
  Index cell;   ///< the first corner of its cell
  Index column; ///< its horizontal part
  Vec3 part;    ///< from 0 to 1 along each axis
};
CellPlace Locate(const Grid &grid, Vec3 x, int dim);

/// A segment that the indenter may press.
struct PressedSegment {
  CellPlace place;
  Vec3 normal;        ///< of the indenter
  double area;        ///< of the body's surface, m2
  double gap;         ///< to the indenter at the end of the step, m
  double left, right; ///< ends along the first axis, m
  double sound = 0;   ///< speed of sound of its material, m/s
  bool flows = false; ///< as metals do, which average their volume
};

/// Corner c of a cell: bit a of c chooses the upper node along axis a.
inline Index Corner(Index cell, int c) { return {cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1)}; }
/// Product over the first `axes` axes of hats about a corner, of half width `width` cells.
inline double CornerHat(Vec3 part, int c, int axes, double width = 1)
{
  double hat = 1;
  for (int a = 0; a < axes; ++a) hat *= std::max(0.0, 1 - (c >> a & 1 ? 1 - part[a] : part[a]) / width);
  return hat;
}
/// Its gradient, 1/m, for cells of a size.
Vec3 CornerHatSlope(Vec3 part, int c, int axes, double spacing, double width);

/// Sums over segments s, with H_j the hat of column j, K_j its kernel of half width alpha h, n the indenter's normal, up
/// component z. Doubles throughout.
struct ContactColumn {
  double kernel_area = 0; ///< k_j = sum_s K_j w_s, m2
  double flowing = 0;     ///< the part of k_j of segments that flow, m2
  double sound = 0;       ///< sum_s K_j w_s c_s, m3/s
  double gap = 0;         ///< sum_s K_j w_s g_s, m3
  double area = 0;        ///< a_j = -sum_s H_j w_s n_z: projected on the plane normal to the axis, m2
  double share[9] = {};   ///< -sum_s K_j H_i w_s n_z, i = j - 1 ... j + 1 along each axis: load on column i for lambda_j = 1, m2
  double left = HUGE_VAL, right = -HUGE_VAL; ///< ends of the surface under H_j along the first axis, not
                                             ///< beyond held sides, m
};

/// How the weighted gap of a column at a corner of its cell changes as a segment moves, m2: w_s (K_j n + g_s grad K_j), in
/// axisymmetry + w_s K_j g_s/r along the radius. Without the terms by the gap, where surface flows past columns, closing gaps
/// would give work that the indenter has not done. Elastic surfaces do not flow, and leave them out, as does a tip that moves
/// sideways: it passes the columns, so that they would push the body without pushing the indenter.
Vec3 GapGradient(const ContactView &view, const PressedSegment &segment, int corner, double width);

/// Unit tangent of the indenter's surface at its normal n beside a horizontal axis: that axis after the smallest turn that brings
/// the upward axis to -n. The tangents beside all horizontal axes are normal to each other and change as smoothly as n does.
Vec3 SurfaceTangent(Vec3 normal, int axis, int up);

/// The columns under all segments within reach of the indenter, the same on all ranks of the group.
class ContactColumns
{
public:
  ContactColumns() = default;
  ContactColumns(const ContactColumns &) = delete;
  ContactColumns &operator=(const ContactColumns &) = delete;
  ~ContactColumns();

  /// Sums up the columns of the segments of all ranks. width: alpha; least_gap: of this rank's segments, then of all, m; pattern:
  /// to which ranks this one sends, then who sends to whom; at_border: segments of this rank, then of any, lie in cells whose
  /// nodes hang on those of the coarser level. Collective on the group.
  PetscErrorCode Sum(const ContactView &view, double width, const std::vector<PressedSegment> &segments, double *least_gap,
                     SendPattern *pattern, bool *at_border);

  const IndexBox &Box() const { return box_; } ///< of the columns; empty where nothing is near
  int Place(Index column) const { return (column[1] - box_.lower[1]) * box_.Size(0) + column[0] - box_.lower[0]; }
  const ContactColumn &At(Index column) const { return columns_[Place(column)]; }

  /// The pressures p_i = (load on column i)/a_i, Pa; lambda, Pa. Both [columns].
  std::vector<double> Pressures(const std::vector<double> &lambda) const;

private:
  PetscErrorCode FindBox(const ContactView &view, const std::vector<PressedSegment> &segments);
  void Crop();
  void Add(const ContactView &view, double width, const PressedSegment &segment);

  IndexBox box_;
  std::vector<ContactColumn> columns_;
  UnitHandle column_unit_;
  MPI_Op add_ = MPI_OP_NULL;
};

/// k_j of a column whose surface is level and complete: it ends at the sides of the domain, m2.
double FullKernelArea(const ContactView &view, double width, Index column);

/// Whether a column presses nodes that have no motion of their own, at the border to the coarser level or beyond.
bool CrossesBorder(const ContactView &view, Index column);

} // namespace mlgimp
