// What the user chooses of contact.
#pragma once

#include "pointwise/geometry.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

struct ContactSettings {
  std::string method = "pressure"; ///< one of ContactMethods, or none
  double friction = 0;             ///< Coulomb's coefficient, of `pressure`; infinite where surfaces stick
  bool monitor = false;            ///< a line per solve
};

/// Numbers that a column of cells leaves to the next step with `pressure`: a mean pressure, and ratios of tractions to pressures
/// along two axes; else one for each unknown.
inline int NumbersPerColumn(const ContactSettings &settings) { return settings.method == "pressure" ? 3 : 1; }

/// Whether the method finds pressures, which its points then have.
inline bool FindsPressures(const ContactSettings &settings)
{
  return settings.method != "none" && settings.method != "multimesh";
}

/// Names that -contact accepts besides none: pressure, and in plane strain point_pressure and multimesh for comparison.
std::vector<std::string> ContactMethods(GeometryKind geometry);

} // namespace mlgimp
