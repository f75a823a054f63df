// The sweeps, written once for all geometries and shape functions.
#include "level/sweeps/kernels.hpp"

#include "base/pack.hpp"
#include "level/sweeps/cell_average.hpp"
#include "level/sweeps/node_shares.hpp"
#include "level/sweeps/point_blocks.hpp"
#include "level/sweeps/short_wave.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mlgimp
{

namespace
{

/// The sweeps in a geometry with a shape function.
template <class Geometry, class Shape> class SweepKernels : public Kernels
{
  static constexpr int dim = Geometry::kDim, kRate = Geometry::kRate;
  using Weights = AxisStencils<dim>;
  template <int components> using At = GroupStencil<dim, components>;
  using AtRates = At<NodeLayout::Rates(dim)>;

public:
  void PointsToGrid(const SweepView &view, const BodyAcceleration &acceleration, double time, Budgets &budgets) const override
  {
    Weights w;
    NodeShares<Geometry> shares;
    budgets.hoop_force = 0;
    ForEachBlock(view, [&](const Block &b) {
      const Extents<dim> points = ExtentsOf<dim>(b);
      budgets.clamped_sizes += SetWeights<true>(view, b, points, w);
      budgets.hoop_force += shares.Set(b, points, view.owned);
      if (acceleration) shares.AddBodyForces(b, acceleration, time);
      if (NodeShares<Geometry>::kHasBody || acceleration)
        shares.template AddTo<true>(view.grid, w, b);
      else
        shares.template AddTo<false>(view.grid, w, b);
    });
  }

  void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, Budgets &budgets, PointFailure &failure) const override
  {
    Weights w;
    Motion<dim> motion, change; // with the new velocity, and by how much that is new
    ForEachBlock(view, [&](const Block &b) {
      Extents<dim> points = ExtentsOf<dim>(b);
      SetWeights<false>(view, b, points, w);
      GatherVelocities(view.grid, w, b, plan.strain_rate, motion, change);
      if (plan.damped > 0) DampNoise(b, plan.damped, motion.u, change.u, budgets);
      AddVelocity(b, change.u);
      if (plan.strain_rate) budgets.short_wave_dissipation += plan.dt * KeepStrainRate(b, points, motion, change);
      if (plan.scatter) (plan.project ? ScatterRates<true> : ScatterRates<false>)(view.grid, w, b, motion.u);
      if (b.average >= 0) AddGrowth<Geometry>(b, points, view.grid, plan.dt, motion);
      if (plan.strain) AdvanceStress<Geometry>(b, points, plan.dt, plan.scale, motion, budgets, failure);
      if (plan.move) Move<dim>(b, points, view.grid, plan.dt, motion.u, failure);
    });
  }

  /// gradient = sum (v_i - v) grad S_ip with v the mean of the nodes' velocities by S.
  VelocitySample VelocityAt(const SweepView &view, int point, double mass_cutoff) const override
  {
    Weights w;
    Vec3 mean{};
    double sum = 0;
    VelocitySample sample{};
    SetWeights(view, point, w);
    const auto for_each_node = [&](auto work) {
      ForEachNodeOf(w, 0, view.grid.IndexSpace(), [&](std::ptrdiff_t node, double weight, const auto &slope) {
        if (view.grid.Sums()[node].mass > mass_cutoff) work(view.grid.Velocity(node), weight, slope);
      });
    };
    for_each_node([&](NodeVelocity node, double weight, const auto &) {
      sum += weight;
      for (int d = 0; d < dim; ++d) mean[d] += weight * node.velocity[d], sample.change[d] += weight * node.change[d];
    });
    if (sum == 0) return sample;
    for (int d = 0; d < dim; ++d) mean[d] /= sum, sample.change[d] /= sum;
    for_each_node([&](NodeVelocity node, double, const auto &slope) {
      for (int d = 0; d < dim; ++d)
        for (int axis = 0; axis < dim; ++axis) sample.L[dim * d + axis] += slope[axis] * (node.velocity[d] - mean[d]);
    });
    return sample;
  }

  void ScatterTensors(const SweepView &view) const override
  {
    if constexpr (dim == 2) {
      Weights w;
      alignas(64) double shares[8 * kBlock];
      ForEachBlock(view, [&](const Block &b) {
        SetWeights<false>(view, b, ExtentsOf<dim>(b), w);
        for (int p = 0; p < b.count; ++p) {
          StoreVector(shares + 8 * p, b.mass[p] * LoadVector(b.F + 4 * p));
          StoreVector(shares + 8 * p + 4, b.mass[p] * LoadVector(b.stress + 4 * p));
        }
        AddToRates(view.grid, w, b.count, shares);
      });
    }
  }

  void TensorsAt(const SweepView &view, int point, double tensors[8]) const override
  {
    if constexpr (dim == 2) {
      Weights w;
      SetWeights(view, point, w);
      const AtRates at(w, 0, view.grid.IndexSpace(), view.grid.Arrays().RatesArray());
      for (int k = 0; k < 8; ++k) tensors[k] = Gather<dim, false>(at, k).value[0];
    }
  }

  void ApplyRates(const SweepView &view, const RatesPlan &plan, Budgets &budgets, PointFailure &failure) const override
  {
    Weights w;
    Motion<dim> motion;
    alignas(64) Row projected[dim], smooth[kRate];
    ForEachBlock(view, [&](const Block &b) {
      Extents<dim> points = ExtentsOf<dim>(b);
      SetWeights<false>(view, b, points, w);
      GatherRates(view.grid, w, b, plan, motion, projected, smooth);
      if (b.average >= 0) AverageGrowth<Geometry>(b, points, view.grid, plan.dt, motion, budgets);
      if (plan.strain) AdvanceStress<Geometry>(b, points, plan.dt, plan.scale, motion, budgets, failure);
      if (plan.short_wave.On()) ShortWaveStress<Geometry>(b, points, view.grid, plan.short_wave, plan.dt, motion.u, smooth);
      if (plan.xpic_fraction > 0) MixVelocity(b, plan.xpic_fraction, projected, budgets);
      if (plan.move) Move<dim>(b, points, view.grid, plan.dt, motion.u, failure);
    });
  }

private:
  /// Returns the number of clamped half sizes, where it `counts`: one sweep of a step does.
  template <bool counts>
  static int SetWeights(const SweepView &view, const PointArrays &b, const Extents<dim> &points, Weights &w)
  {
    return ComputeAxisStencils<Geometry, Shape, counts>(view.grid.IndexSpace(), b.count, points, w);
  }
  /// Of one point, as the first of a block.
  static void SetWeights(const SweepView &view, int point, Weights &w)
  {
    const PointArrays one = Slice(view.points, point, point + 1);
    SetWeights<false>(view, one, ExtentsOf<dim>(one), w);
  }

  /// Velocity of the grid at the points of a block, and its change in the step, with the gradients of both; that of the change
  /// only where asked for.
  static void GatherVelocities(const Grid &grid, const Weights &w, const Block &b, bool change_gradient, Motion<dim> &motion,
                               Motion<dim> &change)
  {
    ForEachGroup(w, b.count, [&](int p, int) {
      const At<NodeLayout::Velocity(dim)> at(w, p, grid.IndexSpace(), grid.Arrays().VelocityArray());
      PrefetchNext<Geometry>(b, p, kMomentum);
      constexpr int kChange = NodeLayout::Velocity(dim) / 2; // size
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) {
        KeepGathered(Gather<dim>(at, d), d, p, motion);
        if (change_gradient)
          KeepGathered(Gather<dim>(at, kChange + d), d, p, change);
        else
          StoreVector(change.u[d] + p, Gather<dim, false>(at, kChange + d).value);
      }
    });
  }
  static void KeepGathered(const Gathered<dim> &sum, int d, int p, Motion<dim> &motion)
  {
    StoreVector(motion.u[d] + p, sum.value);
#pragma GCC unroll 3
    for (int a = 0; a < dim; ++a) StoreVector(motion.L[dim * d + a] + p, sum.slope[a]);
  }

  /// Mass-proportional damping of what the points move otherwise than the nodes, v_p <- v_p - share (v_p - sum S (v - dv)_i): the
  /// nodal forces have that of the nodes. Adds up what it takes with the change of velocity that follows.
  static void DampNoise(const PointArrays &b, double share, const Row *u, const Row *change, Budgets &budgets)
  {
    double work = 0;
    for (int d = 0; d < dim; ++d) {
      double impulse = 0;
      for (int p = 0; p < b.count; ++p) {
        double &v = b.velocity[dim * p + d];
        const double taken = share * (v - (u[d][p] - change[d][p])), given = b.mass[p] * taken;
        impulse -= given;
        work += given * (v + 0.5 * (change[d][p] - taken));
        v -= taken;
      }
      budgets.damping_impulse[d] += impulse;
    }
    budgets.damping_work += work;
  }

  static void AddVelocity(const PointArrays &b, const Row *change)
  {
    for (int p = 0; p < b.count; ++p)
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) b.velocity[dim * p + d] += change[d][p];
  }

  /// The second velocity, with its gradient where strain follows; of points that average their volume the new one; projected
  /// velocity; strain rate of the nodes.
  static void GatherRates(const Grid &grid, const Weights &w, const Block &b, const RatesPlan &plan, Motion<dim> &motion,
                          Row *projected, Row *smooth)
  {
    const int parts = kStressOfPoint | kInternal | (b.average >= 0 ? kMassOfPoint : 0) | (plan.xpic_fraction > 0 ? kMomentum : 0);
    ForEachGroup(w, b.count, [&](int p, int) {
      const AtRates at(w, p, grid.IndexSpace(), grid.Arrays().RatesArray());
      const At<NodeLayout::Velocity(dim)> new_velocity(w, p, grid.IndexSpace(), grid.Arrays().VelocityArray());
      const auto value = [&](int k) { return Gather<dim, false>(at, k).value; };
      PrefetchNext<Geometry>(b, p, parts);
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) {
        if (plan.strain)
          KeepGathered(b.average < 0 ? Gather<dim>(at, d) : Gather<dim>(new_velocity, d), d, p, motion);
        else
          StoreVector(motion.u[d] + p, value(d));
        if (plan.xpic_fraction > 0) StoreVector(projected[d] + p, value(NodeLayout::Projected(dim) + d));
      }
      if (!plan.short_wave.On()) return;
#pragma GCC unroll 6
      for (int k = 0; k < kRate; ++k) StoreVector(smooth[k] + p, value(NodeLayout::StrainRate(dim) + k));
    });
  }

  /// Puts the strain rates of a block in the place of its short-wave stress; returns the power of that stress, W,
  /// with the velocity of the points on the nodes. The new one holds what the points never get of its short waves.
  static double KeepStrainRate(const Block &b, const Extents<dim> &points, const Motion<dim> &motion, const Motion<dim> &change)
  {
    alignas(64) double volume[kBlock], sum = 0;
    alignas(64) Row stress[kRate], rate[kRate];
    const Row *const x = points.x, *const u = motion.u, *const L = motion.L, *const du = change.u, *const dL = change.L;
    Volumes<Geometry>(b, points, 1, volume);
    LoadRows<kRate>(b.short_wave_stress, b.count, stress);
#pragma omp simd reduction(+ : sum)
    for (int p = 0; p < b.count; ++p) {
      double power = 0;
#pragma GCC unroll 6
      for (int k = 0; k < kRate; ++k) {
        rate[k][p] = StrainRate<Geometry>(u, L, x, k, p);
        power += (Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1] ? 1 : 2) * stress[k][p] *
                 (rate[k][p] - StrainRate<Geometry>(du, dL, x, k, p));
      }
      sum += volume[p] * power;
    }
    StoreRows<kRate>(rate, b.count, b.short_wave_stress);
    return sum;
  }

  /// Adds momentum and mass times the strain rate kept, which the short-wave viscosity needs, to `rates`, and where it is
  /// projected momentum with the grid's velocity u.
  template <bool project> static void ScatterRates(const Grid &grid, const Weights &w, const PointArrays &b, const Row *u)
  {
    constexpr int n = NodeLayout::Rates(dim);
    alignas(64) double shares[kBlock * n];
    for (int p = 0; p < b.count; ++p) {
      const double mass = b.mass[p], *const v = b.velocity + dim * p, *const D = b.short_wave_stress + kRate * p;
      double *const share = shares + n * p;
      const auto of_grid = [=](int axis) { return project ? u[axis][p] : 0; };
      if constexpr (dim == 2) {
        StoreVector(share, mass * Join(LoadVector<HalfPack>(v), LoadVector<HalfPack>(D)));
        StoreVector(share + 4, mass * Pack{D[2], Geometry::kHoop ? D[3] : 0, of_grid(0), of_grid(1)});
      } else {
        StoreVector(share, mass * Pack{v[0], v[1], v[2], D[0]});
        StoreVector(share + 4, mass * LoadVector(D + 1));
        StoreVector(share + 8, mass * Pack{D[5], of_grid(0), of_grid(1), of_grid(2)});
        StoreVector(share + 12, Pack{});
      }
    }
    AddToRates(grid, w, b.count, shares);
  }

  /// Adds shares of a block to `rates`.
  static void AddToRates(const Grid &grid, const Weights &w, int count, const double *shares)
  {
    constexpr int n = NodeLayout::Rates(dim);
    ForEachGroup(w, count, [&](int first, int points) {
      AddToNodes<dim, n>(w, first, points, grid.IndexSpace(), grid.Arrays().RatesArray(), shares);
    });
  }

  /// v_p <- (1 - alpha) v_p + alpha sum S v2 (XPIC, or PIC at order 1), adding up the kinetic energy lost and the momentum.
  static void MixVelocity(const PointArrays &b, double fraction, const Row *projected, Budgets &budgets)
  {
    double lost = 0;
    alignas(64) Row velocity[dim];
    LoadRows<dim>(b.velocity, b.count, velocity);
    for (int axis = 0; axis < dim; ++axis) {
      double impulse = 0, *const own = velocity[axis];
      const double *const mean = projected[axis], *const mass = b.mass;
#pragma omp simd reduction(+ : lost, impulse)
      for (int p = 0; p < b.count; ++p) {
        const double v = own[p], mixed = v + fraction * (mean[p] - v);
        lost += 0.5 * mass[p] * (v - mixed) * (v + mixed);
        impulse += mass[p] * (mixed - v);
        own[p] = mixed;
      }
      budgets.xpic_impulse[axis] += impulse;
    }
    StoreRows<dim>(velocity, b.count, b.velocity);
    budgets.xpic_dissipation += lost;
  }
};

} // namespace

std::vector<std::string> ShapeFunctions() { return {"linear", "ugimp", "cpgimp"}; }

std::unique_ptr<Kernels> CreateKernels(GeometryKind geometry, const std::string &shape_function)
{
  return WithGeometry(geometry, [&](auto policy) -> std::unique_ptr<Kernels> {
    using Geometry = decltype(policy);
    if (shape_function == "linear") return std::make_unique<SweepKernels<Geometry, Linear>>();
    if (shape_function == "ugimp") return std::make_unique<SweepKernels<Geometry, UniformGimp>>();
    return std::make_unique<SweepKernels<Geometry, ContiguousGimp>>();
  });
}

} // namespace mlgimp
