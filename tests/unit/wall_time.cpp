// The clock that ends a run in time.
#include "program/system/wall_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <unistd.h>

namespace
{

using namespace mlgimp;

constexpr double kEnough = 1000; // s

TEST(WallTime, LeavesTimeForACheckpoint)
{
  WallTime time(kEnough);
  time.StartLooking();
  EXPECT_FALSE(time.IsShort());
  time.RecordWriting(0.1 * kEnough);
  EXPECT_FALSE(time.IsShort());
  time.RecordWriting(0.9 * kEnough);
  EXPECT_TRUE(time.IsShort());
  time.RecordWriting(0.1 * kEnough);
  EXPECT_TRUE(time.IsShort()); // the longest counts
}

TEST(WallTime, LeavesTimeForTheStepsToTheNextLook)
{
  WallTime time(1.2);
  time.StartLooking();
  EXPECT_FALSE(time.IsShort());
  usleep(300000);
  EXPECT_TRUE(time.IsShort()); // 0.9 s are left, and what follows may take as long as these
}

TEST(WallTime, WithoutALimit)
{
  WallTime time(HUGE_VAL);
  time.RecordWriting(1e9);
  EXPECT_FALSE(time.IsShort());
}

} // namespace
