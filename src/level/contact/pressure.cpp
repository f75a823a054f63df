// Contact with one pressure per grid column: P(x) = sum_j K_j(x) lambda_j on the deformed surface.
//
//   B_ij = sum_s K_j(x_s) N_i(x_s) n_s w_s,   sum_s K_j w_s g_s + dt sum_i B_ij . v_i >= 0,   sum over segments s of outer faces,
// with the same B in the force on the nodes and in the condition, so that the work of the indenter is what the body gets.
#include "level/contact/columns.hpp"
#include "level/contact/footprint.hpp"
#include "level/contact/methods.hpp"
#include "level/contact/system.hpp"

#include <algorithm>
#include <cfloat>
#include <climits>
#include <map>

namespace mlgimp
{

namespace
{

constexpr double kSmallestArea = 0.05; ///< of a column's full kernel, with less of which it is left out
constexpr double kSpare = 0.25;        ///< cells; see SpareGap
constexpr double kWallDepth = 0.1;     ///< cells; see PressedShare
constexpr double kRelease = 2e-4;      ///< see ReleasedGap

/// Cells that a column at the tip may be deeper where the surface covers little of its kernel: a tip that cuts metal takes the
/// surface away, and a column that let go all at once would come back with a blow.
double SpareGap(double covered) { return kSpare * std::max(0.0, 1 - 2 * covered); }

/// The part of a segment that counts. What does not face down its axis, as the side of a flat punch, closes no gap as the
/// indenter moves: elastic surface beside it, with its gap, would hold the column of an edge open, and let it go in blows. Metal
/// is cut by an edge, and lies against the side. Nor does surface that faces the indenter less than half as much as a level one,
/// as the side of a bar under a plate once it leans, or that is so much steeper than the indenter, as the wall of a hole with a
/// ball on its rim: with its whole area and its gaps it would let the rim go all at once, or hold its column open. Such segments
/// count as far as they have got in.
double PressedShare(const ContactView &view, const SurfaceSegment &segment, const SurfaceGap &gap, bool metal)
{
  const int up = view.geometry.Dim() - 1;
  const double level = -gap.normal[up], facing = std::min(segment.normal[up], -Dot(segment.normal, gap.normal)),
               within = std::clamp(-gap.distance / (kWallDepth * view.grid.Geometry().spacing), 0.0, 1.0);
  if (level <= kLeastFacing) return metal ? 1 : within;
  const double least = std::min(kLeastFacing, 0.25 * level);
  return std::max(within, std::min(1.0, (facing - least) / (0.5 * level - least)));
}

/// The largest gap with which a segment counts, m: that of the last column that may be in contact, and what the surface leans
/// away from the indenter across its kernel. What is farther is another surface, as the foot of a step or what lies below a
/// bridge, whose gap would let go of the column.
double LargestGap(const ContactView &view, const SurfaceSegment &segment, Vec3 normal)
{
  const double facing = Dot(segment.normal, normal) / (Norm(segment.normal) * Norm(normal)),
               slope = std::sqrt(std::max(0.0, 1 - facing * facing)), across = 2 * std::sqrt(view.geometry.Dim() - 1.0);
  return std::min(kContactRange, kCandidateGap + across * slope) * view.grid.Geometry().spacing;
}

/// The weighted gap that a column is to have closed by the end of a step, m3. Flow tilts the surface across the last column of a
/// contact and brings it to the next with a gap of hundredths of a cell, and surface that leans away changes the gap as it passes
/// to another level; closed in a step it would be a blow, the harder the shorter the step. What is more than the tip moves closes
/// with kRelease of the speed of sound.
double ReleasedGap(const ContactView &view, Index at, const ContactColumn &column)
{
  const double share = CrossesBorder(view, at) ? 1 : column.flowing / std::max(column.kernel_area, DBL_MIN),
               travel = Norm(view.tip.end - view.tip.start) * column.kernel_area,
               most = travel + kRelease * column.sound * view.dt;
  return column.gap + share * std::max(0.0, -column.gap - most);
}

/// True for the columns of the cells around the tip.
bool IsAtTip(const ContactView &view, Index column)
{
  const double h = view.grid.Geometry().spacing;
  const Vec3 tip = view.tip.start;
  bool near = true;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a) near = near && std::abs(view.grid.Coordinate(a, column[a]) - tip[a]) < h;
  return near;
}

/// False for cells that this rank has not all corners of, or that are not in the group's zone: a segment there is of a point that
/// has failed, which ends the run soon.
bool IsHere(const ContactView &view, Index cell)
{
  const Index last = Corner(cell, view.grid.Geometry().dim == 3 ? 7 : 3);
  const IndexBox here = Intersection(view.grid.Ghosted(), view.group.Zone());
  return here.Contains(cell) && here.Contains(last);
}

constexpr Index kNoCell = {INT_MIN, INT_MIN, INT_MIN};

class PressureContact : public Contact
{
public:
  PetscErrorCode Create(const ContactSettings &settings) override
  {
    settings_ = settings;
    return system_.Create(true, 0, settings);
  }

