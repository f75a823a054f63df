// The constitutive laws: equations between full tensors, the same in all geometries.
//
// A law has Stress (Cauchy, Pa), Energy (recoverable, per initial volume, J/m3) and WaveSpeedSquared (an upper bound over
// directions, (m/s)^2, from F and the square of the largest stretch). The loops over points are in materials.cpp;
// docs/extend.md has the steps to a new law.
#pragma once

#include "base/log.hpp"
#include "base/spectral.hpp"
#include "base/tensor.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// What a user gives for a material; NaN where nothing was given.
struct MaterialConstants {
  double youngs_modulus;    ///< Pa
  double poissons_ratio;    ///< -
  double density;           ///< initial, kg/m3
  double yield_stress;      ///< Pa
  double hardening_modulus; ///< d(yield stress)/d(equivalent plastic strain), Pa
};

/// Hooke's constants, which all laws have at small strain.
struct Elasticity {
  explicit Elasticity(const MaterialConstants &c)
      : density(c.density), lambda(c.youngs_modulus * c.poissons_ratio / ((1 + c.poissons_ratio) * (1 - 2 * c.poissons_ratio))),
        mu(c.youngs_modulus / (2 * (1 + c.poissons_ratio)))
  {
  }
  Sym3 Hooke(const Sym3 &strain) const { return Sphere(lambda * Trace(strain)) + (2 * mu) * strain; }
  double HookeEnergy(const Sym3 &strain) const
  {
    return 0.5 * lambda * Trace(strain) * Trace(strain) + mu * Contract(strain, strain);
  }

  double density, lambda, mu; ///< initial density, kg/m3; Lame's constants, Pa
};

/// A point at the end of a step, as far as laws look at it.
struct LawPoint {
  Mat3 F, strain, increment; ///< new deformation gradient; dt L; I + dt L
  Sym3 stress;               ///< of before the step in Law::Stress, else that of now, Pa
  Sym3 elastic;              ///< elastic left Cauchy-Green tensor, kept up to date by the law that has it
  double plastic_strain;     ///< equivalent, likewise
  double dissipated;         ///< plastic work of the step per initial volume, J/m3
};

/// sigma = (mu/J)(B - I) + (lambda ln J/J) I.
struct NeoHookean : Elasticity {
  static constexpr bool kPlastic = false;
  using Elasticity::Elasticity;

  Sym3 Stress(LawPoint &p) const
  {
    const double J = Determinant(p.F), inverse_J = 1 / J;
    return (mu * inverse_J) * (SymmetricProduct(p.F, p.F) - Sphere(1)) + Sphere(lambda * Log(J) * inverse_J);
  }
  double Energy(const LawPoint &p) const
  {
    const double log_J = Log(Determinant(p.F));
    return 0.5 * mu * (Trace(SymmetricProduct(p.F, p.F) - Sphere(1)) - 2 * log_J) + 0.5 * lambda * log_J * log_J;
  }
  double WaveSpeedSquared(const Mat3 &F, double stretch2) const
  {
    return (lambda * std::max(1 - Log(Determinant(F)), 0.0) + mu * (1 + stretch2)) / density;
  }
};

/// S = lambda tr(E) I + 2 mu E, sigma = F S F^T/J: the large-strain elastic law of many finite-element codes.
struct StVenantKirchhoff : Elasticity {
  static constexpr bool kPlastic = false;
  using Elasticity::Elasticity;

  static Sym3 GreenStrain(const Mat3 &F) { return 0.5 * (SymmetricProduct(Transposed(F), Transposed(F)) - Sphere(1)); }
  Sym3 Stress(LawPoint &p) const { return (1 / Determinant(p.F)) * Push(p.F, Hooke(GreenStrain(p.F))); }
  double Energy(const LawPoint &p) const { return HookeEnergy(GreenStrain(p.F)); }
  double WaveSpeedSquared(const Mat3 &, double stretch2) const
  {
    return (lambda + 2 * mu) / density * std::max(1.0, 0.5 * stretch2 * (3 * stretch2 - 1));
  }
};

/// Small strain: sigma = lambda tr(e) I + 2 mu e, e = sym(F) - I. For verification at small deformation.
struct LinearElastic : Elasticity {
  static constexpr bool kPlastic = false;
  using Elasticity::Elasticity;

