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
      if (view.grid.Arrays().Marks()) MarkCells<dim>(view.grid, points.x, b.count);
      if (acceleration) shares.AddBodyForces(b, acceleration, time);
      if (NodeShares<Geometry>::kHasBody || acceleration)
        shares.template AddTo<true>(view.grid, w, b);
      else
        shares.template AddTo<false>(view.grid, w, b);
    });
  }

  void SpreadChange(const SweepView &view, const SpreadPlan &plan, Budgets &budgets) const override
  {
    Weights w;
    Motion<dim> motion;
    alignas(64) Row velocity[dim], change[dim];
    ForEachBlock(view, [&](const Block &b) {
      const Extents<dim> points = ExtentsOf<dim>(b);
      const bool grows = b.average >= 0;
      if (grows)
        SetWeights<false>(view, b, points, w);
      else if (plan.momentum)
        SetWeights<false, false>(view, b, points, w);
      if (grows) GatherMotion(view.grid, w, b, motion), AddGrowth<Geometry>(b, points, view.grid, plan.dt, motion);
      if (!plan.momentum) return;
      (plan.project || plan.velocity.damped > 0 ? Spread<true> : Spread<false>)(view.grid, w, b, velocity, change);
      ChangeVelocity(b, plan.velocity, velocity, change, budgets);
    });
  }

  void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, Budgets &budgets, PointFailure &failure) const override
  {
    Weights w;
    Motion<dim> motion;
    FromNodes nodes;
    alignas(64) Row rate[kRate];
    ForEachBlock(view, [&](const Block &b) {
      Extents<dim> points = ExtentsOf<dim>(b);
      SetWeights<false>(view, b, points, w);
      GatherNodes(view.grid, w, b, plan, motion, nodes);
      if (plan.change_velocity) ChangeVelocity(b, plan.velocity, nodes.velocity, nodes.change, budgets);
      if (plan.short_wave.On()) budgets.short_wave_dissipation += plan.dt * StrainRates<Geometry>(b, points, motion, rate);
      if (b.average >= 0) AverageGrowth<Geometry>(b, points, view.grid, plan.dt, motion, budgets);
      if (plan.strain) AdvanceStress<Geometry>(b, points, plan.dt, plan.scale, motion, budgets, failure);
      if (plan.short_wave.On())
        ShortWaveStress<Geometry>(b, points, view.grid, plan.short_wave, plan.dt, motion.u, rate, nodes.strain_rate);
      if (plan.xpic_fraction > 0) MixVelocity(b, plan.xpic_fraction, nodes.projected, budgets);
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

  void ScatterTensors(const SweepView &view, double *nodes) const override
  {
    if constexpr (dim == 2) {
      Weights w;
      alignas(64) double shares[kTensors * kBlock];
      ForEachBlock(view, [&](const Block &b) {
        SetWeights<false>(view, b, ExtentsOf<dim>(b), w);
        for (int p = 0; p < b.count; ++p) {
          StoreVector(shares + kTensors * p, b.mass[p] * LoadVector(b.F + 4 * p));
          StoreVector(shares + kTensors * p + 4, b.mass[p] * LoadVector(b.stress + 4 * p));
        }
        ForEachGroup(w, b.count, [&](int first, int count) {
          AddToNodes<dim, kTensors, kTensors / kLanes>(w, first, count, view.grid.IndexSpace(), nodes, shares + kTensors * first);
        });
      });
    }
  }

  void TensorsAt(const SweepView &view, double *nodes, int point, double *tensors) const override
  {
    if constexpr (dim == 2) {
      Weights w;
      SetWeights(view, point, w);
      const At<kTensors> at(w, 0, view.grid.IndexSpace(), nodes);
      for (int k = 0; k < kTensors; ++k) tensors[k] = Gather<dim, false>(at, k).value[0];
    }
  }

private:
  /// What the points of a block get from the nodes beside their motion.
  struct FromNodes {
    alignas(64) Row velocity[dim], change[dim], projected[dim], strain_rate[kRate];
  };

  /// Returns the number of clamped half sizes, where it `counts`: one sweep of a step does.
  template <bool counts, bool slopes = true>
  static int SetWeights(const SweepView &view, const PointArrays &b, const Extents<dim> &points, Weights &w)
  {
    return ComputeAxisStencils<Geometry, Shape, counts, slopes>(view.grid.IndexSpace(), b.count, points, w);
  }
  /// Of one point, as the first of a block.
  static void SetWeights(const SweepView &view, int point, Weights &w)
  {
    const PointArrays one = Slice(view.points, point, point + 1);
    SetWeights<false>(view, one, ExtentsOf<dim>(one), w);
  }

  /// The velocity that moves the points of a block, with its gradient: the second one, but of points that average their volume
  /// the new one. Its change, and as the plan needs them velocity, projected velocity and smooth strain rate of the nodes.
  static void GatherNodes(const Grid &grid, const Weights &w, const Block &b, const GridToPointsPlan &plan, Motion<dim> &motion,
                          FromNodes &nodes)
  {
    const bool second = plan.second_velocity && b.average < 0, rates = second || plan.xpic_fraction > 0;
    constexpr int kChange = NodeLayout::Velocity(dim) / 2; // size
    const auto value = [](const auto &at, int k) { return Gather<dim, false>(at, k).value; };
    ForEachGroup(w, b.count, [&](int p, int) {
      const At<NodeLayout::Velocity(dim)> velocity(w, p, grid.IndexSpace(), grid.Arrays().VelocityArray());
      PrefetchNext<Geometry>(b, p, kMomentum | kStressOfPoint | kInternal);
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) {
        if (plan.change_velocity) StoreVector(nodes.change[d] + p, value(velocity, kChange + d));
        if (!second) KeepGathered(Gather<dim>(velocity, d), d, p, motion);
        if (plan.change_velocity && plan.velocity.damped > 0) StoreVector(nodes.velocity[d] + p, value(velocity, d));
      }
      if (rates) {
        const AtRates at(w, p, grid.IndexSpace(), grid.Arrays().RatesArray());
#pragma GCC unroll 3
        for (int d = 0; d < dim; ++d) {
          if (second) KeepGathered(Gather<dim>(at, d), d, p, motion);
          if (plan.xpic_fraction > 0) StoreVector(nodes.projected[d] + p, value(at, NodeLayout::Projected(dim) + d));
        }
      }
      if (!plan.short_wave.On()) return;
      const AtRates at(w, p, grid.IndexSpace(), grid.Arrays().StrainRatesArray());
#pragma GCC unroll 6
      for (int k = 0; k < kRate; ++k) StoreVector(nodes.strain_rate[k] + p, value(at, k));
    });
  }
  /// The new velocity of the nodes at the points of a block, with its gradient.
  static void GatherMotion(const Grid &grid, const Weights &w, const Block &b, Motion<dim> &motion)
  {
    ForEachGroup(w, b.count, [&](int p, int) {
      const At<NodeLayout::Velocity(dim)> at(w, p, grid.IndexSpace(), grid.Arrays().VelocityArray());
      PrefetchNext<Geometry>(b, p, kMassOfPoint);
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) KeepGathered(Gather<dim>(at, d), d, p, motion);
    });
  }
  static void KeepGathered(const Gathered<dim> &sum, int d, int p, Motion<dim> &motion)
  {
    StoreVector(motion.u[d] + p, sum.value);
#pragma GCC unroll 3
    for (int a = 0; a < dim; ++a) StoreVector(motion.L[dim * d + a] + p, sum.slope[a]);
  }

  /// Points take the change of the nodes' velocity in the step; u: that velocity at them, needed where they are damped.
  static void ChangeVelocity(const PointArrays &b, const VelocityPlan &plan, const Row *u, const Row *change, Budgets &budgets)
  {
    if (plan.damped > 0) DampNoise(b, plan.damped, u, change, budgets);
    if (plan.counts_energy) budgets.exchange_energy += EnergyOf(b, change);
    AddVelocity(b, change);
  }

  /// Mass-proportional damping of what the points move otherwise than the nodes, v_p <- v_p - share (v_p - sum S (v - dv)_i): the
  /// nodal forces have that of the nodes.
  static void DampNoise(const PointArrays &b, double share, const Row *u, const Row *change, Budgets &budgets)
  {
    double work = 0;
    for (int d = 0; d < dim; ++d) {
      double impulse = 0;
      for (int p = 0; p < b.count; ++p) {
        double &v = b.velocity[dim * p + d];
        const double taken = share * (v - (u[d][p] - change[d][p])), given = b.mass[p] * taken;
        impulse -= given;
        work += given * (v - 0.5 * taken);
        v -= taken;
      }
      budgets.damping_impulse[d] += impulse;
    }
    budgets.damping_work += work;
  }

  /// v_p <- v_p + dv_p.
  static void AddVelocity(const PointArrays &b, const Row *change)
  {
    for (int p = 0; p < b.count; ++p)
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) b.velocity[dim * p + d] += change[d][p];
  }

  /// The kinetic energy that points get with dv, sum m dv . (v + dv/2), J.
  static double EnergyOf(const PointArrays &b, const Row *change)
  {
    alignas(64) Row velocity[dim];
    double energy = 0;
    LoadRows<dim>(b.velocity, b.count, velocity);
    for (int d = 0; d < dim; ++d) {
      const double *const v = velocity[d], *const dv = change[d], *const mass = b.mass;
#pragma omp simd reduction(+ : energy)
      for (int p = 0; p < b.count; ++p) energy += mass[p] * dv[p] * (v[p] + 0.5 * dv[p]);
    }
    return energy;
  }

  /// Adds mass times the change of the grid's velocity at the points of a block to `rates`, and where it is projected mass times
  /// that velocity.
  template <bool project> static void Spread(const Grid &grid, const Weights &w, const Block &b, Row *velocity, Row *change)
  {
    constexpr int n = NodeLayout::Rates(dim), kChange = NodeLayout::Velocity(dim) / 2, kProjected = NodeLayout::Projected(dim);
    alignas(64) double shares[kLanes * n];
    alignas(64) Row masses[1];
    LoadRows<1>(b.mass, b.count, masses);
    ForEachGroup(w, b.count, [&](int first, int count) {
      const At<NodeLayout::Velocity(dim)> at(w, first, grid.IndexSpace(), grid.Arrays().VelocityArray());
      const Pack mass = FirstLanes(LoadVector(masses[0] + first), count);
      PrefetchNext<Geometry>(b, first, kMomentum);
      Pack parts[n] = {};
#pragma GCC unroll 3
      for (int d = 0; d < dim; ++d) {
        const Pack dv = Gather<dim, false>(at, kChange + d).value;
        StoreVector(change[d] + first, dv);
        parts[d] = mass * dv;
        if (!project) continue;
        const Pack v = Gather<dim, false>(at, d).value;
        StoreVector(velocity[d] + first, v);
        parts[kProjected + d] = mass * v;
      }
      if constexpr (dim == 2 && !project)
        return AddPairsToNodes<n>(w, first, grid.IndexSpace(), grid.Arrays().RatesArray(), PointPairs(parts[0], parts[1]));
      constexpr int vectors = dim == 3 && project ? 2 : 1;
#pragma GCC unroll 2
      for (int k = 0; k < vectors; ++k) StoreTransposed(parts + kLanes * k, shares + kLanes * k, n);
      AddToNodes<dim, n, vectors>(w, first, count, grid.IndexSpace(), grid.Arrays().RatesArray(), shares);
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
