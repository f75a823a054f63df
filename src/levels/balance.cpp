// Weighted ownership ranges.
#include "levels/balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

/// Points per node of a whole grid, row by row.
struct PointMap {
  const std::vector<double> &points;
  int width;
  int Height() const { return static_cast<int>(points.size()) / width; }
  std::vector<double> Marginal(int axis) const
  {
    std::vector<double> sums(axis == 0 ? width : Height(), 0.0);
    for (std::size_t k = 0; k < points.size(); ++k) sums[axis == 0 ? k % width : k / width] += points[k];
    return sums;
  }
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
  for (int row = 0, j = 0; row < static_cast<int>(layout.widths[1].size()); j += layout.widths[1][row++])
    for (int column = 0, i = 0; column < static_cast<int>(layout.widths[0].size()); i += layout.widths[0][column++]) {
      const int m = layout.widths[0][column], n = layout.widths[1][row];
      double work = 2.0 * kHaloWidth * ((m < map.width) * n + (n < map.Height()) * m);
      for (int b = j; b < j + n; ++b)
        for (int a = i; a < i + m; ++a) work += map.points[static_cast<std::size_t>(b) * map.width + a];
      largest = std::max(largest, work);
    }
  return largest;
}

/// The best split into this many blocks; false where there is none.
bool BestSplit(const PointMap &map, int blocks, GridLayout *best)
{
  const std::vector<double> by_column = map.Marginal(0), by_row = map.Marginal(1);
  double least = HUGE_VAL;
  for (int columns = 1; columns <= blocks; ++columns) {
    GridLayout layout;
    if (blocks % columns || !FitsBlocks(map.width, columns) || !FitsBlocks(map.Height(), blocks / columns)) continue;
    Divide(columns, blocks / columns, by_column, by_row, &layout);
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
  while (!BestSplit({points, width}, blocks, layout)) --blocks;
  layout->ranks.resize(blocks);
  std::iota(layout->ranks.begin(), layout->ranks.end(), 0);
}

PetscErrorCode ProposeLayout(MPI_Comm world, Level &level, GridLayout *layout, bool *changed)
{
  const Grid &grid = level.Mesh();
  const GridGeometry &geometry = grid.Geometry();
  PointArrays points;
  PetscFunctionBeginUser;
  PetscCall(level.PointStore().Arrays(&points));
  std::vector<double> counts[2];
  for (int axis = 0; axis < 2; ++axis) {
    counts[axis].assign(geometry.Nodes(axis), 0.0);
    for (int p = 0; p < points.count; ++p) ++counts[axis][grid.Nearest(axis, points.position[2 * p + axis]) + geometry.padding];
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts[axis].data(), geometry.Nodes(axis), MPI_DOUBLE, MPI_SUM, world));
  }
  const auto &widths = grid.Layout().widths;
  Divide(static_cast<int>(widths[0].size()), static_cast<int>(widths[1].size()), counts[0], counts[1], layout);
  layout->ranks = grid.Layout().ranks;
  *changed = layout->widths != grid.Layout().widths;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
