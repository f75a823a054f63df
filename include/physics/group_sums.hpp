// Sums over the nodes of a group of points that share them: gathered from the nodes, points being the lanes of vectors, and
// added to them, components being the lanes. So neither way needs sums over lanes.
#pragma once

#include "physics/shape.hpp"

#include <cstddef>
#include <type_traits>

namespace mlgimp
{

/// Hides the address from GCC's optimiser, which otherwise finds out the distances of all nodes before the loop over
/// groups, and loads each of them from memory where an address with a constant in it would do.
inline double *Opaque(double *x)
{
  __asm__("" : "+r"(x));
  return x;
}

/// The middle node of a row of nodes along x of points with a nearest node, in an array with so many components; rows along y are
/// the fastest.
template <int dim, int components> inline double *MiddleOfRow(const Lattice &grid, double *nearest, int row)
{
  const std::ptrdiff_t along_y = static_cast<std::ptrdiff_t>(grid.stride[1]) * components,
                       along_z = static_cast<std::ptrdiff_t>(grid.stride[2]) * components;
  return Opaque(nearest + (row % 3 - 1) * along_y + (dim == 2 ? 0 : (row / 3 - 1) * along_z));
}

/// How far ahead along x a group asks for the nodes above it, which no group before has used.
inline constexpr int kNodesAhead = 4; // size

/// The stencils of a group of points as lanes of vectors, and their nodes in an array with so many components. Lanes beyond the
/// group hold the weights of other points, or zero.
template <int dim, int components> struct GroupStencil {
  Pack w[dim][3], g[dim][3];
  double *row[dim == 2 ? 3 : 9]; ///< the middle nodes of the rows along x, those of the second axis fastest

  GroupStencil(const AxisStencils<dim> &block, int first, const Lattice &grid, double *array)
  {
    double *const nearest = Opaque(array + static_cast<std::ptrdiff_t>(block.node[first]) * components);
#pragma GCC unroll 9
    for (int k = 0; k < (dim == 2 ? 3 : 9); ++k) {
      row[k] = MiddleOfRow<dim, components>(grid, nearest, k);
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

/// How many rows of nodes a scatter adds to at once, with so many registers for a node: as many as have their sums in registers,
/// beside a share for each row and what passes.
constexpr int RowsAtOnce(int registers) { return 12 * registers + 2 < kRegisters ? 3 : 1; } // size

/// Some of the rows of nodes along x of a group of points, from one on, and for each point the products of its weights along the
/// other axes.
template <int dim, int rows> struct NodeRows {
  const AxisStencils<dim> &block;
  int first, start;
  double *middle[rows];              ///< their middle nodes
  double product[rows][dim][kLanes]; ///< in space

  /// Of point p of the group: S of the other axes, or with the slope along an axis in the place of its weight.
  double Weight(int row, int p) const { return dim == 2 ? block.w[1][start + row][first + p] : product[row][0][p]; }
  double Slope(int row, int axis, int p) const { return dim == 2 ? block.g[1][start + row][first + p] : product[row][axis][p]; }
};

/// Calls work(NodeRows) for all rows of nodes of a group of points, so many at once, in an array with so many components.
template <int dim, int components, int n, class Work>
[[gnu::always_inline]] inline void ForEachRows(const AxisStencils<dim> &block, int first, const Lattice &grid, double *array,
                                               Work work)
{
  double *const nearest = Opaque(array + static_cast<std::ptrdiff_t>(block.node[first]) * components);
#pragma GCC unroll 9
  for (int start = 0; start < (dim == 2 ? 3 : 9); start += n) {
    NodeRows<dim, n> rows = {block, first, start, {}, {}};
#pragma GCC unroll 3
    for (int r = 0; r < n; ++r) {
      const int y = (start + r) % 3, z = (start + r) / 3;
      rows.middle[r] = MiddleOfRow<dim, components>(grid, nearest, start + r);
      if (y == 2) Prefetch<1>(rows.middle[r], kNodesAhead * components);
      if constexpr (dim == 3) {
        const auto at = [=](const Row &row) { return LoadVector(row + first); };
        StoreVector(rows.product[r][0], at(block.w[1][y]) * at(block.w[2][z]));
        StoreVector(rows.product[r][1], at(block.g[1][y]) * at(block.w[2][z]));
        StoreVector(rows.product[r][2], at(block.w[1][y]) * at(block.g[2][z]));
      }
    }
    work(rows);
  }
}

/// Adds S times the shares of a group of points to their nodes, to the first `vectors` vectors of four of their components;
/// shares [][stride] of the points of the group. Vectors hold the components of a point: sums over points then need no sums
/// over lanes.
template <int dim, int components, int vectors, int stride = components>
inline void AddToNodes(const AxisStencils<dim> &block, int first, int count, const Lattice &grid, double *array,
                       const double *shares)
{
  using Vector = std::conditional_t<vectors % (kWideLanes / kLanes) == 0, WidePack, Pack>;
  constexpr int lanes = sizeof(Vector) / sizeof(double), n = vectors * kLanes / lanes, kRows = RowsAtOnce(n);
  ForEachRows<dim, components, kRows>(block, first, grid, array, [&](const NodeRows<dim, kRows> &rows) {
    Vector sum[kRows][3][n];
    const auto place = [&](int r, int k, int c) { return rows.middle[r] + (k - 1) * components + lanes * c; };
    const auto for_each = [&](auto work) {
#pragma GCC unroll 3
      for (int r = 0; r < kRows; ++r)
#pragma GCC unroll 3
        for (int k = 0; k < 3; ++k)
#pragma GCC unroll 4
          for (int c = 0; c < n; ++c) work(r, k, c);
    };
    for_each([&](int r, int k, int c) { sum[r][k][c] = LoadVector<Vector>(place(r, k, c)); });
    for (int p = 0; p < count; ++p) {
      Vector share[kRows][n];
#pragma GCC unroll 3
      for (int r = 0; r < kRows; ++r)
#pragma GCC unroll 4
        for (int c = 0; c < n; ++c) share[r][c] = rows.Weight(r, p) * LoadVector<Vector>(shares + stride * p + lanes * c);
      for_each([&](int r, int k, int c) { sum[r][k][c] += block.w[0][k][first + p] * share[r][c]; });
    }
    for_each([&](int r, int k, int c) { StoreVector(place(r, k, c), sum[r][k][c]); });
  });
}

/// Two numbers of each point of a group, as of even and odd points: (x0, y0, x2, y2) and (x1, y1, x3, y3). The two numbers of a
/// point would fill half a vector.
struct PointPairs {
  Pack even, odd;

  PointPairs(Pack x, Pack y) : even(EvenLanes(x, y)), odd(OddLanes(x, y)) {}
  explicit PointPairs(Pack both) : PointPairs(both, both) {}
};

/// Adds S times two numbers of the points of a group to the first two components of their nodes, in the plane; those of lanes
/// beyond the group are to be zero.
template <int components>
inline void AddPairsToNodes(const AxisStencils<2> &block, int first, const Lattice &grid, double *array, const PointPairs &share)
{
  const auto pairs = [&](const Row &row) { return PointPairs(LoadVector(row + first)); };
  const PointPairs w[3] = {pairs(block.w[0][0]), pairs(block.w[0][1]), pairs(block.w[0][2])};
  ForEachRows<2, components, 3>(block, first, grid, array, [&](const NodeRows<2, 3> &rows) {
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r) {
      const PointPairs of_row = pairs(block.w[1][r]);
      const Pack even = of_row.even * share.even, odd = of_row.odd * share.odd;
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) {
        const Pack sum = w[k].even * even + w[k].odd * odd;
        double *const node = rows.middle[r] + (k - 1) * components;
        StoreVector(node, LoadVector<HalfPack>(node) + (Low(sum) + High(sum)));
      }
    }
  });
}

} // namespace mlgimp
