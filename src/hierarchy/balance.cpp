// Weighted ownership ranges.
#include "hierarchy/balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

/// Points per node of a whole grid, with their sums over all rectangles from the first node.
class PointMap
{
public:
  PointMap(const std::vector<double> &points, int width)
      : width_(width), height_(static_cast<int>(points.size()) / width),
        sums_((width + 1) * static_cast<std::size_t>(height_ + 1), 0.0)
  {
    for (int j = 0; j < height_; ++j)
      for (int i = 0; i < width; ++i)
        Sum(i + 1, j + 1) = points[static_cast<std::size_t>(j) * width + i] + Sum(i, j + 1) + Sum(i + 1, j) - Sum(i, j);
  }
  int Width() const { return width_; }
  int Height() const { return height_; }
  double In(int i, int j, int columns, int rows) const
  {
    return Sum(i + columns, j + rows) - Sum(i, j + rows) - Sum(i + columns, j) + Sum(i, j);
  }
  std::vector<double> Marginal(int axis) const
  {
    std::vector<double> sums;
    for (int k = 0; k < (axis == 0 ? width_ : height_); ++k)
      sums.push_back(axis == 0 ? In(k, 0, 1, height_) : In(0, k, width_, 1));
    return sums;
  }

private:
  double Sum(int i, int j) const { return sums_[static_cast<std::size_t>(j) * (width_ + 1) + i]; }
  double &Sum(int i, int j) { return sums_[static_cast<std::size_t>(j) * (width_ + 1) + i]; }
  int width_, height_;
  std::vector<double> sums_;
};

bool FitsBlocks(int nodes, int blocks) { return blocks == 1 || nodes >= blocks * kHaloWidth; }

void Divide(int columns, int rows, const std::vector<double> &by_column, const std::vector<double> &by_row, GridLayout *layout)
{
  layout->widths[0] = DivideByWeight(by_column, columns, kHaloWidth);
  layout->widths[1] = DivideByWeight(by_row, rows, kHaloWidth);
}

/// Work of a block in points: a halo node costs about as much as a point.
double Work(const PointMap &map, int i, int j, int columns, int rows)
{
  const double halo = 2.0 * kHaloWidth * ((columns < map.Width()) * rows + (rows < map.Height()) * columns);
  return halo + map.In(i, j, columns, rows);
}

/// Work of the busiest block.
double LargestWork(const PointMap &map, const GridLayout &layout)
{
  double largest = 0;
  int j = 0;
  for (const PetscInt rows : layout.widths[1]) {
    int i = 0;
    for (const PetscInt columns : layout.widths[0]) {
      largest = std::max(largest, Work(map, i, j, columns, rows));
      i += columns;
    }
    j += rows;
  }
  return largest;
}

/// Work of columns [i, i + columns) in the busiest of the rows of blocks that `layout` has; of rows, where axis is 1.
double LargestWork(const PointMap &map, const GridLayout &layout, int axis, int i, int columns)
{
  double largest = 0;
  int j = 0;
  for (const PetscInt rows : layout.widths[1 - axis]) {
    largest = std::max(largest, axis == 0 ? Work(map, i, j, columns, rows) : Work(map, j, i, rows, columns));
    j += rows;
  }
  return largest;
}

/// Cuts along an axis into as many ranges as `layout` has, none with more work than `limit`; false where that cannot be.
bool CutWithin(const PointMap &map, int axis, double limit, GridLayout *layout)
{
  const int nodes = axis == 0 ? map.Width() : map.Height();
  std::vector<PetscInt> widths;
  int start = 0;
  for (int left = static_cast<int>(layout->widths[axis].size()) - 1; left >= 0; --left) {
    const int most = nodes - start - left * kHaloWidth; // leaves room for the ranges to come
    int width = std::min(kHaloWidth, most);
    while (width < most && LargestWork(map, *layout, axis, start, width + 1) <= limit) ++width;
    if (LargestWork(map, *layout, axis, start, width) > limit) return false;
    widths.push_back(width);
    start += width;
  }
  if (start < nodes) return false;
  layout->widths[axis] = widths;
  return true;
}

