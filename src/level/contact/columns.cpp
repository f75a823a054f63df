// Sums over the surface of all ranks by columns of the grid.
#include "level/contact/columns.hpp"

#include <algorithm>
#include <climits>

namespace mlgimp
{

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
PetscErrorCode ContactColumns::FindBox(const ContactView &view, const PressedSurface &surface)
{
  const int dim = view.geometry.Dim();
  PetscFunctionBeginUser;
  box_ = view.group.Zone();
  for (int a = dim - 1; a < 3; ++a) box_.lower[a] = 0, box_.upper[a] = 1;
  if (box_.lower[0] > INT_MIN) PetscFunctionReturn(PETSC_SUCCESS);
  box_ = kNowhere;
  for (const PressedSurface::Cell &cell : surface.Cells())
    for (const int corner : {0, (1 << (dim - 1)) - 1}) box_.Include(Corner(cell.column, corner));
  for (int &lower : box_.lower) lower = -lower; // of all ranks the lowest
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &box_, sizeof box_ / sizeof(int), MPI_INT, MPI_MAX, view.group.Comm()));
  for (int &lower : box_.lower) lower = -lower;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where held sides end the surface along the first axis, m. Faces of points that are drawn out beside one reach beyond it.
static double EndOfSurface(const ContactView &view, Side side)
{
  if (view.sides.kind[side] == BoundaryKind::kFree) return SignOf(side) * HUGE_VAL;
  return view.grid.Coordinate(0, view.sides.node[side]);
}

/// Adds what a cell has of the column at one of its corners.
void ContactColumns::Add(const ContactView &view, const PressedSurface::Cell &cell, int c)
{
  const Index at = Corner(cell.column, c);
  const double x = view.grid.Coordinate(0, at[0]), h = view.grid.Geometry().spacing;
  ContactColumn &column = columns_[Place(at)];
  column.kernel_area += cell.kernel_area[c];
  column.flowing += cell.flowing[c];
  column.sound += cell.sound[c];
  column.gap += cell.gap[c];
  column.area += cell.area[c];
  double *const share = column.share + 4 - (c & 1) - 3 * (c >> 1); // on the column at the first corner
  for (int i = 0; i < 4; ++i)
    if (cell.share[c][i] != 0) share[(i & 1) + 3 * (i >> 1)] += cell.share[c][i]; // in the plane there are two
  column.left = std::min(column.left, std::max({cell.left, x - h, EndOfSurface(view, kXLower)}));
  column.right = std::max(column.right, std::min({cell.right, x + h, EndOfSurface(view, kXUpper)}));
}

/// Leaves the columns that have some surface.
void ContactColumns::Crop()
{
  const IndexBox whole = box_;
  const std::vector<ContactColumn> all = std::move(columns_);
  box_ = kNowhere;
  ForEach(whole, [&](Index at) {
    if (all[whole.Place(at)].left != HUGE_VAL) box_.Include(at);
  });
  columns_.clear();
  ForEach(box_, [&](Index at) { columns_.push_back(all[whole.Place(at)]); });
}

PetscErrorCode ContactColumns::Sum(const ContactView &view, const PressedSurface &surface, double *least_gap,
                                   SendPattern *pattern, bool *at_border)
{
  constexpr int kHalf = 32; // bits; a double holds so many without rounding, and no two ranks set the same
  PetscFunctionBeginUser;
  if (add_ == MPI_OP_NULL) {
    PetscCall(column_unit_.Create(sizeof(ContactColumn) / sizeof(double)));
    PetscCallMPI(MPI_Op_create(AddColumns, 1, &add_));
  }
  PetscCall(FindBox(view, surface));
  columns_.assign(box_.Count(), {});
  for (const PressedSurface::Cell &cell : surface.Cells())
    for (int c = 0; c < 1 << (view.geometry.Dim() - 1); ++c) Add(view, cell, c);
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
