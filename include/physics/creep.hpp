// Creep: laws that say how fast a metal flows under a stress, and their integration over a step.
//
// A law is a struct with LeastStress, RateAt and StressAt and a row of RateLaws in metals.cpp; docs/extend.md has the steps to a
// new one.
#pragma once

#include "physics/hardening.hpp"

#include <cmath>

namespace mlgimp
{

/// Rate of the equivalent plastic strain under von Mises' stress, and its derivative, 1/s, 1/(Pa s).
struct CreepRate {
  double rate, by_stress;
};

/// Norton: rate = a0 (q/s0)^n.
struct NortonCreep {
  static constexpr bool kThermal = false, kOfRate = true, kCreeps = true;
  explicit NortonCreep(const MaterialConstants &c)
      : rate(c.creep_rate), exponent(c.creep_exponent), stress(c.creep_stress), inverse_stress(1 / c.creep_stress),
        inverse_exponent(1 / c.creep_exponent)
  {
  }
  [[gnu::always_inline]] double LeastStress(double) const { return 0; } ///< below which nothing flows, Pa
  [[gnu::always_inline]] CreepRate RateAt(double q) const
  {
    const double now = rate * Pow(q * inverse_stress, exponent);
    return {now, exponent * now / q};
  }
  [[gnu::always_inline]] double StressAt(double r) const { return stress * Pow(r / rate, inverse_exponent); }

  double rate, exponent, stress, inverse_stress, inverse_exponent;
};

/// Garofalo (1963): rate = a0 exp(-Q/(R T)) sinh(q/s0)^n; with n = 1 Eyring's law (1936).
struct GarofaloCreep {
  static constexpr bool kThermal = false, kOfRate = true, kCreeps = true;
  explicit GarofaloCreep(const MaterialConstants &c)
      : rate(c.creep_rate * std::exp(-c.activation_energy / (kGasConstant * c.initial_temperature))), exponent(c.creep_exponent),
        stress(c.creep_stress), inverse_stress(1 / c.creep_stress), inverse_exponent(1 / c.creep_exponent)
  {
  }
  [[gnu::always_inline]] double LeastStress(double) const { return 0; }
  [[gnu::always_inline]] CreepRate RateAt(double q) const
  {
    const double grows = Exp(std::min(q * inverse_stress, kLargest)), falls = 1 / grows;
    const double sinh = q * inverse_stress > kSmall ? 0.5 * (grows - falls) : q * inverse_stress, cosh = 0.5 * (grows + falls);
    const double now = rate * Pow(sinh, exponent);
    return {now, exponent * now * cosh / sinh * inverse_stress};
  }
  [[gnu::always_inline]] double StressAt(double r) const
  {
    const double s = Pow(r / rate, inverse_exponent);
    return stress * Log(s + std::sqrt(s * s + 1));
  }

