// What the user chooses of contact.
#pragma once

#include "pointwise/geometry.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

struct ContactSettings {
  std::string method = "pressure"; ///< one of ContactMethods, or none
  double width = 1;                ///< alpha: half width of the kernels of `pressure` in cells, (0, 1]
  int serial_unknowns = 2000;      ///< with fewer unknowns one rank solves
  bool monitor = false;            ///< a line per solve
};

/// Names that -contact accepts besides none: pressure, and in plane strain point_pressure and multimesh for comparison.
std::vector<std::string> ContactMethods(GeometryKind geometry);

} // namespace mlgimp
