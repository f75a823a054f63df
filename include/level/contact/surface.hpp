// The surface that the indenter may press: its segments, and what they add up to in the cells of the grid.
//
// A column is a line of nodes along the last axis, named by its horizontal node. In the plane columns are in a row, in space in a
// plane. Horizontal indices have zeros from the last axis on.
#pragma once

#include "level/contact/body.hpp"

#include <algorithm>
#include <array>
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
/// Hats of half width `width` cells about the columns at the corners of a cell, in the plane the first two.
inline std::array<double, 4> ColumnHats(Vec3 part, int dim, double width = 1)
{
  const auto hat = [width](double from) { return std::max(0.0, 1 - from / width); };
  const double lower = dim == 3 ? hat(part[1]) : 1, upper = dim == 3 ? hat(1 - part[1]) : 0;
  return {hat(part[0]) * lower, hat(1 - part[0]) * lower, hat(part[0]) * upper, hat(1 - part[0]) * upper};
}

/// Unit tangent of the indenter's surface at its normal n beside a horizontal axis: that axis after the smallest turn that brings
/// the upward axis to -n. The tangents beside all horizontal axes are normal to each other and change as smoothly as n does.
Vec3 SurfaceTangent(Vec3 normal, int axis, int up);

/// Whether the tip moves along the surface in the step.
bool MovesSideways(const ContactView &view);

/// The segments of this rank, added up.
class PressedSurface
{
public:
  /// The segments in a cell: what they are to the columns at its corners, see ContactColumn.
  struct Cell {
    Index cell, column;
    double kernel_area[4] = {}, flowing[4] = {}, sound[4] = {}, gap[4] = {}, area[4] = {};
    double share[4][4] = {};                   ///< of the load by each of the columns on each
    double left = HUGE_VAL, right = -HUGE_VAL; ///< ends of the segments along the first axis, m
  };
  /// The segments of a point in a cell.
  struct PointPart {
    int point;
    std::size_t cell;
    double area[4];       ///< sum_s H_j w_s of the columns at the corners, m2
    bool under_kernel[4]; ///< some K_j is not zero
  };

  /// Starts with no segments.
  void Clear(const ContactView &view, const ContactSettings &settings);
  /// Adds a segment of a point. Not in cells that this rank has not all corners of, or that are not in the group's zone: it is of
  /// a point that has failed, which ends the run soon.
  void Add(const ContactView &view, int point, const PressedSegment &segment);

  const std::vector<Cell> &Cells() const { return cells_; }
  const std::vector<PointPart> &PointParts() const { return parts_; } ///< those of a point stand together
  /// B of unknown u, the pressure or a traction, of the column at corner c of a cell with the node at corner k, m2.
  Vec3 Coupling(std::size_t cell, int c, int u, int k) const
  {
    const NodeCouplings &with = couplings_[(4 * cell + c) * per_column_ + u];
    return {with.B[0][k], with.B[1][k], with.B[2][k]};
  }

private:
  /// Of one unknown with the corners of a cell: by axis and corner, m2.
  struct alignas(64) NodeCouplings {
    double B[3][8] = {};
  };

  std::size_t FindCell(const CellPlace &place);

  double width_ = 1;
  int per_column_ = 1;
  IndexBox here_;              ///< cells that segments may be in
  std::vector<int> cell_here_; ///< where each of them is among cells_, or -1
  std::vector<Cell> cells_;
  std::vector<NodeCouplings> couplings_; ///< [cells][4 columns][unknowns]
  std::vector<PointPart> parts_;
};

} // namespace mlgimp
