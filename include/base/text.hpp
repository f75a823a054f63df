// Numbers and places as text, and messages with values in them.
#pragma once

#include "base/tensor.hpp"

#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>

namespace mlgimp
{

/// A number as the user gave it or as a file must have it: the shortest text that reads back exactly.
std::string FormatNumber(double x);
/// A computed number for people to read: four digits.
std::string FormatRounded(double x);
/// "x,y", in space "x,y,z", exact: as options have it.
std::string FormatVector(Vec3 x, int dim);
/// "(x, y)", in space "(x, y, z)", rounded.
std::string FormatPlace(Vec3 x, int dim);

/// A value as Format has it.
template <class Value> std::string ToText(const Value &value)
{
  if constexpr (std::is_same_v<Value, char>)
    return std::string(1, value);
  else if constexpr (std::is_integral_v<Value>)
    return std::to_string(value);
  else if constexpr (std::is_convertible_v<Value, double>)
    return FormatRounded(value);
  else
    return value;
}
std::string FillIn(std::string_view pattern, std::initializer_list<std::string> values);

/// The pattern with the next value in place of each {}: text as it is, whole numbers with all digits, others as FormatRounded
/// has them; give FormatNumber(x) where x must be exact. The pattern is one literal, with as many {} as there are values:
/// tests/python/test_messages.py reads all calls.
template <class... Values> std::string Format(const char *pattern, const Values &...values)
{
  return FillIn(pattern, {ToText(values)...});
}

} // namespace mlgimp
