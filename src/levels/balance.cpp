// Weighted ownership ranges.
#include "levels/balance.hpp"

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

/// Work of the busiest block in points: a halo node costs about as much as a point.
double LargestWork(const PointMap &map, const GridLayout &layout)
{
  double largest = 0;
  int j = 0;
  for (const PetscInt rows : layout.widths[1]) {
    int i = 0;
    for (const PetscInt columns : layout.widths[0]) {
      const double halo = 2.0 * kHaloWidth * ((columns < map.Width()) * rows + (rows < map.Height()) * columns);
      largest = std::max(largest, halo + map.In(i, j, columns, rows));
      i += columns;
    }
    j += rows;
  }
  return largest;
}

/// Moves single cuts by a node while that takes work from the busiest block.
void ShiftCuts(const PointMap &map, GridLayout *layout)
{
  constexpr int kMostSweeps = 100;
  double work = LargestWork(map, *layout);
  bool better = true;
  for (int sweep = 0; better && sweep < kMostSweeps; ++sweep) {
    better = false;
    for (auto &widths : layout->widths)
      for (std::size_t k = 0; k + 1 < widths.size(); ++k)
        for (const int step : {-1, 1}) {
          if (widths[k] + step < kHaloWidth || widths[k + 1] - step < kHaloWidth) continue;
          widths[k] += step, widths[k + 1] -= step;
          const double now = LargestWork(map, *layout);
          if (now < work)
            work = now, better = true;
          else
            widths[k] -= step, widths[k + 1] += step;
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
    ShiftCuts(map, &layout);
    if (const double work = LargestWork(map, layout); work < least) {
      least = work;
      *best = layout;
    }
  }
  return std::isfinite(least);
}

} // namespace

void MakeLayout(int ranks, double least_points, const std::vector<double> &points, int width, GridLayout *layout)
{
  const double total = std::accumulate(points.begin(), points.end(), 0.0);
  int blocks = static_cast<int>(std::clamp(total / least_points, 1.0, static_cast<double>(ranks)));
  const PointMap map(points, width);
  while (!BestSplit(map, blocks, layout)) --blocks;
  layout->ranks.resize(blocks);
  std::iota(layout->ranks.begin(), layout->ranks.end(), 0);
}

PetscErrorCode ProposeLayout(MPI_Comm world, Level &level, GridLayout *layout, bool *changed)
{
  constexpr double kWorthWhile = 0.98; // of the busiest block's work
  const Grid &grid = level.Mesh();
  const GridGeometry &geometry = grid.Geometry();
  const int width = geometry.Nodes(0);
  std::vector<double> counts(static_cast<std::size_t>(width) * geometry.Nodes(1), 0.0);
  PointArrays points;
  PetscFunctionBeginUser;
  PetscCall(level.PointStore().Arrays(&points));
  for (int p = 0; p < points.count; ++p) {
    const int i = grid.Nearest(0, points.position[2 * p]) + geometry.padding,
              j = grid.Nearest(1, points.position[2 * p + 1]) + geometry.padding;
    ++counts[static_cast<std::size_t>(j) * width + i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_DOUBLE, MPI_SUM, world));
  const PointMap map(counts, width);
  const auto &widths = grid.Layout().widths;
  Divide(static_cast<int>(widths[0].size()), static_cast<int>(widths[1].size()), map.Marginal(0), map.Marginal(1), layout);
  ShiftCuts(map, layout);
  layout->ranks = grid.Layout().ranks;
  *changed = LargestWork(map, *layout) < kWorthWhile * LargestWork(map, grid.Layout());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
