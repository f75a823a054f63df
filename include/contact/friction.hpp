// Coulomb's friction on segments: tractions beside the pressures that were found, a ratio to them for each column.
//
// The traction of a segment is p_s sum_j H_j(x_s) sum_a r_ja t_a, t_a the unit tangents of the indenter's surface beside the
// horizontal axes. The ratios minimise the energy of the slips, r . R r/2 + r . s0, with |r_j| <= mu: a column sticks, or slips
// with r_j = -mu s_j/|s_j|. By projected gradients with momentum, restarted where they go uphill (O'Donoghue and Candes 2015).
#pragma once

#include "contact/segment_problem.hpp"

#include <array>
#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// Unit tangent of the indenter's surface at its normal n beside a horizontal axis: that axis after the smallest turn that brings
/// the upward axis to -n. The tangents beside all horizontal axes are normal to each other and change as smoothly as n does.
Vec3 SurfaceTangent(Vec3 normal, int axis, int up);

class Friction
{
public:
  using Ratio = std::array<double, 2>; ///< along the horizontal axes

  explicit Friction(double coefficient) : coefficient_(coefficient) {}

  /// Begins a step from the ratios of the last one, by the columns' keys.
  void Begin(const BoundaryConditions &sides, int dim, const SegmentProblem &problem,
             const std::unordered_map<std::int64_t, Ratio> &before);
  /// Finds the ratios beside pressures q, with the indenter moving by `way`. Returns the change of the impulses since the last
  /// time, as a share of the pressures' impulse.
  double Solve(const SegmentProblem &problem, const std::vector<double> &q, Vec3 way);

  const std::vector<Ratio> &Ratios() const { return ratios_; } ///< [columns]
  const std::vector<Vec3> &Motion() const { return motion_; }  ///< of nodes by friction, m
  const std::vector<Vec3> &Forces() const { return forces_; }  ///< on nodes, N
  double UpwardForce() const { return upward_force_; }         ///< on the body along the axis, N
  double Heat() const { return heat_; }                        ///< of columns that slip, J

private:
  using Field = std::vector<Ratio>;
  /// Forces on candidates by ratios, or of unit ratios along one axis.
  void SetForces(const SegmentProblem &problem, const Field &ratios);
  /// Slips of columns by motions of candidates, weighted as their tractions are, J.
  Field SlipsOf(const SegmentProblem &problem, const std::vector<Vec3> &motion) const;
  Field Response(const SegmentProblem &problem, const Field &ratios);
  void Project(Ratio *ratio) const;

  double coefficient_;
  int axes_ = 1, up_ = 1;
  std::vector<std::array<Vec3, 2>> tangents_; ///< [candidates]
  std::vector<double> normal_forces_;         ///< w_s p_s, N
  Field ratios_, free_;                       ///< free: 1 along axes that no side holds
  std::vector<Vec3> on_segments_, forces_, motion_;
  double upward_force_ = 0, heat_ = 0;
};

} // namespace mlgimp
