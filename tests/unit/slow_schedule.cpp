// The schedule of a slow test: it passes through its turns without a jump, in the times it promises.
#include "program/case/slow_schedule.hpp"
#include "program/case/test_legs.hpp"
#include "unit/largest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

constexpr SlowPace kPace = {2.0, 40, HUGE_VAL, 0.05}; // N T = 80, ramps of 16, speed of a loading to x: x/64

/// Largest change of speed between two of many times, of the largest speed.
double LargestJump(const PiecewiseLinear &speed, double end, int count)
{
  double largest = 0;
  for (int k = 0; k < count; ++k)
    largest = Largest({largest, std::abs(speed.Value(end * (k + 1) / count) - speed.Value(end * k / count))});
  return largest / speed.LargestMagnitude(0, end);
}

} // namespace

TEST(SlowSchedule, PassesThroughItsTurns)
{
  const std::vector<double> turns = {0, 0.4, 0.36, 1, 0};
  const SlowSchedule schedule(kPace, turns);
  const std::vector<double> found = schedule.Speed().TurnsOfIntegral(schedule.EndTime());
  ASSERT_EQ(found.size(), turns.size());
  for (std::size_t k = 0; k < turns.size(); ++k) EXPECT_NEAR(found[k], turns[k], 1e-13);
  EXPECT_EQ(schedule.Speed().EndValue(), 0);
}

/// A ramp of 3 s^2 - 2 s^3 changes at most 1.5 times as fast as a straight one of 16 s.
TEST(SlowSchedule, HasNoJumps)
{
  const SlowSchedule schedule(kPace, {0, 0.4, 0.36, 1, 0});
  constexpr int kCount = 20000;
  EXPECT_LT(LargestJump(schedule.Speed(), schedule.EndTime(), kCount), 1.5 / 16 * schedule.EndTime() / kCount);
}

TEST(SlowSchedule, TakesTheTransitsItPromises)
{
  const SlowSchedule load(kPace, {0, 1});
  EXPECT_NEAR(load.EndTime(), 80 + 8 * 2, 1e-12);
  EXPECT_NEAR(load.LargestSpeed(), 1.0 / 64, 1e-15);
  ASSERT_EQ(load.Holds().size(), 1u);
  EXPECT_NEAR(load.Holds()[0].first, 80, 1e-12);
  EXPECT_NEAR(load.Speed().Integral(80), 1, 1e-14);
  // The first twentieth of the unloading takes as long, but for half a ramp at its end.
  const SlowSchedule both(kPace, {0, 1, 0});
  EXPECT_NEAR(both.Speed().Integral(96 + 80 - 8), 0.95, 1e-13);
}

/// The same later, after a rest.
TEST(SlowSchedule, StartsLater)
{
  SlowPace pace = kPace;
  pace.start = 7;
  const SlowSchedule at_once(kPace, {0, 1, 0}), later(pace, {0, 1, 0});
  EXPECT_NEAR(later.EndTime(), at_once.EndTime() + 7, 1e-12);
  EXPECT_EQ(later.Speed().LargestMagnitude(0, 7), 0);
  for (int k = 0; k < 100; ++k) EXPECT_NEAR(later.Speed().Integral(7 + 2.5 * k), at_once.Speed().Integral(2.5 * k), 1e-14);
  EXPECT_NEAR(later.Power(2).Value(7 + 80), 1, 1e-13);
  EXPECT_EQ(later.Power(2).Value(7), 0);
}

/// 3 s^2 - 2 s^3 to a chord of a sixteenth: half the second derivative, 3, times a quarter of the length's square.
TEST(SlowSchedule, RisesSmoothly)
{
  const PiecewiseLinear rise = SmoothRise(5, 4);
  for (int k = 0; k <= 100; ++k) {
    const double s = 0.01 * k;
    EXPECT_NEAR(rise.Value(4 * s), 5 * s * s * (3 - 2 * s), 5 * 0.75 / 256);
  }
  EXPECT_EQ(rise.Value(100), 5);
}

