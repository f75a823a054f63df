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

/// The hat function at the point's centre: the original material point method.
struct Linear {
  static constexpr bool kUsesDeformation = false;
  /// d: centre less nearest node, in cells, |d| <= 1/2; w, g: weights and slopes (per cell) of the nodes -1, 0, 1.
  static inline void Evaluate(double d, double, double w[3], double g[3])
  {
    w[0] = std::max(-d, 0.0);
    w[2] = std::max(d, 0.0);
    g[0] = d < 0 ? -1.0 : 0.0;
    g[2] = d < 0 ? 0.0 : 1.0;
    w[1] = 1 - w[0] - w[2];
    g[1] = -g[0] - g[2];
  }
};

/// The mean of the hat function over [d - l, d + l], from its antiderivative; l is the half size in cells, l <= 1/2.
struct UniformGimp {
  static constexpr bool kUsesDeformation = false;
  static inline void Evaluate(double d, double l, double w[3], double g[3])
  {
    const double a0 = std::min(d - l, 0.0), b0 = std::min(d + l, 0.0); // the part below the nearest node
    const double a1 = std::max(d - l, 0.0), b1 = std::max(d + l, 0.0); // the part above it
    const double q = 0.5 / l;
    w[0] = 0.5 * q * (a0 - b0) * (a0 + b0);
    w[2] = 0.5 * q * (b1 - a1) * (b1 + a1);
    g[0] = q * (a0 - b0);
    g[2] = q * (b1 - a1);
    w[1] = 1 - w[0] - w[2];
    g[1] = -g[0] - g[2];
  }
};

/// The same with the rectangle stretched by the diagonal of F (contiguous-particle GIMP).
struct ContiguousGimp : UniformGimp {
  static constexpr bool kUsesDeformation = true;
};

/// Half sizes outside this range, in cells, are clamped: Evaluate divides by l, and three nodes reach no further.
inline constexpr double kMinHalfSize = 1e-3, kMaxHalfSize = 0.5;

/// Weights of `count` <= kBlock points.
/// x [count][dim] positions, m; half_size [count][dim] initial half sizes, m; F [count][dim*dim] deformation gradient.
/// Returns the number of half sizes that had to be clamped.
template <class Shape, int dim>
int ComputeStencil(const Lattice<dim> &grid, int count, const double *x, const double *half_size, const double *F,
                   Stencil<dim> &stencil)
{
  double w[dim][3][kBlock], g[dim][3][kBlock];
  const double inverse_h = grid.inverse_spacing;
  int clamped = 0;
  std::fill_n(stencil.node, count, 0);
  for (int axis = 0; axis < dim; ++axis) {
    const double origin = grid.origin[axis];
    const int first = grid.first[axis], stride = grid.stride[axis];
#pragma omp simd reduction(+ : clamped)
    for (int p = 0; p < count; ++p) {
      const double a = (x[dim * p + axis] - origin) * inverse_h, nearest = std::floor(a + 0.5);
      double size = half_size[dim * p + axis] * inverse_h;
      if constexpr (Shape::kUsesDeformation) {
        size = 0;
        for (int b = 0; b < dim; ++b) {
          const double edge = F[dim * dim * p + dim * axis + b] * half_size[dim * p + b];
          size += edge * edge;
        }
        size = std::sqrt(size) * inverse_h;
      }
      const double l = std::min(std::max(size, kMinHalfSize), kMaxHalfSize);
      clamped += std::abs(size - l) > 1e-9;
      double weight[3], slope[3];
      Shape::Evaluate(a - nearest, l, weight, slope);
      for (int k = 0; k < 3; ++k) {
        w[axis][k][p] = weight[k];
        g[axis][k][p] = slope[k] * inverse_h;
      }
      stencil.node[p] += (static_cast<int>(nearest) - first) * stride;
    }
  }
  for (int k = 0; k < Stencil<dim>::kNodes; ++k) {
    const double *weight[dim], *slope[dim];
    stencil.offset[k] = 0;
    for (int axis = 0, rest = k; axis < dim; ++axis, rest /= 3) {
      weight[axis] = w[axis][rest % 3];
      slope[axis] = g[axis][rest % 3];
      stencil.offset[k] += (rest % 3 - 1) * grid.stride[axis];
    }
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      double S = 1, dS[dim];
      for (int a = 0; a < dim; ++a) S *= weight[a][p];
      for (int b = 0; b < dim; ++b) {
        dS[b] = slope[b][p];
        for (int a = 0; a < dim; ++a) dS[b] *= a == b ? 1.0 : weight[a][p];
      }
      stencil.S[k][p] = S;
      for (int b = 0; b < dim; ++b) stencil.dS[b][k][p] = dS[b];
    }
  }
  return clamped;
}

} // namespace mlgimp
