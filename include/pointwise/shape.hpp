// Shape functions: the weights and slopes of a block of material points on the nodes around them (paper's Eq. 6).
//
// A point is served by the three nodes per direction around its nearest node. This is the only file that loops over
// axes; it returns flat stencils (node offset, S, grad S), and all transfer kernels loop over those.
#pragma once

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// Points are worked on in blocks of this many, small enough for the first-level cache.
inline constexpr int kBlock = 64;

/// The index space of one rank's ghosted piece of a grid, as far as weights need it.
template <int dim> struct Lattice {
  double origin[dim];     ///< position of global node 0, m
  double inverse_spacing; ///< 1/h, 1/m
  int first[dim];         ///< global index of the first node of the ghosted array
  int stride[dim];        ///< distance of neighbouring nodes in the ghosted array, nodes
};

/// Weights of a block of points: `node + offset[k]` is the k-th node of a point in the ghosted array.
template <int dim> struct Stencil {
  static constexpr int kNodes = dim == 2 ? 9 : 27;
  int offset[kNodes];
  int node[kBlock];              ///< nearest node
  double S[kNodes][kBlock];      ///< weights
  double dS[dim][kNodes][kBlock]; ///< gradients, 1/m
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

/// The hat function at the point's centre: the original material point method.
struct Linear {
  static constexpr bool kUsesDeformation = false;
  /// d: centre less nearest node, in cells, |d| <= 1/2.
  static inline AxisWeights Evaluate(double d, double)
  {
    return Complete(std::max(-d, 0.0), std::max(d, 0.0), d < 0 ? -1.0 : 0.0, d < 0 ? 0.0 : 1.0);
  }
};

/// The mean of the hat function over [d - l, d + l], from its antiderivative; l is the half size in cells, l <= 1/2.
struct UniformGimp {
  static constexpr bool kUsesDeformation = false;
  static inline AxisWeights Evaluate(double d, double l)
  {
    const double a0 = std::min(d - l, 0.0), b0 = std::min(d + l, 0.0); // the part below the nearest node
    const double a1 = std::max(d - l, 0.0), b1 = std::max(d + l, 0.0); // the part above it
    const double q = 0.5 / l;
    return Complete(0.5 * q * (a0 - b0) * (a0 + b0), 0.5 * q * (b1 - a1) * (b1 + a1), q * (a0 - b0), q * (b1 - a1));
  }
};

/// The same with the rectangle stretched along each axis by F (contiguous-particle GIMP): l_a^2 = sum_b (F_ab l0_b)^2.
struct ContiguousGimp : UniformGimp {
  static constexpr bool kUsesDeformation = true;
};

/// Half sizes outside this range, in cells, are clamped: Evaluate divides by l, and three nodes reach no further.
inline constexpr double kMinHalfSize = 1e-3, kMaxHalfSize = 0.5;

/// Half sizes of points in cells along an axis, within the clamps; returns the number that had to be clamped.
template <class Shape, int dim>
int ComputeHalfSizes(int axis, double inverse_h, int count, const double *half_size, const double *F, double *l)
{
  int clamped = 0;
#pragma omp simd reduction(+ : clamped)
  for (int p = 0; p < count; ++p) {
    double size = half_size[dim * p + axis];
    if constexpr (Shape::kUsesDeformation) {
      double square = 0;
#pragma GCC unroll 3
      for (int b = 0; b < dim; ++b) {
        const double edge = F[dim * dim * p + dim * axis + b] * half_size[dim * p + b];
        square += edge * edge;
      }
      size = std::sqrt(square);
    }
    size *= inverse_h;
    l[p] = std::min(std::max(size, kMinHalfSize), kMaxHalfSize);
    clamped += std::abs(size - l[p]) > 1e-9 ? 1 : 0;
  }
  return clamped;
}

/// Weights of `count` <= kBlock points.
/// x [count][dim] positions, m; half_size [count][dim] initial half sizes, m; F [count][dim*dim] deformation gradient.
/// Returns the number of half sizes that had to be clamped.
template <class Shape, int dim>
int ComputeStencil(const Lattice<dim> &grid, int count, const double *x, const double *half_size, const double *F,
                   Stencil<dim> &stencil)
{
  double w[dim][3][kBlock], g[dim][3][kBlock], l[kBlock];
  const double inverse_h = grid.inverse_spacing;
  int clamped = 0;
  std::fill_n(stencil.node, count, 0);
  for (int axis = 0; axis < dim; ++axis) {
    const double origin = grid.origin[axis];
    const int first = grid.first[axis], stride = grid.stride[axis];
    double *const wa[3] = {w[axis][0], w[axis][1], w[axis][2]}, *const ga[3] = {g[axis][0], g[axis][1], g[axis][2]};
    clamped += ComputeHalfSizes<Shape, dim>(axis, inverse_h, count, half_size, F, l);
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const double a = (x[dim * p + axis] - origin) * inverse_h, nearest = std::floor(a + 0.5);
      const AxisWeights at = Shape::Evaluate(a - nearest, l[p]);
      wa[0][p] = at.w[0], wa[1][p] = at.w[1], wa[2][p] = at.w[2];
      ga[0][p] = at.g[0] * inverse_h, ga[1][p] = at.g[1] * inverse_h, ga[2][p] = at.g[2] * inverse_h;
      stencil.node[p] += (static_cast<int>(nearest) - first) * stride;
    }
  }
  for (int k = 0; k < Stencil<dim>::kNodes; ++k) {
    stencil.offset[k] = 0;
    for (int axis = 0, rest = k; axis < dim; ++axis, rest /= 3) stencil.offset[k] += (rest % 3 - 1) * grid.stride[axis];
    for (int slope = -1; slope < dim; ++slope) { // S, then its derivative along each axis
      const double *factor[dim];
      for (int axis = 0, rest = k; axis < dim; ++axis, rest /= 3)
        factor[axis] = axis == slope ? g[axis][rest % 3] : w[axis][rest % 3];
      double *product = slope < 0 ? stencil.S[k] : stencil.dS[slope][k];
#pragma omp simd
      for (int p = 0; p < count; ++p) {
        double value = factor[0][p];
#pragma GCC unroll 3
        for (int axis = 1; axis < dim; ++axis) value *= factor[axis][p];
        product[p] = value;
      }
    }
  }
  return clamped;
}

} // namespace mlgimp
