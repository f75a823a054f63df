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
  bool own_width = false;          ///< the user chose it
  double friction = 0;             ///< Coulomb's coefficient, of `pressure`; infinite where surfaces stick
  int serial_unknowns = 500;       ///< with fewer unknowns one rank solves
  bool monitor = false;            ///< a line per solve
};

/// Unknowns of a column of cells in `pressure`: the pressure and, with friction, tractions along the horizontal axes.
inline int UnknownsPerColumn(const ContactSettings &settings, const Geometry &geometry)
{
  return settings.friction > 0 ? geometry.Dim() : 1;
}

/// Whether the method finds pressures, which its points then have.
inline bool FindsPressures(const ContactSettings &settings)
{
  return settings.method != "none" && settings.method != "multimesh";
}

/// Names that -contact accepts besides none: pressure, and in plane strain point_pressure and multimesh for comparison.
std::vector<std::string> ContactMethods(GeometryKind geometry);

} // namespace mlgimp