  static Sym3 Strain(const Mat3 &F) { return SymmetricPart(F) - Sphere(1); }
  Sym3 Stress(LawPoint &p) const { return Hooke(Strain(p.F)); }
  double Energy(const LawPoint &p) const { return HookeEnergy(Strain(p.F)); }
  double WaveSpeedSquared(const Mat3 &, double stretch2) const { return (lambda + 2 * mu) / density * std::max(1.0, stretch2); }
};

/// Jaumann rate of the Cauchy stress: sigma <- Q sigma Q^T + lambda tr(d) I + 2 mu d with d = sym(dt L), and
/// Q = (I - w/2)^-1 (I + w/2), w = dt L - d, the rotation of Hughes & Winget (1980).
struct Hypoelastic : Elasticity {
  static constexpr bool kPlastic = false;
  using Elasticity::Elasticity;

  /// Q = I + 2/(1 + a.a) (A + A^2), where A = w/2 and A v = a x v.
  static Mat3 Rotation(const Mat3 &l)
  {
    const double x = 0.25 * (l.zy - l.yz), y = 0.25 * (l.xz - l.zx), z = 0.25 * (l.yx - l.xy);
    const double s = 2 / (1 + x * x + y * y + z * z);
    return {1 - s * (y * y + z * z), s * (x * y - z), s * (x * z + y), s * (x * y + z),        1 - s * (x * x + z * z),
            s * (y * z - x),         s * (x * z - y), s * (y * z + x), 1 - s * (x * x + y * y)};
  }
  Sym3 Stress(LawPoint &p) const { return Push(Rotation(p.strain), p.stress) + Hooke(SymmetricPart(p.strain)); }
  double Energy(const LawPoint &p) const
  {
    const double mean = Trace(p.stress) / 3, bulk = lambda + 2 * mu / 3;
    const Sym3 deviator = p.stress - Sphere(mean);
    return Determinant(p.F) * (0.5 * mean * mean / bulk + Contract(deviator, deviator) / (4 * mu));
  }
  double WaveSpeedSquared(const Mat3 &F, double) const { return (lambda + 2 * mu) * Determinant(F) / density; }
};

/// Von Mises plasticity with linear isotropic hardening: multiplicative, logarithmic elastic strain, radial return of the
/// Kirchhoff stress (Simo 1992).
struct VonMises : Elasticity {
  static constexpr bool kPlastic = true;

  explicit VonMises(const MaterialConstants &c)
      : Elasticity(c), yield_stress(c.yield_stress), hardening_modulus(c.hardening_modulus)
  {
  }

  static Vec3 HalfLog(const Vec3 &v) { return {0.5 * Log(v[0]), 0.5 * Log(v[1]), 0.5 * Log(v[2])}; }
  Sym3 Stress(LawPoint &p) const
  {
    p.elastic = Push(p.increment, p.elastic);
    const Spectrum trial = Decompose(p.elastic);
    const Vec3 strain = HalfLog(trial.value);
    const double mean = (strain[0] + strain[1] + strain[2]) / 3, pressure = (3 * lambda + 2 * mu) * mean;
    Vec3 deviator = strain - Vec3{mean, mean, mean};
    const double equivalent = 2 * mu * std::sqrt(1.5 * Dot(deviator, deviator));
    const double yield = yield_stress + hardening_modulus * p.plastic_strain;
    if (equivalent > yield) {
      const double plastic = (equivalent - yield) / (3 * mu + hardening_modulus);
      deviator = (1 - 3 * mu * plastic / equivalent) * deviator;
      p.plastic_strain += plastic;
      p.dissipated = plastic * (yield + 0.5 * hardening_modulus * plastic);
      p.elastic = trial.Compose(
          {std::exp(2 * (mean + deviator[0])), std::exp(2 * (mean + deviator[1])), std::exp(2 * (mean + deviator[2]))});
    }
    return (1 / Determinant(p.F)) * trial.Compose((2 * mu) * deviator + Vec3{pressure, pressure, pressure});
  }
  double Energy(const LawPoint &p) const
  {
    const Vec3 strain = HalfLog(Decompose(p.elastic).value);
    return HookeEnergy({strain[0], strain[1], strain[2], 0, 0, 0});
  }
  double WaveSpeedSquared(const Mat3 &, double) const { return (lambda + 2 * mu) / density; }

  double yield_stress, hardening_modulus; ///< Pa
};

} // namespace mlgimp
