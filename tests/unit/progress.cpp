// The progress line fits its terminal.
#include "program/system/progress.hpp"

#include <gtest/gtest.h>

namespace
{

using namespace mlgimp;

const Progress kNow = {123456, 1.2345e-8, true, 4.5e-7, 0.0123, 2.3e7, 0.456, 3600};

bool Has(const std::string &line, const std::string &word) { return line.find(word) != std::string::npos; }

TEST(ProgressLine, IsShorterThanTheTerminal)
{
  for (std::size_t columns = 1; columns < 150; ++columns) {
    const std::string line = ProgressLine(kNow, columns);
    EXPECT_LT(line.size(), columns);
    EXPECT_TRUE(columns < 7 || Has(line, "46 %")) << columns;
    EXPECT_TRUE(columns < 20 || Has(line, "3600 s left")) << columns;
    EXPECT_GE(line.size(), ProgressLine(kNow, columns - 1).size());
  }
}

TEST(ProgressLine, LeavesOutWhatMattersLeast)
{
  const std::string all =
      "step 123456  time 1.2345e-08 s  depth 4.5000e-07 m  load 1.2300e-02 N  2.30e+07 points/s   46 %  3600 s left";
  EXPECT_EQ(ProgressLine(kNow, 200), all);
  EXPECT_EQ(ProgressLine(kNow, 80), "step 123456  depth 4.5000e-07 m  load 1.2300e-02 N   46 %  3600 s left");
  EXPECT_EQ(ProgressLine(kNow, 40), "load 1.2300e-02 N   46 %  3600 s left");
}

TEST(ProgressLine, WithoutAnIndenter)
{
  Progress now = kNow;
  now.has_indenter = false;
  EXPECT_EQ(ProgressLine(now, 80), "step 123456  time 1.2345e-08 s  2.30e+07 points/s   46 %  3600 s left");
}

} // namespace
