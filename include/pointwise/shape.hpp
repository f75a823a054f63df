// Shape functions: the weights and slopes of a block of material points on the nodes around them (paper's Eq. 6).
//
// A point is served by the three nodes per direction around its nearest node. The sweeps gather sums from a point's nodes
// and scatter its share to them by the functions below, in two dimensions and in three.
#pragma once

#include "base/pack.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace mlgimp
{

/// Points are worked on in blocks of this many, small enough for the first-level cache.
inline constexpr int kBlock = 64;

/// The index space of one rank's ghosted piece of a grid, as far as weights need it.
struct Lattice {
  double origin[3];       ///< position of global node 0, m
  double inverse_spacing; ///< 1/h, 1/m
  int first[3];           ///< global index of the first node of the ghosted array
  int stride[3];          ///< distance of neighbouring nodes in the ghosted array, nodes
};

/// Weights of a block of points along each axis. The weight of a node is the product of its axes' weights w, the
/// derivative of that along an axis has the slope g in the place of that axis' weight. Index k is the node below, at
/// and above the nearest one.
template <int dim> struct AxisStencils {
  int node[kBlock];                                        ///< nearest node, place in the ghosted array
  alignas(64) double w[dim][3][kBlock], g[dim][3][kBlock]; ///< -, 1/m
};

/// Weights and slopes (per cell) of the nodes below, at and above the nearest one, along one axis.
struct AxisWeights {
  double w[3], g[3];
};

/// Completes a pair of outer weights and slopes: weights add up to one, slopes to zero.
inline AxisWeights Complete(double w_below, double w_above, double g_below, double g_above)
{
  return {{w_below, 1 - w_below - w_above, w_above}, {g_below, -g_below - g_above, g_above}};
}

/// Centres of the parts of a point below and above its nearest node, in cells from the node.
struct HalfCentres {
  double below, above;
};

/// The hat function at the point's centre: the original material point method.
struct Linear {
  static constexpr bool kUsesDeformation = false;
  /// d: centre less nearest node, in cells, |d| <= 1/2.
  static inline AxisWeights Evaluate(double d, double)
  {
    return Complete(std::max(-d, 0.0), std::max(d, 0.0), d < 0 ? -1.0 : 0.0, d < 0 ? 0.0 : 1.0);
  }
  static inline HalfCentres Centres(double d, double) { return {d, d}; }
};

/// The mean of the hat function over [d - l, d + l], from its antiderivative; l is the half size in cells, l <= 1/2.
struct UniformGimp {
  static constexpr bool kUsesDeformation = false;
  static inline AxisWeights Evaluate(double d, double l)
  {
    const double a0 = std::min(d - l, 0.0), b0 = std::min(d + l, 0.0); // the part below the nearest node
    const double a1 = (d - l) - a0, b1 = (d + l) - b0;                 // the part above it
    const double q = 0.5 / l;
    return Complete(0.5 * q * (a0 - b0) * (a0 + b0), 0.5 * q * (b1 - a1) * (b1 + a1), q * (a0 - b0), q * (b1 - a1));
  }
  static inline HalfCentres Centres(double d, double l)
  {
    return {0.5 * (std::min(d - l, 0.0) + std::min(d + l, 0.0)), 0.5 * (std::max(d - l, 0.0) + std::max(d + l, 0.0))};
  }
};

/// The same with the rectangle stretched along each axis by F (contiguous-particle GIMP): l_a^2 = sum_b (F_ab l0_b)^2.
struct ContiguousGimp : UniformGimp {
  static constexpr bool kUsesDeformation = true;
};

/// Half sizes outside this range, in cells, are clamped: Evaluate divides by l, and three nodes reach no further.
inline constexpr double kMinHalfSize = 1e-3, kMaxHalfSize = 0.5;

/// Half size of one point along an axis, m.
template <class Shape, int dim> inline double HalfSize(int axis, const double *half_size, const double *F)
{
  if constexpr (!Shape::kUsesDeformation) return half_size[axis];
  double square = 0;
#pragma GCC unroll 3
  for (int b = 0; b < dim; ++b) {
    const double edge = F[dim * axis + b] * half_size[b];
    square += edge * edge;
  }
  return std::sqrt(square);
}

/// Weights of `count` <= kBlock points of a geometry.
/// x [count][dim] positions, m; half_size [count][dim] initial half sizes, m; F [count][dim*dim] deformation gradient.
/// In axisymmetry the slopes along the radius hold the mean radius of the part of the point on their side over the point's
/// radius, so that a uniform stress leaves no force; the point ends at the axis.
/// Returns the number of half sizes that had to be clamped.
template <class Geometry, class Shape>
int ComputeAxisStencils(const Lattice &grid, int count, const double *x, const double *half_size, const double *F,
                        AxisStencils<Geometry::kDim> &stencils)
{
  constexpr int dim = Geometry::kDim;
  const double inverse_h = grid.inverse_spacing;
  double origin[dim], first[dim], stride[dim], node[kBlock], clamped = 0; // no integers: they would halve the vectors
  for (int axis = 0; axis < dim; ++axis)
    origin[axis] = grid.origin[axis], first[axis] = grid.first[axis], stride[axis] = grid.stride[axis];
#pragma omp simd reduction(+ : clamped)
  for (int p = 0; p < count; ++p) {
    node[p] = 0;
#pragma GCC unroll 3
    for (int axis = 0; axis < dim; ++axis) {
      const double a = (x[dim * p + axis] - origin[axis]) * inverse_h, nearest = std::floor(a + 0.5);
      double size = HalfSize<Shape, dim>(axis, half_size + dim * p, F + dim * dim * p) * inverse_h;
      if (Geometry::kHoop && axis == 0) size = std::min(size, x[dim * p] * inverse_h);
      const double l = std::min(std::max(size, kMinHalfSize), kMaxHalfSize);
      clamped += std::abs(size - l) > 1e-9 ? 1.0 : 0.0;
      AxisWeights at = Shape::Evaluate(a - nearest, l);
      node[p] += (nearest - first[axis]) * stride[axis];
      if (Geometry::kHoop && axis == 0) {
        const HalfCentres centres = Shape::Centres(a - nearest, l);
        const double radius = origin[0] * inverse_h + nearest, inverse_radius = 1 / (origin[0] * inverse_h + a);
        at.g[0] *= (radius + centres.below) * inverse_radius;
        at.g[2] *= (radius + centres.above) * inverse_radius;
        at.g[1] = -at.g[0] - at.g[2];
      }
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) stencils.w[axis][k][p] = at.w[k], stencils.g[axis][k][p] = at.g[k] * inverse_h;
    }
  }
  std::copy_n(node, count, stencils.node);
  return static_cast<int>(clamped);
}