TEST(SlowSchedule, BoundsTheSpeed)
{
  SlowPace pace = kPace;
  pace.max_speed = 1e-3;
  const SlowSchedule schedule(pace, {0, 1, 0});
  EXPECT_NEAR(schedule.LargestSpeed(), 1e-3, 1e-18);
  EXPECT_NEAR(schedule.Speed().Integral(schedule.EndTime()), 0, 1e-13);
}

TEST(SlowSchedule, CountsDepthsFromTheSurface)
{
  EXPECT_NEAR(SlowSchedule(kPace, {0, 1.5}, 0.5).LargestSpeed(), 1.0 / 64, 1e-15);
}

/// x^2 at many times, and exactly nothing where the schedule comes back to nothing.
TEST(SlowSchedule, GivesPowers)
{
  const SlowSchedule schedule(kPace, {0, 0.7, 0, 1});
  const PiecewiseLinear speed = schedule.Speed(), power = schedule.Power(2);
  for (int k = 0; k <= 1000; ++k) {
    const double t = schedule.EndTime() * k / 1000, x = speed.Integral(t);
    EXPECT_NEAR(power.Value(t), x * x, 2e-4);
  }
  const std::vector<double> turns = power.Turns();
  ASSERT_EQ(turns.size(), 4u);
  EXPECT_NEAR(turns[1], 0.49, 1e-13);
  EXPECT_EQ(turns[2], 0);
  EXPECT_NEAR(turns[3], 1, 1e-13);
}

TEST(PiecewiseLinearTurns, AreWhereItTurns)
{
  const PiecewiseLinear values({1, 2, 3, 4, 5}, {0, 3, 3, 1, 2});
  EXPECT_EQ(values.Turns(), (std::vector<double>{0, 3, 1, 2}));
  const PiecewiseLinear speed({0, 2, 4}, {1, -1, 0}); // back from 1/2 on, and on to the end
  const std::vector<double> turns = speed.TurnsOfIntegral(4);
  ASSERT_EQ(turns.size(), 3u);
  EXPECT_NEAR(turns[1], 0.5, 1e-15);
  EXPECT_NEAR(turns[2], -1, 1e-15);
}

/// A test up through a middle value, a hold, and down: its legs, their places in the schedule, and the time at each value.
TEST(SlowSchedule, HasTheLegsOfATest)
{
  std::vector<TestLeg> legs = LegsOf({1, 3, 3, 0}, {2, 4, 100, 110});
  ASSERT_EQ(legs.size(), 3U);
  EXPECT_EQ(EndsOf(legs), (std::vector<double>{0, 3, 3, 0})) << "from nothing at time 0 on";
  EXPECT_FALSE(legs[0].Holds());
  EXPECT_TRUE(legs[1].Holds());
  EXPECT_EQ(legs[0].TimeOf(-1), 0) << "before the surface";
  EXPECT_EQ(legs[0].TimeOf(0.5), 1);
  EXPECT_EQ(legs[0].TimeOf(2), 3);
  EXPECT_EQ(legs[0].TimeOf(9), 4);
  EXPECT_EQ(legs[2].TimeOf(1.5), 105);
  EXPECT_EQ(legs[2].TimeOf(-1), 110);
  const SlowSchedule schedule(kPace, EndsOf(legs));
  ASSERT_EQ(schedule.Legs().size(), 3U);
  EXPECT_TRUE(schedule.Holds().empty()) << "the hold of the test comes before the way back";
  const auto [begin, end] = schedule.Legs()[1];
  EXPECT_NEAR(end - begin, 80, 1e-12);
  EXPECT_NEAR(schedule.Speed().Integral(begin), 3, 1e-12);
  EXPECT_NEAR(schedule.Speed().Integral(end), 3, 1e-12);
  EXPECT_EQ(schedule.Legs()[2].first, end);
}
