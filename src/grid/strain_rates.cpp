// Strain rates of cells, layer by layer along the last axis.
#include "grid/strain_rates.hpp"

#include "base/pack.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// Sums over the nodes at the lower x of a cell: of velocities, and of these with the sign of each other axis; their least mass.
template <int dim> struct CellFace {
  Pack sum{}, along[2]{}; ///< y, z
  double mass = HUGE_VAL;

  CellFace() = default;
  /// Of the cell above a node, of which the index space has a cell.
  CellFace(const Grid &grid, std::ptrdiff_t place)
  {
#pragma GCC unroll 4
    for (int k = 0; k < 1 << (dim - 1); ++k) {
      const std::ptrdiff_t node = place + (k & 1) * grid.IndexSpace().stride[1] + (k >> 1) * grid.IndexSpace().stride[2];
      const Pack v = LoadVector(grid.Velocity(node).velocity);
      sum += v;
      along[0] = k & 1 ? along[0] + v : along[0] - v;
      if (dim == 3) along[1] = k >> 1 ? along[1] + v : along[1] - v;
      mass = std::min(mass, grid.Sums()[node].mass);
    }
  }
};

/// What a cell has from its corners.
template <int dim, bool has_hoop> struct CellMotion {
  Pack slope[dim]; ///< columns of L, 1/s
  double hoop;     ///< v_r/r, 1/s
  double weight;   ///< the least mass of the corners where points lie in the cell, or zero

  /// radius: of the middle, m; per_cell: 1/(2^(dim-1) h); mark: above zero where points lie in the cell.
  CellMotion(const CellFace<dim> &lower, const CellFace<dim> &upper, double per_cell, double radius, double mark)
  {
    slope[0] = per_cell * (upper.sum - lower.sum);
#pragma GCC unroll 2
    for (int axis = 1; axis < dim; ++axis) slope[axis] = per_cell * (lower.along[axis - 1] + upper.along[axis - 1]);
    hoop = has_hoop ? (lower.sum[0] + upper.sum[0]) / (4 * radius) : 0; // size
    weight = mark > 0 ? std::min(lower.mass, upper.mass) : 0;
  }

  void PutRate(CellRate *cell) const
  {
    const double xy = 0.5 * (slope[1][0] + slope[0][1]);
    if constexpr (dim == 2 && !has_hoop) {
      StoreVector(cell->strain, weight * Pack{slope[0][0], slope[1][1], xy, 1});
    } else if constexpr (dim == 2) {
      StoreVector(cell->strain, weight * Pack{slope[0][0], slope[1][1], hoop, xy});
      StoreVector(cell->strain + 4, Pack{0, 0, weight, 0});
    } else {
      StoreVector(cell->strain, weight * Pack{slope[0][0], slope[1][1], slope[2][2], xy});
      StoreVector(cell->strain + 4, weight * Pack{0.5 * (slope[2][1] + slope[1][2]), 0.5 * (slope[2][0] + slope[0][2]), 1, 0});
    }
  }
};

/// Strain rates, times weights, and those, of the cells around a node that lie on one side of it along x; `above`: those in the
/// layer above it, the last of them. In the plane there is no `high`, and the weight is the last number of `low`.
template <int dim, bool has_hoop> struct CellColumn {
  static constexpr bool kHasHigh = dim == 3 || has_hoop;
  Pack low{}, high{};

  CellColumn() = default;
  CellColumn(const CellRate *above, const CellRate *below, std::ptrdiff_t along_y)
  {
#pragma GCC unroll 2
    for (int k = 0; k < dim - 1; ++k) {
      low += LoadVector(above[-k * along_y].strain) + LoadVector(below[-k * along_y].strain);
      if constexpr (kHasHigh) high += LoadVector(above[-k * along_y].strain + 4) + LoadVector(below[-k * along_y].strain + 4);
    }
  }
};

/// Layers of cells and of nodes are perpendicular to the last axis. In front of the cells of a layer, along each axis of it, lie
/// ones without a rate, so that every node has cells around it.
template <int dim, bool has_hoop> class CellRates
{
  static constexpr int last = dim - 1;

public:
  CellRates(Grid &grid) : grid_(grid) {}

  void Find()
  {
    const IndexBox &box = grid_.Ghosted();
    const int rows = dim == 3 ? box.Size(1) : 1, first = dim == 3;
    along_y_ = box.Size(0) + 1;
    const std::ptrdiff_t count = along_y_ * (rows + first);
    CellRate *layers[2] = {grid_.Arrays().Layer(0, count), grid_.Arrays().Layer(1, count)};
    std::fill_n(layers[0], count, CellRate{}), std::fill_n(layers[1], count, CellRate{});
    for (int layer = 0; layer < box.Size(last); ++layer) {
      CellRate *const above = layers[layer % 2], *const below = layers[1 - layer % 2];
      if (layer + 1 == box.Size(last)) std::fill_n(above, count, CellRate{});
      const auto row = [&](int y) {
        return dim == 3 ? Index{box.lower[0], box.lower[1] + y, box.lower[2] + layer}
                        : Index{box.lower[0], box.lower[1] + layer, 0};
      };
      for (int y = 0; layer + 1 < box.Size(last) && y < rows - first; ++y) PutRow(row(y), above + (y + first) * along_y_ + 1);
      for (int y = 0; y < rows; ++y) PutMeans(row(y), above + (y + first) * along_y_, below + (y + first) * along_y_);
    }
  }

private:
  /// Of the cells above a row of nodes along x from `at` on.
  void PutRow(Index at, CellRate *cells)
  {
    const double h = grid_.Geometry().spacing, per_cell = grid_.IndexSpace().inverse_spacing / (1 << last);
    const std::ptrdiff_t place = grid_.Place(at);
    const int count = grid_.Ghosted().Size(0) - 1;
    CellFace<dim> lower(grid_, place);
    for (int x = 0; x < count; ++x) {
      const CellFace<dim> upper(grid_, place + x + 1);
      const double radius = has_hoop ? grid_.Geometry().Coordinate(0, at[0] + x) + 0.5 * h : 1;
      const CellMotion<dim, has_hoop> motion(lower, upper, per_cell, radius, grid_.Arrays().Marks()[place + x]);
      motion.PutRate(cells + x);
      lower = upper;
    }
  }

  /// On a row of nodes from `at` on; the first cells are those before the row.
  void PutMeans(Index at, const CellRate *above, const CellRate *below)
  {
    constexpr int n = NodeLayout::Rates(dim);
    double *const rates = grid_.Arrays().StrainRates(grid_.Place(at));
    const int count = grid_.Ghosted().Size(0);
    using Column = CellColumn<dim, has_hoop>;
    Column before(above, below, along_y_);
    for (int x = 0; x < count; ++x) {
      const Column after(above + x + 1, below + x + 1, along_y_);
      const Pack low = before.low + after.low, high = before.high + after.high;
      const double weight = Column::kHasHigh ? high[2] : low[3], inverse = weight > 0 ? 1 / weight : 0;
      StoreVector(rates + n * x, inverse * low);
      if constexpr (dim == 3) StoreVector(rates + n * x + 4, inverse * high);
      before = after;
    }
  }

  Grid &grid_;
  std::ptrdiff_t along_y_ = 0; ///< distance of rows of cells in a layer
};

} // namespace

void FindStrainRates(Grid &grid, bool has_hoop)
{
  if (grid.Geometry().dim == 3)
    CellRates<3, false>(grid).Find();
  else if (has_hoop)
    CellRates<2, true>(grid).Find();
  else
    CellRates<2, false>(grid).Find();
}

} // namespace mlgimp
