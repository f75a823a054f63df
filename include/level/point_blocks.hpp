// What the sweeps do with a block of points by itself: volumes, strain and stress, motion.
#pragma once

#include "base/log.hpp"
#include "level/kernels.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

inline constexpr double kLargestStrainIncrement = 0.5; ///< of one step; det F stays positive below it

/// Consecutive points of one material, as arrays of their own.
struct Block : PointArrays {
  int start;
  const Material &material;
  int average; ///< place of the material among those that average their volume, or -1
};

/// Calls `work(block)` for all points, block by block of at most kBlock.
template <class Work> void ForEachBlock(const SweepView &view, Work work)
{
  for (int start = 0, end; start < view.points.count; start = end) {
    end = view.bodies.BlockEnd(view.points, start);
    work(Block{Slice(view.points, start, end), start, view.bodies.Of(view.points, start),
               view.bodies.average[view.points.body[start]]});
  }
}

/// Current volumes J m / rho0, m3 (of the thickness that the masses were made with).
template <class Geometry> void Volumes(const Block &b, double *volume)
{
  constexpr int dim = Geometry::kDim;
  const double inverse_density = 1 / b.material.Density();
  const double *const F = b.F, *const mass = b.mass, *const x = b.position, *const radius = b.initial_radius;
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    volume[p] = Determinant(F + dim * dim * p, dim) * mass[p] * inverse_density;
    if constexpr (Geometry::kHoop) volume[p] *= x[dim * p] / radius[p];
  }
}

inline void Record(PointFailure &failure, PointFailure::Kind kind, const PointArrays &b, int p)
{
  if (failure.kind == PointFailure::kNone) failure = {kind, b.id[p], b.Position(p)};
}

/// Finds the point that deforms too fast or is no number.
template <class Geometry>
void RecordStrain(const Block &b, double dt, const double (*L)[Geometry::kGradient], const double *hoop_ratio,
                  PointFailure &failure)
{
  constexpr int dim = Geometry::kDim;
  for (int p = 0; p < b.count; ++p) {
    double sum = 0, largest_row = Geometry::kHoop ? std::abs(hoop_ratio[p] - 1) : 0;
    for (int k = 0; k < dim * dim; ++k) sum += b.F[PointArrays::At(p, dim * dim) + k];
    for (int i = 0; i < dim; ++i) {
      double row = 0;
      for (int j = 0; j < dim; ++j) row += std::abs(L[p][dim * i + j]);
      largest_row = std::max(largest_row, row);
    }
    if (!std::isfinite(sum))
      Record(failure, PointFailure::kNotFinite, b, p);
    else if (dt * largest_row > kLargestStrainIncrement)
      Record(failure, PointFailure::kDeformedTooFast, b, p);
  }
}

/// Growth of volume of the points of a block in a step, det(I + dt L) - 1, in axisymmetry with that along the hoop.
template <class Geometry>
void VolumeGrowth(const Block &b, double dt, const double (*L)[Geometry::kGradient], const double *grid_velocity, double *growth)
{
  constexpr int dim = Geometry::kDim;
  const double *const x = b.position;
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    const double *const l = L[p], first = dt * (l[0] + l[dim + 1] + (dim == 3 ? l[8] : 0));
    double second = l[0] * l[dim + 1] - l[1] * l[dim], third = 0;
    if constexpr (dim == 3) {
      second += l[0] * l[8] - l[2] * l[6] + l[4] * l[8] - l[5] * l[7];
      third = dt * dt * dt * Determinant(l, dim);
    }
    growth[p] = first + dt * dt * second + third;
    if constexpr (Geometry::kHoop) growth[p] += (1 + growth[p]) * dt * grid_velocity[dim * p] / x[dim * p];
  }
}

/// Place of the cell that the centre of a point lies in.
template <int dim> std::ptrdiff_t CellOf(const Lattice &grid, const double *x)
{
  std::ptrdiff_t cell = 0;
  for (int axis = 0; axis < dim; ++axis)
    cell += (static_cast<int>(std::floor((x[axis] - grid.origin[axis]) * grid.inverse_spacing)) - grid.first[axis]) *
            static_cast<std::ptrdiff_t>(grid.stride[axis]);
  return cell;
}

/// Adds mass and growth of volume of a block to its cells.
template <class Geometry>
void AddGrowth(const Block &b, const Grid &grid, double dt, const double (*L)[Geometry::kGradient], const double *grid_velocity)
{
  double growth[kBlock];
  VolumeGrowth<Geometry>(b, dt, L, grid_velocity, growth);
  for (int p = 0; p < b.count; ++p) {
    CellSums &cell = grid.Cell(CellOf<Geometry::kDim>(grid.IndexSpace(), b.position + Geometry::kDim * p), b.average);
    cell.mass += b.mass[p];
    cell.growth += b.mass[p] * growth[p];
  }
}

