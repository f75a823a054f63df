// Shape functions: the weights and slopes of a block of material points on the nodes around them (paper's Eq. 6).
//
// A point is served by the three nodes per direction around its nearest node.
#pragma once

#include "base/rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace mlgimp
{

/// Half sizes outside this range, in cells, are clamped: Evaluate divides by l, and three nodes reach no further.
inline constexpr double kMinHalfSize = 1e-3, kMaxHalfSize = 0.5;

/// The least half size of points that flow may make thin, in cells. Nodes that have mass of one point alone, as beyond a surface,
/// give it a stiffness over mass of up to c^2/(h l) for each axis along which they lie beyond: with steps of 0.4 h/c it is stable
/// down to this where it is thin across two, as at the edge of a lip.
inline constexpr double kMinFlowHalfSize = 0.125;

/// The index space of one rank's ghosted piece of a grid, as far as weights need it.
struct Lattice {
  double origin[3];       ///< position of global node 0, m
  double inverse_spacing; ///< 1/h, 1/m
  int first[3];           ///< global index of the first node of the ghosted array
  int stride[3];          ///< distance of neighbouring nodes in the ghosted array, nodes
  /// Where points end along each axis, at sides of symmetry: their places in cells from node 0.
  double end[3][2] = {{-HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, HUGE_VAL}};
  double least_half_size = kMinHalfSize; ///< of points, in cells
  bool has_ends = false;                 ///< whether there are such sides
};

/// Weights of a block of points along each axis. The weight of a node is the product of its axes' weights w, the
/// derivative of that along an axis has the slope g in the place of that axis' weight. Index k is the node below, at
/// and above the nearest one. Weights of no point are zero.
template <int dim> struct AxisStencils {
  alignas(64) Row w[dim][3] = {};
  Row node = {};                  ///< nearest node, place in the ghosted array: a whole number; -1 beyond the points
  alignas(64) Row g[dim][3] = {}; ///< 1/m
};

/// Where the points of a block are, their initial half sizes and their deformation gradients by rows.
template <int dim> struct Extents {
  alignas(64) Row x[dim], half_size[dim], F[dim * dim]; ///< m, m, -

  /// x, half_size [count][dim]; F [count][dim*dim]; count <= kBlock.
  Extents(int count, const double *x_of, const double *half_size_of, const double *F_of)
  {
    constexpr int n = dim * dim;
    int p = 0;
    for (; p + kLanes <= count; p += kLanes) {
      LoadLanes<dim>(x_of + dim * p, p, x), LoadLanes<dim>(half_size_of + dim * p, p, half_size);
      LoadLanes<n>(F_of + n * p, p, F);
    }
    LoadLast<dim>(x_of, p, count, x), LoadLast<dim>(half_size_of, p, count, half_size), LoadLast<n>(F_of, p, count, F);
  }
};

/// Weights and slopes (per cell) of the nodes below, at and above the nearest one, along one axis: of a point, or of the points
/// in the lanes of a Pack.
template <class Real> struct AxisWeights {
  Real w[3], g[3];
};

/// Completes a pair of outer weights and slopes: weights add up to one, slopes to zero.
template <class Real> inline AxisWeights<Real> Complete(Real w_below, Real w_above, Real g_below, Real g_above)
{
  return {{w_below, 1 - w_below - w_above, w_above}, {g_below, -(g_below + g_above), g_above}};
}

/// Centres of the parts of a point below and above its nearest node, in cells from the node.
template <class Real> struct HalfCentres {
  Real below, above;
};

/// The hat function at the point's centre: the original material point method.
struct Linear {
  static constexpr bool kUsesDeformation = false;
  /// d: centre less nearest node, in cells, |d| <= 1/2. Slopes are per cell times 1/h.
  template <class Real> static inline AxisWeights<Real> Evaluate(Real d, Real, double inverse_h = 1)
  {
    const Real zero{}, g_above = d < zero ? zero : zero + inverse_h;
    return Complete(Most(-d, zero), Most(d, zero), g_above - inverse_h, g_above);
  }
  template <class Real> static inline HalfCentres<Real> Centres(Real d, Real) { return {d, d}; }
};

/// The mean of the hat function over [d - l, d + l], from its antiderivative; l is the half size in cells, l <= 1/2.
struct UniformGimp {
  static constexpr bool kUsesDeformation = false;
  template <class Real> static inline AxisWeights<Real> Evaluate(Real d, Real l, double inverse_h = 1)
  {
    const double half_h = 0.5 / inverse_h;
    const Real zero{}, a0 = Least(d - l, zero), b0 = Least(d + l, zero); // the part below the nearest node
    const Real a1 = Most(d - l, zero), b1 = Most(d + l, zero);           // the part above it
    const Real q = 0.5 * inverse_h / l, g0 = q * (a0 - b0), g1 = q * (b1 - a1);
    return Complete(half_h * g0 * (a0 + b0), half_h * g1 * (a1 + b1), g0, g1);
  }
  template <class Real> static inline HalfCentres<Real> Centres(Real d, Real l)
  {
    const Real zero{};
    return {0.5 * (Least(d - l, zero) + Least(d + l, zero)), 0.5 * (Most(d - l, zero) + Most(d + l, zero))};
  }
};

/// The same with the rectangle stretched along each axis by F (contiguous-particle GIMP): l_a^2 = sum_b (F_ab l0_b)^2.
struct ContiguousGimp : UniformGimp {
  static constexpr bool kUsesDeformation = true;
};

/// Half sizes of the points in a Pack along an axis, m.
template <class Shape, int dim> inline Pack HalfSizes(int axis, const Extents<dim> &points, int p)
{
  if constexpr (!Shape::kUsesDeformation) return LoadVector(points.half_size[axis] + p);
  Pack square{};
#pragma GCC unroll 3
  for (int b = 0; b < dim; ++b) {
    const Pack edge = LoadVector(points.F[dim * axis + b] + p) * LoadVector(points.half_size[b] + p);
    square = b == 0 ? edge * edge : square + edge * edge;
  }
  return Root(square);
}

/// Weights of `count` <= kBlock points of a geometry.
/// In axisymmetry the slopes along the radius hold the mean radius of the part of the point on their side over the point's
/// radius, so that a uniform stress leaves no force. A point ends at the axis and at sides of symmetry: one that reached beyond
/// by rounding or strain would alone give mass to nodes there, whose stiffness over mass grows like its inverse size.
/// Returns the number of half sizes that had to be clamped, where it `counts`; without `slopes`, those stay as they were.
template <class Geometry, class Shape, bool counts, bool slopes, bool ends>
int ComputeAxisStencils(const Lattice &grid, int count, const Extents<Geometry::kDim> &points,
                        AxisStencils<Geometry::kDim> &stencils)
{
  constexpr int dim = Geometry::kDim;
  const double inverse_h = grid.inverse_spacing;
  double first = 0; // of the ghosted array
  Pack clamped{};
  for (int axis = 0; axis < dim; ++axis) first += static_cast<double>(grid.first[axis]) * grid.stride[axis];
  for (int p = 0; p < count; p += kLanes) {
    Pack place = Spread(-first), off{};
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis) {
      const Pack x = LoadVector(points.x[axis] + p), a = (x - grid.origin[axis]) * inverse_h, nearest = Floor(a + 0.5);
      const Pack size = HalfSizes<Shape, dim>(axis, points, p) * inverse_h;
      Pack l = Least(Most(size, Spread(grid.least_half_size)), Spread(kMaxHalfSize));
      const Pack excess = size - l;
      if constexpr (ends) {
        const Pack room = Least(a - grid.end[axis][0], grid.end[axis][1] - a);
        l = room > Pack{} ? Least(l, room) : l; // weights and slopes are exact then, however small the room is
      }
      if constexpr (counts) off += excess * excess > 1e-18 ? Spread(1) : Pack{};
      AxisWeights<Pack> at = Shape::Evaluate(a - nearest, l, inverse_h);
      place += nearest * grid.stride[axis];
      if (slopes && Geometry::kHoop && axis == 0) {
        const HalfCentres<Pack> centres = Shape::Centres(a - nearest, l);
        const Pack radius = grid.origin[0] * inverse_h + nearest, inverse_radius = 1 / (grid.origin[0] * inverse_h + a);
        at.g[0] *= (radius + centres.below) * inverse_radius;
        at.g[2] *= (radius + centres.above) * inverse_radius;
        at.g[1] = -at.g[0] - at.g[2];
      }
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) {
        StoreVector(stencils.w[axis][k] + p, at.w[k]);
        if constexpr (slopes) StoreVector(stencils.g[axis][k] + p, at.g[k]);
      }
    }
    StoreVector(stencils.node + p, place);
    if constexpr (counts) clamped += FirstLanes(off, count - p);
  }
  StoreVector(stencils.node + count, Spread(-1)); // no group goes beyond
  return static_cast<int>(clamped[0] + clamped[1] + clamped[2] + clamped[3]);
}
template <class Geometry, class Shape, bool counts = true, bool slopes = true>
int ComputeAxisStencils(const Lattice &grid, int count, const Extents<Geometry::kDim> &points,
                        AxisStencils<Geometry::kDim> &stencils)
{
  return grid.has_ends ? ComputeAxisStencils<Geometry, Shape, counts, slopes, true>(grid, count, points, stencils)
                       : ComputeAxisStencils<Geometry, Shape, counts, slopes, false>(grid, count, points, stencils);
}

