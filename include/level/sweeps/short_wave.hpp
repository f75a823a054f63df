// The short-wave viscosity of a block of points: its strength and its stress.
#pragma once

#include "level/sweeps/point_blocks.hpp"

#include <algorithm>

namespace mlgimp
{

/// Component of the strain rate of point p of a block that moves with u, with the gradient L.
template <class Geometry> inline double StrainRate(const Row *u, const Row *L, const Row *x, int component, int p)
{
  constexpr int dim = Geometry::kDim;
  const int a = Geometry::kRateAxes[component][0], b = Geometry::kRateAxes[component][1];
  if (Geometry::kHoop && a == 2) return u[0][p] / x[0][p];
  return a == b ? L[dim * a + a][p] : 0.5 * (L[dim * a + b][p] + L[dim * b + a][p]);
}

/// |E|^2 of the Green strain E = (F^T F - I)/2 of point p.
template <class Geometry> double GreenStrainSquared(const Row *F, double hoop, int p)
{
  constexpr int dim = Geometry::kDim;
  double square = 0;
#pragma GCC unroll 6
  for (int k = 0; k < Geometry::kRate; ++k) {
    const int a = Geometry::kRateAxes[k][0], b = Geometry::kRateAxes[k][1];
    double C = 0;
    if (Geometry::kHoop && a == 2)
      C = hoop * hoop;
    else
#pragma GCC unroll 3
      for (int c = 0; c < dim; ++c) C += F[dim * c + a][p] * F[dim * c + b][p];
    const double E = 0.5 * (a == b ? C - 1 : C);
    square += (a == b ? 1 : 2) * E * E;
  }
  return square;
}

/// Part of the strength by the cells that a point moves in a step. Without it waves of a body that crosses cells grow (MUSL).
inline constexpr double kOfMotion = 30;

/// Largest strength, which keeps the explicit viscosity stable.
inline constexpr double kMaxStrength = 0.3;

/// h_p = min(0.3, a + b |E|^2 + kOfMotion (|u| dt/h)^2): E is the Green strain, in metals the elastic strain, as flow would make
/// it a rate effect. cells_per_speed: dt/h; u: the grid's velocity at the points.
template <class Geometry>
void ShortWaveStrength(const Block &b, const Extents<Geometry::kDim> &points, const ShortWaveViscosity &viscosity,
                       double cells_per_speed, const Row *u, double *strength)
{
  const double of_motion = kOfMotion * cells_per_speed * cells_per_speed;
  const Row *const F = points.F, *const x = points.x;
  const double *const radius = b.initial_radius;
  if (b.material.Traits().flows) {
    alignas(64) Row stress[Geometry::kStress];
    const Elasticity elastic = b.material.Elastic();
    LoadRows<Geometry::kStress>(b.stress, b.count, stress);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) strength[p] = elastic.StrainSquared(StressIn<Geometry>(stress, p));
  } else {
#pragma omp simd
    for (int p = 0; p < b.count; ++p) strength[p] = GreenStrainSquared<Geometry>(F, Geometry::kHoop ? x[0][p] / radius[p] : 1, p);
  }
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    double speed2 = 0;
#pragma GCC unroll 3
    for (int d = 0; d < Geometry::kDim; ++d) speed2 += u[d][p] * u[d][p];
    strength[p] = std::min(kMaxStrength, viscosity.a + viscosity.b * strength[p] + of_motion * speed2);
  }
}

/// Strain rates of the points of a block; returns the power of their short-wave stress on these, W.
template <class Geometry>
double StrainRates(const Block &b, const Extents<Geometry::kDim> &points, const Motion<Geometry::kDim> &motion, Row *rate)
{
  constexpr int kRate = Geometry::kRate;
  alignas(64) double volume[kBlock], sum = 0;
  alignas(64) Row stress[kRate];
  const Row *const x = points.x, *const u = motion.u, *const L = motion.L;
  Volumes<Geometry>(b, points, 1, volume);
  LoadRows<kRate>(b.short_wave_stress, b.count, stress);
#pragma omp simd reduction(+ : sum)
  for (int p = 0; p < b.count; ++p) {
    double power = 0;
#pragma GCC unroll 6
    for (int k = 0; k < kRate; ++k) {
      rate[k][p] = StrainRate<Geometry>(u, L, x, k, p);
      power += (Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1] ? 1 : 2) * stress[k][p] * rate[k][p];
    }
    sum += volume[p] * power;
  }
  return sum;
}

/// s = h_p (h/c0) (lambda tr(D') I + 2 mu D'), D' = D - smooth, D the strain rates of the points.
template <class Geometry>
void ShortWaveStress(const Block &b, const Extents<Geometry::kDim> &points, const Grid &grid, const ShortWaveViscosity &viscosity,
                     double dt, const Row *u, const Row *rate, const Row *smooth)
{
  constexpr int kRate = Geometry::kRate;
  const double time = grid.Geometry().spacing / b.material.SpeedOfSound();
  const double lambda = time * b.material.Elastic().lambda, mu2 = 2 * time * b.material.Elastic().mu;
  alignas(64) double strength[kBlock];
  alignas(64) Row s[kRate];
  ShortWaveStrength<Geometry>(b, points, viscosity, dt / grid.Geometry().spacing, u, strength);
#pragma omp simd
  for (int p = 0; p < b.count; ++p) {
    double trace = 0, difference[kRate];
#pragma GCC unroll 6
    for (int k = 0; k < Geometry::kRate; ++k) {
      difference[k] = rate[k][p] - smooth[k][p];
      if (Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1]) trace += difference[k];
    }
#pragma GCC unroll 6
    for (int k = 0; k < Geometry::kRate; ++k) {
      const double sphere = Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1] ? lambda * trace : 0;
      s[k][p] = strength[p] * (sphere + mu2 * difference[k]);
    }
  }
  StoreRows<kRate>(s, b.count, b.short_wave_stress);
}

} // namespace mlgimp