  ContactPressures Pressures() const override { return system_.Pressures(); }
  void SetPressures(const ContactPressures &pressures) override { system_.SetPressures(pressures); }

  PetscErrorCode Apply(const ContactView &view, ContactReport *report) override
  {
    PetscFunctionBeginUser;
    *report = {};
    CollectSegments(view, report);
    SendPattern pattern = OwnersOfNodes(view, &report->at_border);
    PetscCall(columns_.Sum(view, settings_.width, segments_, &least_gap_, &pattern, &report->at_border));
    NumberUnknowns(view);
    MakeCouplings(view);
    PetscCall(system_.Solve(view, unknowns_, std::move(couplings_), pattern, report));
    const std::vector<double> lambda = LambdaOfColumns();
    MeasureFootprint(view, columns_, lambda, report);
    report->local_points = CountLoadedPoints(view.geometry.Dim(), lambda);
    if (unknowns_.empty()) report->room = least_gap_ - kCandidateGap * view.grid.Geometry().spacing;
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode PressuresOnPoints(const ContactView &view, std::vector<double> *pressures) override
  {
    ContactReport discarded;
    SendPattern nobody = 0;
    std::size_t s = 0;
    std::vector<double> of_columns;
    PetscFunctionBeginUser;
    CollectSegments(view, &discarded);
    PetscCall(columns_.Sum(view, settings_.width, segments_, &least_gap_, &nobody, &discarded.at_border));
    PetscCall(PressuresOfColumns(view, &of_columns));
    pressures->assign(view.points.Count(), 0.0);
    for (const PointSegments &of : points_) {
      double load = 0, area = 0;
      for (; s < of.end; ++s)
        load += segments_[s].area * PressureAt(view, segments_[s].place, of_columns), area += segments_[s].area;
      if (area > 0) (*pressures)[of.point] = load / area;
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// A point near the indenter, and where its segments end among all; they begin where those of the point before it end.
  struct PointSegments {
    int point;
    std::size_t end;
  };

  /// The couplings of the columns of a cell with its corners, [columns][corners].
  struct CellCouplings {
    CellPlace place;
    Vec3 B[3][4][8] = {}; ///< of the pressure and of tractions along the horizontal axes
  };

  void CollectSegments(const ContactView &view, ContactReport *report)
  {
    const double range = kContactRange * view.grid.Geometry().spacing;
    std::vector<SurfaceSegment> all;
    segments_.clear();
    points_.clear();
    least_gap_ = range;
    const PointArrays points = view.points.Arrays();
    const std::vector<int> &surface = view.points.SurfacePoints();
    for (int p : surface) {
      if (FarFromIndenter(view, points, p)) continue;
      const Material &material = view.bodies.Of(points, p);
      const bool flows = material.AveragesVolume();
      const double sound = material.SpeedOfSound();
      const bool metal = material.IsMetal();
      all.clear();
      AddPointSegments(points, p, view.geometry, &all);
      for (const SurfaceSegment &s : all) {
        const SurfaceGap gap = view.indenter.Gap(s.x, view.tip.end);
        if (gap.distance > range) continue;
        least_gap_ = std::min(least_gap_, gap.distance);
        report->penetration = std::max(report->penetration, -view.indenter.Gap(s.x, view.tip.start).distance);
        const CellPlace place = Locate(view.grid, s.x, view.geometry.Dim());
        const double area = Faces(s, gap.normal) ? s.area * PressedShare(view, s, gap, metal) : 0;
        if (area > 0 && gap.distance <= LargestGap(view, s, gap.normal) && IsHere(view, place.cell))
          segments_.push_back(
              {place, gap.normal, area, gap.distance, s.x[0] - s.half_width, s.x[0] + s.half_width, sound, flows});
      }
      points_.push_back({p, segments_.size()});
    }
  }

  /// To which ranks this one may send couplings: the owners of all nodes around its segments. at_border: nodes of the coarser
  /// level are among them.
  SendPattern OwnersOfNodes(const ContactView &view, bool *at_border) const
  {
    const PetscMPIInt rank = RankIn(view.group.Comm());
    SendPattern pattern = 0;
    std::vector<ContactCoupling> corners;
    Index last = kNoCell;
    *at_border = false;
    if (!view.border && RanksOf(view.group.Comm()) == 1) return pattern;
    for (const PressedSegment &segment : segments_) {
      const Index cell = segment.place.cell;
      for (int k = 0; cell != last && k < 1 << view.geometry.Dim(); ++k) corners.push_back({Corner(cell, k), 0, {}, {}});
      last = cell;
    }
    if (view.border) ContactSystem::AddBeyondBorder(*view.border, &corners);
    *at_border = !corners.empty() && corners.back().coarser;
    if (RanksOf(view.group.Comm()) > kFewRanks) return pattern;
    for (const ContactCoupling &corner : corners)
      if (const PetscMPIInt owner = ContactSystem::OwnerOf(view, corner); owner >= 0) pattern |= Sends(rank, owner);
    return pattern;
  }

  void NumberUnknowns(const ContactView &view)
  {
    const double h = view.grid.Geometry().spacing;
    const int per_column = UnknownsPerColumn(settings_, view.geometry);
    unknowns_.clear();
    number_.clear();
    ForEach(columns_.Box(), [&](Index at) {
      const ContactColumn &column = columns_.At(at);
      const double full = FullKernelArea(view, settings_.width, at), area = column.kernel_area;
      const double gap = ReleasedGap(view, at, column) + (IsAtTip(view, at) ? SpareGap(area / full) * h * column.flowing : 0);
      const bool kept = area >= kSmallestArea * full && gap <= kCandidateGap * h * area;
      number_.push_back(kept ? static_cast<int>(unknowns_.size()) : -1);
      for (int u = 0; kept && u < per_column; ++u) unknowns_.push_back({KeyOf(view, at) + u, u == 0 ? gap : 0});
    });
  }

  /// The key of a column's pressure; those of its tractions follow.
  std::int64_t KeyOf(const ContactView &view, Index column) const
  {
    const int per_column = UnknownsPerColumn(settings_, view.geometry);
    return per_column * (column[0] + std::int64_t(view.grid.Geometry().Nodes(0)) * column[1]);
  }

  /// p_i of the last solve on the columns as they are now. Collective on the group, whose first rank has all of lambda.
  PetscErrorCode PressuresOfColumns(const ContactView &view, std::vector<double> *pressures) const
  {
    std::vector<double> lambda;
    PetscFunctionBeginUser;
    ForEach(columns_.Box(), [&](Index at) {
      const auto found = system_.Pressures().find(KeyOf(view, at));
      lambda.push_back(found == system_.Pressures().end() ? 0 : found->second);
    });
    PetscCallMPI(MPI_Bcast(lambda.data(), static_cast<PetscMPIInt>(lambda.size()), MPI_DOUBLE, 0, view.group.Comm()));
    *pressures = columns_.Pressures(lambda);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// sum_i H_i p_i, Pa.
  double PressureAt(const ContactView &view, const CellPlace &place, const std::vector<double> &of_columns) const
  {
    const int axes = view.geometry.Dim() - 1;
    double pressure = 0;
    for (int c = 0; c < 1 << axes; ++c)
      pressure += CornerHat(place.part, c, axes) * of_columns[columns_.Place(Corner(place.column, c))];
    return pressure;
  }

  /// Adds up the couplings cell by cell: most segments lie in the cell of the one before.
  void MakeCouplings(const ContactView &view)
  {
    const int dim = view.geometry.Dim(), columns = 1 << (dim - 1), corners = 1 << dim;
    const int per_column = UnknownsPerColumn(settings_, view.geometry);
    std::map<Index, CellCouplings> cells;
    auto cell = cells.end();
    for (const PressedSegment &segment : segments_) {
      const CellPlace &place = segment.place;
      if (cell == cells.end() || place.cell != cell->first) cell = cells.try_emplace(place.cell, CellCouplings{place, {}}).first;
      double hat[8];
      for (int k = 0; k < corners; ++k) hat[k] = CornerHat(place.part, k, dim);
      for (int c = 0; c < columns; ++c) {
        if (NumberOf(place, c) < 0) continue;
        for (int u = 0; u < per_column; ++u) {
          const Vec3 change = u == 0 ? GapGradient(view, segment, c, settings_.width) : SlipGradient(view, segment, c, u - 1);
          for (int k = 0; k < corners; ++k) cell->second.B[u][c][k] = cell->second.B[u][c][k] + hat[k] * change;
        }
      }
    }
    couplings_.clear();
    for (const auto &one : cells) Keep(dim, per_column, one.second);
  }

  /// How the weighted slip of a column along an axis grows as a segment moves, m2. At a side that is held across that axis there
  /// is none: tractions of both its sides are opposite.
  Vec3 SlipGradient(const ContactView &view, const PressedSegment &segment, int corner, int axis) const
  {
    const int axes = view.geometry.Dim() - 1;
    const Index column = Corner(segment.place.column, corner);
    for (const Side side : SidesAcross(axis))
      if (view.sides.kind[side] != BoundaryKind::kFree && view.sides.Reaches(side, column)) return {};
    const double kernel = CornerHat(segment.place.part, corner, axes, settings_.width);
    return segment.area * kernel * SurfaceTangent((1 / Norm(segment.normal)) * segment.normal, axis, axes);
  }

  int NumberOf(const CellPlace &place, int c) const { return number_[columns_.Place(Corner(place.column, c))]; }

  void Keep(int dim, int per_column, const CellCouplings &cell)
  {
    for (int c = 0; c < 1 << (dim - 1); ++c) {
      const int number = NumberOf(cell.place, c);
      for (int k = 0; number >= 0 && k < 1 << dim; ++k)
        for (int u = 0; u < per_column; ++u)
          couplings_.push_back({Corner(cell.place.cell, k), number + u, cell.B[u][c][k], cell.B[u][c][k]});
    }
  }

  /// The pressures of the last solve by columns, 0 of those that it left out.
  std::vector<double> LambdaOfColumns() const
  {
    std::vector<double> lambda;
    for (const int number : number_) lambda.push_back(number < 0 ? 0 : system_.Lambda()[number]);
    return lambda;
  }

  /// Points with a segment under the kernel of a loaded column.
  int CountLoadedPoints(int dim, const std::vector<double> &lambda) const
  {
    int count = 0;
    std::size_t s = 0;
    for (const PointSegments &of : points_) {
      bool loaded = false;
      for (; s < of.end; ++s)
        for (int c = 0; c < 1 << (dim - 1); ++c)
          loaded = loaded || (lambda[columns_.Place(Corner(segments_[s].place.column, c))] > 0 &&
                              CornerHat(segments_[s].place.part, c, dim - 1, settings_.width) > 0);
      count += loaded;
    }
    return count;
  }

  ContactSettings settings_;
  std::vector<PressedSegment> segments_;
  double least_gap_ = 0; ///< of segments within reach, m
  std::vector<PointSegments> points_;
  ContactColumns columns_;
  std::vector<int> number_; ///< of each column's pressure among the unknowns, or -1
  std::vector<ContactUnknown> unknowns_;
  std::vector<ContactCoupling> couplings_;
  ContactSystem system_;
};

} // namespace

std::unique_ptr<Contact> MakePressureContact() { return std::make_unique<PressureContact>(); }

} // namespace mlgimp
