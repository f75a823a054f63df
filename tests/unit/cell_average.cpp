// Against locking: points of a cell share their growth of volume, and the work that the stress has of it is in the budgets.
#include "level/sweeps/cell_average.hpp"

#include "simulation/setup.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <map>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20261125);

constexpr int kCount = 53;     // with a rest for vectors of four, eight and sixteen
constexpr double kStep = 1e-3; // s
constexpr double kH = 0.5;     // m, of cells; the grid begins at 0

/// Points of one metal, every other with outer faces, where no difference of volume settles.
template <class Geometry> struct Cloud {
  static constexpr int dim = Geometry::kDim, stresses = Geometry::kStress;
  Cloud()
  {
    for (double &v : x) v = Random(0.1, 1.9);
    for (double &v : stress) v = Random(-1e6, 1e6);
    for (int p = 0; p < kCount; ++p) {
      mass[p] = Random(1, 2), radius[p] = x[dim * p] * Random(0.95, 1.05), faces[p] = p % 2;
      for (int k = 0; k < dim * dim; ++k) F[dim * dim * p + k] = (k % (dim + 1) == 0) + Random(-0.05, 0.05);
    }
    for (Row &row : motion.L)
      for (double &v : row) v = Random(-1, 1);
    for (Row &row : motion.u)
      for (double &v : row) v = Random(-0.1, 0.1);
  }
  Block Of(const Material &material)
  {
    PointArrays a{};
    a.count = kCount, a.dim = dim, a.stress_components = stresses;
    a.position = x.data(), a.half_size = half.data(), a.F = F.data(), a.stress = stress.data(), a.mass = mass.data();
    a.faces = faces.data(), a.initial_radius = Geometry::kHoop ? radius.data() : nullptr;
    return {a, 0, material, 0};
  }
  /// det(I + dt L), with the growth along the hoop.
  double Ratio(int p, const Row *L) const
  {
    double A[dim * dim];
    for (int k = 0; k < dim * dim; ++k) A[k] = (k % (dim + 1) == 0) + kStep * L[k][p];
    return Determinant(A, dim) * (Geometry::kHoop ? 1 + kStep * motion.u[0][p] / x[dim * p] : 1);
  }
  /// m3; of a radian in axisymmetry.
  double Volume(int p, double density) const
  {
    const double hoop = Geometry::kHoop ? x[dim * p] / radius[p] : 1;
    return Determinant(&F[dim * dim * p], dim) * hoop * mass[p] / density;
  }
  std::vector<int> Cell(int p) const
  {
    std::vector<int> cell;
    for (int d = 0; d < dim; ++d) cell.push_back(static_cast<int>(std::floor(x[dim * p + d] / kH)));
    return cell;
  }
  std::vector<double> x = std::vector<double>(dim * kCount), half = std::vector<double>(dim * kCount, 0.1 * kH),
                      F = std::vector<double>(dim * dim * kCount), stress = std::vector<double>(stresses * kCount),
                      mass = std::vector<double>(kCount), radius = std::vector<double>(kCount);
  std::vector<int> faces = std::vector<int>(kCount);
  Motion<dim> motion{};
};

template <class Geometry> void CheckAverage(GeometryKind kind, double own)
{
  constexpr int dim = Geometry::kDim;
  constexpr double kDensity = 1000;
  const auto material = CreateMaterial("j2", {1e9, 0.3, kDensity, 1e6, 0}, kind);
  material->AverageVolume(own);
  const GridGeometry geometry = {{0, 0, 0}, kH, {4, 4, dim == 3 ? 4 : 0}, 1, dim};
  Grid grid;
  ASSERT_EQ(grid.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry), 1), PETSC_SUCCESS);
  Cloud<Geometry> cloud;
  const Motion<dim> before = cloud.motion;
  const Block block = cloud.Of(*material);
  const Extents<dim> points = ExtentsOf<dim>(block);
  Budgets budgets;
  grid.Arrays().ClearRates();
  AddGrowth<Geometry>(block, points, grid, kStep, cloud.motion);
  ASSERT_EQ(grid.ShareRates(0), PETSC_SUCCESS);
  AverageGrowth<Geometry>(block, points, grid, kStep, cloud.motion, budgets);

  struct Sums {
    double mass = 0, growth = 0, volume = 0;
  };
  std::map<std::vector<int>, Sums> sums;
  for (int p = 0; p < kCount; ++p) {
    Sums &cell = sums[cloud.Cell(p)];
    cell.mass += cloud.mass[p], cell.growth += cloud.mass[p] * (cloud.Ratio(p, before.L) - 1);
    cell.volume += cloud.Volume(p, kDensity);
  }
  double work = 0, size = 0;
  for (int p = 0; p < kCount; ++p) {
    const Sums &cell = sums[cloud.Cell(p)];
    const double of_cell = 1 + cell.growth / cell.mass, alone = cloud.Ratio(p, before.L);
    double rate2 = 0; // |D|^2
    for (int k = 0; k < dim * dim; ++k) rate2 += std::pow((before.L[k][p] + before.L[k % dim * dim + k / dim][p]) / 2, 2);
    const double difference = cloud.faces[p] ? 0 : cell.volume / cell.mass * cloud.mass[p] / cloud.Volume(p, kDensity) - 1;
    EXPECT_NEAR(cloud.Ratio(p, cloud.motion.L),
                std::pow(of_cell, 1 - own) * std::pow(alone, own) * std::exp(kSettling * kStep * std::sqrt(rate2) * difference),
                1e-12)
        << "point " << p;
    for (int d = 0; d < dim; ++d) { // the change of L is a sphere, but for products of dt L with it
      const double share = kStep * (cloud.motion.L[(dim + 1) * d][p] - before.L[(dim + 1) * d][p]) * cloud.Volume(p, kDensity) *
                           cloud.stress[Geometry::kStress * p + d];
      work -= share, size += std::abs(share);
    }
  }
  EXPECT_GT(sums.size(), 5U);
  EXPECT_NEAR(budgets.averaging_work, work, 2 * kStep * size);
}

} // namespace

TEST(CellAverage, GrowthAndWork)
{
  for (const double own : {0.0, 0.05}) {
    CheckAverage<PlaneStrain>(GeometryKind::kPlaneStrain, own);
    CheckAverage<Axisymmetric>(GeometryKind::kAxisymmetric, own);
    CheckAverage<Spatial>(GeometryKind::kSpatial, own);
  }
}
