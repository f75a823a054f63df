// The sweeps, written once for all shape functions.
#include "level/kernels.hpp"

#include "base/pack.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kLargestStrainIncrement = 0.5; ///< of one step; det F stays positive below it

/// Consecutive points of one material, as arrays of their own.
struct Block : PointArrays {
  int start;
  int last; ///< point of the rank, counted from `start`
  const Material &material;
};

/// The block that begins at point `start`: at most kBlock points.
Block CutBlock(const SweepView &view, int start)
{
  const PointArrays &all = view.points;
  return {Slice(all, start, view.bodies.BlockEnd(all, start)), start, all.count - 1 - start, view.bodies.Of(all, start)};
}

/// Calls `work(block)` for all points, block by block.
template <class Work> void ForEachBlock(const SweepView &view, Work work)
{
  for (int start = 0; start < view.points.count;) {
    const Block block = CutBlock(view, start);
    work(block);
    start += block.count;
  }
}

/// Asks for what the next block's weights are made of while this block's point p is in work: that loop does little else
/// than wait for it.
void PrefetchNext(const Block &b, int p)
{
  const int next = std::min(p + kBlock, b.last);
  __builtin_prefetch(b.position + 2 * next);
  __builtin_prefetch(b.half_size + 2 * next);
  __builtin_prefetch(b.F + 4 * next);
}

/// Current volumes J m / rho0, m3 (of the thickness that the masses were made with).
void Volumes(const Block &b, double *volume)
{
  const double inverse_density = 1 / b.material.Density();
#pragma omp simd
  for (int p = 0; p < b.count; ++p)
    volume[p] = (b.F[4 * p] * b.F[4 * p + 3] - b.F[4 * p + 1] * b.F[4 * p + 2]) * b.mass[p] * inverse_density;
}

void Record(PointFailure &failure, PointFailure::Kind kind, const PointArrays &b, int p)
{
  if (failure.kind == PointFailure::kNone) failure = {kind, b.id[p], {b.position[2 * p], b.position[2 * p + 1]}};
}

/// Advances F, stress and internal variables of a block. L [kBlock][4] in 1/s.
void AdvanceStress(const Block &b, double dt, const double (*L)[4], SweepTotals &totals, PointFailure &failure)
{
  alignas(64) double increment[kBlock][4], plastic[kBlock] = {};
  const double largest = AdvanceDeformation<PlaneStrain>(b.count, dt, L[0], increment[0], b.F);
  const double *const F = b.F;
  double sum = 0; // finite only if all of F is
#pragma omp simd reduction(+ : sum)
  for (int k = 0; k < 4 * b.count; ++k) sum += F[k];
  if (!(largest <= kLargestStrainIncrement) || !std::isfinite(sum)) {
    for (int p = 0; p < b.count; ++p) {
      const double row_x = std::abs(L[p][0]) + std::abs(L[p][1]), row_y = std::abs(L[p][2]) + std::abs(L[p][3]);
      if (!std::isfinite(b.F[4 * p] + b.F[4 * p + 1] + b.F[4 * p + 2] + b.F[4 * p + 3]))
        Record(failure, PointFailure::kNotFinite, b, p);
      else if (dt * std::max(row_x, row_y) > kLargestStrainIncrement)
        Record(failure, PointFailure::kDeformedTooFast, b, p);
    }
  }
  const MaterialBatch batch = {b.count, dt, L[0], increment[0], b.F, nullptr, nullptr, b.stress, b.history, b.history_components};
  b.material.UpdateStress(batch, plastic);
  if (b.material.HistorySize())
    for (int p = 0; p < b.count; ++p) totals.plastic_dissipation += plastic[p] * b.mass[p] / b.material.Density();
}

