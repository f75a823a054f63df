// The columns of the grid under the surface: what it weighs in each, on all ranks together.
#pragma once

#include "base/exchange.hpp"
#include "base/handle.hpp"
#include "level/contact/surface.hpp"

#include <vector>

namespace mlgimp
{

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

/// The columns under all segments within reach of the indenter, the same on all ranks of the group.
class ContactColumns
{
public:
  ContactColumns() = default;
  ContactColumns(const ContactColumns &) = delete;
  ContactColumns &operator=(const ContactColumns &) = delete;
  ~ContactColumns();

  /// Sums up the columns of the surface of all ranks. least_gap: of this rank's segments, then of all, m; pattern: to which ranks
  /// this one sends, then who sends to whom; at_border: segments of this rank, then of any, lie in cells whose nodes hang on
  /// those of the coarser level. Collective on the group.
  PetscErrorCode Sum(const ContactView &view, const PressedSurface &surface, double *least_gap, SendPattern *pattern,
                     bool *at_border);

  const IndexBox &Box() const { return box_; } ///< of the columns; empty where nothing is near
  std::int64_t Place(Index column) const { return box_.Place(column); }
  const ContactColumn &At(Index column) const { return columns_[Place(column)]; }

  /// The pressures p_i = (load on column i)/a_i, Pa; lambda, Pa. Both [columns].
  std::vector<double> Pressures(const std::vector<double> &lambda) const;

private:
  PetscErrorCode FindBox(const ContactView &view, const PressedSurface &surface);
  void Add(const ContactView &view, const PressedSurface::Cell &cell, int c);
  void Crop();

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
