// Shape functions: the weights and slopes of a block of material points on the nodes around them (paper's Eq. 6).
//
// A point is served by the three nodes per direction around its nearest node. The sweeps gather sums from a point's nodes
// and scatter its share to them by the functions below, in two dimensions and in three.
#pragma once

#include "pointwise/rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace mlgimp
{

/// Half sizes outside this range, in cells, are clamped: Evaluate divides by l, and three nodes reach no further.
inline constexpr double kMinHalfSize = 1e-3, kMaxHalfSize = 0.5;

/// The least half size of points that flow may make thin, in cells. A node that has mass of one point alone, as beyond a surface,
/// has a stiffness over mass of up to c^2/(h l) for each axis: with steps of 0.4 h/c it is stable down to this across the
/// surface.
inline constexpr double kMinFlowHalfSize = 0.06;

/// The index space of one rank's ghosted piece of a grid, as far as weights need it.
struct Lattice {
  double origin[3];       ///< position of global node 0, m
  double inverse_spacing; ///< 1/h, 1/m
  int first[3];           ///< global index of the first node of the ghosted array
  int stride[3];          ///< distance of neighbouring nodes in the ghosted array, nodes
  /// Where points end along each axis, at sides of symmetry: their places in cells from node 0.
  double end[3][2] = {{-HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, HUGE_VAL}};
  double least_half_size = kMinHalfSize; ///< of points, in cells
};

/// Weights of a block of points along each axis. The weight of a node is the product of its axes' weights w, the
/// derivative of that along an axis has the slope g in the place of that axis' weight. Index k is the node below, at
/// and above the nearest one. Weights of no point are zero.
template <int dim> struct AxisStencils {
  alignas(64) Row w[dim][3] = {};
  Row node = {};                  ///< nearest node, place in the ghosted array: a whole number
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
  return {{w_below, 1 - w_below - w_above, w_above}, {g_below, -g_below - g_above, g_above}};
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
/// Returns the number of half sizes that had to be clamped, where it `counts`.
template <class Geometry, class Shape, bool counts = true>
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
      const Pack excess = size - l, room = Least(a - grid.end[axis][0], grid.end[axis][1] - a);
      l = room > Pack{} ? Least(l, room) : l; // weights and slopes are exact then, however small the room is
      if constexpr (counts) off += excess * excess > 1e-18 ? Spread(1) : Pack{};
      AxisWeights<Pack> at = Shape::Evaluate(a - nearest, l, inverse_h);
      place += nearest * grid.stride[axis];
      if (Geometry::kHoop && axis == 0) {
        const HalfCentres<Pack> centres = Shape::Centres(a - nearest, l);
        const Pack radius = grid.origin[0] * inverse_h + nearest, inverse_radius = 1 / (grid.origin[0] * inverse_h + a);
        at.g[0] *= (radius + centres.below) * inverse_radius;
        at.g[2] *= (radius + centres.above) * inverse_radius;
        at.g[1] = -at.g[0] - at.g[2];
      }
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) {
        StoreVector(stencils.w[axis][k] + p, at.w[k]);
        StoreVector(stencils.g[axis][k] + p, at.g[k]);
      }
    }
    StoreVector(stencils.node + p, place);
    if constexpr (counts) clamped += FirstLanes(off, count - p);
  }
  return static_cast<int>(clamped[0] + clamped[1] + clamped[2] + clamped[3]);
}

/// Calls work(node, weight, slopes) for the nodes of point p of a block: place in the ghosted array, S, and the derivatives
/// of S along the axes. For code outside the sweeps.
template <int dim, class Work> void ForEachNodeOf(const AxisStencils<dim> &block, int p, const Lattice &grid, Work work)
{
  constexpr int kNodes = dim == 2 ? 9 : 27;
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
    count = std::min(CountEqual(LoadVector(block.node + first), block.node[first]), points - first);
    work(first, count);
  }
}

/// A place of which the compiler knows no more than that: else it finds out the distances of all nodes before the loop over
/// groups, and loads each of them from memory where an address with a constant in it would do.
inline double *Opaque(double *x)
{
  __asm__("" : "+r"(x));
  return x;
}

/// How far ahead along x a group asks for the nodes above it, which no group before has used.
inline constexpr int kNodesAhead = 4;

