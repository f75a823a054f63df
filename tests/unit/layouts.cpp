// Cuts of a grid into blocks, and blocks to ranks: against the best of all cuts, and by their properties.
#include "hierarchy/partition/balance.hpp"
#include "hierarchy/partition/mapping.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// A grid of points per node with a cloud somewhere, few points elsewhere.
std::vector<double> Cloud(int width, int height)
{
  std::vector<double> points;
  const double x = Random(0, width), y = Random(0, height), size = Random(6, 12);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) points.push_back(std::hypot(i - x, j - y) < size ? 40 : i % 3);
  return points;
}

/// The node of each point.
std::vector<Index> NodesOf(const std::vector<double> &points, int width)
{
  std::vector<Index> nodes;
  for (int k = 0; k < static_cast<int>(points.size()); ++k)
    nodes.insert(nodes.end(), static_cast<int>(points[k]), {k % width, k / width, 0});
  return nodes;
}

/// Points of nodes [i, i + columns) x [j, j + rows), and a point for each halo node.
double Work(const std::vector<double> &points, int width, int i, int j, int columns, int rows)
{
  const int height = static_cast<int>(points.size()) / width;
  double work = 2 * kHaloWidth * ((columns < width ? rows : 0) + (rows < height ? columns : 0));
  for (int b = j; b < j + rows; ++b)
    for (int a = i; a < i + columns; ++a) work += points[b * width + a];
  return work;
}

double LargestWork(const std::vector<double> &points, int width, const GridLayout &layout)
{
  double largest = 0;
  int j = 0;
  for (const int rows : layout.widths[1]) {
    int i = 0;
    for (const int columns : layout.widths[0])
      largest = Largest({largest, Work(points, width, i, j, columns, rows)}), i += columns;
    j += rows;
  }
  return largest;
}

void ExpectWhole(const GridLayout &layout, int width, int height)
{
  const int nodes[2] = {width, height};
  for (int axis = 0; axis < 2; ++axis) {
    const auto &widths = layout.widths[axis];
    EXPECT_EQ(std::accumulate(widths.begin(), widths.end(), 0), nodes[axis]);
    EXPECT_GE(*std::min_element(widths.begin(), widths.end()), std::min(kHaloWidth, nodes[axis]));
  }
  EXPECT_EQ(static_cast<int>(layout.ranks.size()), layout.Blocks());
}

} // namespace

TEST(Layouts, DivideByWeight)
{
  EXPECT_EQ(DivideByWeight(std::vector<double>(12, 1.0), 4, 3), (std::vector<PetscInt>{3, 3, 3, 3}));
  EXPECT_EQ(DivideByWeight({4, 1, 1, 1, 1}, 2, 1), (std::vector<PetscInt>{1, 4}));
  EXPECT_EQ(DivideByWeight({0, 0, 0, 0, 0, 9}, 2, 3), (std::vector<PetscInt>{3, 3}));
  for (int n = 0; n < 100; ++n) {
    const int parts = 1 + n % 5, minimum = 1 + n % 3;
    std::vector<double> weights;
    for (int k = 0; k < 40; ++k) weights.push_back(Random(0, 1));
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    int end = 0;
    double sum = 0;
    const std::vector<PetscInt> widths = DivideByWeight(weights, parts, minimum);
    ASSERT_EQ(static_cast<int>(widths.size()), parts);
    for (int part = 0; part < parts; ++part) {
      EXPECT_GE(widths[part], minimum);
      for (int k = 0; k < widths[part]; ++k) sum += weights[end++];
      EXPECT_NEAR(sum, total * (part + 1) / parts, 0.5) << "half of the largest weight";
    }
    EXPECT_EQ(end, 40);
  }
}

/// A grid of so many nodes, padding included.
GridGeometry Plane(int width, int height) { return {{}, 1, {width - 3, height - 3, 0}, 1, 2}; }

/// Rows are too few to cut, so that all cuts can be tried.
TEST(Layouts, BestCutsAlongAnAxis)
{
  constexpr int kWidth = 30, kHeight = 2 * kHaloWidth - 1;
  for (int n = 0; n < 50; ++n) {
    const std::vector<double> points = Cloud(kWidth, kHeight);
    GridLayout layout, other;
    ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, 3, 1, NodesOf(points, kWidth), Plane(kWidth, kHeight), &layout), PETSC_SUCCESS);
    ExpectWhole(layout, kWidth, kHeight);
    ASSERT_EQ(layout.widths[0].size(), 3U);
    double least = HUGE_VAL;
    for (int a = kHaloWidth; a <= kWidth - 2 * kHaloWidth; ++a)
      for (int b = kHaloWidth; b <= kWidth - a - kHaloWidth; ++b) {
        other.widths = {{{a, b, kWidth - a - b}, {kHeight}, {1}}};
        least = std::min(least, LargestWork(points, kWidth, other));
      }
    EXPECT_LE(LargestWork(points, kWidth, layout), least * (1 + 1e-3));
  }
}

