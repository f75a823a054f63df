// Half widths of contacts from given pressures.
#include "level/contact/width.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace
{

constexpr double kH = 0.5;   // m
constexpr int kColumns = 40; // the tip is above the middle one
constexpr double kTip = 0.5 * kColumns * kH;

/// Mean of a pressure by the hat function of the column at the distance x from the tip: what an unknown stands for.
double HatMean(const std::function<double(double)> &pressure, double x)
{
  constexpr int kParts = 400;
  double sum = 0;
  for (int k = 0; k < kParts; ++k) {
    const double part = (2 * k + 1.0) / kParts - 1;
    sum += (1 - std::abs(part)) * pressure(x + part * kH) * 2 / kParts;
  }
  return sum;
}

/// The half width that is found for a pressure over the distance from the tip, on a surface from `start` to `end`.
double Found(const std::function<double(double)> &pressure, double start, double end)
{
  std::vector<mlgimp::SurfaceRange> ranges;
  std::vector<double> pressures;
  for (int i = 0; i <= kColumns; ++i) {
    const double x = i * kH;
    pressures.push_back(std::max(0.0, HatMean(pressure, x - kTip)));
    ranges.push_back({x, std::max(x - kH, kTip + start), std::min(x + kH, kTip + end)});
  }
  return mlgimp::HalfWidth(ranges, pressures, true, kTip, 1e-6 * kH);
}

} // namespace

/// p = sqrt(1 - (x/a)^2) and arcosh(a/|x|): the edge is found to a part of a cell, wherever it lies between nodes.
TEST(ContactWidth, CylinderAndWedge)
{
  for (double a = 10 * kH; a < 11 * kH; a += 0.09 * kH) {
    const auto cylinder = [a](double x) { return std::abs(x) < a ? std::sqrt(1 - x * x / (a * a)) : 0; };
    const auto wedge = [a](double x) { return std::abs(x) < a ? std::acosh(a / std::abs(x)) : 0; };
    EXPECT_NEAR(Found(cylinder, -15 * kH, 15 * kH), a, 0.15 * kH);
    EXPECT_NEAR(Found(wedge, -15 * kH, 15 * kH), a, 0.15 * kH);
    EXPECT_NEAR(Found(wedge, 0, 15 * kH), a, 0.15 * kH) << "half of a symmetric case";
  }
}

/// Where the pressure does not fall to the edge, the end of the surface is the end of the contact.
TEST(ContactWidth, FlatPunch)
{
  constexpr double kReach = 6.3 * kH;
  const auto punch = [](double x) { return std::abs(x) < kReach ? 1 / std::sqrt(1 - x * x / (6.6 * 6.6 * kH * kH)) : 0; };
  EXPECT_NEAR(Found(punch, -kReach, kReach), kReach, 1e-12);
}

TEST(ContactWidth, NoContact)
{
  EXPECT_EQ(Found([](double) { return -1.0; }, -15 * kH, 15 * kH), 0);
}
