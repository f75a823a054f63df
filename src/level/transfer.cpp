// The sweeps, written once for all shape functions.
#include "level/transfer.hpp"

#include "base/pack.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kLargestStrainIncrement = 0.5; ///< of one step; AdvanceDeformation is exact below it

/// The points of a block as a PointArrays of their own.
PointArrays Slice(const PointArrays &all, int start)
{
  PointArrays b = all;
  b.count = std::min(kBlock, all.count - start);
  b.id += start;
  b.position += 2 * start;
  b.velocity += 2 * start;
  b.F += 4 * start;
  b.stress += 4 * start;
  b.short_wave_stress += 3 * start;
  b.mass += start;
  b.half_size += 2 * start;
  b.body += start;
  b.faces += start;
  if (b.history) b.history += all.history_components * start;
  return b;
}

/// Current volumes J m / rho0, m3 (of the thickness that the masses were made with).
void Volumes(const PointArrays &b, const BodyTable &bodies, double *volume)
{
  double inverse_density[kBlock];
  for (int p = 0; p < b.count; ++p) inverse_density[p] = 1 / bodies.material[b.body[p]]->Density();
#pragma omp simd
  for (int p = 0; p < b.count; ++p)
    volume[p] = (b.F[4 * p] * b.F[4 * p + 3] - b.F[4 * p + 1] * b.F[4 * p + 2]) * b.mass[p] * inverse_density[p];
}

/// Calls `work(first, count, material)` for each run of points of one material.
template <class Work> void ForEachMaterial(const PointArrays &b, const BodyTable &bodies, Work work)
{
  for (int first = 0, end; first < b.count; first = end) {
    const Material *material = bodies.material[b.body[first]];
    for (end = first + 1; end < b.count && bodies.material[b.body[end]] == material;) ++end;
    work(first, end - first, *material);
  }
}

void Record(PointFailure &failure, PointFailure::Kind kind, const PointArrays &b, int p)
{
  if (failure.kind == PointFailure::kNone) failure = {kind, b.id[p], {b.position[2 * p], b.position[2 * p + 1]}};
}

/// Advances F, stress and internal variables of a block. L [4][kBlock] in 1/s.
void AdvanceStress(const PointArrays &b, const BodyTable &bodies, double dt, const double (*L)[kBlock],
                   SweepTotals &totals, PointFailure &failure)
{
  double increment[4][kBlock], plastic[kBlock] = {};
  const double largest = AdvanceDeformation(b.count, dt, L, increment, b.F);
  double sum = 0; // finite only if all of F is
  for (int k = 0; k < 4 * b.count; ++k) sum += b.F[k];
  if (!(largest <= kLargestStrainIncrement) || !std::isfinite(sum)) {
    for (int p = 0; p < b.count; ++p) {
      double rate = 0;
      for (int k = 0; k < 4; ++k) rate = std::max(rate, std::abs(dt * L[k][p]));
      if (!std::isfinite(b.F[4 * p] + b.F[4 * p + 1] + b.F[4 * p + 2] + b.F[4 * p + 3]))
        Record(failure, PointFailure::kNotFinite, b, p);
      else if (rate > 0.5 * kLargestStrainIncrement)
        Record(failure, PointFailure::kDeformedTooFast, b, p);
    }
  }
  ForEachMaterial(b, bodies, [&](int first, int count, const Material &material) {
    MaterialBatch batch{count, dt, {}, {}, b.F + 4 * first, b.stress + 4 * first, nullptr, b.history_components};
    for (int k = 0; k < 4; ++k) batch.L[k] = L[k] + first, batch.increment[k] = increment[k] + first;
    if (b.history) batch.history = b.history + b.history_components * first;
    material.UpdateStress(batch, plastic + first);
    if (material.HistorySize())
      for (int p = first; p < first + count; ++p) totals.plastic_dissipation += plastic[p] * b.mass[p] / material.Density();
  });
}

/// Moves the points of a block; a point that would leave this rank's nodes stays and is recorded as a failure.
void Move(const PointArrays &b, const Grid &grid, double dt, const double *grid_velocity, PointFailure &failure)
{
  for (int axis = 0; axis < 2; ++axis) {
    const double h = grid.Geometry().spacing, lower = grid.Coordinate(axis, grid.GhostLower(axis)) + 0.5 * h;
    const double upper = lower + (grid.GhostSize(axis) - 2) * h;
    double target[kBlock];
    int lost = 0;
#pragma omp simd reduction(+ : lost)
    for (int p = 0; p < b.count; ++p) {
      const double old = b.position[2 * p + axis];
      target[p] = old + dt * grid_velocity[2 * p + axis];
      const bool inside = target[p] >= lower && target[p] < upper; // false for a NaN
      lost += !inside;
      b.position[2 * p + axis] = inside ? target[p] : old;
    }
    for (int p = 0; lost && p < b.count; ++p)
      if (!(target[p] >= lower && target[p] < upper))
        Record(failure, std::isfinite(target[p]) ? PointFailure::kLeftGrid : PointFailure::kNotFinite, b, p);
  }
}

