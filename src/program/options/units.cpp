// The table of units, and their products.
#include "program/options/units.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iterator>

namespace mlgimp
{

namespace
{

/// A symbol of a unit, and the prefixes that may stand before it. There are none by which one letter in capitals makes another
/// quantity of the same kind that people have: mPa is no modulus but a slip for MPa, and Mm is no length of a specimen.
struct Symbol {
  const char *name;
  std::array<int, 6> powers; ///< m, kg, s, K, mol, degree
  double size;               ///< beside a power of ten
  int tens;
  const char *prefixes;
  double offset = 0;
};

constexpr double kStandardGravity = 9.80665, kPound = 0.45359237, kInch = 0.0254,
                 kElectronVolt = 1.602176634; ///< exact: SI; of 1e-19 J
constexpr std::array<int, 6> kLength = {1, 0, 0, 0, 0, 0}, kMass = {0, 1, 0, 0, 0, 0}, kTime = {0, 0, 1, 0, 0, 0},
                             kRate = {0, 0, -1, 0, 0, 0}, kForce = {1, 1, -2, 0, 0, 0}, kStress = {-1, 1, -2, 0, 0, 0},
                             kEnergy = {2, 1, -2, 0, 0, 0}, kTemperature = {0, 0, 0, 1, 0, 0}, kAmount = {0, 0, 0, 0, 1, 0},
                             kAngle = {0, 0, 0, 0, 0, 1}; // exact

constexpr Symbol kSymbols[] = {
    {"1", {}, 1, 0, ""},
    {"%", {}, 1, -2, ""},
    {"m", kLength, 1, 0, "fpnumck"},
    {"Angstrom", kLength, 1, -10, ""},
    {"\xc3\x85", kLength, 1, -10, ""}, // the letter A with a ring
    {"g", kMass, 1, -3, "numk"},
    {"s", kTime, 1, 0, "fpnum"},
    {"min", kTime, 60, 0, ""},
    {"h", kTime, 3600, 0, ""},
    {"Hz", kRate, 1, 0, "kMG"},
    {"N", kForce, 1, 0, "pnumkM"},
    {"gf", kForce, kStandardGravity, -3, "k"},
    {"Pa", kStress, 1, 0, "kMGT"},
    {"bar", kStress, 1, 5, ""},
    {"psi", kStress, kPound *kStandardGravity / (kInch * kInch), 0, "k"},
    {"J", kEnergy, 1, 0, "fpnumkM"},
    {"eV", kEnergy, kElectronVolt, -19, ""},
    {"K", kTemperature, 1, 0, ""},
    {"degC", kTemperature, 1, 0, "", 273.15},
    {"\xc2\xb0"
     "C",
     kTemperature, 1, 0, "", 273.15}, // with the sign of degrees
    {"mol", kAmount, 1, 0, ""},
    {"deg", kAngle, 1, 0, ""},
    {"degrees", kAngle, 1, 0, ""},
    {"\xc2\xb0", kAngle, 1, 0, ""},
    {"rad", kAngle, 180 / M_PI, 0, "um"},
};

constexpr char kPrefixes[] = "fpnumckMGT";
constexpr int kPrefixTens[] = {-15, -12, -9, -6, -3, -2, 3, 6, 9, 12};

/// Kinds of quantities, and how people write their units.
struct Kind {
  const char *unit, *name, *examples;
};
constexpr Kind kKinds[] = {
    {"", "a pure number", ""},
    {"m", "a length", "nm, um, mm, m"},
    {"N", "a force", "nN, uN, mN, N"},
    {"Pa", "a stress", "kPa, MPa, GPa"},
    {"s", "a time", "ns, us, ms, s, min, h"},
    {"kg", "a mass", "g, kg"},
    {"kg/m3", "a density", "g/cm3, kg/m3"},
    {"J", "an energy", "nJ, mJ, J"},
    {"K", "a temperature", "K, degC"},
    {"deg", "an angle", "deg, rad"},
    {"m/s", "a speed", "nm/s, um/s, mm/s, m/s"},
    {"m/s2", "an acceleration", "mm/s2, m/s2"},
    {"1/s", "a rate", "1/s, Hz"},
    {"N/m", "a stiffness", "N/m, mN/um"},
    {"J/mol", "an energy of a mole", "kJ/mol, J/mol"},
    {"J/kg/K", "a heat capacity", "J/kg/K"},
    {"m2", "an area", "nm2, um2, mm2"},
    {"m3", "a volume", "um3, mm3"},
    {"N/s", "a rate of load", "uN/s, mN/s"},
};

/// The text with the letter u for both letters mu that keyboards and documents have.
std::string WithPlainMicro(std::string text)
{
  for (const char *micro : {"\xc2\xb5", "\xce\xbc"})
    for (std::size_t at; (at = text.find(micro)) != std::string::npos;) text.replace(at, std::strlen(micro), "u");
  return text;
}

std::optional<Unit> ParseSymbol(const std::string &text)
{
  for (const Symbol &symbol : kSymbols) {
    const std::size_t length = std::strlen(symbol.name);
    if (text.size() < length || text.compare(text.size() - length, length, symbol.name) != 0) continue;
    if (text.size() == length) return Unit{symbol.powers, symbol.size, symbol.tens, symbol.offset};
    const char prefix = text[0];
    if (text.size() == length + 1 && std::strchr(symbol.prefixes, prefix))
      return Unit{symbol.powers, symbol.size, symbol.tens + kPrefixTens[std::strchr(kPrefixes, prefix) - kPrefixes]};
  }
  return {};
}

/// A symbol with its power, as m3, s^2 or s-1.
std::optional<Unit> ParsePower(const std::string &text)
{
  std::size_t end = text.size();
  while (end > 1 && std::isdigit(static_cast<unsigned char>(text[end - 1]))) --end;
  const bool has_power = end < text.size() && text.size() - end < 2;
  int power = has_power ? text[end] - '0' : 1;
  if (!has_power && end < text.size()) return {};
  if (has_power && end > 1 && text[end - 1] == '-') power = -power, --end;
  if (has_power && end > 1 && text[end - 1] == '^') --end;
  std::optional<Unit> unit = ParseSymbol(text.substr(0, end));
  if (!unit || power == 1) return unit;
  for (int &each : unit->powers) each *= power;
  return Unit{unit->powers, std::pow(unit->size, power), power * unit->tens};
}

std::string InBaseUnits(const Unit &unit)
{
  constexpr const char *kBases[] = {"m", "kg", "s", "K", "mol", "deg"};
  std::string text;
  for (std::size_t k = 0; k < unit.powers.size(); ++k)
    if (unit.powers[k] != 0)
      text += (text.empty() ? "" : " ") + std::string(kBases[k]) + (unit.powers[k] == 1 ? "" : std::to_string(unit.powers[k]));
  return text;
}

const Kind *FindKind(const Unit &unit)
{
  const auto *kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind &one) { return ParseUnit(one.unit)->IsLike(unit); });
  return kind == std::end(kKinds) ? nullptr : kind;
}

} // namespace