/// Against locking: the gradients `averaged` are those of L with the mean growth of volume over the points of the cell,
/// j = (1 + g_cell)^(1 - w) (1 + g)^w with the share w of the own growth g; I + dt L keeps its form in the plane, or in space.
/// Adds up the work of the stress on the difference.
template <class Geometry>
void AverageGrowth(const Block &b, const Grid &grid, double dt, const double *grid_velocity,
                   const double (*L)[Geometry::kGradient], double (*averaged)[Geometry::kGradient], Budgets &budgets)
{
  constexpr int dim = Geometry::kDim;
  constexpr double kLeast = 0.1; // below it the strain is refused, by a message that a logarithm of less would spoil
  double growth[kBlock], mean[kBlock], volume[kBlock], work = 0;
  const double exponent = (1 - b.material.OwnGrowth()) / dim, rate = 1 / dt;
  VolumeGrowth<Geometry>(b, dt, L, grid_velocity, growth);
  Volumes<Geometry>(b, volume);
  for (int p = 0; p < b.count; ++p) mean[p] = grid.Cell(CellOf<dim>(grid.IndexSpace(), b.position + dim * p), b.average).growth;
  const double *const stress = b.stress;
#pragma omp simd reduction(+ : work)
  for (int p = 0; p < b.count; ++p) {
    const double ratio = std::max(1 + mean[p], kLeast) / std::max(1 + growth[p], kLeast);
    const double stretch = exponent * Log(ratio); // of a step: small
    const double excess = stretch * (1 + stretch / 2 * (1 + stretch / 3 * (1 + stretch / 4 * (1 + stretch / 5))));
#pragma GCC unroll 9
    for (int k = 0; k < dim * dim; ++k) averaged[p][k] = L[p][k] + excess * (L[p][k] + (k % (dim + 1) == 0 ? rate : 0));
    const double *const s = stress + Geometry::kStress * p;
    work -= volume[p] * excess * (s[0] + s[1] + (dim == 3 ? s[2] : 0)); // of the part I/dt, beside which L is small
  }
  budgets.averaging_work += work;
}

/// Advances F, stress and internal variables of a block. L [kBlock][dim*dim] in 1/s; grid_velocity [count][dim], which points
/// move with in the step: it gives F_zz = r/R at its end.
template <class Geometry>
void AdvanceStress(const Block &b, double dt, const double (*L)[Geometry::kGradient], const double *grid_velocity,
                   Budgets &budgets, PointFailure &failure)
{
  constexpr int size = Geometry::kGradient, dim = Geometry::kDim;
  alignas(64) double increment[kBlock][size], hoop[kBlock], hoop_ratio[kBlock] = {}, plastic[kBlock] = {};
  double largest = AdvanceDeformation<Geometry>(b.count, dt, L[0], increment[0], b.F);
  const double *const F = b.F, *const x = b.position, *const radius = b.initial_radius;
  if constexpr (Geometry::kHoop) {
#pragma omp simd reduction(max : largest)
    for (int p = 0; p < b.count; ++p) {
      const double r = x[dim * p] + dt * grid_velocity[dim * p];
      hoop[p] = r / radius[p];
      hoop_ratio[p] = r / x[dim * p];
      largest = std::max(largest, std::abs(hoop_ratio[p] - 1));
    }
  }
  double sum = 0; // finite only if all of F is
#pragma omp simd reduction(+ : sum)
  for (int k = 0; k < size * b.count; ++k) sum += F[k];
  if (!(largest <= kLargestStrainIncrement) || !std::isfinite(sum)) RecordStrain<Geometry>(b, dt, L, hoop_ratio, failure);
  const MaterialBatch batch = {b.count,
                               dt,
                               L[0],
                               increment[0],
                               b.F,
                               Geometry::kHoop ? hoop : nullptr,
                               Geometry::kHoop ? hoop_ratio : nullptr,
                               b.stress,
                               b.history,
                               b.history_components};
  b.material.UpdateStress(batch, plastic);
  if (b.material.HistorySize())
    for (int p = 0; p < b.count; ++p) budgets.plastic_work += plastic[p] * b.mass[p] / b.material.Density();
}

/// Moves the points of a block; a point that would leave this rank's nodes stays and is recorded as a failure.
template <class Geometry>
void Move(const PointArrays &b, const Grid &grid, double dt, const double *grid_velocity, PointFailure &failure)
{
  constexpr int dim = Geometry::kDim;
  const double h = grid.Geometry().spacing;
  double lower[dim * kBlock], upper[dim * kBlock];
  for (int axis = 0; axis < dim; ++axis) {
    const double first = grid.Coordinate(axis, grid.Ghosted().lower[axis]) + 0.5 * h;
    const double last = first + (grid.Ghosted().Size(axis) - 2) * h;
    for (int p = 0; p < kBlock; ++p) lower[dim * p + axis] = first, upper[dim * p + axis] = last;
  }
  const auto inside = [&](double x, int k) { return x >= lower[k] && x < upper[k]; }; // false for a NaN
  double *const position = b.position, target[dim * kBlock], lost = 0;
#pragma omp simd reduction(+ : lost)
  for (int k = 0; k < dim * b.count; ++k) {
    target[k] = position[k] + dt * grid_velocity[k];
    const bool stays = inside(target[k], k);
    lost += stays ? 0.0 : 1.0;
    position[k] = stays ? target[k] : position[k];
  }
  for (int k = 0; lost > 0 && k < dim * b.count; ++k)
    if (!inside(target[k], k))
      Record(failure, std::isfinite(target[k]) ? PointFailure::kLeftGrid : PointFailure::kNotFinite, b, k / dim);
}

} // namespace mlgimp
