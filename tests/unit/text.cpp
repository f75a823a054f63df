// Numbers as text, and values in messages.
#include "base/text.hpp"

#include <gtest/gtest.h>

#include <cstdint>

using namespace mlgimp;

TEST(Text, NumbersThatReadBack)
{
  EXPECT_EQ(FormatNumber(0.1), "0.1");
  EXPECT_EQ(FormatNumber(1.0 / 3), "0.33333333333333331");
  EXPECT_EQ(FormatNumber(2e9), "2e+09");
  EXPECT_EQ(FormatVector({0.5, -1, 3}, 2), "0.5,-1");
  EXPECT_EQ(FormatVector({0.5, -1, 1e-9}, 3), "0.5,-1,1e-09");
}

TEST(Text, RoundedNumbers)
{
  EXPECT_EQ(FormatRounded(1.0 / 3), "0.3333");
  EXPECT_EQ(FormatPlace({1, 0.25, 3}, 2), "(1.000000e+00, 2.500000e-01)");
  EXPECT_EQ(FormatPlace({1, 0.25, 3}, 3), "(1.000000e+00, 2.500000e-01, 3.000000e+00)");
}

TEST(Text, ValuesInMessages)
{
  const std::string name = "-levels";
  const std::int64_t many = 1234567890123;
  EXPECT_EQ(Format("no value"), "no value");
  EXPECT_EQ(Format("{} must be {}", name, "above 1"), "-levels must be above 1");
  EXPECT_EQ(Format("{} = {} m", 'x', 1.0 / 3), "x = 0.3333 m");
  EXPECT_EQ(Format("{}{}{}", 12345678, many, std::size_t{7}), "1234567812345678901237");
  EXPECT_EQ(Format("{}", FormatNumber(1.0 / 3)), "0.33333333333333331");
  EXPECT_EQ(Format("{} and {}", "{}", "b"), "{} and b"); // braces of a value are text
}

TEST(Text, OnlyMistakesAreLeftAsTheyAre)
{
  EXPECT_EQ(Format("{} and {}", 1), "1 and {}");
  EXPECT_EQ(Format("one {}", 1, 2), "one 12");
}
