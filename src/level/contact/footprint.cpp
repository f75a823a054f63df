// Columns in contact are those that carry load and what touches between them.
#include "level/contact/footprint.hpp"
#include "level/contact/width.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// Whether the surface goes on under a column: at the end of a body it has less than its half.
static bool GoesOn(const ContactView &view, const ContactColumns &columns, Index at)
{
  constexpr double kReached = 0.4; // of a column's area; a surface that ends at its place has a half
  return columns.Box().Contains(at) && columns.At(at).area > kReached * FullKernelArea(view, 1, at);
}

/// Whether a column is in contact: it is loaded, or it touches between two that are, or between one and the body's end. The
/// column next to a punch's edge, where the pressure has no bound, is often the one that carries nothing, with a gap that grows
/// as the surface leans over the edge; and on metal that flows every other column may, as the nodes hardly feel what neighbours
/// take from each other.
static bool IsPressed(const ContactView &view, const ContactColumns &columns, Index at, const std::vector<double> &lambda)
{
  const ContactColumn &column = columns.At(at);
  const double touches = column.flowing > 0 ? 0.3 : 0.1; // cells
  const auto loaded = [&](Index i) { return columns.Box().Contains(i) && lambda[columns.Place(i)] > 0; };
  const auto closes = [&](Index i) { return loaded(i) || !GoesOn(view, columns, i); };
  if (loaded(at)) return true;
  bool between = false;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a) {
    Index before = at, after = at;
    --before[a], ++after[a];
    between = between || (closes(before) && closes(after) && (loaded(before) || loaded(after)));
  }
  return between && column.gap < touches * view.grid.Geometry().spacing * column.kernel_area;
}

/// The projected area of a column in contact, m2: that of its faces. Metal that flows draws them out unevenly, so that they
/// leave gaps and overlap: where the surface goes on under all columns beside it, and these are in contact, all of the column is
/// taken to be covered.
static double PressedArea(const ContactView &view, const ContactColumns &columns, Index at, const std::vector<bool> &pressed)
{
  bool inside = columns.At(at).flowing > 0;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a)
    for (const Side side : SidesAcross(a)) {
      Index next = at;
      next[a] += SignOf(side);
      if (view.sides.kind[side] != BoundaryKind::kFree && view.sides.Reaches(side, at)) continue;
      inside = inside && GoesOn(view, columns, next) && pressed[columns.Place(next)];
    }
  return inside ? FullKernelArea(view, 1, at) : columns.At(at).area;
}

/// How many models of this kind make the whole tip: 2 for each side of symmetry that it is on.
static int PartsOfTip(const ContactView &view)
{
  const GridGeometry &grid = view.grid.Geometry();
  int parts = 1;
  for (int s = 0; s < 2 * (view.geometry.Dim() - 1); ++s) {
    const double from_side = view.tip.start[s / 2] - view.grid.Coordinate(s / 2, view.sides.node[s]);
    if (view.sides.kind[s] == BoundaryKind::kSymmetry && std::abs(from_side) < 1e-6 * grid.spacing) parts *= 2;
  }
  return parts;
}

void MeasureFootprint(const ContactView &view, const ContactColumns &columns, const std::vector<double> &lambda,
                      ContactReport *report)
{
  const int dim = view.geometry.Dim();
  std::vector<SurfaceRange> ranges;
  std::vector<bool> pressed;
  ForEach(columns.Box(), [&](Index at) {
    ranges.push_back({view.grid.Coordinate(0, at[0]), columns.At(at).left, columns.At(at).right});
    pressed.push_back(IsPressed(view, columns, at, lambda));
  });
  ForEach(columns.Box(), [&](Index at) {
    if (!pressed[columns.Place(at)]) return;
    report->area += PressedArea(view, columns, at, pressed);
    report->crosses = report->crosses || CrossesBorder(view, at);
    for (int a = 0; a < dim - 1; ++a)
      report->reach = std::max(report->reach, std::abs(view.grid.Coordinate(a, at[a]) - view.tip.start[a]));
  });
  const double rounding = 1e-6 * view.grid.Geometry().spacing;
  for (const double pressure : columns.Pressures(lambda)) report->peak_pressure = std::max(report->peak_pressure, pressure);
  report->half_width = dim == 3 ? std::sqrt(PartsOfTip(view) * report->area / PETSC_PI)
                                : HalfWidth(ranges, lambda, true, view.tip.start[0], rounding);
}

} // namespace mlgimp