template <class Shape> class ShapeTransfer : public Transfer
{
  using Weights = Stencil<2>;

public:
  void PointsToGrid(const SweepView &view, const BodyAcceleration &acceleration, double time,
                    SweepTotals &totals) const override
  {
    Weights w;
    double volume[kBlock], body_force[2 * kBlock] = {}, values[kBlock][12];
    const double counts = view.owned ? 1 : 0;
    for (int start = 0; start < view.points.count; start += kBlock) {
      const PointArrays b = Slice(view.points, start);
      totals.clamped_sizes += ComputeStencil<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      Volumes(b, view.bodies, volume);
      if (acceleration) acceleration(time, b.count, b.id, b.position, body_force);
#pragma omp simd
      for (int p = 0; p < b.count; ++p) {
        const double m = b.mass[p], V = volume[p];
        const double xx = b.stress[4 * p] + b.short_wave_stress[3 * p];
        const double yy = b.stress[4 * p + 1] + b.short_wave_stress[3 * p + 1];
        const double xy = b.stress[4 * p + 3] + b.short_wave_stress[3 * p + 2];
        double *value = values[p];
        value[0] = m, value[1] = m * b.velocity[2 * p], value[2] = m * b.velocity[2 * p + 1], value[3] = counts * m;
        value[4] = m * body_force[2 * p], value[5] = m * body_force[2 * p + 1];
        value[6] = counts * value[4], value[7] = counts * value[5];
        value[8] = -V * xx, value[9] = -V * xy, value[10] = -V * yy, value[11] = 0;
      }
      for (int p = 0; p < b.count; ++p) {
        const double *value = values[p];
        const Pack with_S = Load(value), force_S = Load(value + 4);
        const Pack with_dx = {value[8], value[9], 0, 0}, with_dy = {value[9], value[10], 0, 0};
        double *center = view.grid.Arrays().sums + static_cast<std::ptrdiff_t>(w.node[p]) * NodeArrays::kSums;
        for (int k = 0; k < Weights::kNodes; ++k) {
          double *node = center + w.offset[k] * NodeArrays::kSums;
          const double S = w.S[k][p];
          Store(node, Load(node) + S * with_S);
          Store(node + 4, Load(node + 4) + S * force_S + w.dS[0][k][p] * with_dx + w.dS[1][k][p] * with_dy);
        }
      }
    }
  }

  void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, SweepTotals &totals,
                    PointFailure &failure) const override
  {
    Weights w;
    double value[kBlock][4], slope_x[kBlock][4], slope_y[kBlock][4], L[4][kBlock];
    for (int start = 0; start < view.points.count; start += kBlock) {
      const PointArrays b = Slice(view.points, start);
      double *grid_velocity = view.grid_velocity + 2 * start;
      ComputeStencil<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      GatherVelocity(view.grid, w, b.count, value, slope_x, slope_y);
#pragma omp simd
      for (int p = 0; p < b.count; ++p) {
        grid_velocity[2 * p] = value[p][0];
        grid_velocity[2 * p + 1] = value[p][1];
        b.velocity[2 * p] += value[p][2];
        b.velocity[2 * p + 1] += value[p][3];
        L[0][p] = slope_x[p][0], L[1][p] = slope_y[p][0], L[2][p] = slope_x[p][1], L[3][p] = slope_y[p][1];
      }
      if (plan.strain_rate) KeepStrainRate(b, view.bodies, plan.dt, slope_x, slope_y, totals);
      if (plan.scatter) ScatterRates(view.grid, w, b, grid_velocity);
      if (plan.strain) AdvanceStress(b, view.bodies, plan.dt, L, totals, failure);
      if (plan.move) Move(b, view.grid, plan.dt, grid_velocity, failure);
    }
  }

  void VelocityAt(const SweepView &view, int point, double change[2], double gradient[4]) const override
  {
    Weights w;
    double value[1][4], slope_x[1][4], slope_y[1][4];
    StencilOf(view, point, w);
    GatherVelocity(view.grid, w, 1, value, slope_x, slope_y);
    change[0] = value[0][2], change[1] = value[0][3];
    gradient[0] = slope_x[0][0], gradient[1] = slope_y[0][0], gradient[2] = slope_x[0][1], gradient[3] = slope_y[0][1];
  }

  void ScatterTensors(const SweepView &view) const override
  {
    Weights w;
    for (int start = 0; start < view.points.count; start += kBlock) {
      const PointArrays b = Slice(view.points, start);
      ComputeStencil<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      for (int p = 0; p < b.count; ++p) {
        const Pack F = Load(b.F + 4 * p), stress = Load(b.stress + 4 * p);
        double *center = view.grid.Arrays().rates + static_cast<std::ptrdiff_t>(w.node[p]) * NodeArrays::kRates;
        for (int k = 0; k < Weights::kNodes; ++k) {
          double *node = center + w.offset[k] * NodeArrays::kRates;
          Store(node, Load(node) + (b.mass[p] * w.S[k][p]) * F);
          Store(node + 4, Load(node + 4) + (b.mass[p] * w.S[k][p]) * stress);
        }
      }
    }
  }

  void TensorsAt(const SweepView &view, int point, double tensors[8]) const override
  {
    Weights w;
    StencilOf(view, point, w);
    std::fill_n(tensors, 8, 0.0);
    const double *center = view.grid.Arrays().rates + static_cast<std::ptrdiff_t>(w.node[0]) * NodeArrays::kRates;
    for (int k = 0; k < Weights::kNodes; ++k)
      for (int c = 0; c < 8; ++c) tensors[c] += w.S[k][0] * center[w.offset[k] * NodeArrays::kRates + c];
  }

  void ApplyRates(const SweepView &view, const RatesPlan &plan, SweepTotals &totals,
                  PointFailure &failure) const override
  {
    Weights w;
    double L[4][kBlock], projected[2][kBlock], smooth[3][kBlock];
    for (int start = 0; start < view.points.count; start += kBlock) {
      const PointArrays b = Slice(view.points, start);
      ComputeStencil<Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
      GatherRates(view.grid, w, b.count, L, projected, smooth);
      if (plan.strain) AdvanceStress(b, view.bodies, plan.dt, L, totals, failure);
      if (plan.short_wave.On()) ShortWaveStress(b, view, plan.short_wave, smooth);
      if (plan.xpic_fraction > 0) MixVelocity(b, plan.xpic_fraction, projected, totals);
      if (plan.move) Move(b, view.grid, plan.dt, view.grid_velocity + 2 * start, failure);
    }
  }