/// Calls work(node, weight, slopes) for the nodes of point p of a block: place in the ghosted array, S, and the derivatives
/// of S along the axes. For code outside the sweeps.
template <int dim, class Work> void ForEachNodeOf(const AxisStencils<dim> &block, int p, const Lattice &grid, Work work)
{
  constexpr int kNodes = dim == 2 ? 9 : 27;
  for (int k = 0; k < kNodes; ++k) {
    const int at[3] = {k % 3, k / 3 % 3, k / 9};
    std::ptrdiff_t node = block.node[p];
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

/// One point's stencil in registers, for a nodal array with so many components.
template <int dim> struct PointStencil {
  double w[dim][3], g[dim][3];
  std::ptrdiff_t nearest;     ///< place of the nearest node in the array, doubles
  std::ptrdiff_t stride[dim]; ///< of neighbouring nodes, doubles

  PointStencil(const AxisStencils<dim> &block, int p, const Lattice &grid, int components)
  {
    nearest = static_cast<std::ptrdiff_t>(block.node[p]) * components;
    for (int axis = 0; axis < dim; ++axis) {
      stride[axis] = static_cast<std::ptrdiff_t>(grid.stride[axis]) * components;
      for (int k = 0; k < 3; ++k) w[axis][k] = block.w[axis][k][p], g[axis][k] = block.g[axis][k][p];
    }
  }
};

/// Sums of nodal values times weights, and times the slopes along each axis.
template <class Vector, int axes> struct Gathered {
  Vector value{}, slope[axes]{};
};

/// Sums the doubles of a Vector at the nodes around `node`: rows along x first, then over the rows, so that products of
/// weights are never formed. Without `with_slope`, slopes stay zero.
template <class Vector, int axes, bool with_slope = true, int dim>
inline Gathered<Vector, axes> Gather(const PointStencil<dim> &at, const double *node)
{
  constexpr int axis = axes - 1;
  Gathered<Vector, axes> sum;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    const double *row = node + (k - 1) * at.stride[axis];
    Vector value;
    if constexpr (axis == 0) {
      value = LoadVector<Vector>(row);
    } else {
      const Gathered<Vector, axis> inner = Gather<Vector, axis, with_slope>(at, row);
      value = inner.value;
#pragma GCC unroll 3
      for (int a = 0; with_slope && a < axis; ++a) sum.slope[a] += at.w[axis][k] * inner.slope[a];
    }
    sum.value += at.w[axis][k] * value;
    if constexpr (with_slope) sum.slope[axis] += at.g[axis][k] * value;
  }
  return sum;
}

/// What a point adds to the eight doubles of each of its nodes: S value + grad S . flux, the latter to the last four.
template <int axes> struct Share {
  WidePack value;
  HighPack flux[axes];
};

/// Adds a point's share to the nodes around `node`, products by rows as in Gather. Without `with_flux`, flux is zero.
template <int axes, bool with_flux, int dim>
inline void Scatter(const PointStencil<dim> &at, const Share<axes> &share, double *node)
{
  constexpr int axis = axes - 1;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    double *row = node + (k - 1) * at.stride[axis];
    WidePack value = at.w[axis][k] * share.value;
    if constexpr (with_flux) value += at.g[axis][k] * share.flux[axis];
    if constexpr (axis == 0) {
      StoreVector(row, LoadVector<WidePack>(row) + value);
    } else {
      Share<axis> inner = {value, {}};
#pragma GCC unroll 3
      for (int a = 0; with_flux && a < axis; ++a) inner.flux[a] = at.w[axis][k] * share.flux[a];
      Scatter<axis, with_flux>(at, inner, row);
    }
  }
}

} // namespace mlgimp
