// Hardening of metals: the flow stress over equivalent plastic strain, its rate and the temperature, and the return to it.
//
// A law is a struct with At and a row of the table in metals.cpp; docs/extend.md has the steps to a new one.
#pragma once

#include "base/log.hpp"
#include "base/rows.hpp"
#include "physics/crystal/stiffness.hpp"

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
  double saturation_stress = NAN, saturation_strain = NAN;           ///< Pa, -
  std::vector<double> plastic_strains = {}, flow_stresses = {};      ///< of a table, -, Pa
  double rate_sensitivity = NAN, reference_rate = NAN;               ///< -, 1/s
  double thermal_exponent = NAN, melting_temperature = NAN;          ///< -, K
  double heat_capacity = NAN;                                        ///< per mass, J/(kg K)
  double initial_temperature = 293;                                  ///< K
  double reference_temperature = NAN;                                ///< of the constants, where not the initial one, K
  bool adiabatic = false;                                            ///< plastic work heats the point
  std::string rate_law = "none";                                     ///< how flow depends on its rate
  double creep_stress = NAN, creep_rate = NAN, creep_exponent = NAN; ///< Pa, 1/s, -
  std::vector<double> relaxation_times = {}, relaxation_shares = {}, relaxation_bulk_shares = {}; ///< of terms, s, -, -
  double activation_energy = 0;                                                                   ///< J/mol
  Crystal crystal = {};                                                                           ///< of the law anisotropic
};

/// Flow stress, and its derivatives by plastic strain and by its rate, Pa, Pa, Pa s.
struct FlowPoint {
  double stress, by_strain, by_rate;
};

/// sy + H a.
struct LinearHardening {
  static constexpr bool kThermal = false, kOfRate = false, kCreeps = false;
  explicit LinearHardening(const MaterialConstants &c) : yield(c.yield_stress), modulus(c.hardening_modulus) {}
  [[gnu::always_inline]] FlowPoint At(double a, double, double) const { return {yield + modulus * a, modulus, 0}; }
  double yield, modulus;
};

/// Swift: sy (1 + a/e0)^n; the power law of the indentation literature is that with e0 = sy/E.
struct SwiftHardening {
  static constexpr bool kThermal = false, kOfRate = false, kCreeps = false;
  explicit SwiftHardening(const MaterialConstants &c)
      : yield(c.yield_stress), exponent(c.hardening_exponent),
        inverse_strain(std::isnan(c.hardening_strain) ? c.youngs_modulus / c.yield_stress : 1 / c.hardening_strain)
  {
  }
  [[gnu::always_inline]] FlowPoint At(double a, double, double) const
  {
    const double base = 1 + a * inverse_strain, stress = yield * Pow(base, exponent);
    return {stress, exponent * stress * inverse_strain / base, 0};
  }
  double yield, exponent, inverse_strain;
};

/// Voce: ss - (ss - sy) exp(-a/ec).
struct VoceHardening {
  static constexpr bool kThermal = false, kOfRate = false, kCreeps = false;
  explicit VoceHardening(const MaterialConstants &c)
      : saturation(c.saturation_stress), range(c.saturation_stress - c.yield_stress), strain(c.saturation_strain)
  {
  }
  [[gnu::always_inline]] FlowPoint At(double a, double, double) const
  {
    const double missing = range * Exp(-a / strain);
    return {saturation - missing, missing / strain, 0};
  }
  double saturation, range, strain;
};

/// Ludwik: sy + B a^n.
struct LudwikHardening {
  static constexpr bool kThermal = false, kOfRate = false, kCreeps = false;
  explicit LudwikHardening(const MaterialConstants &c)
      : yield(c.yield_stress), modulus(c.hardening_modulus), exponent(c.hardening_exponent)
  {
  }
  [[gnu::always_inline]] FlowPoint At(double a, double, double) const
  {
    const double hardening = modulus * Pow(a, exponent);
    return {yield + hardening, a > 0 ? exponent * hardening / a : HUGE_VAL, 0};
  }
  double yield, modulus, exponent;
};

/// Straight lines between given points, level after the last.
struct TableHardening {
  static constexpr bool kThermal = false, kOfRate = false, kCreeps = false;
  explicit TableHardening(const MaterialConstants &c) : strains(c.plastic_strains), stresses(c.flow_stresses) {}
  [[gnu::always_inline]] FlowPoint At(double a, double, double) const
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
  static constexpr bool kThermal = true, kOfRate = true, kCreeps = false;
  explicit JohnsonCookHardening(const MaterialConstants &c)
      : ludwik(c), sensitivity(c.rate_sensitivity), reference_rate(c.reference_rate), exponent(c.thermal_exponent),
        reference(std::isnan(c.reference_temperature) ? c.initial_temperature : c.reference_temperature),
        melting(c.melting_temperature)
  {
  }
  [[gnu::always_inline]] FlowPoint At(double a, double rate, double temperature) const
  {
    const FlowPoint cold = ludwik.At(a, 0, 0);
    const double part = std::min(std::max((temperature - reference) / (melting - reference), 0.0), 1.0);
    const double soft = 1 - Pow(part, exponent), factor = 1 + sensitivity * Log(std::max(rate / reference_rate, 1.0));
    const double by_rate = cold.stress * soft * (sensitivity / rate);
    return {cold.stress * factor * soft, cold.by_strain * factor * soft, rate > reference_rate ? by_rate : 0};
  }
  LudwikHardening ludwik;
  double sensitivity, reference_rate, exponent, reference, melting;
};