private:
  static void StencilOf(const SweepView &view, int point, Weights &w)
  {
    const PointArrays &all = view.points;
    ComputeStencil<Shape>(view.grid.IndexSpace(), 1, all.position + 2 * point, all.half_size + 2 * point, all.F + 4 * point, w);
  }

  /// value, slopes [count][4]: velocity and its change at the points, and their gradients.
  static void GatherVelocity(const Grid &grid, const Weights &w, int count, double (*value)[4], double (*slope_x)[4],
                             double (*slope_y)[4])
  {
    for (int p = 0; p < count; ++p) {
      const double *center = grid.Arrays().velocity + static_cast<std::ptrdiff_t>(w.node[p]) * NodeArrays::kVelocity;
      Pack v{}, dx{}, dy{};
      for (int k = 0; k < Weights::kNodes; ++k) {
        const Pack node = Load(center + w.offset[k] * NodeArrays::kVelocity);
        v += w.S[k][p] * node;
        dx += w.dS[0][k][p] * node;
        dy += w.dS[1][k][p] * node;
      }
      Store(value[p], v);
      Store(slope_x[p], dx);
      Store(slope_y[p], dy);
    }
  }

  /// L [4][kBlock]: gradient of the second velocity; projected [2][kBlock]; smooth [3][kBlock]: nodal strain rate.
  static void GatherRates(const Grid &grid, const Weights &w, int count, double (*L)[kBlock], double (*projected)[kBlock],
                          double (*smooth)[kBlock])
  {
    for (int p = 0; p < count; ++p) {
      const double *center = grid.Arrays().rates + static_cast<std::ptrdiff_t>(w.node[p]) * NodeArrays::kRates;
      Pack v{}, dx{}, dy{}, rate{};
      for (int k = 0; k < Weights::kNodes; ++k) {
        const double *node = center + w.offset[k] * NodeArrays::kRates;
        const Pack velocity = Load(node);
        v += w.S[k][p] * velocity;
        dx += w.dS[0][k][p] * velocity;
        dy += w.dS[1][k][p] * velocity;
        rate += w.S[k][p] * Load(node + 4);
      }
      L[0][p] = dx[0], L[1][p] = dy[0], L[2][p] = dx[1], L[3][p] = dy[1];
      projected[0][p] = v[2], projected[1][p] = v[3];
      for (int k = 0; k < 3; ++k) smooth[k][p] = rate[k];
    }
  }

  /// Books the work of the short-wave stress that acted in this step and puts the strain rate in its place.
  /// The work is that with the mean velocity of the step. Slopes [count][4]: of the new velocity and of its change.
  static void KeepStrainRate(const PointArrays &b, const BodyTable &bodies, double dt, const double (*slope_x)[4],
                             const double (*slope_y)[4], SweepTotals &totals)
  {
    double volume[kBlock], work = 0;
    Volumes(b, bodies, volume);
#pragma omp simd reduction(+ : work)
    for (int p = 0; p < b.count; ++p) {
      double *s = b.short_wave_stress + 3 * p;
      const double *x = slope_x[p], *y = slope_y[p], xx = x[0], yy = y[1], xy = 0.5 * (x[1] + y[0]);
      work += volume[p] * (s[0] * (xx - 0.5 * x[2]) + s[1] * (yy - 0.5 * y[3]) + 2 * s[2] * (xy - 0.25 * (x[3] + y[2])));
      s[0] = xx, s[1] = yy, s[2] = xy;
    }
    totals.short_wave_dissipation += dt * work;
  }

  /// Adds momentum, momentum of the grid's velocity, and mass times strain rate to `rates`.
  static void ScatterRates(const Grid &grid, const Weights &w, const PointArrays &b, const double *grid_velocity)
  {
    for (int p = 0; p < b.count; ++p) {
      const double m = b.mass[p], *rate = b.short_wave_stress + 3 * p;
      const Pack momentum = {m * b.velocity[2 * p], m * b.velocity[2 * p + 1], m * grid_velocity[2 * p],
                             m * grid_velocity[2 * p + 1]};
      const Pack strain_rate = {m * rate[0], m * rate[1], m * rate[2], 0};
      double *center = grid.Arrays().rates + static_cast<std::ptrdiff_t>(w.node[p]) * NodeArrays::kRates;
      for (int k = 0; k < Weights::kNodes; ++k) {
        double *node = center + w.offset[k] * NodeArrays::kRates;
        Store(node, Load(node) + w.S[k][p] * momentum);
        Store(node + 4, Load(node + 4) + w.S[k][p] * strain_rate);
      }
    }
  }

  /// s = h_p (h/c0) (lambda tr(D') I + 2 mu D'), D' = D - smooth, h_p = min(0.3, a + b |E|^2), E = (F^T F - I)/2.
  static void ShortWaveStress(const PointArrays &b, const SweepView &view, const ShortWaveViscosity &viscosity,
                              const double (*smooth)[kBlock])
  {
    ForEachMaterial(b, view.bodies, [&](int first, int count, const Material &material) {
      const double time = view.grid.Geometry().spacing / material.SpeedOfSound();
      const double lambda = time * material.Lambda(), mu2 = 2 * time * material.Mu();
#pragma omp simd
      for (int p = first; p < first + count; ++p) {
        const double *F = b.F + 4 * p;
        double *s = b.short_wave_stress + 3 * p;
        const double Exx = 0.5 * (F[0] * F[0] + F[2] * F[2] - 1), Eyy = 0.5 * (F[1] * F[1] + F[3] * F[3] - 1);
        const double Exy = 0.5 * (F[0] * F[1] + F[2] * F[3]);
        const double strength =
            std::min(0.3, viscosity.a + viscosity.b * (Exx * Exx + Eyy * Eyy + 2 * Exy * Exy));
        const double xx = s[0] - smooth[0][p], yy = s[1] - smooth[1][p], xy = s[2] - smooth[2][p];
        s[0] = strength * (lambda * (xx + yy) + mu2 * xx);
        s[1] = strength * (lambda * (xx + yy) + mu2 * yy);
        s[2] = strength * mu2 * xy;
      }
    });
  }

  /// v_p <- (1 - alpha) v_p + alpha sum S v2 (XPIC, or PIC at order 1), booking the kinetic energy lost.
  static void MixVelocity(const PointArrays &b, double fraction, const double (*projected)[kBlock],
                          SweepTotals &totals)
  {
    double lost = 0;
#pragma omp simd reduction(+ : lost)
    for (int p = 0; p < b.count; ++p)
      for (int axis = 0; axis < 2; ++axis) {
        double &v = b.velocity[2 * p + axis];
        const double mixed = v + fraction * (projected[axis][p] - v);
        lost += 0.5 * b.mass[p] * (v - mixed) * (v + mixed);
        v = mixed;
      }
    totals.xpic_dissipation += lost;
  }
};

} // namespace

std::vector<std::string> ShapeFunctions() { return {"linear", "ugimp", "cpgimp"}; }

std::unique_ptr<Transfer> CreateTransfer(const std::string &shape_function)
{
  if (shape_function == "linear") return std::make_unique<ShapeTransfer<Linear>>();
  if (shape_function == "ugimp") return std::make_unique<ShapeTransfer<UniformGimp>>();
  return std::make_unique<ShapeTransfer<ContiguousGimp>>();
}

} // namespace mlgimp
