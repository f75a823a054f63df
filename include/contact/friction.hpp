// Coulomb's friction on segments: a traction on each beside the pressure that was found.
//
//   |t_s| <= mu p_s,   slip_s = 0 (stick)   or   t_s = -mu p_s slip_s/|slip_s|
//   slip_s = dt (v(x_s) - V) + c ((t - Pi t)_s - (t0 - Pi t0)_s)     along the tangents, t0 of the last step
//
// As to pressures, the body yields to tractions between the nodes. Tractions minimise the energy of the slips, by projected
// gradients with momentum, restarted where they go uphill (O'Donoghue and Candes 2015).
#pragma once

#include "contact/segment_problem.hpp"

#include <array>
#include <vector>

namespace mlgimp
{

/// Unit tangent of the indenter's surface at its normal n beside a horizontal axis: that axis after the smallest turn that brings
/// the upward axis to -n. The tangents beside all horizontal axes are normal to each other and change as smoothly as n does.
Vec3 SurfaceTangent(Vec3 normal, int axis, int up);

class Friction
{
public:
  using Along = std::array<double, 2>; ///< the tangents

  explicit Friction(double coefficient) : coefficient_(coefficient) {}

  /// Begins a step from the tractions of the last one.
  void Begin(const BoundaryConditions &sides, int dim, const SegmentProblem &problem);
  /// Finds the tractions beside pressures q, with the indenter moving by `way`. Returns the change of the impulses since the last
  /// time, as a share of the pressures' impulse.
  double Solve(const SegmentProblem &problem, const std::vector<double> &q, Vec3 way);

  Along Traction(const SegmentProblem &problem, int k) const; ///< of a candidate, Pa
  const std::vector<Vec3> &Motion() const { return motion_; } ///< of nodes by friction, m
  const std::vector<Vec3> &Forces() const { return forces_; } ///< on nodes, N
  double UpwardForce() const { return upward_force_; }        ///< on the body along the axis, N
  double Heat() const { return heat_; }                       ///< of what slips, J
  double Stored() const { return stored_; }                   ///< in what yields between the nodes, J

private:
  using Field = std::vector<Along>; ///< [candidates]: tractions times the roots of areas, or slips times these
  /// The slips that tractions cause; leaves the forces on nodes, what these move, and what yields between them.
  Field Response(const SegmentProblem &problem, const Field &tractions);
  void Yield(const SegmentProblem &problem, const Field &tractions, Field *yields) const;
  Field SlipsOf(const SegmentProblem &problem, const std::vector<Vec3> &motion) const;
  std::vector<double> Bounds(const SegmentProblem &problem, const std::vector<double> &q);
  double MostOf(double q) const { return q > 0 ? coefficient_ * q : 0; }
  void SumUp(const SegmentProblem &problem, const std::vector<double> &q, const Field &free_slips);

  double coefficient_;
  int axes_ = 1, up_ = 1;
  std::array<std::vector<char>, 2> held_;     ///< [columns]: across an axis by a side
  std::vector<std::array<Vec3, 2>> tangents_; ///< [candidates]
  Field tractions_, yields_, yields_before_;
  std::vector<Vec3> forces_, motion_;
  double upward_force_ = 0, heat_ = 0, stored_ = 0;
};

} // namespace mlgimp
