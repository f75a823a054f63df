// Numbers as text, and values in messages.
#include "base/text.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace mlgimp
{

static std::string Print(const char *format, int digits, double x)
{
  char text[32];
  std::snprintf(text, sizeof text, format, digits, x);
  return text;
}

std::string FormatNumber(double x)
{
  std::string text;
  for (int digits : {6, 12, 17})
    if (text = Print("%.*g", digits, x); std::strtod(text.c_str(), nullptr) == x) break;
  return text;
}

std::string FormatRounded(double x) { return Print("%.*g", 4, x); }

std::string FormatVector(Vec3 x, int dim)
{
  const std::string plane = FormatNumber(x[0]) + "," + FormatNumber(x[1]);
  return dim == 3 ? plane + "," + FormatNumber(x[2]) : plane;
}

std::string FormatPlace(Vec3 x, int dim)
{
  std::string text;
  for (int axis = 0; axis < dim; ++axis) text += (axis > 0 ? ", " : "(") + Print("%.*e", 6, x[axis]);
  return text + ")";
}

/// Values too many come at the end, and {} too many stay: a message with a mistake is better than none.
std::string FillIn(std::string_view pattern, std::initializer_list<std::string> values)
{
  std::string text;
  for (const std::string &value : values) {
    const std::size_t at = std::min(pattern.find("{}"), pattern.size());
    text.append(pattern.substr(0, at)).append(value);
    pattern.remove_prefix(std::min(at + 2, pattern.size()));
  }
  return text.append(pattern);
}

} // namespace mlgimp