/// Moves the points of a block; a point that would leave this rank's nodes stays and is recorded as a failure.
void Move(const PointArrays &b, const Grid &grid, double dt, const double *grid_velocity, PointFailure &failure)
{
  const double h = grid.Geometry().spacing;
  double lower[2 * kBlock], upper[2 * kBlock];
  for (int axis = 0; axis < 2; ++axis) {
    const double first = grid.Coordinate(axis, grid.GhostLower(axis)) + 0.5 * h, last = first + (grid.GhostSize(axis) - 2) * h;
    for (int p = 0; p < b.count; ++p) lower[2 * p + axis] = first, upper[2 * p + axis] = last;
  }
  const auto inside = [&](double x, int k) { return x >= lower[k] && x < upper[k]; }; // false for a NaN
  double *const position = b.position, target[2 * kBlock], lost = 0;
#pragma omp simd reduction(+ : lost)
  for (int k = 0; k < 2 * b.count; ++k) {
    target[k] = position[k] + dt * grid_velocity[k];
    const bool stays = inside(target[k], k);
    lost += stays ? 0.0 : 1.0;
    position[k] = stays ? target[k] : position[k];
  }
  for (int k = 0; lost > 0 && k < 2 * b.count; ++k)
    if (!inside(target[k], k))
      Record(failure, std::isfinite(target[k]) ? PointFailure::kLeftGrid : PointFailure::kNotFinite, b, k / 2);
}

template <class Shape> class ShapeKernels : public Kernels
{
  using Weights = AxisStencils<2>;

public:
  void PointsToGrid(const SweepView &view, const BodyAcceleration &acceleration, double time, SweepTotals &totals) const override
  {
    Weights w;
    alignas(64) double volume[kBlock], body_force[2 * kBlock] = {};
    const double counts = view.owned ? 1 : 0;
    ForEachBlock(view, [&](const Block &b) {
      totals.clamped_sizes += ComputeAxisStencils<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      Volumes(b, volume);
      if (acceleration) acceleration(time, b.count, b.id, b.position, body_force);
      for (int p = 0; p < b.count; ++p) {
        PrefetchNext(b, p);
        const double m = b.mass[p], *v = b.velocity + 2 * p, *a = body_force + 2 * p, *s = b.short_wave_stress + 3 * p;
        const Pack force = -volume[p] * (LoadVector<Pack>(b.stress + 4 * p) + Pack{s[0], s[1], 0, s[2]}); // xx, yy, zz, xy
        const Share<2> share = {Join(m * Pack{1, v[0], v[1], counts}, m * Pack{a[0], a[1], counts * a[0], counts * a[1]}),
                                {MakeHigh(Pack{force[0], force[3], 0, 0}), MakeHigh(Pack{force[3], force[1], 0, 0})}};
        const PointStencil<2> at(w, p, view.grid.IndexSpace(), NodeArrays::kSums);
        Scatter<2, true>(at, share, view.grid.Arrays().sums + at.nearest);
      }
    });
  }

  void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, SweepTotals &totals,
                    PointFailure &failure) const override
  {
    Weights w;
    alignas(64) double L[kBlock][4], volume[kBlock];
    ForEachBlock(view, [&](const Block &b) {
      double *grid_velocity = view.grid_velocity + 2 * b.start;
      ComputeAxisStencils<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      double power = 0; // of the short-wave stress, W
      if (plan.strain_rate) Volumes(b, volume);
      for (int p = 0; p < b.count; ++p) {
        PrefetchNext(b, p);
        const PointStencil<2> at(w, p, view.grid.IndexSpace(), NodeArrays::kVelocity);
        const auto sum = Gather<Pack, 2>(at, view.grid.Arrays().velocity + at.nearest);
        const Pack dx = sum.slope[0], dy = sum.slope[1];
        for (int d = 0; d < 2; ++d) {
          grid_velocity[2 * p + d] = sum.value[d];
          b.velocity[2 * p + d] += sum.value[2 + d];
        }
        if (plan.strain) StoreVector(L[p], Pack{dx[0], dy[0], dx[1], dy[1]});
        if (plan.strain_rate) power += volume[p] * KeepStrainRate(dx, dy, b.short_wave_stress + 3 * p);
        if (plan.scatter) ScatterRates(view.grid, w, b, p, sum.value);
      }
      totals.short_wave_dissipation += plan.dt * power;
      if (plan.strain) AdvanceStress(b, plan.dt, L, totals, failure);
      if (plan.move) Move(b, view.grid, plan.dt, grid_velocity, failure);
    });
  }

  /// gradient = sum (v_i - v) grad S_ip with v the mean of the nodes' velocities by S.
  void VelocityAt(const SweepView &view, int point, double mass_cutoff, double change[2], double gradient[4]) const override
  {
    Stencil<2> w;
    const PointArrays &all = view.points;
    double mean[2] = {}, sum = 0;
    ComputeStencil<Shape>(view.grid.IndexSpace(), 1, all.position + 2 * point, all.half_size + 2 * point, all.F + 4 * point, w);
    const auto for_each_node = [&](auto work) {
      for (int k = 0; k < Stencil<2>::kNodes; ++k) {
        const std::ptrdiff_t node = w.node[0] + w.offset[k];
        if (view.grid.Arrays().sums[node * NodeArrays::kSums] > mass_cutoff)
          work(k, view.grid.Arrays().velocity + node * NodeArrays::kVelocity);
      }
    };
    std::fill_n(change, 2, 0.0);
    std::fill_n(gradient, 4, 0.0);
    for_each_node([&](int k, const double *v) {
      sum += w.S[k][0];
      for (int d = 0; d < 2; ++d) mean[d] += w.S[k][0] * v[d], change[d] += w.S[k][0] * v[2 + d];
    });
    if (sum == 0) return;
    for (int d = 0; d < 2; ++d) mean[d] /= sum, change[d] /= sum;
    for_each_node([&](int k, const double *v) {
      for (int d = 0; d < 2; ++d)
        for (int axis = 0; axis < 2; ++axis) gradient[2 * d + axis] += w.dS[axis][k][0] * (v[d] - mean[d]);
    });
  }

  void ScatterTensors(const SweepView &view) const override
  {
    Weights w;
    ForEachBlock(view, [&](const Block &b) {
      ComputeAxisStencils<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      for (int p = 0; p < b.count; ++p) {
        const Share<2> share = {Join(b.mass[p] * LoadVector<Pack>(b.F + 4 * p), b.mass[p] * LoadVector<Pack>(b.stress + 4 * p)),
                                {}};
        const PointStencil<2> at(w, p, view.grid.IndexSpace(), NodeArrays::kRates);
        Scatter<2, false>(at, share, view.grid.Arrays().rates + at.nearest);
      }
    });
  }

  void TensorsAt(const SweepView &view, int point, double tensors[8]) const override
  {
    Weights w;
    StencilOf(view, point, w);
    const PointStencil<2> at(w, 0, view.grid.IndexSpace(), NodeArrays::kRates);
    const double *nearest = view.grid.Arrays().rates + at.nearest;
    StoreVector(tensors, Gather<WidePack, 2>(at, nearest).value);
  }

  void ApplyRates(const SweepView &view, const RatesPlan &plan, SweepTotals &totals, PointFailure &failure) const override
  {
    Weights w;
    alignas(64) double L[kBlock][4], velocity[kBlock][4], smooth[kBlock][4];
    ForEachBlock(view, [&](const Block &b) {
      ComputeAxisStencils<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      GatherRates(view.grid, w, b, L, velocity, plan.short_wave.On() ? smooth : nullptr);
      if (plan.strain) AdvanceStress(b, plan.dt, L, totals, failure);
      if (plan.short_wave.On()) ShortWaveStress(b, view.grid, plan.short_wave, smooth);
      if (plan.xpic_fraction > 0) MixVelocity(b, plan.xpic_fraction, velocity, totals);
      if (plan.move) Move(b, view.grid, plan.dt, view.grid_velocity + 2 * b.start, failure);
    });
  }