std::optional<Unit> ParseUnit(const std::string &text)
{
  const std::string plain = WithPlainMicro(text);
  Unit product;
  if (plain.empty()) return product;
  int sign = 1;
  for (std::size_t begin = 0, end; begin <= plain.size(); begin = end + 1) {
    end = std::min(plain.find_first_of("/*", begin), plain.size());
    const std::optional<Unit> factor = end == 0 ? Unit() : ParsePower(plain.substr(begin, end - begin)); // 3/s is 3 1/s
    if (!factor) return {};
    if (begin == 0 && end == plain.size()) return factor;
    for (std::size_t k = 0; k < product.powers.size(); ++k) product.powers[k] += sign * factor->powers[k];
    product.size *= std::pow(factor->size, sign);
    product.tens += sign * factor->tens;
    sign = end < plain.size() && plain[end] == '/' ? -1 : 1;
  }
  return product;
}

double Unit::InBase(const std::string &number) const
{
  const std::size_t end = std::min(number.find_first_of("eE"), number.size());
  const int exponent = end < number.size() ? std::atoi(number.c_str() + end + 1) : 0;
  return size * std::strtod(Format("{}e{}", number.substr(0, end), std::to_string(exponent + tens)).c_str(), nullptr) + offset;
}

std::string KindOf(const Unit &unit)
{
  const Kind *kind = FindKind(unit);
  return kind ? kind->name : Format("a quantity in {}", InBaseUnits(unit));
}

std::string ExamplesOf(const Unit &unit)
{
  const Kind *kind = FindKind(unit);
  return kind ? kind->examples : "";
}

} // namespace mlgimp