/// Points that may flow in a step, arrays [count].
struct FlowStates {
  int count;                    ///< at most kBlock
  const double *trial;          ///< von Mises' stress q of the step without flow, Pa
  const double *plastic_strain; ///< at its start
  const double *temperature;    ///< at its start, K; null where the law is not kThermal
  const double *before;         ///< von Mises' stress at its start, Pa; null where the law is not kCreeps
  const double *three_mu; ///< what the stress q loses by a plastic strain of one: 3 mu/J, as q is that of Cauchy's stress, Pa
  double rate_per_strain; ///< real rate for a plastic strain of one in the step, 1/s
};

/// How they flow: plastic strain of the step, and plastic work per volume of now, J/m3, by the trapezoidal rule at the step's
/// rate.
struct PlasticStep {
  alignas(64) double strain[kBlock], work[kBlock];
};

/// The search of plastic strains: the interval each is in, and whether it is still looked for (0 or 1).
struct FlowSearch {
  alignas(64) double lower[kBlock], upper[kBlock], open[kBlock];
};

template <class Law> double TemperatureOf(const Law &, const FlowStates &states, int p)
{
  if constexpr (Law::kThermal)
    return states.temperature[p]; // NOLINT(clang-analyzer-core.uninitialized.UndefReturn): a row that LoadRows has filled
  else
    return 0;
}

/// One step of the search for all points, by Newton's method or by halving; returns how many are still open.
template <class Law>
[[gnu::always_inline]] inline double Approach(const Law &law, FlowStates states, bool halves, FlowSearch &search, double *strain)
{
  constexpr double kTolerance = 1e-12, kLastStep = 1e-7; // rounding: of q; of d, as the error after a step is about its square
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const double rate = states.rate_per_strain;
  double still_open = 0;
#pragma omp simd reduction(+ : still_open)
  for (int p = 0; p < states.count; ++p) {
    const double q = states.trial[p], d = strain[p], three_mu = states.three_mu[p];
    const FlowPoint flow = law.At(states.plastic_strain[p] + d, rate * d, TemperatureOf(law, states, p));
    const double excess = q - three_mu * d - flow.stress, by_rate = rate * flow.by_rate;
    const bool found = (std::abs(excess) <= kTolerance * q) | (search.upper[p] - search.lower[p] <= kEpsilon * search.upper[p]);
    const double lower = excess > 0 ? d : search.lower[p], upper = excess > 0 ? search.upper[p] : d;
    const double change = excess / (three_mu + flow.by_strain + by_rate);
    const double newton = by_rate > 0 ? d * Exp(std::min(change, (excess + three_mu * d) / by_rate) / d) : d + change;
    const bool trusted = !halves & (newton > lower) & (newton < upper);
    const double next = trusted ? newton : 0.5 * (lower + upper);
    const bool moves = (search.open[p] > 0) & !found;
    search.lower[p] = lower, search.upper[p] = upper;
    strain[p] = moves ? next : d;
    search.open[p] = (moves & (!trusted | (std::abs(next - d) > kLastStep * next))) ? 1 : 0;
    still_open += search.open[p];
  }
  return still_open;
}

/// The plastic strain d of each point in a step and the flow stress at its start, without a rate, [count], with q - 3 mu d =
/// flow(a + d); none within the yield surface. Newton's method from the right, where flow rises less and less: in d, and in ln d
/// where flow rises with the rate, as that is a straight line in ln d: no farther than where that alone takes up q. Halving where
/// it leaves the interval, and in every third step of many: where a metal first yields, fast, d and ln d can send it to and fro
/// for ever.
template <class Law> [[gnu::always_inline]] inline void FindFlow(const Law &law, FlowStates states, double *strain, double *start)
{
  constexpr int kMaxSteps = 200, kFewSteps = 8; // rounding
  FlowSearch search;
  double open = 0;
#pragma omp simd reduction(+ : open)
  for (int p = 0; p < states.count; ++p) {
    start[p] = law.At(states.plastic_strain[p], 0, TemperatureOf(law, states, p)).stress;
    strain[p] = search.upper[p] = std::max(states.trial[p] - start[p], 0.0) / states.three_mu[p];
    search.lower[p] = 0, search.open[p] = states.trial[p] > start[p] ? 1 : 0;
    open += search.open[p];
  }
  for (int k = 0; k < kMaxSteps && open > 0; ++k) {
    const bool halves = k > kFewSteps && k % 3 == 0;
    open = Approach(law, states, halves, search, strain);
  }
}

/// Plastic strains, and the work by the flow stress at both ends of the step at its rate.
template <class Law> [[gnu::always_inline]] inline void FlowOf(const Law &law, FlowStates states, PlasticStep &step)
{
  alignas(64) double start[kBlock];
  FindFlow(law, states, step.strain, start);
  const double rate = Law::kOfRate ? states.rate_per_strain : 0;
#pragma omp simd
  for (int p = 0; p < states.count; ++p) {
    const double d = step.strain[p];
    if constexpr (Law::kOfRate) start[p] = law.At(states.plastic_strain[p], rate * d, TemperatureOf(law, states, p)).stress;
    step.work[p] = 0.5 * d * (start[p] + states.trial[p] - states.three_mu[p] * d);
  }
}

/// The same of a straight line, at once.
inline void FlowOf(const LinearHardening &law, FlowStates states, PlasticStep &step)
{
#pragma omp simd
  for (int p = 0; p < states.count; ++p) {
    const double start = law.At(states.plastic_strain[p], 0, 0).stress;
    const double d = std::max(states.trial[p] - start, 0.0) / (states.three_mu[p] + law.modulus);
    step.strain[p] = d, step.work[p] = 0.5 * d * (2 * start + law.modulus * d);
  }
}

} // namespace mlgimp