/// Calls work(node, weight, slopes) for the nodes of point p of a block: place in the ghosted array, S, and the derivatives
/// of S along the axes. For code outside the sweeps.
template <int dim, class Work> void ForEachNodeOf(const AxisStencils<dim> &block, int p, const Lattice &grid, Work work)
{
  constexpr int kNodes = dim == 2 ? 9 : 27; // size
  for (int k = 0; k < kNodes; ++k) {
    const int at[3] = {k % 3, k / 3 % 3, k / 9};
    auto node = static_cast<std::ptrdiff_t>(block.node[p]);
    double weight = 1;
    std::array<double, dim> slope;
    slope.fill(1);
    for (int axis = 0; axis < dim; ++axis) {
      node += (at[axis] - 1) * static_cast<std::ptrdiff_t>(grid.stride[axis]);
      weight *= block.w[axis][at[axis]][p];
      for (int a = 0; a < dim; ++a) slope[a] *= (a == axis ? block.g : block.w)[axis][at[axis]][p];
    }
    work(node, weight, slope);
  }
}

/// Calls work(first, count) for the groups of a block: at most kLanes points in a row with the same nodes.
template <int dim, class Work> [[gnu::flatten]] void ForEachGroup(const AxisStencils<dim> &block, int points, Work work)
{
  for (int first = 0, count; first < points; first += count) {
    count = CountEqual(LoadVector(block.node + first), block.node[first]);
    work(first, count);
  }
}

} // namespace mlgimp
