// How messages name a place.
#pragma once

#include "base/tensor.hpp"

#include <cstdio>
#include <string>

namespace mlgimp
{

/// "(x, y)", in space "(x, y, z)".
inline std::string FormatPlace(Vec3 x, int dim)
{
  char text[3 * 24];
  const int length = std::snprintf(text, sizeof text, "(%.6e, %.6e", x[0], x[1]);
  if (dim == 3) std::snprintf(text + length, sizeof text - length, ", %.6e", x[2]);
  return text + std::string(")");
}

} // namespace mlgimp