/// Takes work from the busiest block by the best cuts along each axis in turn, those along the other being kept.
void ImproveCuts(const PointMap &map, GridLayout *layout)
{
  constexpr double kTolerance = 1e-4;
  double before = HUGE_VAL, work = LargestWork(map, *layout);
  while (work < before) {
    before = work;
    for (const int axis : {0, 1}) {
      double lower = 0, upper = work;
      while (upper - lower > kTolerance * work) {
        const double middle = 0.5 * (lower + upper);
        (CutWithin(map, axis, middle, layout) ? upper : lower) = middle;
      }
      work = LargestWork(map, *layout);
    }
  }
}

/// The best split into this many blocks; false where there is none.
bool BestSplit(const PointMap &map, int blocks, GridLayout *best)
{
  const std::vector<double> by_column = map.Marginal(0), by_row = map.Marginal(1);
  double least = HUGE_VAL;
  for (int columns = 1; columns <= blocks; ++columns) {
    GridLayout layout;
    if (blocks % columns || !FitsBlocks(map.Width(), columns) || !FitsBlocks(map.Height(), blocks / columns)) continue;
    Divide(columns, blocks / columns, by_column, by_row, &layout);
    ImproveCuts(map, &layout);
    if (const double work = LargestWork(map, layout); work < least) {
      least = work;
      *best = layout;
    }
  }
  return std::isfinite(least);
}

} // namespace

/// How many ranks suit a number of points.
static int SuitableRanks(double points, int ranks, double least_points)
{
  return static_cast<int>(std::clamp(points / least_points, 1.0, static_cast<double>(ranks)));
}

void FirstLayout(int ranks, double least_points, const std::vector<double> &points, int width, GridLayout *layout)
{
  const double total = std::accumulate(points.begin(), points.end(), 0.0);
  int blocks = SuitableRanks(total, ranks, least_points);
  const PointMap map(points, width);
  while (!BestSplit(map, blocks, layout)) --blocks;
  layout->ranks.resize(blocks);
  std::iota(layout->ranks.begin(), layout->ranks.end(), 0);
}

bool NeedsOtherRanks(double points, int blocks, int ranks, double least_points)
{
  const double each = points / blocks;
  return (each < 0.5 * least_points || each > 2 * least_points) && SuitableRanks(points, ranks, least_points) != blocks;
}

PetscErrorCode BetterLayout(MPI_Comm world, Level &level, double least_points, GridLayout *layout, bool *changed)
{
  constexpr double kWorthWhile = 0.98; // of the busiest block's work
  const Grid &grid = level.Mesh();
  const GridGeometry &geometry = grid.Geometry();
  const int width = geometry.Nodes(0);
  std::vector<double> counts(static_cast<std::size_t>(width) * geometry.Nodes(1), 0.0);
  PointArrays points;
  PetscMPIInt ranks;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(world, &ranks));
  PetscCall(level.PointStore().Arrays(&points));
  for (int p = 0; p < points.count; ++p) {
    const int i = grid.Nearest(0, points.position[2 * p]) + geometry.padding,
              j = grid.Nearest(1, points.position[2 * p + 1]) + geometry.padding;
    ++counts[static_cast<std::size_t>(j) * width + i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_DOUBLE, MPI_SUM, world));
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  if (NeedsOtherRanks(total, grid.Layout().Blocks(), ranks, least_points)) {
    FirstLayout(ranks, least_points, counts, width, layout);
    *changed = layout->Blocks() != grid.Layout().Blocks();
    if (*changed) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PointMap map(counts, width);
  const auto &widths = grid.Layout().widths;
  Divide(static_cast<int>(widths[0].size()), static_cast<int>(widths[1].size()), map.Marginal(0), map.Marginal(1), layout);
  ImproveCuts(map, layout);
  layout->ranks = grid.Layout().ranks;
  *changed = LargestWork(map, *layout) < kWorthWhile * LargestWork(map, grid.Layout());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
