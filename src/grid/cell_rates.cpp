// Strain rates of cells, layer by layer along the last axis.
#include "grid/cell_rates.hpp"

#include "base/pack.hpp"
#include "base/tensor.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace mlgimp
{

namespace
{

/// What a cell has from its corners.
template <int dim, bool has_hoop> class CellMotion
{
public:
  CellMotion(const Grid &grid, double mass_cutoff)
      : sums_(grid.Sums()), velocity_(grid.Arrays().VelocityArray()), lattice_(grid.IndexSpace()), mass_cutoff_(mass_cutoff)
  {
  }

  /// Of the cell above the node at a place; r: radius of its middle, m.
  void Find(std::ptrdiff_t place, double r)
  {
    constexpr int corners = 1 << dim;
    const double per_h = lattice_.inverse_spacing / (corners / 2); // size
    Pack mean{};
    weight_ = HUGE_VAL;
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis) slope_[axis] = Pack{};
#pragma GCC unroll 8
    for (int k = 0; k < corners; ++k) {
      std::ptrdiff_t corner = place;
#pragma GCC unroll 3
      for (int axis = 0; axis < dim; ++axis) corner += (k >> axis & 1) * lattice_.stride[axis];
      const Pack v = LoadVector(velocity_ + NodeLayout::Velocity(dim) * corner);
      weight_ = std::min(weight_, sums_[corner].mass);
      if (has_hoop) mean += v;
#pragma GCC unroll 3
      for (int axis = 0; axis < dim; ++axis) slope_[axis] = k >> axis & 1 ? slope_[axis] + v : slope_[axis] - v;
    }
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis) slope_[axis] *= per_h;
    hoop_ = has_hoop ? mean[0] / (corners * r) : 0;
    if (!(weight_ > mass_cutoff_)) weight_ = 0;
  }

  void PutRate(CellRate *cell) const
  {
    const double xy = 0.5 * (slope_[1][0] + slope_[0][1]);
    if constexpr (dim == 2) {
      StoreVector(cell->strain,
                  weight_ * (has_hoop ? Pack{slope_[0][0], slope_[1][1], hoop_, xy} : Pack{slope_[0][0], slope_[1][1], xy, 0}));
      StoreVector(cell->strain + 4, Pack{0, 0, weight_, 0});
    } else {
      StoreVector(cell->strain, weight_ * Pack{slope_[0][0], slope_[1][1], slope_[2][2], xy});
      StoreVector(cell->strain + 4,
                  weight_ * Pack{0.5 * (slope_[2][1] + slope_[1][2]), 0.5 * (slope_[2][0] + slope_[0][2]), 1, 0});
    }
  }

  double Growth(double dt) const
  {
    if (weight_ == 0) return HUGE_VAL;
    double I_L[dim * dim];
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j) I_L[dim * i + j] = (i == j) + dt * slope_[j][i];
    return Determinant(I_L, dim) * (1 + dt * hoop_) - 1;
  }

private:
  const NodeSums *sums_;
  const double *velocity_;
  const Lattice &lattice_;
  double mass_cutoff_, weight_ = 0, hoop_ = 0;
  Pack slope_[dim]{}; ///< columns of L
};

/// The mean over the cells around a node that have a strain rate; cell: that above it in the layer above, and in that below.
template <int dim> void PutMean(const CellRate *above, const CellRate *below, std::ptrdiff_t along_y, double *strain_rate)
{
  Pack low{}, high{};
  for (const CellRate *const layer : {below, above})
#pragma GCC unroll 4
    for (int k = 0; k < 1 << (dim - 1); ++k) {
      const CellRate *const cell = layer - (k & 1) - (k >> 1) * along_y;
      low += LoadVector(cell->strain), high += LoadVector(cell->strain + 4);
    }
  const double inverse = high[2] > 0 ? 1 / high[2] : 0;
  StoreVector(strain_rate, inverse * low);
  if constexpr (dim == 3) StoreVector(strain_rate + 4, inverse * high);
}

/// Layers of cells and of nodes are perpendicular to the last axis. A layer of cells has one more beside each node in front,
/// without a rate, so that every node has all cells around it.
template <int dim, bool has_hoop> void FindRates(Grid &grid, double mass_cutoff, double dt)
{
  constexpr int last = dim - 1;
  const IndexBox &box = grid.Ghosted();
  const int rows = dim == 3 ? box.Size(1) : 1;
  const std::ptrdiff_t along_y = box.Size(0) + 1, count = along_y * (rows + (dim == 3));
  CellMotion<dim, has_hoop> motion(grid, mass_cutoff);
  CellRate *layers[2] = {grid.Arrays().Layer(0, count), grid.Arrays().Layer(1, count)};
  std::fill_n(layers[1], count, CellRate{});
  for (int layer = 0; layer < box.Size(last); ++layer) {
    CellRate *const above = layers[layer % 2], *const below = layers[(layer + 1) % 2];
    std::fill_n(above, count, CellRate{});
    const auto for_each = [&](int less, auto work) {
      for (int y = 0; y < rows - (dim == 3 ? less : 0); ++y)
        for (int x = 0; x < box.Size(0) - less; ++x) {
          Index at = box.lower;
          at[0] += x, at[1] += y, at[last] += layer;
          work(at, grid.Place(at), (y + (dim == 3)) * along_y + x + 1);
        }
    };
    if (layer + 1 < box.Size(last))
      for_each(1, [&](Index at, std::ptrdiff_t place, std::ptrdiff_t cell) {
        motion.Find(place, has_hoop ? grid.Geometry().Coordinate(0, at[0]) + 0.5 * grid.Geometry().spacing : 1);
        motion.PutRate(above + cell);
        if (grid.Arrays().CellStride() > 0) grid.Arrays().Growths()[place] = motion.Growth(dt);
      });
    for_each(0, [&](Index, std::ptrdiff_t place, std::ptrdiff_t cell) {
      PutMean<dim>(above + cell, below + cell, along_y, grid.Rates(place) + NodeLayout::StrainRate(dim));
    });
  }
}

} // namespace

void FindCellRates(Grid &grid, bool has_hoop, double mass_cutoff, double dt)
{
  if (grid.Geometry().dim == 3)
    FindRates<3, false>(grid, mass_cutoff, dt);
  else if (has_hoop)
    FindRates<2, true>(grid, mass_cutoff, dt);
  else
    FindRates<2, false>(grid, mass_cutoff, dt);
}

} // namespace mlgimp
