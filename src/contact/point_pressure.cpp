// The paper's Eq. 11 as printed: one pressure per material point that would pass the indenter's surface.
//
//   V^c_p = dt sum_i S_ip/m_i sum_q T_iq P_q,  T_iq = int_face S_i ds,  gap at the point's centre (its Fig. 2).
// With several points per cell the matrix is rank deficient, so 1e-2 of its diagonal is added. T_iq is S_iq times the face's area
// A_q, so that q = sqrt(A) P makes the matrix symmetric.
#include "contact/contact.hpp"

#include "base/exchange.hpp"
#include "contact/contact_nodes.hpp"
#include "contact/pressure_solver.hpp"
#include "surface/pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace mlgimp
{

namespace
{

/// A point near the indenter.
struct PressedPoint {
  std::int64_t id;
  Index nearest;                ///< node; those beside it have its weights
  std::array<double, 9> weight; ///< S_ip
  Vec3 normal;                  ///< of the indenter
  double area;                  ///< of its faces that are turned to the indenter, m2
  double gap;                   ///< of its centre at the end of the step, m
  double left, right;           ///< ends of those faces, m
};

/// Calls work(k, node) for the nodes of a point.
template <class Work> void ForEachNode(const PressedPoint &point, Work work)
{
  int k = 0;
  ForEach({{-1, -1, 0}, {2, 2, 1}}, [&](Index by) { work(k++, point.nearest + by); });
}

class PointProblem : public PressureProblem
{
public:
  void Build(double dt, const ContactNodes &nodes, std::vector<PressedPoint> points)
  {
    dt_ = dt, nodes_ = &nodes, points_ = std::move(points);
    gaps_.clear(), closing_.clear(), node_.clear();
    for (const PressedPoint &point : points_) {
      Vec3 velocity{};
      ForEachNode(point, [&](int k, Index node) {
        node_.push_back(nodes.NumberOf(node));
        if (node_.back() >= 0) velocity = velocity + point.weight[k] * nodes.At(node_.back()).velocity;
      });
      gaps_.push_back(std::sqrt(point.area) * (point.gap + dt_ * Dot(point.normal, velocity)));
      closing_.push_back(-std::sqrt(point.area) * point.normal[1]);
    }
    SetDiagonal();
  }

  int Size() const override { return static_cast<int>(points_.size()); }
  void Multiply(const double *q, double *y) const override
  {
    std::vector<Vec3> moved = Spread(q);
    nodes_->Move(dt_, &moved);
    for (int p = 0; p < Size(); ++p) y[p] = shift_[p] * q[p] + std::sqrt(points_[p].area) * Dot(points_[p].normal, At(p, moved));
  }
  void Diagonal(double *diagonal) const override
  {
    for (int p = 0; p < Size(); ++p) diagonal[p] = (1 + 1 / kShift) * shift_[p];
  }

  /// Forces of pressures on nodes, N.
  std::vector<Vec3> Spread(const double *q) const
  {
    std::vector<Vec3> forces(nodes_->Size());
    for (int p = 0; p < Size(); ++p)
      for (int k = 0; k < kNodes; ++k) {
        if (node_[kNodes * p + k] < 0) continue;
        Vec3 &force = forces[node_[kNodes * p + k]];
        force = force + (points_[p].weight[k] * std::sqrt(points_[p].area) * q[p]) * points_[p].normal;
      }
    return forces;
  }
  const std::vector<PressedPoint> &Of() const { return points_; }

private:
  static constexpr int kNodes = 9;       // size
  static constexpr double kShift = 1e-2; ///< of the diagonal, added to it

  Vec3 At(int p, const std::vector<Vec3> &nodes) const
  {
    Vec3 sum{};
    for (int k = 0; k < kNodes; ++k)
      if (const int node = node_[kNodes * p + k]; node >= 0) sum = sum + points_[p].weight[k] * nodes[node];
    return sum;
  }
  void SetDiagonal()
  {
    shift_.assign(Size(), 0.0);
    std::vector<double> unit(Size(), 0.0);
    for (int p = 0; p < Size(); ++p) {
      unit[p] = 1;
      std::vector<Vec3> moved = Spread(unit.data());
      nodes_->Move(dt_, &moved);
      shift_[p] = kShift * std::sqrt(points_[p].area) * Dot(points_[p].normal, At(p, moved));
      unit[p] = 0;
    }
  }

  double dt_ = 0;
  const ContactNodes *nodes_ = nullptr;
  std::vector<PressedPoint> points_;
  std::vector<int> node_;     ///< [points][kNodes]
  std::vector<double> shift_; ///< [points]
};

/// What the first rank sends the others after a solve. Doubles throughout.
struct Outcome {
  double solved, half_width, peak, may_reach_coarser_level;
};

class PointPressureContact : public Contact
{
public:
  using Contact::Contact;

  PetscErrorCode Create(const ContactSettings &settings) override
  {
    settings_ = settings;
    return solver_.Create();
  }

  ContactPressures Pressures() const override { return pressures_; }
  void SetPressures(const ContactPressures &pressures) override { pressures_ = pressures; }

  PetscErrorCode Apply(const SurfaceInputs &surface, const NodeMotion &motion, const ContactStep &step,
                       ContactReport *report) override
  {
    std::vector<PressedPoint> points;
    std::vector<Index> nodes;
    std::vector<Vec3> impulses;
    Outcome outcome{1, 0, 0, 1};
    PetscFunctionBeginUser;
    *report = {};
    const PointArrays arrays = surface.points.Arrays();
    for (int p : surface.points.SurfacePoints())
      if (!FarFromIndenter(surface, step.tip.end, arrays.Position(p))) AddPoint(surface, step.tip, p, &points, report);
    for (const PressedPoint &point : points) ForEachNode(point, [&](int, Index node) { nodes.push_back(node); });
    PetscCall(nodes_.Gather(motion, nodes));
    PetscCall(ExchangeRecords(
        group_.Comm(), &points, [](const PressedPoint &) { return 0; }, kAllToFirst));
    std::sort(points.begin(), points.end(), [](const PressedPoint &a, const PressedPoint &b) { return a.id < b.id; });
    if (RankIn(group_.Comm()) == 0)
      PetscCall(SolveOnFirst(step, surface.grid.Geometry().spacing, std::move(points), &outcome, &impulses, report));
    std::vector<double> numbers(&outcome.solved, &outcome.solved + sizeof outcome / sizeof(double));
    PetscCall(ShareFromFirst(group_.Comm(), &numbers, kFirstToAll));
    std::copy(numbers.begin(), numbers.end(), &outcome.solved);
    report->solved = outcome.solved != 0;
    report->half_width = outcome.half_width, report->peak_pressure = outcome.peak,
    report->may_reach_coarser_level = outcome.may_reach_coarser_level != 0;
    PetscCall(nodes_.Push(motion, impulses, {}, report));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode PressuresOnPoints(const SurfaceInputs &surface, Vec3, std::vector<double> *pressures) override
  {
    std::vector<std::pair<std::int64_t, double>> all(pressures_.begin(), pressures_.end());
    PetscFunctionBeginUser;
    PetscCall(BroadcastList(group_.Comm(), &all));
    const std::unordered_map<std::int64_t, double> by_id(all.begin(), all.end());
    const PointArrays points = surface.points.Arrays();
    pressures->assign(points.count, 0.0);
    for (int p : surface.points.SurfacePoints())
      if (const auto found = by_id.find(static_cast<std::int64_t>(points.id[p])); found != by_id.end())
        (*pressures)[p] = found->second;
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  static void AddPoint(const SurfaceInputs &surface, const TipStep &tip, int p, std::vector<PressedPoint> *pressed,
                       ContactReport *report)
  {
    const PointArrays points = surface.points.Arrays();
    const Vec3 x = points.Position(p);
    const SurfaceGap gap = surface.indenter.Gap(x, tip.end);
    double length = 0, area = 0;
    ForEachSegment(points, p, surface.geometry, HUGE_VAL, [&](const SurfaceSegment &segment) {
      if (Faces(segment, gap.normal)) length += 2 * segment.half_width, area += segment.area;
    });
    if (length == 0) return;
    report->penetration = std::max(report->penetration, -surface.indenter.Gap(x, tip.start).distance);
    PressedPoint point{static_cast<std::int64_t>(points.id[p]),
                       surface.grid.Geometry().Nearest(x),
                       {},
                       gap.normal,
                       area,
                       gap.distance,
                       x[0] - 0.5 * length,
                       x[0] + 0.5 * length};
    AxisStencils<2> w;
    ComputeAxisStencils<PlaneStrain, ContiguousGimp>(
        surface.grid.IndexSpace(), 1, Extents<2>(1, points.position + 2 * p, points.half_size + 2 * p, points.F + 4 * p), w);
    ForEachNode(point, [&](int k, Index node) {
      const Index by = node - point.nearest;
      point.weight[k] = w.w[0][by[0] + 1][0] * w.w[1][by[1] + 1][0];
    });
    pressed->push_back(point);
  }

  PetscErrorCode SolveOnFirst(const ContactStep &step, double h, std::vector<PressedPoint> points, Outcome *outcome,
                              std::vector<Vec3> *impulses, ContactReport *report)
  {
    PressureReport found;
    PetscFunctionBeginUser;
    problem_.Build(step.dt, nodes_, std::move(points));
    if (problem_.Size() == 0) {
      pressures_.clear();
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    std::vector<double> q;
    for (const PressedPoint &point : problem_.Of()) {
      const auto before = pressures_.find(point.id);
      q.push_back(before != pressures_.end() ? std::sqrt(point.area) * before->second : 0);
    }
    PetscCall(solver_.Solve(problem_, step.tip, 0, &q, &found));
    if (settings_.monitor && found.pressing) PetscCall(PrintSolve(step.time, problem_.Size(), found));
    *impulses = problem_.Spread(q.data());
    for (Vec3 &impulse : *impulses) impulse = step.dt * impulse;
    nodes_.Restrict(impulses);
    pressures_.clear();
    double left = HUGE_VAL, right = -HUGE_VAL;
    for (int p = 0; p < problem_.Size(); ++p) {
      if (q[p] <= 0) continue;
      const PressedPoint &point = problem_.Of()[p];
      const double pressure = pressures_[point.id] = q[p] / std::sqrt(point.area);
      outcome->peak = std::max(outcome->peak, pressure);
      left = std::min(left, point.left), right = std::max(right, point.right);
    }
    if (left < right) outcome->half_width = HalfWidth(left, right, step.tip.start[0], h);
    outcome->may_reach_coarser_level = nodes_.AreAtBorder();
    outcome->solved = found.solved;
    report->local_points = found.pressing, report->set_updates = std::max(found.turns, 1);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// Half the width of what is pressed; all of it where it lies on one side of the tip.
  static double HalfWidth(double left, double right, double tip, double h)
  {
    const double rounding = 1e-6 * h;
    return left < tip - rounding && right > tip + rounding ? 0.5 * (right - left) : right - left;
  }

  ContactSettings settings_;
  ContactNodes nodes_;
  PointProblem problem_;
  PressureSolver solver_;
  ContactPressures pressures_; ///< on the first rank
};

} // namespace

std::unique_ptr<Contact> MakePointPressureContact(const ContactGroup &group)
{
  return std::make_unique<PointPressureContact>(group);
}

} // namespace mlgimp
