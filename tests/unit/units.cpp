// Units of quantities: sizes, products and powers, kinds, and what is no unit.
#include "program/options/units.hpp"

#include <gtest/gtest.h>

using namespace mlgimp;

namespace
{

struct Row {
  const char *number, *unit, *base;
  double value; ///< in the base
};

} // namespace

TEST(Units, AreTheSameNumbersAsInTheirBase)
{
  const Row rows[] = {{"200", "nm", "m", 200e-9},
                      {"0.1", "nm", "m", 0.1e-9},
                      {"3.7e-2", "um", "m", 3.7e-8},
                      {"2", "\xc2\xb5m", "m", 2e-6},
                      {"2", "\xce\xbcm", "m", 2e-6},
                      {"5", "Angstrom", "m", 5e-10},
                      {"70", "GPa", "Pa", 70e9},
                      {"2.7", "g/cm3", "kg/m3", 2700},
                      {"2.7", "g/cm^3", "kg/m3", 2700},
                      {"10", "mN", "N", 10e-3},
                      {"25", "gf", "N", 0.24516625},
                      {"1", "kgf", "N", 9.80665},
                      {"2", "min", "s", 120},
                      {"2", "h", "s", 7200},
                      {"0.05", "nm/s", "m/s", 0.05e-9},
                      {"9810", "mm/s2", "m/s2", 9.81},
                      {"3", "mN/um", "N/m", 3000},
                      {"140", "kJ/mol", "J/mol", 140e3},
                      {"0.5", "J/g/K", "J/kg/K", 500},
                      {"3", "/s", "1/s", 3},
                      {"3", "1/s", "1/s", 3},
                      {"3", "s-1", "1/s", 3},
                      {"20", "degC", "K", 293.15},
                      {"300", "K", "K", 300},
                      {"70.3", "deg", "degrees", 70.3},
                      {"70.3", "\xc2\xb0", "degrees", 70.3},
                      {"5", "%", "", 0.05}};
  for (const Row &row : rows) {
    const auto unit = ParseUnit(row.unit), base = ParseUnit(row.base);
    ASSERT_TRUE(unit && base) << row.unit;
    EXPECT_TRUE(unit->IsLike(*base)) << row.unit;
    EXPECT_DOUBLE_EQ(unit->InBase(row.number), row.value) << row.unit;
  }
  EXPECT_EQ(ParseUnit("nm")->InBase("0.1"), 0.1e-9) << "to the last digit";
  EXPECT_EQ(ParseUnit("nm")->InBase("123.456"), 123.456e-9);
  EXPECT_EQ(ParseUnit("g/cm3")->InBase("7.31"), 7310);
  EXPECT_NEAR(ParseUnit("rad")->InBase("1"), 57.29577951308232, 1e-13);
}

TEST(Units, WhatIsNone)
{
  for (const char *text : {"foo", "mPa", "Mm", "gpa", "nm/", "/", "m3.5", "m^", "2", "kdeg", "nmm", "m m", "pa"})
    EXPECT_FALSE(ParseUnit(text)) << text;
}

TEST(Units, Kinds)
{
  EXPECT_EQ(KindOf(*ParseUnit("GPa")), "a stress");
  EXPECT_EQ(KindOf(*ParseUnit("N/mm2")), "a stress");
  EXPECT_EQ(KindOf(*ParseUnit("mN/um")), "a stiffness");
  EXPECT_EQ(KindOf(*ParseUnit("m4")), "a quantity in m4");
  EXPECT_EQ(KindOf(*ParseUnit("m/s3")), "a quantity in m s-3");
  EXPECT_EQ(ExamplesOf(*ParseUnit("m")), "nm, um, mm, m");
}