TEST(Layouts, CutsOfThePlane)
{
  constexpr int kWidth = 40, kHeight = 28;
  for (int n = 0; n < 50; ++n) {
    const int ranks = 2 + n % 7;
    const std::vector<double> points = Cloud(kWidth, kHeight);
    GridLayout layout;
    ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, ranks, 1, NodesOf(points, kWidth), Plane(kWidth, kHeight), &layout), PETSC_SUCCESS);
    ExpectWhole(layout, kWidth, kHeight);
    EXPECT_EQ(layout.Blocks(), ranks);
    for (int columns = 1; columns <= ranks; ++columns) { // no worse than any division by the sums of columns and rows
      if (ranks % columns || ranks / columns * kHaloWidth > kHeight) continue;
      std::vector<double> by_column(kWidth, 0.0), by_row(kHeight, 0.0);
      for (int k = 0; k < kWidth * kHeight; ++k) by_column[k % kWidth] += points[k], by_row[k / kWidth] += points[k];
      GridLayout plain;
      plain.widths = {DivideByWeight(by_column, columns, kHaloWidth), DivideByWeight(by_row, ranks / columns, kHaloWidth), {1}};
      EXPECT_LE(LargestWork(points, kWidth, layout), LargestWork(points, kWidth, plain) * (1 + 1e-3));
    }
  }
}

/// Each rank knows some of the points, and all find the layout that one finds who knows all.
TEST(LayoutsOnRanks, SameAsOnOne)
{
  constexpr int kWidth = 40, kHeight = 28;
  PetscMPIInt rank, ranks;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Random.seed(5);
  for (int n = 0; n < 20; ++n) {
    const std::vector<Index> all = NodesOf(Cloud(kWidth, kHeight), kWidth);
    std::vector<Index> own;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (static_cast<int>(k * k % ranks) == rank) own.push_back(all[k]);
    GridLayout alone, together;
    ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, 6, 1, all, Plane(kWidth, kHeight), &alone), PETSC_SUCCESS);
    ASSERT_EQ(FirstLayout(PETSC_COMM_WORLD, 6, 1, own, Plane(kWidth, kHeight), &together), PETSC_SUCCESS);
    EXPECT_EQ(alone.widths, together.widths);
  }
}

TEST(Layouts, FewPointsTakeFewRanks)
{
  const std::vector<double> points(20 * 20, 1.0);
  GridLayout layout;
  ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, 8, 100, NodesOf(points, 20), Plane(20, 20), &layout), PETSC_SUCCESS);
  EXPECT_EQ(layout.Blocks(), 4);
  EXPECT_EQ(layout.ranks, (std::vector<PetscMPIInt>{0, 1, 2, 3}));
  ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, 8, 1000, NodesOf(points, 20), Plane(20, 20), &layout), PETSC_SUCCESS);
  EXPECT_EQ(layout.Blocks(), 1);
  ASSERT_EQ(FirstLayout(PETSC_COMM_SELF, 64, 1, NodesOf(std::vector<double>(7 * 7, 1.0), 7), Plane(7, 7), &layout),
            PETSC_SUCCESS); // room for two blocks along each axis
  EXPECT_EQ(layout.Blocks(), 4);
}

/// Each block talks to one block of the next level: the best map sends nothing between ranks.
TEST(Mapping, PartnersMeet)
{
  for (int ranks : {2, 3, 8}) {
    std::vector<BlockTraffic> traffic;
    RankMap map;
    for (int level = 0; level < 3; ++level) {
      std::vector<int> partner(ranks);
      std::iota(partner.begin(), partner.end(), 0);
      map.emplace_back(partner.begin(), partner.end());
      std::shuffle(partner.begin(), partner.end(), Random);
      for (int block = 0; level < 2 && block < ranks; ++block) traffic.push_back({level, block, partner[block], 100.0 + block});
    }
    EXPECT_EQ(BytesBetweenRanks(traffic, ImproveMap(traffic, ranks, map)), 0) << ranks << " ranks";
  }
}

/// Also METIS has nothing to say.
TEST(Mapping, OneBlockARankAndNoWorse)
{
  testing::internal::CaptureStdout();
  for (int n = 0; n < 200; ++n) {
    const int ranks = 1 + n % 8;
    std::vector<BlockTraffic> traffic;
    RankMap map;
    for (int level = 0; level < 3; ++level) {
      const int blocks = level == 0 ? ranks : 1 + static_cast<int>(Random(0, 1) * ranks);
      map.emplace_back(blocks);
      std::iota(map.back().begin(), map.back().end(), 0);
    }
    for (int level = 0; level < 2; ++level)
      for (int a = 0; a < static_cast<int>(map[level].size()); ++a)
        for (int b = 0; b < static_cast<int>(map[level + 1].size()); ++b)
          if (Random(0, 1) < 0.4) traffic.push_back({level, a, b, Random(1, 1e6)});
    const RankMap better = ImproveMap(traffic, ranks, map);
    ASSERT_EQ(better.size(), map.size());
    EXPECT_LE(BytesBetweenRanks(traffic, better), BytesBetweenRanks(traffic, map));
    for (int level = 0; level < 3; ++level) {
      EXPECT_EQ(better[level].size(), map[level].size());
      EXPECT_EQ(std::set<PetscMPIInt>(better[level].begin(), better[level].end()).size(), map[level].size());
      for (const PetscMPIInt rank : better[level]) EXPECT_TRUE(rank >= 0 && rank < ranks);
    }
    if (better == map) continue;
    RankMap swapped = better; // no exchange of two blocks of the coarsest level saves anything
    for (int a = 0; a < ranks; ++a)
      for (int b = 0; b < a; ++b) {
        std::swap(swapped[0][a], swapped[0][b]);
        EXPECT_GE(BytesBetweenRanks(traffic, swapped), BytesBetweenRanks(traffic, better) * (1 - 1e-12));
        std::swap(swapped[0][a], swapped[0][b]);
      }
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}
