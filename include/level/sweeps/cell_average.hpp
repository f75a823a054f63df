// Against locking: the growth of volume of points becomes the mean over those of their cell.
#pragma once

#include "base/log.hpp"
#include "level/sweeps/point_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// Of the difference between a point's relative volume and the mean of its cell a share goes with strain: all but 1/e of it while
/// a point is strained by a twentieth. With 4 pressures show what points brought from other cells, as chequers in films. Of
/// metals, whose volume changes by pressure over bulk modulus alone: the differences are no strain to speak of. Points of a body
/// that does not flow keep their neighbours, and differ within a cell as strain does.
inline constexpr double kSettling = 20;

/// Growth of volume of the points of a block in a step, det(I + dt L) - 1, in axisymmetry with that along the hoop.
template <class Geometry>
void VolumeGrowth(const Block &b, const Row *x, double dt, const Motion<Geometry::kDim> &motion, double *growth)
{
  constexpr int dim = Geometry::kDim;
  const Row *const L = motion.L, *const u = motion.u;
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    const double first = dt * (L[0][p] + L[dim + 1][p] + (dim == 3 ? L[8][p] : 0));
    double second = L[0][p] * L[dim + 1][p] - L[1][p] * L[dim][p], third = 0;
    if constexpr (dim == 3) {
      second += L[0][p] * L[8][p] - L[2][p] * L[6][p] + L[4][p] * L[8][p] - L[5][p] * L[7][p];
      third = dt * dt * dt * Determinant<Geometry>(L, p);
    }
    growth[p] = first + dt * dt * second + third;
    if constexpr (Geometry::kHoop) growth[p] += (1 + growth[p]) * dt * u[0][p] / x[0][p];
  }
}

/// Where the cells that the centres of points lie in have their sums, or with a distance of one their marks. Summed up as
/// doubles, which vectorise better and hold any place.
template <int dim> void FindCells(const Grid &grid, const Row *x, int count, int distance, int *cell)
{
  const Lattice &lattice = grid.IndexSpace();
  const double *const origin = lattice.origin, inverse_spacing = lattice.inverse_spacing;
  double stride[dim], first = 0;
  for (int axis = 0; axis < dim; ++axis) {
    stride[axis] = static_cast<double>(distance) * lattice.stride[axis];
    first += stride[axis] * lattice.first[axis];
  }
#pragma omp simd
  for (int p = 0; p < count; ++p) {
    double place = -first;
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis) place += stride[axis] * std::floor((x[axis][p] - origin[axis]) * inverse_spacing);
    cell[p] = static_cast<int>(place);
  }
}

/// Marks the cells that points lie in.
template <int dim> void MarkCells(const Grid &grid, const Row *x, int count)
{
  alignas(64) int cell[kBlock];
  FindCells<dim>(grid, x, count, 1, cell);
  for (int p = 0; p < count; ++p) grid.Arrays().Marks()[cell[p]] = 1;
}

/// What the average needs of the points of a block: growth of volume in the step, current volume, cell.
template <class Geometry> struct CellParts {
  CellParts(const Block &b, const Extents<Geometry::kDim> &points, const Grid &grid, double dt,
            const Motion<Geometry::kDim> &motion)
  {
    VolumeGrowth<Geometry>(b, points.x, dt, motion, growth);
    Volumes<Geometry>(b, points, 1, volume);
    FindCells<Geometry::kDim>(grid, points.x, b.count, grid.Arrays().CellStride(), cell);
  }
  alignas(64) double growth[kBlock], volume[kBlock];
  alignas(64) int cell[kBlock];
};

/// Adds mass, growth of volume and relative volume of a block to its cells.
template <class Geometry>
void AddGrowth(const Block &b, const Extents<Geometry::kDim> &points, const Grid &grid, double dt,
               const Motion<Geometry::kDim> &motion)
{
  const CellParts<Geometry> parts(b, points, grid, dt, motion);
  const double density = b.material.Density();
  CellSums *const cells = grid.Arrays().Cells(b.average);
  constexpr int kApart = 8; // size: points of a cell lie beside each other, and their sums would wait for each other
  for (int first = 0; first < kApart; ++first)
    for (int p = first; p < b.count; p += kApart) {
      CellSums &cell = cells[parts.cell[p]];
      cell.mass += b.mass[p];
      cell.growth += b.mass[p] * parts.growth[p];
      cell.relative_volume += density * parts.volume[p];
    }
}