private:
  static void StencilOf(const SweepView &view, int point, Weights &w)
  {
    const PointArrays &all = view.points;
    ComputeAxisStencils<Shape>(view.grid.IndexSpace(), 1, all.position + 2 * point, all.half_size + 2 * point, all.F + 4 * point,
                               w);
  }

  /// [count][4] each: gradient of the second velocity; second and projected velocity; nodal strain rate xx, yy, xy, if asked
  /// for.
  static void GatherRates(const Grid &grid, const Weights &w, const Block &b, double (*L)[4], double (*velocity)[4],
                          double (*smooth)[4])
  {
    for (int p = 0; p < b.count; ++p) {
      PrefetchNext(b, p);
      const PointStencil<2> at(w, p, grid.IndexSpace(), NodeArrays::kRates);
      const double *nearest = grid.Arrays().rates + at.nearest;
      const auto sum = Gather<WidePack, 2>(at, nearest);
      const Pack dx = Low(sum.slope[0]), dy = Low(sum.slope[1]);
      StoreVector(L[p], Pack{dx[0], dy[0], dx[1], dy[1]});
      StoreVector(velocity[p], Low(sum.value));
      if (smooth) StoreVector(smooth[p], High(sum.value));
    }
  }

  /// Puts the strain rate of a point in the place of its short-wave stress s; returns the power of that stress, W/m3, with
  /// the mean velocity of the step. dx, dy: slopes of the new velocity and of its change.
  static double KeepStrainRate(Pack dx, Pack dy, double *s)
  {
    const double xx = dx[0], yy = dy[1], xy = 0.5 * (dx[1] + dy[0]);
    const double power = s[0] * (xx - 0.5 * dx[2]) + s[1] * (yy - 0.5 * dy[3]) + 2 * s[2] * (xy - 0.25 * (dx[3] + dy[2]));
    s[0] = xx, s[1] = yy, s[2] = xy;
    return power;
  }

  /// Adds momentum, momentum of the grid's velocity u, and mass times strain rate of a point to `rates`.
  static void ScatterRates(const Grid &grid, const Weights &w, const PointArrays &b, int p, Pack u)
  {
    const double m = b.mass[p], *v = b.velocity + 2 * p, *rate = b.short_wave_stress + 3 * p;
    const Share<2> share = {Join(m * Pack{v[0], v[1], u[0], u[1]}, m * Pack{rate[0], rate[1], rate[2], 0}), {}};
    const PointStencil<2> at(w, p, grid.IndexSpace(), NodeArrays::kRates);
    Scatter<2, false>(at, share, grid.Arrays().rates + at.nearest);
  }

  /// s = h_p (h/c0) (lambda tr(D') I + 2 mu D'), D' = D - smooth, h_p = min(0.3, a + b |E|^2), E = (F^T F - I)/2.
  static void ShortWaveStress(const Block &b, const Grid &grid, const ShortWaveViscosity &viscosity, const double (*smooth)[4])
  {
    const double time = grid.Geometry().spacing / b.material.SpeedOfSound();
    const double lambda = time * b.material.Lambda(), mu2 = 2 * time * b.material.Mu();
#pragma omp simd
    for (int p = 0; p < b.count; ++p) {
      const double *F = b.F + 4 * p;
      double *s = b.short_wave_stress + 3 * p;
      const double Exx = 0.5 * (F[0] * F[0] + F[2] * F[2] - 1), Eyy = 0.5 * (F[1] * F[1] + F[3] * F[3] - 1);
      const double Exy = 0.5 * (F[0] * F[1] + F[2] * F[3]);
      const double strength = std::min(0.3, viscosity.a + viscosity.b * (Exx * Exx + Eyy * Eyy + 2 * Exy * Exy));
      const double xx = s[0] - smooth[p][0], yy = s[1] - smooth[p][1], xy = s[2] - smooth[p][2];
      s[0] = strength * (lambda * (xx + yy) + mu2 * xx);
      s[1] = strength * (lambda * (xx + yy) + mu2 * yy);
      s[2] = strength * mu2 * xy;
    }
  }

  /// v_p <- (1 - alpha) v_p + alpha sum S v2 (XPIC, or PIC at order 1), adding up the kinetic energy lost and the momentum.
  static void MixVelocity(const PointArrays &b, double fraction, const double (*velocity)[4], SweepTotals &totals)
  {
    double lost = 0;
    for (int axis = 0; axis < 2; ++axis) {
      double impulse = 0;
#pragma omp simd reduction(+ : lost, impulse)
      for (int p = 0; p < b.count; ++p) {
        double &v = b.velocity[2 * p + axis];
        const double mixed = v + fraction * (velocity[p][2 + axis] - v);
        lost += 0.5 * b.mass[p] * (v - mixed) * (v + mixed);
        impulse += b.mass[p] * (mixed - v);
        v = mixed;
      }
      totals.xpic_impulse[axis] += impulse;
    }
    totals.xpic_dissipation += lost;
  }
};

} // namespace

std::vector<std::string> ShapeFunctions() { return {"linear", "ugimp", "cpgimp"}; }

std::unique_ptr<Kernels> CreateKernels(const std::string &shape_function)
{
  if (shape_function == "linear") return std::make_unique<ShapeKernels<Linear>>();
  if (shape_function == "ugimp") return std::make_unique<ShapeKernels<UniformGimp>>();
  return std::make_unique<ShapeKernels<ContiguousGimp>>();
}

} // namespace mlgimp
