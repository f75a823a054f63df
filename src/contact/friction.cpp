// The ratios of tractions to pressures.
#include "contact/friction.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace mlgimp
{

Vec3 SurfaceTangent(Vec3 normal, int axis, int up)
{
  constexpr double kOpposite = 1e-12; // of a normal that points up there is no smallest turn; an indenter's tip has none
  Vec3 tangent{}, middle = -1 * normal;
  const double turned = -normal[axis] / std::max(1 - normal[up], kOpposite);
  middle[up] += 1;
  tangent[axis] = 1;
  return tangent - turned * middle;
}

void Friction::Begin(const BoundaryConditions &sides, int dim, const SegmentProblem &problem,
                     const std::unordered_map<std::int64_t, Ratio> &before)
{
  up_ = dim - 1, axes_ = up_;
  tangents_.resize(problem.Size());
  for (int k = 0; k < problem.Size(); ++k)
    for (int a = 0; a < axes_; ++a)
      tangents_[k][a] = SurfaceTangent((1 / Norm(problem.NormalOf(k))) * problem.NormalOf(k), a, up_);
  const std::vector<SurfaceColumn> &columns = problem.Columns();
  ratios_.assign(columns.size(), {}), free_.assign(columns.size(), {1, axes_ > 1 ? 1.0 : 0.0});
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (int a = 0; a < axes_; ++a)
      for (const Side side : SidesAcross(a)) // tractions of both its sides are opposite
        if (sides.kind[side] != BoundaryKind::kFree && sides.Reaches(side, columns[j].at)) free_[j][a] = 0;
    if (const auto found = before.find(columns[j].key); found != before.end())
      for (int a = 0; a < axes_; ++a) ratios_[j][a] = free_[j][a] * found->second[a];
  }
  motion_.assign(problem.Nodes().Size(), {}), forces_ = motion_;
  upward_force_ = heat_ = 0;
}

void Friction::SetForces(const SegmentProblem &problem, const Field &ratios)
{
  on_segments_.assign(tangents_.size(), {});
  for (int k = 0; k < problem.Size(); ++k) {
    if (normal_forces_[k] == 0) continue;
    for (int c = 0; c < problem.ColumnsOfEach(); ++c)
      for (int a = 0; a < axes_; ++a)
        on_segments_[k] =
            on_segments_[k] + (normal_forces_[k] * problem.HatOf(k, c) * ratios[problem.ColumnOf(k, c)][a]) * tangents_[k][a];
  }
}

Friction::Field Friction::SlipsOf(const SegmentProblem &problem, const std::vector<Vec3> &motion) const
{
  Field slips(ratios_.size());
  for (int k = 0; k < problem.Size(); ++k) {
    if (normal_forces_[k] == 0) continue;
    for (int a = 0; a < axes_; ++a) {
      const double along = normal_forces_[k] * Dot(tangents_[k][a], motion[k]);
      for (int c = 0; c < problem.ColumnsOfEach(); ++c) slips[problem.ColumnOf(k, c)][a] += problem.HatOf(k, c) * along;
    }
  }
  return slips;
}

/// R r: the slips that ratios cause; leaves forces on nodes and what these move.
Friction::Field Friction::Response(const SegmentProblem &problem, const Field &ratios)
{
  SetForces(problem, ratios);
  problem.Spread(on_segments_, &forces_);
  motion_ = forces_;
  problem.Move(&motion_);
  return SlipsOf(problem, problem.MotionOf(motion_));
}

void Friction::Project(Ratio *ratio) const
{
  const double size = std::hypot((*ratio)[0], (*ratio)[1]);
  if (size > coefficient_)
    for (double &one : *ratio) one *= coefficient_ / size;
}

double Friction::Solve(const SegmentProblem &problem, const std::vector<double> &q, Vec3 way)
{
  constexpr int kMost = 1000;
  constexpr double kStop = 1e-10, kAcross = 1.1; // of the ratios' size; tangents along two axes are coupled a little
  const std::size_t columns = ratios_.size();
  const std::vector<Vec3> forces_before = forces_;
  normal_forces_.resize(problem.Size());
  double pressed = 0;
  for (int k = 0; k < problem.Size(); ++k) normal_forces_[k] = problem.ForceOf(k, q), pressed += normal_forces_[k];
  // What slips without friction.
  std::vector<Vec3> by_pressures(problem.Size()), nodes;
  for (int k = 0; k < problem.Size(); ++k) by_pressures[k] = normal_forces_[k] * problem.NormalOf(k);
  problem.Spread(by_pressures, &nodes);
  problem.Move(&nodes);
  std::vector<Vec3> motion = problem.MotionOf(nodes);
  const std::vector<Vec3> before = problem.MotionBefore();
  for (int k = 0; k < problem.Size(); ++k) motion[k] = motion[k] + before[k] - way;
  const Field free_slips = SlipsOf(problem, motion);
  // Row sums bound the response of a column, as all weights are positive.
  Field ones(columns, {1, 0}), ratios = ratios_, ahead = ratios_;
  const Field sums = Response(problem, ones);
  double most = 0, theta = 1;
  std::vector<double> diagonal(columns);
  for (std::size_t j = 0; j < columns; ++j) most = std::max(most, sums[j][0]);
  for (std::size_t j = 0; j < columns; ++j)
    diagonal[j] = std::max({sums[j][0], 1e-9 * most, DBL_MIN}) * (axes_ > 1 ? kAcross : 1);
  for (int iteration = 0; iteration < kMost; ++iteration) {
    const Field slips = Response(problem, ahead), last = ratios;
    double uphill = 0, moves = 0, size = 0;
    for (std::size_t j = 0; j < columns; ++j) {
      for (int a = 0; a < axes_; ++a) ratios[j][a] = free_[j][a] * (ahead[j][a] - (slips[j][a] + free_slips[j][a]) / diagonal[j]);
      Project(&ratios[j]);
      for (int a = 0; a < axes_; ++a) {
        const double change = ratios[j][a] - last[j][a];
        uphill += diagonal[j] * (ahead[j][a] - ratios[j][a]) * change;
        moves += diagonal[j] * change * change, size += diagonal[j] * ratios[j][a] * ratios[j][a];
      }
    }
    const double next = uphill > 0 ? 1 : 0.5 * (1 + std::sqrt(1 + 4 * theta * theta)), part = uphill > 0 ? 0 : (theta - 1) / next;
    theta = next;
    for (std::size_t j = 0; j < columns; ++j)
      for (int a = 0; a < axes_; ++a) ahead[j][a] = ratios[j][a] + part * (ratios[j][a] - last[j][a]);
    if (moves <= kStop * kStop * size) break;
  }
  ratios_ = ratios;
  const Field slips = Response(problem, ratios_);
  heat_ = upward_force_ = 0;
  for (std::size_t j = 0; j < columns; ++j) {
    double heat = 0;
    for (int a = 0; a < axes_; ++a) heat -= ratios_[j][a] * (slips[j][a] + free_slips[j][a]);
    if (std::hypot(ratios_[j][0], ratios_[j][1]) > coefficient_ * (1 - 1e-9)) heat_ += std::max(0.0, heat);
  }
  for (const Vec3 &force : on_segments_) upward_force_ += force[up_];
  double change = 0;
  for (std::size_t i = 0; i < forces_.size(); ++i) change += Norm(forces_[i] - forces_before[i]);
  return change / std::max(pressed, DBL_MIN);
}

} // namespace mlgimp