/// The gradients of L become those with the mean growth of volume over the points of the cell,
/// j = (1 + g_cell)^(1 - w) (1 + g)^w exp(q (J_cell/J - 1)) with the share w of the own growth g, q = kSettling dt |D|; I + dt L
/// keeps its form in the plane, or in space. The last factor is of points that come from other cells: without it they keep what
/// those had, and neighbours differ more with every border that they cross; not of points with faces, where contact
/// would be noisy by it. Adds up the work of the stress on the difference.
template <class Geometry>
void AverageGrowth(const Block &b, const Extents<Geometry::kDim> &points, const Grid &grid, double dt,
                   Motion<Geometry::kDim> &motion, Budgets &budgets)
{
  constexpr int dim = Geometry::kDim;
  constexpr double kMinSum = 0.1; // rounding: less is refused as a strain, by a message that a division by zero would spoil
  const CellParts<Geometry> parts(b, points, grid, dt, motion);
  alignas(64) double sums[3][kBlock]; // of the point's cell
  alignas(64) Row sigma[dim]; // normal stresses; as rows, since GCC does the end of a loop that skips components without vectors
  LoadRows<dim>(b.stress, b.count, sigma, Geometry::kStress);
  const CellSums *const cells = grid.Arrays().Cells(b.average);
  for (int p = 0; p < b.count; ++p) {
    const CellSums &cell = cells[parts.cell[p]];
    sums[0][p] = cell.mass, sums[1][p] = cell.growth, sums[2][p] = cell.relative_volume;
  }
  const double exponent = 2 * (1 - b.material.KeptVolumeShare()) / dim, rate = 1 / dt;
  const double settling = b.material.Traits().flows ? kSettling * dt / dim : 0, specific_volume = 1 / b.material.Density();
  const double *const mass = b.mass, *const growth = parts.growth, *const volume = parts.volume;
  const int *const faces = b.faces;
  Row *const L = motion.L;
  double work = 0;
#pragma omp simd reduction(+ : work)
  for (int p = 0; p < b.count; ++p) {
    // ln((1 + mean)/(1 + growth)) = 2 atanh s; the means are sums over the cell's mass, and all is over one division.
    const double cell_mass = sums[0][p], mean = sums[1][p], own = cell_mass * growth[p]; // growths, times that mass
    const double sum = std::max(2 * cell_mass + mean + own, kMinSum * cell_mass), inverse = 1 / (sum * volume[p] * cell_mass);
    const double s = (mean - own) * (volume[p] * cell_mass) * inverse;
    double square = 0; // |D|^2
#pragma GCC unroll 3
    for (int i = 0; i < dim; ++i) {
      square += L[dim * i + i][p] * L[dim * i + i][p];
#pragma GCC unroll 2
      for (int j = 0; j < i; ++j) {
        const double twice = L[dim * i + j][p] + L[dim * j + i][p];
        square += 0.5 * twice * twice;
      }
    }
    const double difference = faces[p] ? 0 : sums[2][p] * (specific_volume * mass[p]) * (sum * inverse) - 1;
    const double stretch = exponent * s * AtanhRatio<4>(s * s) + settling * std::sqrt(square) * difference;
    const double excess = SmallGrowth(stretch);
#pragma GCC unroll 9
    for (int k = 0; k < dim * dim; ++k) L[k][p] += excess * (L[k][p] + (k % (dim + 1) == 0 ? rate : 0));
    const double trace = sigma[0][p] + sigma[1][p] + (dim == 3 ? sigma[dim - 1][p] : 0);
    work -= volume[p] * excess * trace; // of the part I/dt, beside which L is small
  }
  budgets.averaging_work += work;
}

} // namespace mlgimp
