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
  const double level = -gap.normal[up], facing = std::min(segment.normal[up], -Dot(segment.normal, gap.normal));
  if (level > kLeastFacing && facing >= 0.5 * level) return 1;
  const double within = std::clamp(-gap.distance / (kWallDepth * view.grid.Geometry().spacing), 0.0, 1.0);
  if (level <= kLeastFacing) return metal ? 1 : within;
  const double least = std::min(kLeastFacing, 0.25 * level);
  return std::max(within, (facing - least) / (0.5 * level - least));
}

/// How long the segments of a point's faces may be, m; 0: as short as can be. In space, where the parts of both edges multiply,
/// loads of a ball are within 0.1 % of those with the shortest. A sharp tip needs these at first, and the edge of a body, where
/// they tell how far it reaches under the last column.
double LongestSegment(const ContactView &view, const PointArrays &points, int p)
{
  constexpr double kLongest = 0.3, kAtTip = 2; // cells
  const double h = view.grid.Geometry().spacing;
  const Vec3 from_tip = points.Position(p) - view.tip.start;
  const int faces = points.faces[p];
  const bool at_edge = faces & (faces - 1); // more than one bit
  if (view.geometry.Dim() < 3 || at_edge || std::max(std::abs(from_tip[0]), std::abs(from_tip[1])) < kAtTip * h) return 0;
  return kLongest * h;
}

