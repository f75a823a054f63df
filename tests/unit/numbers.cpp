// Numbers of points: those of children follow from their parent's and the other way round.
#include "hierarchy/transfer/point_transfer.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

using namespace mlgimp;

TEST(Numbers, ChildrenAndParents)
{
  for (int children : {4, 9, 16}) {
    constexpr std::int64_t kSeeds = 1000;
    const PointNumbers numbers(kSeeds, children);
    std::int64_t lower = 0, upper = kSeeds; // numbers of this generation: [lower, upper)
    int generation = 0;
    for (; generation < 100 && numbers.CanSplit(upper - 1); ++generation) {
      const std::int64_t ids[] = {lower, lower + 1, lower + (upper - lower) / 2, upper - 1};
      for (std::int64_t id : ids) {
        EXPECT_EQ(numbers.Parent(id) == -1, generation == 0);
        for (int c = 0; c < children; ++c) {
          const std::int64_t child = numbers.Child(id, c);
          EXPECT_EQ(numbers.Parent(child), id);
          EXPECT_EQ(numbers.ChildIndex(child), c);
          EXPECT_GE(child, upper);
          EXPECT_EQ(child - upper, (id - lower) * children + c);
        }
      }
      const std::int64_t next = numbers.Child(upper - 1, children - 1) + 1;
      EXPECT_EQ(numbers.Child(lower, 0), upper);
      EXPECT_GT(next, upper);
      lower = upper, upper = next;
    }
    // Splitting ends before the numbers overflow.
    EXPECT_GT(generation, 5);
    EXPECT_LT(generation, 100);
    EXPECT_LT(upper, INT64_MAX / 2);
  }
}
