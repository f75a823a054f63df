// Shape functions by their properties at random places.
#include "physics/geometry.hpp"
#include "physics/shape.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// The mean over [d - l, d + l] of the hat function of `node`, exactly: trapezia between its kinks. l = 0: its value.
double MeanHat(int node, double d, double l)
{
  const auto hat = [&](double x) { return std::max(1 - std::abs(x - node), 0.0); };
  if (l == 0) return hat(d);
  double sum = 0, from = d - l;
  for (double knot : {node - 1.0, static_cast<double>(node), node + 1.0, d + l}) {
    const double to = std::min(std::max(knot, from), d + l);
    sum += 0.5 * (hat(from) + hat(to)) * (to - from);
    from = to;
  }
  return sum / (2 * l);
}

/// Largest errors of the weights along an axis over many random offsets; half sizes are drawn from `sizes`.
template <class Shape> void CheckAxisWeights(const std::string &name, const std::vector<double> &sizes)
{
  double unity = 0, slopes = 0, linear = 0, outside = 0, mean = 0, derivative = 0, mirror = 0;
  for (double l : sizes)
    for (int n = 0; n < 400; ++n) {
      const double d = Random(-0.4999, 0.4999), step = 1e-5 * (l > 0 ? l : 1);
      const AxisWeights at = Shape::Evaluate(d, l), back = Shape::Evaluate(-d, l);
      const AxisWeights above = Shape::Evaluate(d + step, l), below = Shape::Evaluate(d - step, l);
      unity = Largest({unity, std::abs(at.w[0] + at.w[1] + at.w[2] - 1)});
      slopes = Largest({slopes, std::abs(at.g[0] + at.g[1] + at.g[2])});
      linear = Largest({linear, std::abs(at.w[2] - at.w[0] - d) + std::abs(at.g[2] - at.g[0] - 1)});
      for (int k = 0; k < 3; ++k) {
        outside = Largest({outside, -at.w[k], at.w[k] - 1});
        mean = Largest({mean, std::abs(at.w[k] - MeanHat(k - 1, d, l))});
        mirror = Largest({mirror, std::abs(at.w[k] - back.w[2 - k]), std::abs(at.g[k] + back.g[2 - k])});
        if (l > 0 || std::abs(d) > step)
          derivative = Largest({derivative, std::abs((above.w[k] - below.w[k]) / (2 * step) - at.g[k])});
      }
    }
  // Round-off grows as 1/l, down to l = 1e-3. A difference across a kink of the slope, which is 1/(2 l) steep, is off by
  // up to step/(4 l).
  EXPECT_LE(unity, 1e-15) << name + ": weights add up to one";
  EXPECT_LE(slopes, 1e-12) << name + ": slopes add up to zero";
  EXPECT_LE(linear, 1e-12) << name + ": linear functions and their slope are reproduced";
  EXPECT_LE(outside, 1e-15) << name + ": weights leave [0, 1] by";
  EXPECT_LE(mean, 1e-12) << name + ": weights are means of the hat function";
  EXPECT_LE(derivative, 1e-5) << name + ": slopes are derivatives of the weights";
  EXPECT_LE(mirror, 1e-15) << name + ": a reflection exchanges weights";
}

/// Stencils of a block of points in 2D against products of means of hat functions over the points' current extent.
template <class Shape> void CheckStencil(const std::string &name)
{
  constexpr double kH = 0.37;
  const Lattice lattice = {{-1.3, 2.1, 0}, 1 / kH, {-2, 3, 0}, {1, 40, 0}, {{5, HUGE_VAL}, {-HUGE_VAL, 15}}, kMinHalfSize, true};
  double x[2 * kBlock], half[2 * kBlock], F[4 * kBlock], largest = 0;
  int clamped = 0;
  AxisStencils<2> stencil;
  for (int p = 0; p < kBlock; ++p) {
    for (int a = 0; a < 2; ++a) {
      x[2 * p + a] = lattice.origin[a] + kH * Random(5, 15);
      half[2 * p + a] = kH * (p % 8 == a ? 0.5 : p % 8 == 2 + a ? 0.7 : p % 8 == 4 + a ? 1e-4 : Random(0.05, 0.3));
    }
    for (int c = 0; c < 4; ++c) F[4 * p + c] = (c % 3 == 0) + (p % 8 < 6 ? 0 : Random(-0.3, 0.3));
  }
  const int counted = ComputeAxisStencils<PlaneStrain, Shape>(lattice, kBlock, Extents<2>(kBlock, x, half, F), stencil);
  for (int p = 0; p < kBlock; ++p) {
    double l[2], sum = 0;
    for (int a = 0; a < 2; ++a) {
      const double *f = F + 4 * p + 2 * a, *size = half + 2 * p;
      const double place = (x[2 * p + a] - lattice.origin[a]) / kH;
      l[a] = (Shape::kUsesDeformation ? std::hypot(f[0] * size[0], f[1] * size[1]) : size[a]) / kH;
      clamped += l[a] > kMaxHalfSize + 1e-9 || l[a] < kMinHalfSize;
      l[a] = std::min({std::max(l[a], kMinHalfSize), kMaxHalfSize, place - lattice.end[a][0], lattice.end[a][1] - place});
      if (std::is_same_v<Shape, Linear>) l[a] = 0;
    }
    double gradient[2][2] = {};
    ForEachNodeOf(stencil, p, lattice, [&](std::ptrdiff_t node, double weight, const std::array<double, 2> &slope) {
      const int index = static_cast<int>(node) + 40 * 3 - 2; // global node i + 40 j
      const double dx = (x[2 * p] - lattice.origin[0]) / kH - index % 40,
                   dy = (x[2 * p + 1] - lattice.origin[1]) / kH - index / 40;
      largest = Largest({largest, std::abs(weight - MeanHat(0, dx, l[0]) * MeanHat(0, dy, l[1]))});
      sum += weight;
      for (int a = 0; a < 2; ++a) {
        gradient[a][0] += slope[a] * kH * (index % 40);
        gradient[a][1] += slope[a] * kH * (index / 40);
      }
    });
    largest = Largest({largest, std::abs(sum - 1), 1e-2 * std::abs(gradient[0][0] - 1), 1e-2 * std::abs(gradient[1][1] - 1),
                       1e-2 * std::abs(gradient[0][1]), 1e-2 * std::abs(gradient[1][0])});
  }
  EXPECT_LE(largest, 1e-12) << name + ": weights of points in the plane, gradients of linear functions";
  EXPECT_EQ(counted, clamped) << name + ": clamped sizes are counted";
}