/// Whether a segment within reach counts: its gap is at most that of the last column that may be in contact, and what the surface
/// leans away from the indenter across its kernel. What is farther is another surface, as the foot of a step or what lies below a
/// bridge, whose gap would let go of the column.
bool MayTouch(const ContactView &view, const SurfaceSegment &segment, const SurfaceGap &gap)
{
  const double h = view.grid.Geometry().spacing, beyond = gap.distance - kCandidateGap * h,
               facing = Dot(segment.normal, gap.normal), square = Dot(gap.normal, gap.normal),
               across_square = 4 * (view.geometry.Dim() - 1) * h * h;
  return beyond <= 0 || beyond * beyond * square <= across_square * (square - facing * facing);
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
    PetscCall(columns_.Sum(view, surface_, &least_gap_, &pattern, &report->at_border));
    NumberUnknowns(view);
    MakeCouplings(view);
    PetscCall(system_.Solve(view, unknowns_, couplings_, pattern, report));
    const std::vector<double> lambda = LambdaOfColumns();
    MeasureFootprint(view, columns_, lambda, report);
    report->local_points = CountLoadedPoints(view, lambda);
    if (unknowns_.empty()) report->room = least_gap_ - kCandidateGap * view.grid.Geometry().spacing;
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode PressuresOnPoints(const ContactView &view, std::vector<double> *pressures) override
  {
    ContactReport discarded;
    SendPattern nobody = 0;
    std::vector<double> of_columns;
    PetscFunctionBeginUser;
    CollectSegments(view, &discarded);
    PetscCall(columns_.Sum(view, surface_, &least_gap_, &nobody, &discarded.at_border));
    PetscCall(PressuresOfColumns(view, &of_columns));
    pressures->assign(view.points.Count(), 0.0);
    ForEachPoint([&](auto first, auto end) {
      double load = 0, area = 0;
      for (auto part = first; part != end; ++part)
        for (int c = 0; c < ColumnsOfCell(view); ++c) {
          load += part->area[c] * of_columns[columns_.Place(ColumnOf(part->cell, c))];
          area += part->area[c];
        }
      (*pressures)[first->point] = load / area;
    });
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  static int ColumnsOfCell(const ContactView &view) { return 1 << (view.geometry.Dim() - 1); }
  static int NodesOfCell(const ContactView &view) { return 1 << view.geometry.Dim(); }
  /// Column c of a cell of the surface.
  Index ColumnOf(std::size_t cell, int c) const { return Corner(surface_.Cells()[cell].column, c); }

  /// Calls work(first, end) for the parts of each point.
  template <class Work> void ForEachPoint(Work work) const
  {
    const std::vector<PressedSurface::PointPart> &parts = surface_.PointParts();
    for (auto first = parts.begin(), end = first; first != parts.end(); first = end) {
      while (end != parts.end() && end->point == first->point) ++end;
      work(first, end);
    }
  }

  /// What segments have of a point's material.
  struct SegmentMaterial {
    double sound;
    bool flows, metal;
  };

  void CollectSegments(const ContactView &view, ContactReport *report)
  {
    surface_.Clear(view, settings_);
    least_gap_ = kContactRange * view.grid.Geometry().spacing;
    most_deeper_ = MovesSideways(view) ? HUGE_VAL : Norm(view.tip.end - view.tip.start);
    const PointArrays points = view.points.Arrays();
    for (const int p : view.points.SurfacePoints()) {
      if (FarFromIndenter(view, points, p)) continue;
      const Material &material = view.bodies.Of(points, p);
      const SegmentMaterial traits = {material.SpeedOfSound(), material.AveragesVolume(), material.IsMetal()};
      ForEachSegment(points, p, view.geometry, LongestSegment(view, points, p),
                     [&](const SurfaceSegment &segment) { CollectSegment(view, p, traits, segment, report); });
    }
  }

  void CollectSegment(const ContactView &view, int point, const SegmentMaterial &material, const SurfaceSegment &s,
                      ContactReport *report)
  {
    const double h = view.grid.Geometry().spacing;
    const SurfaceGap gap = view.indenter.Gap(s.x, view.tip.end);
    if (gap.distance > kContactRange * h) return;
    least_gap_ = std::min(least_gap_, gap.distance);
    if (most_deeper_ - gap.distance > report->penetration)
      report->penetration = std::max(report->penetration, -view.indenter.Gap(s.x, view.tip.start).distance);
    if (!Faces(s, gap.normal) || !MayTouch(view, s, gap)) return;
    const double area = s.area * PressedShare(view, s, gap, material.metal);
    if (area > 0)
      surface_.Add(view, point,
                   {Locate(view.grid, s.x, view.geometry.Dim()), gap.normal, area, gap.distance, s.x[0] - s.half_width,
                    s.x[0] + s.half_width, material.sound, material.flows});
  }

  /// To which ranks this one may send couplings: the owners of all nodes around its segments. at_border: nodes of the coarser
  /// level are among them.
  SendPattern OwnersOfNodes(const ContactView &view, bool *at_border) const
  {
    const PetscMPIInt rank = RankIn(view.group.Comm());
    SendPattern pattern = 0;
    std::vector<ContactCoupling> corners;
    *at_border = false;
    if (!view.border && RanksOf(view.group.Comm()) == 1) return pattern;
    for (const PressedSurface::Cell &one : surface_.Cells())
      for (int k = 0; k < NodesOfCell(view); ++k) corners.push_back({Corner(one.cell, k), 0, {}, {}});
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

  void MakeCouplings(const ContactView &view)
  {
    const int per_column = UnknownsPerColumn(settings_, view.geometry);
    couplings_.clear();
    for (std::size_t cell = 0; cell < surface_.Cells().size(); ++cell)
      for (int c = 0; c < ColumnsOfCell(view); ++c) {
        const int number = number_[columns_.Place(ColumnOf(cell, c))];
        for (int k = 0; number >= 0 && k < NodesOfCell(view); ++k)
          for (int u = 0; u < per_column; ++u) {
            const Vec3 B = surface_.Coupling(cell, c, u, k);
            couplings_.push_back({Corner(surface_.Cells()[cell].cell, k), number + u, B, B});
          }
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
  int CountLoadedPoints(const ContactView &view, const std::vector<double> &lambda) const
  {
    int count = 0;
    ForEachPoint([&](auto first, auto end) {
      count += std::any_of(first, end, [&](const PressedSurface::PointPart &part) {
        bool loaded = false;
        for (int c = 0; c < ColumnsOfCell(view); ++c)
          loaded = loaded || (part.under_kernel[c] && lambda[columns_.Place(ColumnOf(part.cell, c))] > 0);
        return loaded;
      });
    });
    return count;
  }

  ContactSettings settings_;
  PressedSurface surface_;
  double least_gap_ = 0;   ///< of segments within reach, m
  double most_deeper_ = 0; ///< by which a segment may lie deeper at the start of the step than at its end, m
  ContactColumns columns_;
  std::vector<int> number_; ///< of each column's pressure among the unknowns, or -1
  std::vector<ContactUnknown> unknowns_;
  std::vector<ContactCoupling> couplings_;
  ContactSystem system_;
};

} // namespace

std::unique_ptr<Contact> MakePressureContact() { return std::make_unique<PressureContact>(); }

} // namespace mlgimp
