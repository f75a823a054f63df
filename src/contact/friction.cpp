// The tractions of segments.
#include "contact/friction.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace mlgimp
{

Vec3 SurfaceTangent(Vec3 normal, int axis, int up)
{
  constexpr double kOpposite =
      1e-12; // rounding: of a normal that points up there is no smallest turn; an indenter's tip has none
  Vec3 tangent{}, middle = -1 * normal;
  const double turned = -normal[axis] / std::max(1 - normal[up], kOpposite);
  middle[up] += 1;
  tangent[axis] = 1;
  return tangent - turned * middle;
}

void Friction::Begin(const BoundaryConditions &sides, int dim, const SegmentProblem &problem)
{
  up_ = dim - 1, axes_ = up_;
  const std::size_t count = problem.Size();
  tangents_.resize(count), tractions_.assign(count, {});
  const std::vector<SurfaceColumn> &columns = problem.Columns();
  for (int a = 0; a < axes_; ++a) {
    held_[a].assign(columns.size(), 0);
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (const Side side : SidesAcross(a))
        held_[a][j] |= sides.kind[side] != BoundaryKind::kFree && sides.Reaches(side, columns[j].at);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const SegmentProblem::Candidate &one = problem.CandidateAt(k);
    for (int a = 0; a < axes_; ++a) {
      tangents_[k][a] = SurfaceTangent((1 / Norm(one.normal)) * one.normal, a, up_);
      tractions_[k][a] = one.root_area * one.traction_before[a];
    }
  }
  Yield(problem, tractions_, &yields_before_);
  motion_.assign(problem.Nodes().Size(), {}), forces_ = motion_;
  upward_force_ = heat_ = stored_ = 0;
}

Friction::Along Friction::Traction(const SegmentProblem &problem, int k) const
{
  const double root_area = problem.CandidateAt(k).root_area;
  return {tractions_[k][0] / root_area, tractions_[k][1] / root_area};
}

void Friction::Yield(const SegmentProblem &problem, const Field &tractions, Field *yields) const
{
  yields->assign(tractions.size(), {});
  std::vector<double> one(tractions.size());
  for (int a = 0; a < axes_; ++a) {
    for (std::size_t k = 0; k < one.size(); ++k) one[k] = tractions[k][a];
    const std::vector<double> yield = problem.YieldTo(one, held_[a]);
    for (std::size_t k = 0; k < one.size(); ++k) (*yields)[k][a] = yield[k];
  }
}

Friction::Field Friction::SlipsOf(const SegmentProblem &problem, const std::vector<Vec3> &motion) const
{
  Field slips(tangents_.size());
  for (std::size_t k = 0; k < slips.size(); ++k)
    for (int a = 0; a < axes_; ++a) slips[k][a] = problem.CandidateAt(k).root_area * Dot(tangents_[k][a], motion[k]);
  return slips;
}

Friction::Field Friction::Response(const SegmentProblem &problem, const Field &tractions)
{
  std::vector<Vec3> forces(tangents_.size());
  for (std::size_t k = 0; k < forces.size(); ++k)
    for (int a = 0; a < axes_; ++a) forces[k] = forces[k] + problem.CandidateAt(k).root_area * tractions[k][a] * tangents_[k][a];
  problem.Spread(forces, &forces_);
  motion_ = forces_;
  problem.Move(&motion_);
  Field slips = SlipsOf(problem, problem.MotionOf(motion_));
  Yield(problem, tractions, &yields_);
  for (std::size_t k = 0; k < slips.size(); ++k)
    for (int a = 0; a < axes_; ++a) slips[k][a] += yields_[k][a];
  return slips;
}

/// Of the response on the diagonal. All weights are positive, so that an even traction on what presses bounds what nodes move by;
/// between them it yields less than without Pi.
std::vector<double> Friction::Bounds(const SegmentProblem &problem, const std::vector<double> &q)
{
  constexpr double kAcross = 1.1; // tangents along two axes are coupled a little
  Field even(tangents_.size());
  for (std::size_t k = 0; k < even.size(); ++k) even[k][0] = q[k] > 0 ? problem.CandidateAt(k).root_area : 0;
  Response(problem, even);
  const Field slips = SlipsOf(problem, problem.MotionOf(motion_));
  std::vector<double> bounds(even.size(), DBL_MIN);
  for (std::size_t k = 0; k < even.size(); ++k)
    if (q[k] > 0)
      bounds[k] =
          (slips[k][0] / problem.CandidateAt(k).root_area + problem.CandidateAt(k).Compliance()) * (axes_ > 1 ? kAcross : 1);
  return bounds;
}

static double LimitTo(double most, Friction::Along *traction)
{
  const double size = std::hypot((*traction)[0], (*traction)[1]);
  if (size > most)
    for (double &one : *traction) one *= most / size;
  return size;
}

double Friction::Solve(const SegmentProblem &problem, const std::vector<double> &q, Vec3 way)
{
  constexpr int kMaxIterations = 1000; // rounding
  constexpr double kStop = 1e-10;      // rounding: of the tractions' size
  const std::size_t count = tangents_.size();
  const std::vector<Vec3> forces_before = forces_;
  // What slips without friction.
  std::vector<Vec3> motion(count), nodes;
  double pressed = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double force = problem.CandidateAt(k).Force(q[k]);
    motion[k] = force * problem.CandidateAt(k).normal;
    pressed += force;
  }
  problem.Spread(motion, &nodes);
  problem.Move(&nodes);
  motion = problem.MotionOf(nodes);
  const std::vector<Vec3> before = problem.MotionBefore();
  for (std::size_t k = 0; k < count; ++k) motion[k] = motion[k] + before[k] - way;
  Field free_slips = SlipsOf(problem, motion);
  for (std::size_t k = 0; k < count; ++k)
    for (int a = 0; a < axes_; ++a) free_slips[k][a] -= yields_before_[k][a];
  const std::vector<double> bounds = Bounds(problem, q);
  for (std::size_t k = 0; k < count; ++k) LimitTo(MostOf(q[k]), &tractions_[k]);
  Field ahead = tractions_;
  double theta = 1;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Field slips = Response(problem, ahead), last = tractions_;
    double uphill = 0, moves = 0, size = 0;
    for (std::size_t k = 0; k < count; ++k) {
      for (int a = 0; a < axes_; ++a) tractions_[k][a] = ahead[k][a] - (slips[k][a] + free_slips[k][a]) / bounds[k];
      LimitTo(MostOf(q[k]), &tractions_[k]);
      for (int a = 0; a < axes_; ++a) {
        const double change = tractions_[k][a] - last[k][a];
        uphill += bounds[k] * (ahead[k][a] - tractions_[k][a]) * change;
        moves += bounds[k] * change * change, size += bounds[k] * tractions_[k][a] * tractions_[k][a];
      }
    }
    const double next = uphill > 0 ? 1 : 0.5 * (1 + std::sqrt(1 + 4 * theta * theta)), part = uphill > 0 ? 0 : (theta - 1) / next;
    theta = next;
    for (std::size_t k = 0; k < count; ++k)
      for (int a = 0; a < axes_; ++a) ahead[k][a] = tractions_[k][a] + part * (tractions_[k][a] - last[k][a]);
    if (moves <= kStop * kStop * size) break;
  }
  SumUp(problem, q, free_slips);
  double change = 0;
  for (std::size_t i = 0; i < forces_.size(); ++i) change += Norm(forces_[i] - forces_before[i]);
  return change / std::max(pressed, DBL_MIN);
}

/// Forces and energies of the tractions.
void Friction::SumUp(const SegmentProblem &problem, const std::vector<double> &q, const Field &free_slips)
{
  const Field slips = Response(problem, tractions_);
  heat_ = upward_force_ = stored_ = 0;
  for (std::size_t k = 0; k < slips.size(); ++k) {
    double heat = 0;
    for (int a = 0; a < axes_; ++a) {
      heat -= tractions_[k][a] * (slips[k][a] + free_slips[k][a]);
      upward_force_ += problem.CandidateAt(k).root_area * tractions_[k][a] * tangents_[k][a][up_];
      stored_ += 0.5 * tractions_[k][a] * yields_[k][a];
    }
    if (std::hypot(tractions_[k][0], tractions_[k][1]) > MostOf(q[k]) * (1 - 1e-9)) heat_ += std::max(0.0, heat);
  }
}

} // namespace mlgimp
