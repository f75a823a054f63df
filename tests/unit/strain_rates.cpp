// Smooth strain rates of nodes: those of linear motions everywhere, of quadratic ones inside; blind to cells without points.
#include "grid/strain_rates.hpp"

#include "simulation/setup.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20261130);

constexpr double kH = 0.5; // m

/// v_i = a + B_ij x_j + C_ijk x_j x_k.
struct Polynomial {
  double a = 0.3, B[3][3], C[3][3][3];

  Polynomial(int dim, double quadratic)
  {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const bool used = i < dim && j < dim;
        B[i][j] = used ? Random(-1, 1) : 0;
        for (int k = 0; k < 3; ++k) C[i][j][k] = used && k < dim ? quadratic * Random(-1, 1) : 0;
      }
  }
  double Velocity(int i, Vec3 x) const
  {
    double v = a;
    for (int j = 0; j < 3; ++j) {
      v += B[i][j] * x[j];
      for (int k = 0; k < 3; ++k) v += C[i][j][k] * x[j] * x[k];
    }
    return v;
  }
  double StrainRate(int i, int j, Vec3 x) const
  {
    double D = (B[i][j] + B[j][i]) / 2;
    for (int k = 0; k < 3; ++k) D += (C[i][j][k] + C[i][k][j] + C[j][i][k] + C[j][k][i]) * x[k] / 2;
    return D;
  }
};

/// Nodes and cells of which those from 2 to 6 along each axis are full of points; beyond lie nodes that no cell with points has.
class Block
{
public:
  explicit Block(int dim, bool has_hoop = false) : dim_(dim), has_hoop_(has_hoop)
  {
    const GridGeometry geometry = {{0, 0, 0}, kH, {8, 8, dim == 3 ? 8 : 0}, 1, dim};
    EXPECT_EQ(grid_.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry)), PETSC_SUCCESS);
  }
  /// velocity(component, place); mass() of nodes.
  template <class Velocity, class Mass> void Move(Velocity velocity, Mass mass)
  {
    grid_.Arrays().ClearSums();
    ForEach(grid_.Ghosted(), [&](Index at) {
      const std::ptrdiff_t place = grid_.Place(at);
      const bool in_block = IsIn(at, 2, 6);
      grid_.Sums()[place].mass = in_block ? mass() : 1e-9;
      grid_.Arrays().Marks()[place] = IsIn(at, 2, 5) ? 1 : 0;
      for (int d = 0; d < dim_; ++d) grid_.Velocity(place).velocity[d] = in_block ? velocity(d, PlaceOf(at)) : 1e9;
    });
    FindStrainRates(grid_, has_hoop_);
  }
  /// Calls work(place, strain rates) for the nodes of the block that are so many cells from its surface or farther.
  template <class Work> void ForEachNode(int from_surface, Work work) const
  {
    int count = 0;
    ForEach(grid_.Ghosted(), [&](Index at) {
      if (!IsIn(at, 2 + from_surface, 6 - from_surface)) return;
      work(PlaceOf(at), grid_.Arrays().StrainRates(grid_.Place(at)));
      ++count;
    });
    EXPECT_GT(count, 4);
  }

private:
  bool IsIn(Index at, int lower, int upper) const
  {
    bool in = true;
    for (int d = 0; d < dim_; ++d) in = in && at[d] >= lower && at[d] <= upper;
    return in;
  }
  static Vec3 PlaceOf(Index at) { return {kH * at[0], kH * at[1], kH * at[2]}; }

  int dim_;
  bool has_hoop_;
  Grid grid_;
};

/// The axes of the components.
const std::vector<std::vector<int>> kInPlane = {{0, 0}, {1, 1}, {0, 1}},
                                    kInSpace = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};

void CheckPolynomial(int dim, double quadratic, int from_surface)
{
  Block block(dim);
  const Polynomial motion(dim, quadratic);
  block.Move([&](int d, Vec3 x) { return motion.Velocity(d, x); }, [&] { return quadratic > 0 ? 1 : Random(0.1, 1); });
  block.ForEachNode(from_surface, [&](Vec3 x, const double *rates) {
    int k = 0;
    for (const auto &axes : dim == 2 ? kInPlane : kInSpace)
      EXPECT_NEAR(rates[k++], motion.StrainRate(axes[0], axes[1], x), 1e-12) << "component " << k - 1 << ", in " << dim;
  });
}

} // namespace

TEST(StrainRates, OfLinearMotionsAlsoAtSurfaces)
{
  for (const int dim : {2, 3}) CheckPolynomial(dim, 0, 0);
}

TEST(StrainRates, OfQuadraticMotionsInside)
{
  for (const int dim : {2, 3}) CheckPolynomial(dim, 1, 1);
}

TEST(StrainRates, AlongTheHoop)
{
  constexpr double kRate = 0.7, kAlong = -0.4, kShear = 0.2;
  Block block(2, true);
  block.Move([&](int d, Vec3 x) { return d == 0 ? kRate * x[0] : kAlong * x[1] + kShear * x[0]; }, [] { return Random(0.1, 1); });
  block.ForEachNode(0, [&](Vec3, const double *rates) {
    EXPECT_NEAR(rates[0], kRate, 1e-13);
    EXPECT_NEAR(rates[1], kAlong, 1e-13);
    EXPECT_NEAR(rates[2], kRate, 1e-13);
    EXPECT_NEAR(rates[3], kShear / 2, 1e-13);
  });
}
