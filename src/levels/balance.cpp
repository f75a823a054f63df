// Weighted ownership ranges.
#include "levels/balance.hpp"

#include <algorithm>
#include <numeric>

namespace mlgimp
{

/// Number of columns of blocks with the shortest inner borders; 0 where no split leaves wide enough blocks.
static int BestColumns(int blocks, int width, int height)
{
  int best = 0;
  double shortest = HUGE_VAL;
  for (int m = 1; m <= blocks; ++m) {
    const int n = blocks / m;
    if (m * n != blocks || (m > 1 && width < m * kHaloWidth) || (n > 1 && height < n * kHaloWidth)) continue;
    const double border = static_cast<double>(m - 1) * height + static_cast<double>(n - 1) * width;
    if (border < shortest) {
      shortest = border;
      best = m;
    }
  }
  return best;
}

static void Divide(int blocks, const std::vector<double> &columns, const std::vector<double> &rows, GridLayout *layout)
{
  const int best = BestColumns(blocks, static_cast<int>(columns.size()), static_cast<int>(rows.size()));
  layout->widths[0] = DivideByWeight(columns, best, kHaloWidth);
  layout->widths[1] = DivideByWeight(rows, blocks / best, kHaloWidth);
}

void MakeLayout(int ranks, double least_points, const std::vector<double> &columns, const std::vector<double> &rows,
                GridLayout *layout)
{
  const double points = std::accumulate(columns.begin(), columns.end(), 0.0);
  int blocks = static_cast<int>(std::clamp(points / least_points, 1.0, static_cast<double>(ranks)));
  while (BestColumns(blocks, static_cast<int>(columns.size()), static_cast<int>(rows.size())) == 0) --blocks;
  Divide(blocks, columns, rows, layout);
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
  Divide(grid.Layout().Blocks(), counts[0], counts[1], layout);
  layout->ranks = grid.Layout().ranks;
  *changed = layout->widths != grid.Layout().widths;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
