// Contact with one pressure per grid column: P(x) = sum_j H_j(x) lambda_j on the deformed surface.
//
//   B_ij = sum_s H_j(x_s) N_i(x_s) n_s w_s,   gbar_j = sum_s H_j w_s g_s,   sum over segments s of outer faces,
// with the same B in the force on the nodes and in the condition, so that the work of the indenter is what the body gets.
#include "level/contact_methods.hpp"
#include "level/contact_system.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kSmallestWeight = 0.05; ///< of a column's share of the surface, in cells

class PressureContact : public Contact
{
public:
  PetscErrorCode Create(bool monitor) { return system_.Create(true, 0, monitor); }

  ContactPressures Pressures() const override { return system_.Pressures(); }
  void SetPressures(const ContactPressures &pressures) override { system_.SetPressures(pressures); }

  PetscErrorCode Apply(const ContactView &view, ContactReport *report) override
  {
    const double h = view.grid.Geometry().spacing;
    PetscFunctionBeginUser;
    rows_.clear();
    entries_.clear();
    cell_ = {};
    loaded_.clear();
    *report = {};
    PetscCall(CollectSurface(view, report));
    PetscCall(system_.Solve(view, rows_, entries_, kSmallestWeight * h * view.thickness, report));
    report->local_points = CountLoadedPoints();
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// The columns that the segments of a point touch.
  struct PointColumns {
    std::int64_t first, last;
  };

  PetscErrorCode CollectSurface(const ContactView &view, ContactReport *report)
  {
    const std::vector<int> *surface = nullptr;
    PointArrays points;
    SurfaceSegment segments[kSides * kSegmentsPerFace];
    PetscFunctionBeginUser;
    PetscCall(view.points.Arrays(&points));
    PetscCall(view.points.SurfacePoints(&surface));
    for (int p : *surface) {
      if (FarFromIndenter(view, points, p)) continue;
      const int count = PointSegments(points, p, segments);
      PointColumns columns{INT64_MAX, INT64_MIN};
      for (int s = 0; s < count; ++s) AddSegment(view, segments[s], columns, report);
      if (columns.first <= columns.last) loaded_.push_back(columns);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  void AddSegment(const ContactView &view, const SurfaceSegment &segment, PointColumns &columns, ContactReport *report)
  {
    const Grid &grid = view.grid;
    const double h = grid.Geometry().spacing;
    const SurfaceGap gap = view.indenter.Gap(segment.x, view.time + view.dt);
    if (gap.distance > kContactRange * h) return;
    report->penetration = std::max(report->penetration, -view.indenter.Gap(segment.x, view.time).distance);
    if (!Faces(segment, gap.normal)) return;
    int node[2];
    double part[2];
    for (int axis = 0; axis < 2; ++axis) {
      const double a = (segment.x[axis] - grid.Geometry().lower[axis]) / h;
      node[axis] = static_cast<int>(std::floor(a));
      part[axis] = a - node[axis];
    }
    if (cell_.entries == 0 || node[0] != cell_.i || node[1] != cell_.j) OpenCell(grid, node[0], node[1]);
    auto entry = entries_.end() - cell_.entries;
    for (int c = 0; c < 2; ++c) {
      ContactRow &row = rows_[rows_.size() - 2 + c];
      const double weight = (c ? part[0] : 1 - part[0]) * segment.length * view.thickness, half = 0.5 * segment.length;
      row.weight += weight;
      row.gap += weight * gap.distance;
      row.left = std::min(row.left, std::max(segment.x[0] - half, row.x - h));
      row.right = std::max(row.right, std::min(segment.x[0] + half, row.x + h));
      for (; entry != entries_.end() && entry->key == row.key; ++entry) {
        const double Nx = entry->i == node[0] ? 1 - part[0] : part[0], Ny = entry->j == node[1] ? 1 - part[1] : part[1];
        const Vec3 B = weight * Nx * Ny * gap.normal;
        entry->test = entry->test + B;
        entry->force = entry->force + B;
      }
    }
    columns.first = std::min<std::int64_t>(columns.first, node[0]);
    columns.last = std::max<std::int64_t>(columns.last, node[0] + 1);
  }

  /// Two rows and an entry for each of their couplings with a node of the cell, for the segments to come: most lie in the
  /// cell of the one before.
  void OpenCell(const Grid &grid, int i, int j)
  {
    const std::size_t before = entries_.size();
    for (int column = i; column < i + 2; ++column) {
      rows_.push_back({column, 0, 0, grid.Coordinate(0, column), HUGE_VAL, -HUGE_VAL});
      for (int k = 0; k < 4; ++k)
        if (grid.IsLocal({i + k % 2, j + k / 2, 0})) entries_.push_back({column, i + k % 2, j + k / 2, {}, {}});
    }
    cell_ = {i, j, static_cast<int>(entries_.size() - before)};
  }

  int CountLoadedPoints() const
  {
    const ContactPressures &pressures = system_.Pressures();
    return static_cast<int>(std::count_if(loaded_.begin(), loaded_.end(), [&](const PointColumns &columns) {
      auto next = pressures.lower_bound(columns.first);
      return next != pressures.end() && next->first <= columns.last;
    }));
  }

  ContactSystem system_;
  std::vector<ContactRow> rows_;
  std::vector<ContactEntry> entries_;
  struct {
    int i, j, entries; ///< the last ones in entries_
  } cell_{};           ///< of the last segment
  std::vector<PointColumns> loaded_;
};

} // namespace

PetscErrorCode CreatePressureContact(bool monitor, std::unique_ptr<Contact> *contact)
{
  PetscFunctionBeginUser;
  auto created = std::make_unique<PressureContact>();
  PetscCall(created->Create(monitor));
  *contact = std::move(created);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
