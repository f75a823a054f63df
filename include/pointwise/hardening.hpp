// Hardening of metals: the flow stress over equivalent plastic strain, its rate and the temperature, and the return to it.
//
// A law is a struct with At and a row of the table in metals.cpp; docs/extend.md has the steps to a new one.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace mlgimp
{

/// What a user gives for a material; NaN where nothing was given.
struct MaterialConstants {
  double youngs_modulus = NAN;      ///< Pa
  double poissons_ratio = NAN;      ///< -
  double density = NAN;             ///< initial, kg/m3
  double yield_stress = NAN;        ///< initial, Pa
  double hardening_modulus = NAN;   ///< Pa
  std::string hardening = "linear"; ///< name of the law
  double hardening_exponent = NAN, hardening_strain = NAN;
  double saturation_stress = NAN, saturation_strain = NAN;      ///< Pa, -
  std::vector<double> plastic_strains = {}, flow_stresses = {}; ///< of a table, -, Pa
  double rate_sensitivity = NAN, reference_rate = NAN;          ///< -, 1/s
  double thermal_exponent = NAN, melting_temperature = NAN;     ///< -, K
  double heat_capacity = NAN;                                   ///< per mass, J/(kg K)
  double rate_scale = 1;                                        ///< simulated time over real time
  double initial_temperature = 293;                             ///< also that of the constants, K
  bool adiabatic = false;                                       ///< plastic work heats the point
};

/// Flow stress, and its derivatives by plastic strain and by its rate, Pa, Pa, Pa s.
struct FlowPoint {
  double stress, by_strain, by_rate;
};

/// sy + H a.
struct LinearHardening {
  static constexpr bool kThermal = false;
  explicit LinearHardening(const MaterialConstants &c) : yield(c.yield_stress), modulus(c.hardening_modulus) {}
  FlowPoint At(double a, double, double) const { return {yield + modulus * a, modulus, 0}; }
  double yield, modulus;
};

/// Swift: sy (1 + a/e0)^n; the power law of the indentation literature is that with e0 = sy/E.
struct SwiftHardening {
  static constexpr bool kThermal = false;
  explicit SwiftHardening(const MaterialConstants &c)
      : yield(c.yield_stress), exponent(c.hardening_exponent),
        inverse_strain(std::isnan(c.hardening_strain) ? c.youngs_modulus / c.yield_stress : 1 / c.hardening_strain)
  {
  }
  FlowPoint At(double a, double, double) const
  {
    const double base = 1 + a * inverse_strain, stress = yield * std::pow(base, exponent);
    return {stress, exponent * stress * inverse_strain / base, 0};
  }
  double yield, exponent, inverse_strain;
};

/// Voce: ss - (ss - sy) exp(-a/ec).
struct VoceHardening {
  static constexpr bool kThermal = false;
  explicit VoceHardening(const MaterialConstants &c)
      : saturation(c.saturation_stress), range(c.saturation_stress - c.yield_stress), strain(c.saturation_strain)
  {
  }
  FlowPoint At(double a, double, double) const
  {
    const double missing = range * std::exp(-a / strain);
    return {saturation - missing, missing / strain, 0};
  }
  double saturation, range, strain;
};

/// Ludwik: sy + B a^n.
struct LudwikHardening {
  static constexpr bool kThermal = false;
  explicit LudwikHardening(const MaterialConstants &c)
      : yield(c.yield_stress), modulus(c.hardening_modulus), exponent(c.hardening_exponent)
  {
  }
  FlowPoint At(double a, double, double) const
  {
    const double hardening = modulus * std::pow(a, exponent);
    return {yield + hardening, a > 0 ? exponent * hardening / a : HUGE_VAL, 0};
  }
  double yield, modulus, exponent;
};

/// Straight lines between given points, level after the last.
struct TableHardening {
  static constexpr bool kThermal = false;
  explicit TableHardening(const MaterialConstants &c) : strains(c.plastic_strains), stresses(c.flow_stresses) {}
  FlowPoint At(double a, double, double) const
  {
    const auto above = std::upper_bound(strains.begin(), strains.end(), a);
    if (above == strains.end()) return {stresses.back(), 0, 0};
    const auto k = above - strains.begin();
    const double slope = (stresses[k] - stresses[k - 1]) / (strains[k] - strains[k - 1]);
    return {stresses[k - 1] + slope * (a - strains[k - 1]), slope, 0};
  }
  std::vector<double> strains, stresses;
};

/// Johnson & Cook (1983): (sy + B a^n) (1 + C ln max(1, r/r0)) (1 - T*^m), T* = (T - T0)/(Tm - T0).
struct JohnsonCookHardening {
  static constexpr bool kThermal = true;
  explicit JohnsonCookHardening(const MaterialConstants &c)
      : ludwik(c), sensitivity(c.rate_sensitivity), reference_rate(c.reference_rate), exponent(c.thermal_exponent),
        initial(c.initial_temperature), melting(c.melting_temperature)
  {
  }
  FlowPoint At(double a, double rate, double temperature) const
  {
    const FlowPoint cold = ludwik.At(a, 0, 0);
    const double part = std::clamp((temperature - initial) / (melting - initial), 0.0, 1.0);
    const double soft = 1 - std::pow(part, exponent);
    const bool fast = rate > reference_rate;
    const double factor = fast ? 1 + sensitivity * std::log(rate / reference_rate) : 1;
    return {cold.stress * factor * soft, cold.by_strain * factor * soft, fast ? cold.stress * sensitivity / rate * soft : 0};
  }
  LudwikHardening ludwik;
  double sensitivity, reference_rate, exponent, initial, melting;
};

/// A point that may flow in a step.
struct FlowState {
  double plastic_strain, temperature; ///< at its start
  double rate_per_strain;             ///< real rate for a plastic strain of one in the step, 1/s
};

/// How a point flows in a step: its plastic strain, and plastic work per volume, J/m3, by the trapezoidal rule at the step's
/// rate.
struct PlasticStep {
  double strain = 0, work = 0;
};

/// The plastic strain d of a step, with q - 3 mu d = flow(a + d), for the stress q of a step without flow; none within the yield
/// surface. Newton's method from the right, where flow rises less and less: in d, and in ln d where flow rises with the rate, as
/// that is a straight line in ln d: no farther than where that alone takes up q. Halving where it leaves the bracket.
template <class Law> PlasticStep FlowOf(const Law &law, double q, double three_mu, const FlowState &state)
{
  constexpr double kTolerance = 1e-12, kLastStep = 1e-7; // of q; of d, as the error after a step is about its square
  constexpr int kMostIterations = 100;
  double start = law.At(state.plastic_strain, 0, state.temperature).stress;
  if (q <= start) return {};
  double lower = 0, upper = (q - start) / three_mu, d = upper, by_rate = 0;
  for (int k = 0; k < kMostIterations; ++k) {
    const FlowPoint flow = law.At(state.plastic_strain + d, state.rate_per_strain * d, state.temperature);
    const double excess = q - three_mu * d - flow.stress;
    by_rate = state.rate_per_strain * flow.by_rate;
    if (std::abs(excess) <= kTolerance * q || upper - lower <= std::numeric_limits<double>::epsilon() * upper) break;
    (excess > 0 ? lower : upper) = d;
    const double change = excess / (three_mu + flow.by_strain + by_rate), from = d;
    d = by_rate > 0 ? d * std::exp(std::min(change, (excess + three_mu * d) / by_rate) / d) : d + change;
    if (!(d > lower && d < upper)) d = 0.5 * (lower + upper);
    if (std::abs(d - from) <= kLastStep * d) break;
  }
  if (by_rate > 0) start = law.At(state.plastic_strain, state.rate_per_strain * d, state.temperature).stress;
  return {d, 0.5 * d * (start + q - three_mu * d)};
}

/// The same of a straight line, without branches.
inline PlasticStep FlowOf(const LinearHardening &law, double q, double three_mu, const FlowState &state)
{
  const double start = law.At(state.plastic_strain, 0, 0).stress, excess = q - start;
  const double d = excess > 0 ? excess * (1 / (three_mu + law.modulus)) : 0; // the quotient is the same for all points
  return {d, 0.5 * d * (start + law.At(state.plastic_strain + d, 0, 0).stress)};
}

} // namespace mlgimp
