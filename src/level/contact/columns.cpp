// Sums over the surface of the body by columns of the grid.
#include "level/contact/columns.hpp"

#include <algorithm>
#include <climits>

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

Vec3 CornerHatSlope(Vec3 part, int c, int axes, double spacing, double width)
{
  Vec3 slope{};
  if (CornerHat(part, c, axes, width) == 0) return slope;
  for (int a = 0; a < axes; ++a) {
    slope[a] = (c >> a & 1 ? 1 : -1) / (width * spacing);
    for (int b = 0; b < axes; ++b)
      if (b != a) slope[a] *= 1 - (c >> b & 1 ? 1 - part[b] : part[b]) / width;
  }
  return slope;
}

/// Whether the tip moves along the surface in the step.
static bool MovesSideways(const ContactView &view)
{
  bool moves = false;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a) moves = moves || view.tip.end[a] != view.tip.start[a];
  return moves;
}

Vec3 GapGradient(const ContactView &view, const PressedSegment &segment, int corner, double width)
{
  const int axes = view.geometry.Dim() - 1;
  const double kernel = CornerHat(segment.place.part, corner, axes, width), spacing = view.grid.Geometry().spacing;
  Vec3 change = kernel * segment.normal;
  if (segment.flows && !MovesSideways(view)) {
    change = change + segment.gap * CornerHatSlope(segment.place.part, corner, axes, spacing, width);
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

/// Adds columns of one rank to those of another, as MPI asks for it.
static void AddColumns(void *other, void *sum, int *count, MPI_Datatype *)
{
  const auto *from = static_cast<const ContactColumn *>(other);
  auto *to = static_cast<ContactColumn *>(sum);
  for (int k = 0; k < *count; ++k) {
    to[k].kernel_area += from[k].kernel_area;
    to[k].flowing += from[k].flowing;
    to[k].sound += from[k].sound;
    to[k].gap += from[k].gap;
    to[k].area += from[k].area;
    for (int i = 0; i < 9; ++i) to[k].share[i] += from[k].share[i];
    to[k].left = std::min(to[k].left, from[k].left);
    to[k].right = std::max(to[k].right, from[k].right);
  }
}

ContactColumns::~ContactColumns()
{
  if (add_ != MPI_OP_NULL) MPI_Op_free(&add_);
}

/// The columns to add up: those of the group's zone, or where none is known those under the segments of all ranks.
PetscErrorCode ContactColumns::FindBox(const ContactView &view, const std::vector<PressedSegment> &segments)
{
  const int dim = view.geometry.Dim();
  int bounds[4] = {INT_MIN, INT_MIN, INT_MIN, INT_MIN}; // minus the lower, then the upper ones
  PetscFunctionBeginUser;
  box_ = view.group.Zone();
  for (int a = dim - 1; a < 3; ++a) box_.lower[a] = 0, box_.upper[a] = 1;
  if (box_.lower[0] > INT_MIN) PetscFunctionReturn(PETSC_SUCCESS);
  for (const PressedSegment &segment : segments)
    for (int a = 0; a < dim - 1; ++a) {
      bounds[a] = std::max(bounds[a], -segment.place.column[a]);
      bounds[2 + a] = std::max(bounds[2 + a], segment.place.column[a] + 2);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 4, MPI_INT, MPI_MAX, view.group.Comm()));
  box_ = {};
  if (bounds[0] > INT_MIN)
    for (int a = 0; a < 3; ++a) {
      box_.lower[a] = a < dim - 1 ? -bounds[a] : 0;
      box_.upper[a] = a < dim - 1 ? bounds[2 + a] : 1;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where held sides end the surface along the first axis, m. Faces of points that are drawn out beside one reach beyond it.
static double EndOfSurface(const ContactView &view, Side side)
{
  if (view.sides.kind[side] == BoundaryKind::kFree) return SignOf(side) * HUGE_VAL;
  return view.grid.Coordinate(0, view.sides.node[side]);
}

void ContactColumns::Add(const ContactView &view, double width, const PressedSegment &segment)
{
  const int dim = view.geometry.Dim(), corners = 1 << (dim - 1);
  const double h = view.grid.Geometry().spacing;
  const CellPlace &place = segment.place;
  const double left = std::max(segment.left, EndOfSurface(view, kXLower)),
               right = std::min(segment.right, EndOfSurface(view, kXUpper));
  double hat[4];
  for (int c = 0; c < corners; ++c) hat[c] = CornerHat(place.part, c, dim - 1);
  for (int c = 0; c < corners; ++c) {
    const Index at = Corner(place.column, c);
    const double kernel = segment.area * (width == 1 ? hat[c] : CornerHat(place.part, c, dim - 1, width));
    const double x = view.grid.Coordinate(0, at[0]);
    ContactColumn &column = columns_[Place(at)];
    column.kernel_area += kernel;
    column.flowing += segment.flows ? kernel : 0;
    column.sound += kernel * segment.sound;
    column.gap += kernel * segment.gap;
    column.area -= segment.area * hat[c] * segment.normal[dim - 1];
    for (int i = 0; i < corners; ++i) {
      const int offset = 4 + (i & 1) - (c & 1) + 3 * ((i >> 1) - (c >> 1));
      column.share[offset] -= kernel * hat[i] * segment.normal[dim - 1];
    }
    column.left = std::min(column.left, std::max(left, x - h));
    column.right = std::max(column.right, std::min(right, x + h));
  }
}

/// Leaves the columns that have some surface.
void ContactColumns::Crop()
{
  const IndexBox whole = box_;
  const std::vector<ContactColumn> all = std::move(columns_);
  const auto in_all = [&](Index at) { return (at[1] - whole.lower[1]) * whole.Size(0) + at[0] - whole.lower[0]; };
  box_ = {whole.upper, whole.lower};
  box_.lower[2] = 0, box_.upper[2] = 1;
  ForEach(whole, [&](Index at) {
    if (all[in_all(at)].left == HUGE_VAL) return;
    for (int a = 0; a < 2; ++a) {
      box_.lower[a] = std::min(box_.lower[a], at[a]);
      box_.upper[a] = std::max(box_.upper[a], at[a] + 1);
    }
  });
  columns_.clear();
  ForEach(box_, [&](Index at) { columns_.push_back(all[in_all(at)]); });
}

PetscErrorCode ContactColumns::Sum(const ContactView &view, double width, const std::vector<PressedSegment> &segments,
                                   double *least_gap, SendPattern *pattern, bool *at_border)
{
  constexpr int kHalf = 32; // bits; a double holds so many without rounding, and no two ranks set the same
  PetscFunctionBeginUser;
  if (add_ == MPI_OP_NULL) {
    PetscCall(column_unit_.Create(sizeof(ContactColumn) / sizeof(double)));
    PetscCallMPI(MPI_Op_create(AddColumns, 1, &add_));
  }
  PetscCall(FindBox(view, segments));
  columns_.assign(box_.Count(), {});
  for (const PressedSegment &segment : segments) Add(view, width, segment);
  ContactColumn &other = columns_.emplace_back(); // what goes along, as it is added up, and its least found, in the same way
  other.left = *least_gap, other.flowing = *at_border;
  other.area = static_cast<double>(*pattern >> kHalf),
  other.gap = static_cast<double>(*pattern & ((SendPattern(1) << kHalf) - 1));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, columns_.data(), static_cast<int>(columns_.size()), column_unit_, add_, view.group.Comm()));
  *least_gap = columns_.back().left, *at_border = columns_.back().flowing > 0;
  *pattern = static_cast<SendPattern>(columns_.back().area) << kHalf | static_cast<SendPattern>(columns_.back().gap);
  columns_.pop_back();
  Crop();
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<double> ContactColumns::Pressures(const std::vector<double> &lambda) const
{
  std::vector<double> pressures(columns_.size());
  ForEach(box_, [&](Index j) {
    if (lambda[Place(j)] == 0) return;
    for (int offset = 0; offset < 9; ++offset) {
      const Index i = j + Index{offset % 3 - 1, offset / 3 - 1, 0};
      if (box_.Contains(i)) pressures[Place(i)] += At(j).share[offset] * lambda[Place(j)];
    }
  });
  for (std::size_t i = 0; i < pressures.size(); ++i) pressures[i] = pressures[i] > 0 ? pressures[i] / columns_[i].area : 0;
  return pressures;
}

bool CrossesBorder(const ContactView &view, Index column)
{
  const int up = view.geometry.Dim() - 1;
  column[up] = Locate(view.grid, view.tip.start, view.geometry.Dim()).cell[up];
  return view.border && view.border->BlendOf(column).beta == 0;
}

double FullKernelArea(const ContactView &view, double width, Index column)
{
  const double half = 0.5 * width * view.grid.Geometry().spacing, x = view.grid.Coordinate(0, column[0]);
  double area = 1;
  for (int a = 0; a < view.geometry.Dim() - 1; ++a) {
    double sum = 0; // over the halves of the kernel in the domain, each with its centroid
    for (int upper = 0; upper < 2; ++upper) {
      const Side side = static_cast<Side>(2 * a + upper);
      if (view.sides.kind[side] != BoundaryKind::kFree && view.sides.Reaches(side, column)) continue;
      sum += half * (a == 0 ? view.geometry.OutOfPlane(x + (upper ? 2.0 : -2.0) / 3 * half) : 1);
    }
    area *= sum;
  }
  return area;
}

} // namespace mlgimp
