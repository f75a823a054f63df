// What the sweeps do with a block of points by itself: volumes, strain and stress, motion.
#pragma once

#include "level/sweeps/kernels.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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
               view.bodies.average[view.bodies.BodyFor(view.points, start)]});
  }
}

/// Parts of a point's fields that a sweep needs beside those of its weights.
enum PointParts : int {
  kVelocityOfPoint = 1,
  kMassOfPoint = 2,
  kMomentum = kVelocityOfPoint | kMassOfPoint,
  kStressOfPoint = 4, ///< with the short-wave stress
  kInternal = 8
};

/// Asks the memory for points of the next block, with such parts of their fields as are named. A block's part of a field is too
/// short for the processor to notice a stream. To be done between groups, as many requests at once would wait for each other.
/// Always inline: GCC leaves out calls of functions that do nothing else.
template <class Geometry> [[gnu::always_inline]] inline void PrefetchNext(const Block &b, int p, int parts)
{
  constexpr int dim = Geometry::kDim;
  p += kBlock;
  Prefetch<dim>(b.position, p), Prefetch<dim>(b.half_size, p), Prefetch<dim * dim>(b.F, p);
  if (parts & kVelocityOfPoint) Prefetch<dim>(b.velocity, p);
  if (parts & kMassOfPoint) Prefetch<1>(b.mass, p);
  if (parts & kStressOfPoint) Prefetch<Geometry::kStress>(b.stress, p), Prefetch<Geometry::kRate>(b.short_wave_stress, p);
  if (parts & kInternal && b.history) Prefetch<1>(b.history, p, b.history_components);
  if (parts & kInternal && b.average >= 0) Prefetch<1>(b.faces, p);
}

template <int dim> Extents<dim> ExtentsOf(const PointArrays &b) { return {b.count, b.position, b.half_size, b.F}; }

/// Current volumes J m / rho0 with a sign, m3 (of the thickness that the masses were made with).
template <class Geometry> void Volumes(const Block &b, const Extents<Geometry::kDim> &points, int sign, double *volume)
{
  const double inverse_density = sign / b.material.Density();
  const Row *const F = points.F, *const x = points.x;
  const double *const mass = b.mass, *const radius = b.initial_radius;
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    volume[p] = Determinant<Geometry>(F, p) * mass[p] * inverse_density;
    if constexpr (Geometry::kHoop) volume[p] *= x[0][p] / radius[p];
  }
}

inline void Record(PointFailure &failure, PointFailure::Kind kind, const PointArrays &b, int p)
{
  if (failure.kind == PointFailure::kNone) failure = {kind, b.id[p], b.Position(p)};
}

/// Finds the point that deforms too fast or is no number.
template <class Geometry>
void RecordStrain(const Block &b, double dt, const Row *L, const Row *F, const double *hoop_ratio, PointFailure &failure)
{
  constexpr int dim = Geometry::kDim;
  for (int p = 0; p < b.count; ++p) {
    double sum = 0, largest_row = Geometry::kHoop ? std::abs(hoop_ratio[p] - 1) : 0;
    for (int k = 0; k < dim * dim; ++k) sum += F[k][p];
    for (int i = 0; i < dim; ++i) {
      double row = 0;
      for (int j = 0; j < dim; ++j) row += std::abs(L[dim * i + j][p]);
      largest_row = std::max(largest_row, dt * row);
    }
    if (!std::isfinite(sum))
      Record(failure, PointFailure::kNotFinite, b, p);
    else if (largest_row > kLargestStrainIncrement)
      Record(failure, PointFailure::kDeformedTooFast, b, p);
  }
}

/// What the points of a block move with in a step: the grid's velocity u at them [dim], m/s, and the gradient L [dim*dim] that
/// their strain follows, 1/s.
template <int dim> struct Motion {
  alignas(64) Row u[dim], L[dim * dim];
};

/// Advances F, stress and internal variables of a block. In axisymmetry its motion gives F_zz = r/R at the end of the step.
template <class Geometry>
void AdvanceStress(const Block &b, Extents<Geometry::kDim> &points, double dt, double scale, const Motion<Geometry::kDim> &motion,
                   Budgets &budgets, PointFailure &failure)
{
  constexpr int dim = Geometry::kDim;
  alignas(64) double hoop[kBlock], hoop_ratio[kBlock], plastic[kBlock];
  Row *const F = points.F;
  const Row *const x = points.x, *const u = motion.u;
  const double *const radius = b.initial_radius;
  const double largest = AdvanceDeformation<Geometry>(b.count, dt, motion.L, F);
  double largest_hoop = 0;
  if constexpr (Geometry::kHoop) {
#pragma omp simd reduction(max : largest_hoop)
    for (int p = 0; p < b.count; ++p) {
      const double r = x[0][p] + dt * u[0][p];
      hoop[p] = r / radius[p];
      hoop_ratio[p] = r / x[0][p];
      largest_hoop = std::max(largest_hoop, std::abs(hoop_ratio[p] - 1));
    }
  }
  if (!(largest <= kLargestStrainIncrement) || largest_hoop > kLargestStrainIncrement)
    RecordStrain<Geometry>(b, dt, motion.L, F, hoop_ratio, failure);
  StoreRows<dim * dim>(F, b.count, b.F);
  const MaterialBatch batch = {b.count,
                               dt,
                               scale,
                               motion.L,
                               F,
                               Geometry::kHoop ? hoop : nullptr,
                               Geometry::kHoop ? hoop_ratio : nullptr,
                               b.stress,
                               b.history,
                               b.history_components};
  if (b.material.Traits().history) std::fill_n(plastic, b.count, 0.0);
  b.material.UpdateStress(batch, plastic);
  if (b.material.Traits().history)
    budgets.plastic_work += std::transform_reduce(plastic, plastic + b.count, b.mass, 0.0) / b.material.Density();
}

/// Moves the points of a block; a point that would leave this rank's nodes stays and is recorded as a failure.
template <int dim>
void Move(const PointArrays &b, Extents<dim> &points, const Grid &grid, double dt, const Row *u, PointFailure &failure)
{
  for (int axis = 0; axis < dim; ++axis) {
    const double h = grid.Geometry().spacing, lower = grid.Geometry().Coordinate(axis, grid.Ghosted().lower[axis]) + 0.5 * h;
    const double upper = lower + (grid.Ghosted().Size(axis) - 2) * h;
    const auto inside = [=](double x) { return x >= lower && x < upper; }; // false for a NaN
    double *const x = points.x[axis], lost = 0;
    const double *const velocity = u[axis];
#pragma omp simd reduction(+ : lost)
    for (int p = 0; p < b.count; ++p) {
      const double target = x[p] + dt * velocity[p];
      lost += inside(target) ? 0.0 : 1.0;
      x[p] = inside(target) ? target : x[p];
    }
    for (int p = 0; lost > 0 && p < b.count; ++p) // b.position still has the places of before
      if (const double target = b.position[dim * p + axis] + dt * velocity[p]; !inside(target))
        Record(failure, std::isfinite(target) ? PointFailure::kLeftGrid : PointFailure::kNotFinite, b, p);
  }
  StoreRows<dim>(points.x, b.count, b.position);
}

} // namespace mlgimp