/// The stencils of a group of points as lanes of vectors, and their nodes in an array with so many components. Lanes beyond the
/// group hold the weights of other points, or zero.
template <int dim, int components> struct GroupStencil {
  Pack w[dim][3], g[dim][3];
  double *row[dim == 2 ? 3 : 9]; ///< the middle nodes of the rows along x, those of the second axis fastest

  GroupStencil(const AxisStencils<dim> &block, int first, const Lattice &grid, double *array)
  {
    const auto nearest = static_cast<std::ptrdiff_t>(block.node[first]);
#pragma GCC unroll 9
    for (int k = 0; k < (dim == 2 ? 3 : 9); ++k) {
      const std::ptrdiff_t beside = (k % 3 - 1) * static_cast<std::ptrdiff_t>(grid.stride[1]) +
                                    (dim == 2 ? 0 : (k / 3 - 1) * static_cast<std::ptrdiff_t>(grid.stride[2]));
      row[k] = Opaque(array + (nearest + beside) * components);
      if (k % 3 == 2) Prefetch<1>(row[k], kNodesAhead * components);
    }
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis)
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k)
        w[axis][k] = LoadVector(block.w[axis][k] + first), g[axis][k] = LoadVector(block.g[axis][k] + first);
  }
};

/// Sums of nodal values times weights, and times the slopes along each axis.
template <int axes> struct Gathered {
  Pack value{}, slope[axes]{};
};

/// Sums one component of the nodes of a group: rows along x first, then over the rows, so that products of weights are never
/// formed. Without `with_slope`, slopes stay zero. above: number of the layer that a sum along fewer axes is in.
template <int axes, bool with_slope = true, int dim, int components>
inline Gathered<axes> Gather(const GroupStencil<dim, components> &at, int component, int above = 0)
{
  constexpr int axis = axes - 1;
  Gathered<axes> sum;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    Pack value;
    if constexpr (axis == 0) {
      value = Spread(at.row[above][(k - 1) * components + component]);
    } else {
      const Gathered<axis> inner = Gather<axis, with_slope>(at, component, 3 * above + k);
      value = inner.value;
#pragma GCC unroll 3
      for (int a = 0; with_slope && a < axis; ++a)
        sum.slope[a] = k == 0 ? at.w[axis][k] * inner.slope[a] : sum.slope[a] + at.w[axis][k] * inner.slope[a];
    }
    sum.value = k == 0 ? at.w[axis][k] * value : sum.value + at.w[axis][k] * value; // zero would be one more addition
    if constexpr (with_slope) sum.slope[axis] = k == 0 ? at.g[axis][k] * value : sum.slope[axis] + at.g[axis][k] * value;
  }
  return sum;
}

/// What a group of points adds to its nodes: S value in each of `values` components, and S value + grad S . flux in each of
/// `fluxes` others. Lanes beyond the group are zero.
template <int axes, int values, int fluxes> struct Share {
  Pack value[values + fluxes], flux[fluxes + 1][axes]; // one more: there are no arrays of nothing
};

/// Calls add(node, sums [values + fluxes]) for the nodes of a group, with what each lane adds to it; products by rows as in
/// Gather.
template <int axes, int values, int fluxes, int dim, int components, class Add>
inline void Scatter(const GroupStencil<dim, components> &at, const Share<axes, values, fluxes> &share, Add add, int above = 0)
{
  constexpr int axis = axes - 1;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    Share<axis == 0 ? 1 : axis, values, fluxes> inner;
#pragma GCC unroll 9
    for (int c = 0; c < values + fluxes; ++c) inner.value[c] = at.w[axis][k] * share.value[c];
#pragma GCC unroll 3
    for (int c = 0; c < fluxes; ++c) inner.value[values + c] += at.g[axis][k] * share.flux[c][axis];
    if constexpr (axis == 0) {
      add(at.row[above] + (k - 1) * components, inner.value);
    } else {
#pragma GCC unroll 3
      for (int c = 0; c < fluxes; ++c)
#pragma GCC unroll 3
        for (int a = 0; a < axis; ++a) inner.flux[c][a] = at.w[axis][k] * share.flux[c][a];
      Scatter<axis>(at, inner, add, 3 * above + k);
    }
  }
}

/// Adds the sums over the lanes of n vectors to the doubles at `node`; where n is odd, zero to the next one.
template <int n> inline void AddSums(double *node, const Pack *x)
{
  if constexpr (n == 1 || n == 2) {
    StoreVector(node, LoadVector<HalfPack>(node) + SumLanes(x[0], n == 2 ? x[1] : Pack{}));
  } else {
    StoreVector(node, LoadVector(node) + SumLanes(x[0], x[1], x[2], n == 3 ? Pack{} : x[3]));
    if constexpr (n > 4) AddSums<n - 4>(node + 4, x + 4);
  }
}

} // namespace mlgimp
