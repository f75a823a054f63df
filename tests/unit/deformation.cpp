// How F advances in a step.
#include "physics/material.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20261126);

/// F of a block against the product component by component.
template <class G> void ExpectProduct()
{
  constexpr int n = G::kDim, kPoints = 64;
  constexpr double kDt = 0.02;
  Row L[9], F[9], before[9];
  double largest = 0, row = 0;
  for (int k = 0; k < n * n; ++k)
    for (int p = 0; p < kPoints; ++p) L[k][p] = Random(-3, 3), before[k][p] = F[k][p] = Random(-2, 2);
  const double returned = AdvanceDeformation<G>(kPoints, kDt, L, F);
  for (int p = 0; p < kPoints; ++p)
    for (int i = 0; i < n; ++i) {
      double sum = 0;
      for (int j = 0; j < n; ++j) {
        double product = before[n * i + j][p];
        for (int k = 0; k < n; ++k) product += kDt * L[n * i + k][p] * before[n * k + j][p];
        largest = Largest({largest, std::abs(F[n * i + j][p] - product)});
        sum += kDt * std::abs(L[n * i + j][p]);
      }
      row = Largest({row, sum});
    }
  EXPECT_LE(largest, 1e-15) << "F <- (I + dt L) F";
  EXPECT_LE(std::abs(returned - row), 1e-15) << "largest increment of strain";
}

TEST(Deformation, IsTheProductOfIncrements)
{
  ExpectProduct<PlaneStrain>();
  ExpectProduct<Spatial>();
}

} // namespace
