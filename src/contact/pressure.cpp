// Contact with a pressure on each segment of the surface: see segment_problem.hpp.
#include "contact/contact.hpp"

#include "base/exchange.hpp"
#include "contact/friction.hpp"
#include "contact/pressure_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace mlgimp
{

namespace
{

/// What the first rank sends the others after a solve. Doubles throughout.
struct Outcome {
  double travel, limited, solved, half_width, reach, crosses_border, peak, may_reach_coarser_level, empty, least_gap, columns;
};

class PressureContact : public Contact
{
public:
  using Contact::Contact;

  PetscErrorCode Create(const ContactSettings &settings) override
  {
    settings_ = settings;
    return solver_.Create();
  }

  ContactPressures Pressures() const override
  {
    ContactPressures all;
    for (const auto &[column, mean] : means_) all[kKeptOfEach * column] = mean;
    for (const auto &[column, strain] : strains_) all[kKeptOfEach * column + 1] = strain;
    std::int64_t key = 0;
    for (const PatchState &one : last_) {
      key -= kKeptOfEach;
      const double numbers[] = {double(one.patch), double(one.path), one.pressure, one.traction[0], one.traction[1]};
      for (int k = 0; k < kOfPatch; ++k) all[key - k] = numbers[k];
    }
    return all;
  }
  void SetPressures(const ContactPressures &pressures) override
  {
    const auto whole = [](double number) { return static_cast<std::int64_t>(std::clamp(number, 0.0, 9e15)); }; // size
    means_.clear(), strains_.clear(), last_.clear();
    for (const auto &[key, value] : pressures)
      if (key >= 0) (key % kKeptOfEach == 0 ? means_ : strains_)[key / kKeptOfEach] = value;
    std::array<double, kOfPatch> numbers;
    for (std::int64_t key = -kKeptOfEach; pressures.count(key) > 0; key -= kKeptOfEach) {
      for (int k = 0; k < kOfPatch; ++k) numbers[k] = pressures.count(key - k) > 0 ? pressures.at(key - k) : 0;
      last_.push_back({whole(numbers[0]), whole(numbers[1]), numbers[2], {numbers[3], numbers[4]}});
    }
  }

  PetscErrorCode Apply(const SurfaceInputs &surface, const NodeMotion &motion, const ContactStep &step,
                       ContactReport *report) override
  {
    std::vector<Segment> segments;
    std::vector<Vec3> impulses, of_friction;
    Outcome outcome{};
    double least_gap = kContactRange * surface.grid.Geometry().spacing;
    PetscFunctionBeginUser;
    *report = {};
    CollectSegments(surface, step.tip, RankIn(group_.Comm()), &segments, &least_gap, &report->penetration);
    PetscCall(nodes_.Gather(motion, NodesOf(surface.grid, segments)));
    PetscCall(GatherSegments(group_.Comm(), &segments));
    PetscCallMPI(MPI_Reduce(&least_gap, &outcome.least_gap, 1, MPI_DOUBLE, MPI_MIN, 0, group_.Comm()));
    if (RankIn(group_.Comm()) == 0)
      PetscCall(SolveOnFirst(surface, motion, step, std::move(segments), &outcome, &impulses, &of_friction, report));
    std::vector<double> numbers(&outcome.travel, &outcome.travel + sizeof outcome / sizeof(double));
    PetscCall(ShareFromFirst(group_.Comm(), &numbers, kFirstToAll));
    std::copy(numbers.begin(), numbers.end(), &outcome.travel);
    report->travel = outcome.travel, report->limited = outcome.limited != 0, report->solved = outcome.solved != 0;
    report->half_width = outcome.half_width, report->reach = outcome.reach, report->crosses_border = outcome.crosses_border != 0;
    report->peak_pressure = outcome.peak, report->may_reach_coarser_level = outcome.may_reach_coarser_level != 0;
    if (outcome.empty != 0) report->clearance = outcome.least_gap - kCandidateGap * surface.grid.Geometry().spacing;
    PetscCall(ShareColumns(static_cast<std::size_t>(outcome.columns), report));
    PetscCall(nodes_.Push(motion, impulses, of_friction, report));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode Flow(std::vector<ColumnStrain> strains, Surface *surface, double *work) override
  {
    std::vector<SegmentFlow> flows;
    PetscFunctionBeginUser;
    *work = 0;
    PetscCall(ExchangeRecords(
        group_.Comm(), &strains, [](const ColumnStrain &) { return 0; }, kAllToFirst));
    if (RankIn(group_.Comm()) == 0) {
      RecordStrains(strains);
      *work = solution_.shape.flow_work;
      for (const SegmentSolution::Flow &flow : solution_.flows) {
        const Segment &segment = problem_.Segments()[flow.segment];
        flows.push_back({segment.rank, segment.at, flow.by});
      }
    }
    PetscCall(ExchangeRecords(
        group_.Comm(), &flows, [](const SegmentFlow &one) { return one.rank; }, kFirstToAll));
    for (const SegmentFlow &one : flows) surface->Patches()[one.at].flow += one.by;
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode PressuresOnPoints(const SurfaceInputs &surface, Vec3 tip, std::vector<double> *pressures) override
  {
    PetscFunctionBeginUser;
    PetscCall(SpreadLoads(surface.grid.Geometry(), FacesOfPoints(surface, tip), surface.points.Count(), pressures));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscErrorCode PressuresOnPatches(const SurfaceInputs &surface, Vec3 tip, std::vector<double> *pressures) override
  {
    PetscFunctionBeginUser;
    PetscCall(SpreadLoads(surface.grid.Geometry(), FacesOfPatches(surface, tip),
                          static_cast<int>(surface.patches.Patches().size()), pressures));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// Mean over the points under each column.
  void RecordStrains(const std::vector<ColumnStrain> &strains)
  {
    ColumnNumbers weights;
    strains_.clear();
    for (const ColumnStrain &one : strains) strains_[one.key] += one.strain, weights[one.key] += one.weight;
    for (auto &[key, sum] : strains_) sum /= weights[key];
  }

  /// A piece of the surface that is turned to the indenter, of a point or a patch, and the lines around it.
  struct PressedFace {
    int owner, lines = 0;
    double area, projected; ///< m2
    std::int64_t key[4];
    double hat[4];
  };
  struct LineArea {
    std::int64_t key;
    double area; ///< m2
  };

  /// Calls work(key, hat) for the lines of half cells along the last axis around a place.
  template <class Work> static void ForEachLine(const GridGeometry &grid, const CellPlace &place, Work work)
  {
    const int up = grid.dim - 1;
    Index first{};
    Vec3 part{};
    for (int a = 0; a < up; ++a) {
      const bool second = place.part[a] >= 0.5;
      first[a] = 2 * (place.cell[a] + grid.padding) + second, part[a] = 2 * place.part[a] - second;
    }
    const std::array<double, 8> hats = Hats(part, up);
    for (int c = 0; c < 1 << up; ++c) {
      const Index at = Corner(first, c);
      work(at[0] + 2 * std::int64_t(grid.Nodes(0)) * at[1], hats[c]);
    }
  }

  /// Adds a segment to the faces where it is turned to the indenter. as_tip: its slope is that of the indenter there, not its
  /// own, which points' faces have in steps.
  static void AddFace(const SurfaceInputs &surface, Vec3 tip, int owner, const SurfaceSegment &s, bool as_tip,
                      std::vector<PressedFace> *faces)
  {
    const GridGeometry &grid = surface.grid.Geometry();
    const int dim = grid.dim;
    const SurfaceGap gap = surface.indenter.Gap(s.x, tip);
    if (gap.distance > kContactRange * grid.spacing || !Faces(s, gap.normal)) return;
    PressedFace face{owner, 0, s.area, s.area * (as_tip ? -gap.normal[dim - 1] : s.normal[dim - 1]), {}, {}};
    ForEachLine(grid, Locate(grid, s.x),
                [&](std::int64_t key, double hat) { face.key[face.lines] = key, face.hat[face.lines++] = hat; });
    faces->push_back(face);
  }
  static std::vector<PressedFace> FacesOfPoints(const SurfaceInputs &surface, Vec3 tip)
  {
    constexpr double kLength = 0.125; // cells, of a segment
    std::vector<PressedFace> faces;
    const PointArrays points = surface.points.Arrays();
    for (const int p : surface.points.SurfacePoints()) {
      if (FarFromIndenter(surface, tip, points.Position(p))) continue;
      ForEachSegment(points, p, surface.geometry, kLength * surface.grid.Geometry().spacing,
                     [&](const SurfaceSegment &s) { AddFace(surface, tip, p, s, true, &faces); });
    }
    return faces;
  }
  static std::vector<PressedFace> FacesOfPatches(const SurfaceInputs &surface, Vec3 tip)
  {
    std::vector<PressedFace> faces;
    const std::vector<SurfacePatch> &patches = surface.patches.Patches();
    for (std::size_t k = 0; k < patches.size(); ++k)
      if (!FarFromIndenter(surface, tip, patches[k].Center(surface.geometry.Dim())))
        AddFace(surface, tip, static_cast<int>(k), SegmentOf(patches[k], 0.5, 0.5, surface.geometry), false, &faces);
    return faces;
  }

  /// Loads of segments go to lines half a cell apart, by hats about them, and over the areas that the faces have there.
  PetscErrorCode SpreadLoads(const GridGeometry &grid, const std::vector<PressedFace> &faces, int count,
                             std::vector<double> *pressures)
  {
    std::vector<LineArea> areas;
    std::vector<std::pair<std::int64_t, double>> lines;
    PetscFunctionBeginUser;
    for (const PressedFace &face : faces)
      for (int c = 0; c < face.lines; ++c) areas.push_back({face.key[c], face.hat[c] * face.projected});
    PetscCall(ExchangeRecords(
        group_.Comm(), &areas, [](const LineArea &) { return 0; }, kAllToFirst));
    if (RankIn(group_.Comm()) == 0) lines = PressuresOfLines(grid, areas);
    PetscCall(BroadcastList(group_.Comm(), &lines));
    const std::unordered_map<std::int64_t, double> by_key(lines.begin(), lines.end());
    std::vector<double> whole(count, 0.0);
    pressures->assign(count, 0.0);
    for (const PressedFace &face : faces) {
      for (int c = 0; c < face.lines; ++c)
        if (const auto found = by_key.find(face.key[c]); found != by_key.end())
          (*pressures)[face.owner] += face.area * face.hat[c] * found->second;
      whole[face.owner] += face.area;
    }
    for (std::size_t p = 0; p < whole.size(); ++p)
      if (whole[p] > 0) (*pressures)[p] /= whole[p];
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// Loads of the last solve over the lines' areas now, Pa, by key.
  std::vector<std::pair<std::int64_t, double>> PressuresOfLines(const GridGeometry &grid,
                                                                const std::vector<LineArea> &areas) const
  {
    ColumnNumbers projected, loads;
    for (const LineArea &one : areas) projected[one.key] += one.area;
    for (const SegmentSolution::Load &load : solution_.loads)
      ForEachLine(grid, problem_.Segments()[load.segment].place,
                  [&](std::int64_t key, double hat) { loads[key] += hat * load.force; });
    std::vector<std::pair<std::int64_t, double>> pressures;
    for (const auto &[key, load] : loads)
      if (const auto area = projected.find(key); area != projected.end() && area->second > 0)
        pressures.push_back({key, load / area->second});
    return pressures;
  }

  /// Sends that many columns of the first rank to all ranks of the group.
  PetscErrorCode ShareColumns(std::size_t count, ContactReport *report) const
  {
    std::vector<double> numbers;
    PetscFunctionBeginUser;
    if (count == 0) PetscFunctionReturn(PETSC_SUCCESS);
    for (const PressedColumn &one : report->columns) numbers.insert(numbers.end(), {static_cast<double>(one.key), one.share});
    numbers.resize(2 * count);
    PetscCall(ShareFromFirst(group_.Comm(), &numbers, kFirstToAll));
    report->columns.clear();
    for (std::size_t k = 0; k < numbers.size(); k += 2)
      report->columns.push_back({static_cast<std::int64_t>(numbers[k]), numbers[k + 1]});
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode SolveOnFirst(const SurfaceInputs &surface, const NodeMotion &motion, const ContactStep &step,
                              std::vector<Segment> segments, Outcome *outcome, std::vector<Vec3> *impulses,
                              std::vector<Vec3> *of_friction, ContactReport *report)
  {
    PressureReport found;
    PetscFunctionBeginUser;
    problem_.Build(surface.grid.Geometry(), surface.geometry.kind, step.dt, nodes_, std::move(segments), means_, strains_, last_);
    outcome->solved = 1, outcome->empty = problem_.Size() == 0;
    solution_ = {};
    means_.clear(), strains_.clear(), last_.clear();
    if (problem_.Size() == 0) {
      outcome->travel = step.tip.FreeTravel();
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    std::vector<double> q = problem_.Start();
    PetscCall(solver_.Solve(problem_, step.tip, 0, &q, &found));
    Friction friction(settings_.friction);
    if (settings_.friction > 0)
      PetscCall(AddFriction(surface.indenter, motion.Sides(), step, &q, &friction, of_friction, &found, report));
    solution_ = problem_.SolutionOf(q, motion.Border(), step.tip.start, found.travel);
    last_ = problem_.StatesOf(q);
    for (std::size_t k = 0; settings_.friction > 0 && k < last_.size(); ++k) last_[k].traction = friction.Traction(problem_, k);
    *impulses = solution_.impulses;
    for (std::size_t k = 0; k < of_friction->size(); ++k) (*impulses)[k] = (*impulses)[k] + (*of_friction)[k];
    const SegmentSolution::Footprint &shape = solution_.shape;
    outcome->may_reach_coarser_level = nodes_.AreAtBorder();
    outcome->travel = found.travel, outcome->limited = found.limited, outcome->solved = found.solved;
    outcome->reach = shape.reach, outcome->crosses_border = shape.crosses_border, outcome->peak = shape.peak;
    outcome->half_width = HalfWidth(surface, motion.Sides(), step.tip.start, shape.area);
    report->area = shape.area, report->stored = shape.stored + friction.Stored();
    RecordColumns(report);
    outcome->columns = static_cast<double>(report->columns.size());
    report->local_points = shape.points, report->set_updates = std::max(found.turns, 1);
    if (settings_.monitor && found.pressing) PetscCall(PrintSolve(step.time, problem_.Size(), found));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// Mean pressures, for the next step, and what share of columns is pressed.
  void RecordColumns(ContactReport *report)
  {
    for (std::size_t j = 0; j < solution_.columns.size(); ++j) {
      const SegmentSolution::Column &found = solution_.columns[j];
      const SurfaceColumn &column = problem_.Columns()[j];
      if (found.mean > 0) means_[column.key] = found.mean;
      if (found.touching > 0) report->columns.push_back({column.key, found.touching / column.surface});
    }
  }

  /// Tractions and pressures in turns, until the impulses of tractions stay.
  PetscErrorCode AddFriction(const Indenter &indenter, const BoundaryConditions &sides, const ContactStep &step,
                             std::vector<double> *q, Friction *friction, std::vector<Vec3> *impulses, PressureReport *found,
                             ContactReport *report)
  {
    constexpr int kMaxTurns = 20;  // rounding
    constexpr double kStop = 1e-7; // rounding: of the pressures' impulse
    PetscFunctionBeginUser;
    friction->Begin(sides, indenter.up + 1, problem_);
    for (int turn = 0; turn < kMaxTurns; ++turn) {
      const Vec3 way = step.tip.end - step.tip.start + indenter.Up(-found->travel);
      const double change = friction->Solve(problem_, *q, way);
      if (change < kStop) break; // also where there are none
      problem_.SetFriction(friction->Motion());
      PetscCall(solver_.Solve(problem_, step.tip, friction->UpwardForce(), q, found));
    }
    impulses->clear();
    for (const Vec3 &force : friction->Forces()) impulses->push_back(step.dt * force);
    nodes_.Restrict(impulses);
    report->friction_work = friction->Heat();
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  static double HalfWidth(const SurfaceInputs &surface, const BoundaryConditions &sides, Vec3 tip, double area)
  {
    int parts = 1; // of the tip, by sides of symmetry through it
    for (int axis = 0; axis < surface.geometry.Dim() - 1; ++axis)
      for (const Side side : SidesAcross(axis)) {
        const double off = tip[axis] - surface.grid.Geometry().Coordinate(axis, sides.node[side]);
        if (sides.kind[side] == BoundaryKind::kSymmetry && std::abs(off) < 1e-6 * surface.grid.Geometry().spacing) parts *= 2;
      }
    if (surface.geometry.Dim() == 3) return std::sqrt(parts * area / M_PI);
    if (surface.geometry.HasHoop()) return std::sqrt(area / M_PI);
    return area / surface.geometry.OutOfPlane(0) * (parts == 2 ? 1 : 0.5);
  }

  static constexpr int kOfPatch = 5; ///< size: numbers that a patch leaves to the next step, by keys below zero: its own two, a
                                     ///< pressure, tractions; a column, from zero on, leaves a mean pressure and a plastic strain

  ContactSettings settings_;
  ContactNodes nodes_;
  SegmentProblem problem_;
  SegmentSolution solution_; ///< of the last step, on the first rank
  PressureSolver solver_;
  std::vector<PatchState> last_;  ///< of the last step, on the first rank
  ColumnNumbers means_, strains_; ///< of the last step, on the first rank: L_j; what points under columns flowed in it
};

} // namespace

std::unique_ptr<Contact> MakePressureContact(const ContactGroup &group) { return std::make_unique<PressureContact>(group); }

} // namespace mlgimp