TEST(Shapes, AlongAnAxis)
{
  CheckAxisWeights<Linear>("linear", {0});
  CheckAxisWeights<UniformGimp>("GIMP", {0.5, 0.25, 0.125, 0.01, Random(0.02, 0.5), Random(0.02, 0.5), Random(0.02, 0.5)});
}

/// Whether a node lies above the cell that a place is in, along any axis.
template <int dim> bool LiesBeyondCell(std::ptrdiff_t node, const Lattice &lattice, const double *x)
{
  bool beyond = false;
  for (int axis = dim - 1; axis >= 0; --axis) {
    const double cell = std::floor(x[axis] * lattice.inverse_spacing);
    beyond = beyond || static_cast<double>(node / lattice.stride[axis]) > cell + 1;
    node %= lattice.stride[axis];
  }
  return beyond;
}

/// Nodes with mass of one point alone, at steps of 0.4 of the time in which the fastest wave crosses a cell: omega^2 dt^2 < 4, of
/// one node, and of a point with all nodes beyond its cell. It is thin across one axis, or across two.
template <class Geometry> void CheckLonePoint(const std::string &name)
{
  constexpr int dim = Geometry::kDim;
  constexpr double kH = 0.37, kCfl = 0.4;
  const double anywhere[2] = {-HUGE_VAL, HUGE_VAL};
  Lattice lattice = {{}, 1 / kH, {}, {1, 40, 1600}, {}, kMinFlowHalfSize};
  std::vector<double> x(dim * kBlock), half(dim * kBlock), F(dim * dim * kBlock);
  double largest = 0, together = 0;
  for (auto &end : lattice.end) std::copy_n(anywhere, 2, &end[0]);
  for (int n = 0; n < 1000; ++n) {
    for (double &place : x) place = kH * Random(5, 15);
    for (int k = 0; k < dim * kBlock; ++k) {
      const bool thin = k % dim == n / 2 % dim || (n % 2 && k % dim == (n / 2 + 1) % dim);
      half[k] = kH * (thin ? std::pow(10, Random(-4, -0.5)) : 0.25);
    }
    for (int p = 0; p < kBlock; ++p)
      for (int a = 0; a < dim; ++a) F[dim * (dim * p + a) + a] = 1;
    AxisStencils<dim> stencil;
    ComputeAxisStencils<Geometry, ContiguousGimp>(lattice, kBlock, Extents<dim>(kBlock, x.data(), half.data(), F.data()),
                                                  stencil);
    for (int p = 0; p < kBlock; ++p) {
      double beyond = 0;
      ForEachNodeOf(stencil, p, lattice, [&](std::ptrdiff_t node, double weight, const std::array<double, dim> &slope) {
        double square = 0;
        for (double s : slope) square += s * s * kH * kH;
        if (weight > 1e-9) largest = Largest({largest, kCfl * kCfl * square / weight});
        if (weight > 1e-9 && LiesBeyondCell<dim>(node, lattice, &x[dim * p])) beyond += kCfl * kCfl * square / weight;
      });
      together = Largest({together, beyond});
    }
  }
  EXPECT_LT(largest, 4) << name + ": stiffness over mass of a node times the square of a step";
  EXPECT_LT(together, 4) << name + ": of a point with the nodes beyond its cell, times the same";
}

TEST(Shapes, NodesOfAThinPointAreStable)
{
  CheckLonePoint<PlaneStrain>("plane strain");
  CheckLonePoint<Spatial>("space");
}

TEST(Shapes, LeastHalfSize)
{
  double mean = 0;
  for (int n = 0; n < 400; ++n)
    for (int k = 0; k < 3; ++k) {
      const double d = Random(-0.5, 0.5);
      mean = Largest({mean, std::abs(UniformGimp::Evaluate(d, kMinHalfSize).w[k] - MeanHat(k - 1, d, kMinHalfSize))});
    }
  EXPECT_LE(mean, 1e-12);
}

TEST(Shapes, InThePlane)
{
  CheckStencil<Linear>("linear");
  CheckStencil<UniformGimp>("uGIMP");
  CheckStencil<ContiguousGimp>("cpGIMP");
}

} // namespace
