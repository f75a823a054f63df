// What the user chooses of contact.
#pragma once

#include "physics/geometry.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

struct ContactSettings {
  std::string method = "pressure"; ///< one of ContactMethods, or none
  double friction = 0;             ///< Coulomb's coefficient, of `pressure`; infinite where surfaces stick
  bool monitor = false;            ///< a line per solve
};

/// Room for the numbers that a column of cells, or a patch, leaves to the next step with `pressure`; the first is not negative.
inline constexpr int kKeptOfEach = 8; // size
/// The same with any method; one for each unknown with the others.
inline int KeptOfEach(const ContactSettings &settings) { return settings.method == "pressure" ? kKeptOfEach : 1; }

/// Whether the method finds pressures, which its points then have.
inline bool FindsPressures(const ContactSettings &settings)
{
  return settings.method != "none" && settings.method != "multimesh";
}

/// Names that -contact accepts besides none: pressure, and in plane strain point_pressure and multimesh for comparison.
std::vector<std::string> ContactMethods(GeometryKind geometry);

} // namespace mlgimp
