// Weighted ownership ranges.
#include "levels/balance.hpp"

namespace mlgimp
{

bool MakeLayout(int ranks, const std::vector<double> &columns, const std::vector<double> &rows, GridLayout *layout)
{
  const int width = static_cast<int>(columns.size()), height = static_cast<int>(rows.size());
  int best = 0;
  double shortest = HUGE_VAL;
  for (int m = 1; m <= ranks; ++m) {
    const int n = ranks / m;
    if (m * n != ranks || width < m * kHaloWidth || height < n * kHaloWidth) continue;
    const double border = static_cast<double>(m - 1) * height + static_cast<double>(n - 1) * width;
    if (border < shortest) {
      shortest = border;
      best = m;
    }
  }
  if (best == 0) return false;
  layout->widths[0] = DivideByWeight(columns, best, kHaloWidth);
  layout->widths[1] = DivideByWeight(rows, ranks / best, kHaloWidth);
  return true;
}

PetscErrorCode ProposeLayout(Level &level, GridLayout *layout, bool *changed)
{
  const Grid &grid = level.Mesh();
  const GridGeometry &geometry = grid.Geometry();
  PointArrays points;
  PetscMPIInt ranks;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(grid.Comm(), &ranks));
  PetscCall(level.PointStore().Arrays(&points));
  std::vector<double> counts[2];
  for (int axis = 0; axis < 2; ++axis) {
    counts[axis].assign(geometry.Nodes(axis), 0.0);
    for (int p = 0; p < points.count; ++p) ++counts[axis][grid.Nearest(axis, points.position[2 * p + axis]) + geometry.padding];
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts[axis].data(), geometry.Nodes(axis), MPI_DOUBLE, MPI_SUM, grid.Comm()));
  }
  *changed = MakeLayout(ranks, counts[0], counts[1], layout) && layout->widths != grid.Layout().widths;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