  static constexpr double kGasConstant = 8.31446261815324; // exact: J/(mol K)
  static constexpr double kLargest = 300;                  // size: of q/s0, beyond which no rate is met
  static constexpr double kSmall = 1e-5;                   // rounding: sinh x is x below
  double rate, exponent, stress, inverse_stress, inverse_exponent;
};

/// Perzyna (1966): rate = a0 <(q - Y(a))/D>^n, as a flow stress Y(a) + D (rate/a0)^(1/n) with any hardening Y.
template <class Hardening> struct PerzynaFlow {
  static constexpr bool kThermal = false, kOfRate = true, kCreeps = true;
  explicit PerzynaFlow(const MaterialConstants &c)
      : hardening(c), stress(c.creep_stress), inverse_rate(1 / c.creep_rate), inverse_exponent(1 / c.creep_exponent)
  {
  }
  [[gnu::always_inline]] double LeastStress(double a) const { return hardening.At(a, 0, 0).stress; }
  [[gnu::always_inline]] FlowPoint At(double a, double rate, double) const
  {
    const FlowPoint slow = hardening.At(a, 0, 0);
    const double more = stress * Pow(rate * inverse_rate, inverse_exponent);
    return {slow.stress + more, slow.by_strain, inverse_exponent * more / rate};
  }
  Hardening hardening;
  double stress, inverse_rate, inverse_exponent;
};

/// What a stage of a step starts from and ends with, for each point of a block: the strain d of flow at the rate of the stage's
/// end over its time, q + 3 mu d = target.
struct CreepStage {
  alignas(64) double target[kBlock], plastic_strain[kBlock], stress[kBlock], strain[kBlock];
  alignas(64) double rate[kBlock], by_stress[kBlock]; ///< there where a stage has been before, else 0
};

/// No higher than the stress that alone makes all of the target flow: from far above Newton's method is slow.
template <class Law>
[[gnu::always_inline]] inline void BoundStage(const Law &law, const double *three_mu, int count, double time, CreepStage &stage)
{
#pragma omp simd
  for (int p = 0; p < count; ++p)
    stage.stress[p] = std::min(stage.stress[p], law.StressAt(stage.target[p] / (three_mu[p] * time)));
}

/// Newton's method for q, from stage.stress on: the rate is convex in q, so that all its steps but the first come from above. One
/// with the slope of the stage before costs nothing.
template <class Law>
[[gnu::always_inline]] inline void SolveStage(const Law &law, const double *three_mu, int count, double time, CreepStage &stage)
{
  constexpr int kMaxSteps = 100, kFewSteps = 4; // rounding
  constexpr double kLastStep = 1e-7,
                   kMinTarget = 1e-9; // rounding: of q, as the error after a step is about its square; of target
#pragma omp simd
  for (int p = 0; p < count; ++p) {
    const double target = stage.target[p], q = stage.stress[p], factor = three_mu[p] * time;
    const double next = q + (target - q - factor * stage.rate[p]) / (1 + factor * stage.by_stress[p]);
    stage.stress[p] = std::min(std::max(stage.rate[p] > 0 ? next : q, kMinTarget * target), target);
  }
  double open = 1;
  for (int k = 0; k < kMaxSteps && open > 0; ++k) {
    if (k == kFewSteps) BoundStage(law, three_mu, count, time, stage);
    open = 0;
#pragma omp simd reduction(+ : open)
    for (int p = 0; p < count; ++p) {
      const double q = std::max(stage.stress[p], std::numeric_limits<double>::min()), factor = three_mu[p] * time;
      const CreepRate now = law.RateAt(q);
      const double change = (stage.target[p] - q - factor * now.rate) / (1 + factor * now.by_stress);
      const double next = std::min(q + change, stage.target[p]);
      const double rate = std::max(now.rate + now.by_stress * (next - q), 0.0); // target - next would be rounding
      stage.strain[p] = time * rate, stage.rate[p] = rate, stage.by_stress[p] = now.by_stress;
      stage.stress[p] = next;
      open += ((next > 0) & (std::abs(next - q) > kLastStep * next)) ? 1 : 0;
    }
  }
}

template <class Hardening>
[[gnu::always_inline]] inline void SolveStage(const PerzynaFlow<Hardening> &law, const double *three_mu, int count, double time,
                                              CreepStage &stage)
{
  FindFlow(law, {count, stage.target, stage.plastic_strain, nullptr, nullptr, three_mu, 1 / time}, stage.strain, stage.stress);
}

/// Flow in a step, of second order: two implicit stages, stable for any length of it (Alexander 1977). Where the first leaves so
/// little that the second has no stress to flow under, one of first order takes their place.
template <class Law> [[gnu::always_inline]] inline void CreepOf(const Law &law, const FlowStates &states, PlasticStep &step)
{
  const double kPart = 1 - std::sqrt(0.5); // exact
  const double time = 1 / states.rate_per_strain;
  const int count = states.count;
  CreepStage stage;
  alignas(64) double first[kBlock], relaxes[kBlock];
  double any = 0;
#pragma omp simd
  for (int p = 0; p < count; ++p) {
    stage.stress[p] = states.before[p], stage.plastic_strain[p] = states.plastic_strain[p],
    stage.rate[p] = stage.by_stress[p] = 0;
    stage.target[p] = states.before[p] + kPart * (states.trial[p] - states.before[p]);
  }
  SolveStage(law, states.three_mu, count, kPart * time, stage);
#pragma omp simd reduction(+ : any)
  for (int p = 0; p < count; ++p) {
    first[p] = (1 - kPart) / kPart * stage.strain[p];
    stage.target[p] = std::max(states.trial[p] - states.three_mu[p] * first[p], 0.0);
    stage.plastic_strain[p] = states.plastic_strain[p] + first[p];
    relaxes[p] = ((first[p] > 0) & (stage.target[p] <= law.LeastStress(stage.plastic_strain[p]))) ? 1 : 0;
    any += relaxes[p];
  }
  SolveStage(law, states.three_mu, count, kPart * time, stage);
#pragma omp simd
  for (int p = 0; p < count; ++p) step.strain[p] = first[p] + stage.strain[p];
  if (any > 0) {
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      stage.target[p] = stage.stress[p] = states.trial[p], stage.plastic_strain[p] = states.plastic_strain[p];
      stage.rate[p] = stage.by_stress[p] = 0;
    }
    SolveStage(law, states.three_mu, count, time, stage);
#pragma omp simd
    for (int p = 0; p < count; ++p) step.strain[p] = relaxes[p] > 0 ? stage.strain[p] : step.strain[p];
  }
#pragma omp simd
  for (int p = 0; p < count; ++p) {
    const double before = std::max(states.before[p], law.LeastStress(states.plastic_strain[p]));
    step.work[p] = 0.5 * step.strain[p] * (before + states.trial[p] - states.three_mu[p] * step.strain[p]);
  }
}

} // namespace mlgimp
