// Units of quantities: what stands behind a number, as nm, GPa or kg/m3.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace mlgimp
{

/// A unit by powers of the base units m, kg, s, K, mol and degree of angle.
struct Unit {
  std::array<int, 6> powers = {};
  double size = 1;   ///< in those, beside a power of ten
  int tens = 0;      ///< exponent of that power
  double offset = 0; ///< K at its zero, of degrees Celsius

  bool IsLike(const Unit &other) const { return powers == other.powers; }
  /// A number in base units: 0.1 nm is the same as 0.1e-9 m, to the last digit. number: what strtod reads whole, in decimal
  /// digits.
  double InBase(const std::string &number) const;
};

/// The unit of a text: symbols with a prefix and a whole power, as m, um, kg/m3, MPa, m/s^2, J/mol, between which are / or *; a /
/// is for the one symbol behind it. Nothing where it is none that is known. An empty text is the unit of pure numbers.
std::optional<Unit> ParseUnit(const std::string &text);

/// What a unit measures, as "a length"; by base units where it has no name here.
std::string KindOf(const Unit &unit);
/// Units of that kind as people write them, as "nm, um, mm, m"; nothing where it has no name here.
std::string ExamplesOf(const Unit &unit);

} // namespace mlgimp
