// The sweeps, written once for all geometries and shape functions.
#include "level/kernels.hpp"

#include "base/pack.hpp"
#include "level/point_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mlgimp
{

namespace
{

/// The vectors of doubles that the nodes of a geometry hold, and the places in them.
template <class Geometry> struct Lanes;

template <> struct Lanes<PlaneStrain> {
  using Velocity = Pack; ///< (v, dv) of a node
  static constexpr int kChange = 2;
  /// Stress and short-wave stress: xx, yy, zz, xy.
  static Pack Stress(const double *stress, const double *s) { return LoadVector<Pack>(stress) + Pack{s[0], s[1], 0, s[2]}; }
  static Pack Rate(const double *s) { return Pack{s[0], s[1], s[2], 0}; }
};

template <> struct Lanes<Axisymmetric> {
  using Velocity = Pack;
  static constexpr int kChange = 2;
  static Pack Stress(const double *stress, const double *s) { return LoadVector<Pack>(stress) + LoadVector<Pack>(s); }
  static Pack Rate(const double *s) { return LoadVector<Pack>(s); }
};

template <> struct Lanes<Spatial> {
  using Velocity = WidePack;
  static constexpr int kChange = 4;
};

/// Radial force of the hoop stress of a block, -sum V (sigma_zz + s_zz)/r, N.
double HoopForce(const Block &b, const double *volume)
{
  double force = 0;
  for (int p = 0; p < b.count; ++p)
    force -= volume[p] * (b.stress[4 * p + 2] + b.short_wave_stress[4 * p + 2]) / b.position[2 * p];
  return force;
}

/// What a point adds to the NodeSums of its nodes: S times mass, momentum, body force and owned mass, and grad S times the
/// stress, as a force. a: acceleration; counts: 1 for a point that the level owns, else 0; inverse_radius: 1/r in axisymmetry.
template <class Geometry>
inline Share<Geometry::kDim> NodeShare(const Block &b, int p, double volume, const double *a, double counts)
{
  constexpr int dim = Geometry::kDim;
  const double m = b.mass[p], *v = b.velocity + dim * p, *stress = b.stress + Geometry::kStress * p,
               *s = b.short_wave_stress + Geometry::kRate * p;
  static_assert(offsetof(NodeSums, momentum) == 8 && offsetof(NodeSums, force) == 32 && offsetof(NodeSums, owned_mass) == 56);
  if constexpr (dim == 2) {
    const Pack force = -volume * Lanes<Geometry>::Stress(stress, s); // xx, yy, zz, xy
    Pack body = m * Pack{a[0], a[1], 0, counts};
    if constexpr (Geometry::kHoop) body[0] += force[2] / b.position[dim * p];
    return {Join(m * Pack{1, v[0], v[1], 0}, body),
            {MakeHigh(Pack{force[0], force[3], 0, 0}), MakeHigh(Pack{force[3], force[1], 0, 0})}};
  } else {
    const Pack normal = -volume * (LoadVector<Pack>(stress) + LoadVector<Pack>(s)); // xx, yy, zz, xy
    const double yz = -volume * (stress[4] + s[4]), xz = -volume * (stress[5] + s[5]);
    return {Join(m * Pack{1, v[0], v[1], v[2]}, m * Pack{a[0], a[1], a[2], counts}),
            {MakeHigh(Pack{normal[0], normal[3], xz, 0}), MakeHigh(Pack{normal[3], normal[1], yz, 0}),
             MakeHigh(Pack{xz, yz, normal[2], 0})}};
  }
}

/// The sweeps in a geometry with a shape function.
template <class Geometry, class Shape> class SweepKernels : public Kernels
{
  static constexpr int dim = Geometry::kDim, kGradient = Geometry::kGradient, kRate = Geometry::kRate;
  using Weights = AxisStencils<dim>;
  using At = PointStencil<dim>;
  using Velocity = typename Lanes<Geometry>::Velocity;
  using Gradient = double[kGradient];

public:
  void PointsToGrid(const SweepView &view, const BodyAcceleration &acceleration, double time, Budgets &budgets) const override
  {
    Weights w;
    alignas(64) double volume[kBlock], body_force[dim * kBlock] = {};
    const double counts = view.owned ? 1 : 0;
    budgets.hoop_force = 0;
    ForEachBlock(view, [&](const Block &b) {
      budgets.clamped_sizes += SetWeights(view, b, w);
      Volumes<Geometry>(b, volume);
      if (acceleration) acceleration(time, b.count, b.id, b.position, body_force);
      if constexpr (Geometry::kHoop) budgets.hoop_force += HoopForce(b, volume);
      for (int p = 0; p < b.count; ++p) {
        const Share<dim> share = NodeShare<Geometry>(b, p, volume[p], body_force + dim * p, counts);
        const At at(w, p, view.grid.IndexSpace(), NodeLayout::kSums);
        Scatter<dim, true>(at, share, &view.grid.Sums()->mass + at.nearest);
      }
    });
  }

  void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, Budgets &budgets, PointFailure &failure) const override
  {
    Weights w;
    alignas(64) double L[kBlock][kGradient], volume[kBlock];
    ForEachBlock(view, [&](const Block &b) {
      double *const grid_velocity = view.grid_velocity + PointArrays::At(b.start, dim);
      Gradient *const gradient = b.average >= 0 ? GradientsOf(view, b) : plan.strain ? L : nullptr;
      SetWeights(view, b, w);
      double power = 0; // of the short-wave stress, W
      if (plan.strain_rate) Volumes<Geometry>(b, volume);
      for (int p = 0; p < b.count; ++p) {
        const At at(w, p, view.grid.IndexSpace(), NodeLayout::Velocity(dim));
        const auto sum = Gather<Velocity, dim>(at, view.grid.VelocityArray() + at.nearest);
        for (int d = 0; d < dim; ++d) {
          grid_velocity[dim * p + d] = Lane(sum.value, d);
          b.velocity[dim * p + d] += Lane(sum.value, Lanes<Geometry>::kChange + d);
        }
        if (gradient) StoreGradient(gradient[p], sum.slope);
        if (plan.strain_rate) power += volume[p] * KeepStrainRate(sum, b.position + dim * p, b.short_wave_stress + kRate * p);
        if (plan.scatter) ScatterRates(view.grid, w, b, p, grid_velocity + dim * p);
      }
      budgets.short_wave_dissipation += plan.dt * power;
      if (b.average >= 0) AddGrowth<Geometry>(b, view.grid, plan.dt, gradient, grid_velocity);
      if (plan.strain) AdvanceStress<Geometry>(b, plan.dt, L, grid_velocity, budgets, failure);
      if (plan.move) Move<Geometry>(b, view.grid, plan.dt, grid_velocity, failure);
    });
  }

  /// gradient = sum (v_i - v) grad S_ip with v the mean of the nodes' velocities by S.
  VelocitySample VelocityAt(const SweepView &view, int point, double mass_cutoff) const override
  {
    Weights w;
    Vec3 mean{};
    double sum = 0;
    VelocitySample sample{};
    SetWeights(view, Slice(view.points, point, point + 1), w);
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
      ForEachBlock(view, [&](const Block &b) {
        SetWeights(view, b, w);
        for (int p = 0; p < b.count; ++p) {
          const Pack F = LoadVector<Pack>(b.F + 4 * p), stress = LoadVector<Pack>(b.stress + 4 * p);
          const At at(w, p, view.grid.IndexSpace(), NodeLayout::Rates(dim));
          Scatter<dim, false>(at, {Join(b.mass[p] * F, b.mass[p] * stress), {}}, view.grid.RatesArray() + at.nearest);
        }
      });
    }
  }

  void TensorsAt(const SweepView &view, int point, double tensors[8]) const override
  {
    if constexpr (dim == 2) {
      Weights w;
      SetWeights(view, Slice(view.points, point, point + 1), w);
      const At at(w, 0, view.grid.IndexSpace(), NodeLayout::Rates(dim));
      StoreVector(tensors, Gather<WidePack, dim>(at, view.grid.RatesArray() + at.nearest).value);
    }
  }

  void ApplyRates(const SweepView &view, const RatesPlan &plan, Budgets &budgets, PointFailure &failure) const override
  {
    Weights w;
    alignas(64) double L[kBlock][kGradient], projected[kBlock][dim], smooth[kBlock][kRate];
    ForEachBlock(view, [&](const Block &b) {
      double *const grid_velocity = view.grid_velocity + PointArrays::At(b.start, dim);
      SetWeights(view, b, w);
      GatherRates(view.grid, w, b, plan, grid_velocity, L, projected, smooth);
      if (b.average >= 0) AverageGrowth<Geometry>(b, view.grid, plan.dt, grid_velocity, GradientsOf(view, b), L, budgets);
      if (plan.strain) AdvanceStress<Geometry>(b, plan.dt, L, grid_velocity, budgets, failure);
      if (plan.short_wave.On()) ShortWaveStress(b, view.grid, plan.short_wave, smooth);
      if (plan.xpic_fraction > 0) MixVelocity(b, plan.xpic_fraction, projected, budgets);
      if (plan.move) Move<Geometry>(b, view.grid, plan.dt, grid_velocity, failure);
    });
  }

private:
  static int SetWeights(const SweepView &view, const PointArrays &b, Weights &w)
  {
    return ComputeAxisStencils<Geometry, Shape>(view.grid.IndexSpace(), b.count, b.position, b.half_size, b.F, w);
  }

  /// Where the velocity gradients of a block that averages its volume stay between the sweeps.
  static Gradient *GradientsOf(const SweepView &view, const Block &b)
  {
    return reinterpret_cast<Gradient *>(view.gradient + PointArrays::At(b.start, kGradient));
  }

  /// L_ab = d v_a/d x_b, by rows, from the slopes of the velocity.
  template <class Vector> static void StoreGradient(double *L, const Vector (&slope)[dim])
  {
#pragma GCC unroll 3
    for (int i = 0; i < dim; ++i)
#pragma GCC unroll 3
      for (int j = 0; j < dim; ++j) L[dim * i + j] = Lane(slope[j], i);
  }

  /// Gradient of the second velocity; projected velocity; strain rate of the nodes. Before the points' own velocity is known
  /// the second one is what they move with.
  static void GatherRates(const Grid &grid, const Weights &w, const Block &b, const RatesPlan &plan, double *grid_velocity,
                          Gradient *L, double (*projected)[dim], double (*smooth)[kRate])
  {
    const bool own_gradient = b.average >= 0; // that of the new velocity
    for (int p = 0; p < b.count; ++p) {
      const At at(w, p, grid.IndexSpace(), NodeLayout::Rates(dim));
      const double *const nearest = grid.RatesArray() + at.nearest;
      const auto sum = own_gradient ? Gather<WidePack, dim, false>(at, nearest) : Gather<WidePack, dim>(at, nearest);
      WidePack rate = sum.value;
      if constexpr (dim == 3) rate = plan.short_wave.On() ? Gather<WidePack, dim>(at, nearest + 8).value : WidePack{};
      if (plan.strain && !own_gradient) StoreGradient(L[p], sum.slope);
      for (int d = 0; d < dim && !plan.move; ++d) grid_velocity[dim * p + d] = Lane(sum.value, d);
      for (int d = 0; d < dim; ++d) projected[p][d] = Lane(sum.value, NodeLayout::Projected(dim) + d);
      for (int k = 0; k < kRate; ++k) smooth[p][k] = Lane(rate, NodeLayout::StrainRate(dim) % 8 + k);
    }
  }

  /// Component of the strain rate from lanes that begin at `first`: of the new velocity, or of its change.
  static double StrainRate(const Gathered<Velocity, dim> &sum, int first, int component, double radius)
  {
    const int a = Geometry::kRateAxes[component][0], b = Geometry::kRateAxes[component][1];
    if (Geometry::kHoop && a == 2) return Lane(sum.value, first) / radius;
    return a == b ? Lane(sum.slope[a], first + a) : 0.5 * (Lane(sum.slope[a], first + b) + Lane(sum.slope[b], first + a));
  }

  /// Puts the strain rate of a point in the place of its short-wave stress s; returns the power of that stress, W/m3, with
  /// the mean velocity of the step.
  static double KeepStrainRate(const Gathered<Velocity, dim> &sum, const double *x, double *s)
  {
    double power = 0;
#pragma GCC unroll 6
    for (int k = 0; k < kRate; ++k) {
      const double rate = StrainRate(sum, 0, k, x[0]), change = StrainRate(sum, Lanes<Geometry>::kChange, k, x[0]);
      power += (Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1] ? 1 : 2) * s[k] * (rate - 0.5 * change);
      s[k] = rate;
    }
    return power;
  }

  /// Adds momentum, momentum of the grid's velocity u, and mass times strain rate of a point to `rates`.
  static void ScatterRates(const Grid &grid, const Weights &w, const PointArrays &b, int p, const double *u)
  {
    const double m = b.mass[p], *v = b.velocity + dim * p, *rate = b.short_wave_stress + kRate * p;
    const At at(w, p, grid.IndexSpace(), NodeLayout::Rates(dim));
    double *const nearest = grid.RatesArray() + at.nearest;
    if constexpr (dim == 2) {
      Scatter<dim, false>(at, {Join(m * Pack{v[0], v[1], u[0], u[1]}, m * Lanes<Geometry>::Rate(rate)), {}}, nearest);
    } else {
      Scatter<dim, false>(at, {Join(m * Pack{v[0], v[1], v[2], 0}, m * Pack{u[0], u[1], u[2], 0}), {}}, nearest);
      Scatter<dim, false>(at, {Join(m * LoadVector<Pack>(rate), m * Pack{rate[4], rate[5], 0, 0}), {}}, nearest + 8);
    }
  }

  /// |E|^2 of the Green strain E = (F^T F - I)/2.
  static double GreenStrainSquared(const double *F, double hoop)
  {
    double square = 0;
#pragma GCC unroll 6
    for (int k = 0; k < kRate; ++k) {
      const int a = Geometry::kRateAxes[k][0], b = Geometry::kRateAxes[k][1];
      double C = 0;
      if (Geometry::kHoop && a == 2)
        C = hoop * hoop;
      else
#pragma GCC unroll 3
        for (int c = 0; c < dim; ++c) C += F[dim * c + a] * F[dim * c + b];
      const double E = 0.5 * (a == b ? C - 1 : C);
      square += (a == b ? 1 : 2) * E * E;
    }
    return square;
  }

  /// h_p = min(0.3, a + b |E|^2): E is the Green strain, in metals the elastic (b_e - I)/2, as flow would make it a rate effect.
  static void ShortWaveStrength(const Block &b, const ShortWaveViscosity &viscosity, double *strength)
  {
    const double *const F = b.F, *const x = b.position, *const radius = b.initial_radius;
    if (b.material.IsMetal()) {
      const double *const history = b.history;
      const int stride = b.history_components;
#pragma omp simd
      for (int p = 0; p < b.count; ++p) strength[p] = ElasticStrainSquared(history + stride * p);
    } else {
#pragma omp simd
      for (int p = 0; p < b.count; ++p)
        strength[p] = GreenStrainSquared(F + dim * dim * p, Geometry::kHoop ? x[dim * p] / radius[p] : 1);
    }
#pragma omp simd
    for (int p = 0; p < b.count; ++p) strength[p] = std::min(0.3, viscosity.a + viscosity.b * strength[p]);
  }
  static double ElasticStrainSquared(const double *elastic)
  {
    const Sym3 strain = 0.5 * (LoadStress<Geometry>(elastic) - Sphere(1));
    return Contract(strain, strain);
  }

  /// s = h_p (h/c0) (lambda tr(D') I + 2 mu D'), D' = D - smooth.
  static void ShortWaveStress(const Block &b, const Grid &grid, const ShortWaveViscosity &viscosity,
                              const double (*smooth)[kRate])
  {
    const double time = grid.Geometry().spacing / b.material.SpeedOfSound();
    const double lambda = time * b.material.Lambda(), mu2 = 2 * time * b.material.Mu();
    double *const stress = b.short_wave_stress, strength[kBlock];
    ShortWaveStrength(b, viscosity, strength);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) {
      double *const s = stress + kRate * p;
      double trace = 0, difference[kRate];
#pragma GCC unroll 6
      for (int k = 0; k < kRate; ++k) {
        difference[k] = s[k] - smooth[p][k];
        if (Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1]) trace += difference[k];
      }
#pragma GCC unroll 6
      for (int k = 0; k < kRate; ++k) {
        const double sphere = Geometry::kRateAxes[k][0] == Geometry::kRateAxes[k][1] ? lambda * trace : 0;
        s[k] = strength[p] * (sphere + mu2 * difference[k]);
      }
    }
  }

  /// v_p <- (1 - alpha) v_p + alpha sum S v2 (XPIC, or PIC at order 1), adding up the kinetic energy lost and the momentum.
  static void MixVelocity(const PointArrays &b, double fraction, const double (*projected)[dim], Budgets &budgets)
  {
    double lost = 0;
    for (int axis = 0; axis < dim; ++axis) {
      double impulse = 0;
#pragma omp simd reduction(+ : lost, impulse)
      for (int p = 0; p < b.count; ++p) {
        double &v = b.velocity[dim * p + axis];
        const double mixed = v + fraction * (projected[p][axis] - v);
        lost += 0.5 * b.mass[p] * (v - mixed) * (v + mixed);
        impulse += b.mass[p] * (mixed - v);
        v = mixed;
      }
      budgets.xpic_impulse[axis] += impulse;
    }
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
