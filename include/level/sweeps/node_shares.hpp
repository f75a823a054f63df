// What the points of a block add to the sums of their nodes: mass, momentum and forces.
#pragma once

#include "level/sweeps/point_blocks.hpp"
#include "physics/group_sums.hpp"

#include <cstddef>
#include <type_traits>

namespace mlgimp
{

/// A node gets S times mass, owned mass and momentum of a point, and S body + grad S . flux as force. In space the third
/// component of momentum goes with the force, in front of it, as in NodeSums.
template <class Geometry> class NodeShares
{
  static constexpr int dim = Geometry::kDim, kForce = dim == 2 ? 2 : 4;
  using Force = std::conditional_t<dim == 2, HalfPack, Pack>;
  using Weights = AxisStencils<dim>;

public:
  static constexpr bool kHasBody = dim == 3 || Geometry::kHoop; ///< else `body` is that of an acceleration alone

  /// Of a block. In axisymmetry returns the radial force of the hoop stress, -sum V (sigma_zz + s_zz)/r, N.
  double Set(const Block &b, const Extents<dim> &extents, bool owned)
  {
    alignas(64) double volume[kBlock]; // negative, as the forces are
    double hoop_force = 0;
    const HalfPack counts = {1, owned ? 1.0 : 0.0};
    Volumes<Geometry>(b, extents, -1, volume);
    for (int p = 0; p < b.count; ++p) {
      const double *const v = b.velocity + dim * p, *const stress = b.stress + Geometry::kStress * p,
                          *const s = b.short_wave_stress + Geometry::kRate * p;
      double *const flux = flux_[p][0];
      StoreVector(sums_[p], b.mass[p] * Join(counts, LoadVector<HalfPack>(v)));
      if constexpr (dim == 2) {
        constexpr int xy = Geometry::kRate - 1;
        const Pack total = Pack{stress[0], stress[3], stress[3], stress[1]} + Pack{s[0], s[xy], s[xy], s[1]};
        StoreVector(flux, volume[p] * total);
      } else {
        double f[6]; // xx, yy, zz, xy, yz, xz
        for (int k = 0; k < 6; ++k) f[k] = volume[p] * (stress[k] + s[k]);
        StoreVector(flux, Pack{0, f[0], f[3], f[5]});
        StoreVector(flux + 4, Pack{0, f[3], f[1], f[4]});
        StoreVector(flux + 8, Pack{0, f[5], f[4], f[2]});
        StoreVector(body_[p], Pack{b.mass[p] * v[2], 0, 0, 0});
      }
      if constexpr (Geometry::kHoop) {
        const double hoop = volume[p] * (stress[2] + s[2]) / extents.x[0][p];
        StoreVector(body_[p], HalfPack{hoop, 0});
        hoop_force += hoop;
      }
    }
    return hoop_force;
  }

  void AddBodyForces(const Block &b, const BodyAcceleration &acceleration, double time)
  {
    double a[dim * kBlock] = {};
    acceleration(time, b.count, b.id, b.position, a);
    for (int p = 0; p < b.count; ++p)
      for (int d = 0; d < dim; ++d) {
        double &force = body_[p][kForce - dim + d];
        force = (kHasBody ? force : 0) + b.mass[p] * a[dim * p + d];
      }
  }

  /// Adds the shares of a block to its nodes. Sums and forces one after the other: the sums of three rows of nodes stay in
  /// registers then.
  template <bool with_body> void AddTo(const Grid &grid, const Weights &w, const Block &b) const
  {
    const Lattice &space = grid.IndexSpace();
    ForEachGroup(w, b.count, [&](int first, int count) {
      PrefetchNext<Geometry>(b, first, kMomentum | kStressOfPoint);
      AddToNodes<dim, kNode, 1, kLanes>(w, first, count, space, &grid.Sums()->mass, sums_[first]);
      ForEachRows<dim, kNode, kRows>(w, first, space, &grid.Sums()->mass + kPlace,
                                     [&](const NodeRows<dim, kRows> &rows) { AddForces<with_body>(w, first, count, rows); });
    });
  }

private:
  static constexpr int kNode = NodeLayout::kSums, kRows = RowsAtOnce(1); // size: doubles of a node; rows of nodes at once
  static constexpr int kPlace = offsetof(NodeSums, force) / sizeof(double) + dim - kForce;

  template <class Work> static void ForEachNode(Work work)
  {
#pragma GCC unroll 3
    for (int r = 0; r < kRows; ++r)
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) work(r, k);
  }

  template <bool with_body>
  [[gnu::always_inline]] void AddForces(const Weights &w, int first, int count, const NodeRows<dim, kRows> &rows) const
  {
    Force force[kRows][3];
    const auto node = [&](int r, int k) { return rows.middle[r] + (k - 1) * kNode; };
    const auto spread = [](double x) { return First<Force>(Spread(x)); };
    ForEachNode([&](int r, int k) { force[r][k] = LoadVector<Force>(node(r, k)); });
    for (int p = 0; p < count; ++p) {
      Force along[kRows], across[kRows]; // the axis x
#pragma GCC unroll 3
      for (int r = 0; r < kRows; ++r) {
        const auto flux = [&](int axis) { return LoadVector<Force>(flux_[first + p][axis]); };
        const Force S = spread(rows.Weight(r, p));
        along[r] = S * flux(0);
        across[r] = spread(rows.Slope(r, 1, p)) * flux(1);
        if constexpr (dim == 3) across[r] += spread(rows.Slope(r, 2, p)) * flux(2);
        if constexpr (with_body) across[r] += S * LoadVector<Force>(body_[first + p]);
      }
      ForEachNode([&](int r, int k) { force[r][k] += spread(w.w[0][k][first + p]) * across[r]; });
      ForEachNode([&](int r, int k) { force[r][k] += spread(w.g[0][k][first + p]) * along[r]; });
    }
    ForEachNode([&](int r, int k) { StoreVector(node(r, k), force[r][k]); });
  }

  alignas(32) double sums_[kBlock][kLanes];      ///< mass, owned mass, two components of momentum; kg, kg m/s
  alignas(32) double flux_[kBlock][dim][kForce]; ///< -V (sigma + s), by axes of the slope, J
  double body_[kBlock][kForce];                  ///< N; in space behind a component of momentum
};

} // namespace mlgimp
