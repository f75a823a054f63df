// Sums over segments of the surface, cell by cell.
#include "level/contact/surface.hpp"

#include <cmath>

namespace mlgimp
{

CellPlace Locate(const Grid &grid, Vec3 x, int dim)
{
  CellPlace place{};
  for (int a = 0; a < dim; ++a) {
    const double from_first = (x[a] - grid.Geometry().lower[a]) / grid.Geometry().spacing, cell = std::floor(from_first);
    place.cell[a] = static_cast<int>(cell);
    place.part[a] = from_first - cell;
    if (a < dim - 1) place.column[a] = place.cell[a];
  }
  return place;
}

/// The gradient of a column's kernel where it is not zero, 1/m, for cells of a size.
static Vec3 KernelSlope(Vec3 part, int c, int axes, double spacing, double width)
{
  Vec3 slope{};
  for (int a = 0; a < axes; ++a) {
    slope[a] = (c >> a & 1 ? 1 : -1) / (width * spacing);
    for (int b = 0; b < axes; ++b)
      if (b != a) slope[a] *= 1 - (c >> b & 1 ? 1 - part[b] : part[b]) / width;
  }
  return slope;
}

bool MovesSideways(const ContactView &view)
{
  bool moves = false;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a) moves = moves || view.tip.end[a] != view.tip.start[a];
  return moves;
}

/// How the weighted gap of a column at a corner of its cell changes as a segment moves, m2: w_s (K_j n + g_s grad K_j), in
/// axisymmetry + w_s K_j g_s/r along the radius. Without the terms by the gap, where surface flows past columns, closing gaps
/// would give work that the indenter has not done. Elastic surfaces do not flow, and leave them out, as does a tip that moves
/// sideways: it passes the columns, so that they would push the body without pushing the indenter. kernel: K_j.
static Vec3 GapGradient(const ContactView &view, const PressedSegment &segment, int corner, double kernel, double width)
{
  const int axes = view.geometry.Dim() - 1;
  Vec3 change = kernel * segment.normal;
  if (segment.flows && kernel > 0 && !MovesSideways(view)) {
    change = change + segment.gap * KernelSlope(segment.place.part, corner, axes, view.grid.Geometry().spacing, width);
    if (view.geometry.HasHoop()) change[0] += segment.gap * kernel / (0.5 * (segment.left + segment.right));
  }
  return segment.area * change;
}

Vec3 SurfaceTangent(Vec3 normal, int axis, int up)
{
  constexpr double kOpposite = 1e-12; // of a normal that points up there is no smallest turn; an indenter's tip has none
  Vec3 tangent{}, middle = -1 * normal;
  const double turned = -normal[axis] / std::max(1 - normal[up], kOpposite);
  middle[up] += 1;
  tangent[axis] = 1;
  return tangent - turned * middle;
}

/// How the weighted slip of a column along an axis grows as a segment moves, m2. At a side that is held across that axis there
/// is none: tractions of both its sides are opposite. kernel: K_j.
static Vec3 SlipGradient(const ContactView &view, const PressedSegment &segment, int corner, double kernel, int axis)
{
  const Index column = Corner(segment.place.column, corner);
  for (const Side side : SidesAcross(axis))
    if (view.sides.kind[side] != BoundaryKind::kFree && view.sides.Reaches(side, column)) return {};
  return segment.area * kernel * SurfaceTangent((1 / Norm(segment.normal)) * segment.normal, axis, view.geometry.Dim() - 1);
}

/// Adds a segment to the columns at the corners of its cell. up: its place among the components.
static void AddToColumns(const PressedSegment &segment, int up, const std::array<double, 4> &hats,
                         const std::array<double, 4> &kernels, PressedSurface::Cell *cell)
{
  const double area = segment.area, gap = segment.gap, sound = segment.sound, flows = segment.flows ? 1 : 0,
               upward = segment.normal[up];
  for (int c = 0; c < 4; ++c) {
    const double kernel = area * kernels[c];
    cell->kernel_area[c] += kernel;
    cell->flowing[c] += flows * kernel;
    cell->sound[c] += sound * kernel;
    cell->gap[c] += gap * kernel;
    cell->area[c] -= upward * area * hats[c];
  }
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < 4; ++i) cell->share[c][i] -= upward * area * kernels[c] * hats[i];
  cell->left = std::min(cell->left, segment.left);
  cell->right = std::max(cell->right, segment.right);
}

void PressedSurface::Clear(const ContactView &view, const ContactSettings &settings)
{
  width_ = settings.width;
  per_column_ = UnknownsPerColumn(settings, view.geometry);
  here_ = Intersection(view.grid.Ghosted(), view.group.Zone());
  for (int a = 0; a < view.geometry.Dim(); ++a) --here_.upper[a];
  cell_here_.assign(here_.Count(), -1);
  cells_.clear();
  couplings_.clear();
  parts_.clear();
}

std::size_t PressedSurface::FindCell(const CellPlace &place)
{
  int &cell = cell_here_[here_.Place(place.cell)];
  if (cell < 0) {
    cell = static_cast<int>(cells_.size());
    cells_.emplace_back().cell = place.cell, cells_.back().column = place.column;
    couplings_.resize(couplings_.size() + 4 * per_column_);
  }
  return cell;
}

void PressedSurface::Add(const ContactView &view, int point, const PressedSegment &segment)
{
  if (!here_.Contains(segment.place.cell)) return;
  const int dim = view.geometry.Dim(), columns = 1 << (dim - 1);
  const std::size_t cell = FindCell(segment.place);
  const double up = segment.place.part[dim - 1];
  const std::array<double, 4> hats = ColumnHats(segment.place.part, dim), kernels = ColumnHats(segment.place.part, dim, width_);
  double at_nodes[8] = {};
  for (int k = 0; k < 2 * columns; ++k) at_nodes[k] = hats[k % columns] * (k < columns ? 1 - up : up);
  AddToColumns(segment, dim - 1, hats, kernels, &cells_[cell]);
  if (parts_.empty() || parts_.back().point != point || parts_.back().cell != cell) parts_.push_back({point, cell, {}, {}});
  PointPart &part = parts_.back();
  NodeCouplings *with = &couplings_[4 * cell * per_column_];
  for (int c = 0; c < columns; ++c) {
    part.area[c] += segment.area * hats[c];
    part.under_kernel[c] |= kernels[c] > 0;
    for (int u = 0; u < per_column_; ++u, ++with) {
      const Vec3 change =
          u == 0 ? GapGradient(view, segment, c, kernels[c], width_) : SlipGradient(view, segment, c, kernels[c], u - 1);
      for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 8; ++k) with->B[a][k] += change[a] * at_nodes[k];
    }
  }
}

} // namespace mlgimp
