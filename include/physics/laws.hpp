// The elastic laws: equations between full tensors, the same in all geometries. Metals are in metals.cpp.
//
// A law has Stress (Cauchy, Pa), Energy (recoverable, per initial volume, J/m3) and WaveSpeedSquared (an upper bound over
// directions, (m/s)^2, from F and a bound of the square of the largest stretch, in plane strain of those in the plane). The loops
// over points are in materials.cpp; docs/extend.md has the steps to a new law.
#pragma once

#include "base/log.hpp"
#include "base/tensor.hpp"
#include "physics/crystal/stiffness.hpp"
#include "physics/hardening.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// What a law does to its points, for all that treats them.
struct LawTraits {
  bool flows = false;           ///< strain that no energy stores grows without end: points are drawn out
  bool averages_volume = false; ///< the growth of volume is the mean of a cell where the user does not say
  bool splits = false;          ///< drawn out points are halved where the user does not say
  bool has_rate = false;        ///< the stress depends on how fast points are strained
  bool creeps = false;          ///< and it strains under a stress that stays, or loses it under a strain that does
  int history = 0;              ///< internal variables of a point
  int skew_axes = 0;            ///< bits: axes across which the material is not its own mirror image
};

/// Hooke's constants, which all laws have at small strain.
struct Elasticity {
  explicit Elasticity(const MaterialConstants &c)
      : density(c.density), lambda(c.youngs_modulus * c.poissons_ratio / ((1 + c.poissons_ratio) * (1 - 2 * c.poissons_ratio))),
        mu(c.youngs_modulus / (2 * (1 + c.poissons_ratio))), fastest(lambda + 2 * mu),
        plane_modulus(4 * mu * (lambda + mu) / (lambda + 2 * mu))
  {
  }
  LawTraits Traits() const { return {}; }
  Sym3 Hooke(const Sym3 &strain) const { return Sphere(lambda * Trace(strain)) + (2 * mu) * strain; }
  double HookeEnergy(const Sym3 &strain) const
  {
    return 0.5 * lambda * Trace(strain) * Trace(strain) + mu * Contract(strain, strain);
  }

  double Bulk() const { return lambda + 2 * mu / 3; } ///< K, Pa
  /// E/(1 - nu^2), by which a half space yields to pressure, Pa.
  double PlaneModulus() const { return plane_modulus; }
  /// Energy, J/m3, and |e|^2 of the strain e that has this stress by Hooke's law.
  double EnergyOf(const Sym3 &stress) const
  {
    const double mean = kThird * Trace(stress), of_mean = 0.5 / Bulk(), of_shear = 1 / (4 * mu);
    return of_mean * mean * mean + of_shear * DeviatorSquared(stress, mean);
  }
  double StrainSquared(const Sym3 &stress) const
  {
    const double mean = kThird * Trace(stress), of_mean = 1 / (3 * Bulk() * Bulk()), of_shear = 1 / (4 * mu * mu);
    return of_mean * mean * mean + of_shear * DeviatorSquared(stress, mean);
  }

  double density, lambda, mu;    ///< initial density, kg/m3; Lame's constants, Pa
  double fastest, plane_modulus; ///< rho c^2 of the fastest wave at small strain; see PlaneModulus; Pa

private:
  static double DeviatorSquared(const Sym3 &stress, double mean)
  {
    const Sym3 deviator = stress - Sphere(mean);
    return Contract(deviator, deviator);
  }
};

/// The numbers of a point at the end of a step that laws read.
struct LawPoint {
  Mat3 F, strain; ///< new deformation gradient; dt L
  Sym3 stress;    ///< of before the step in Law::Stress, else that of now, Pa
};

/// sigma = (mu/J)(B - I) + (lambda ln J/J) I.
struct NeoHookean : Elasticity {
  using Elasticity::Elasticity;

  Sym3 Stress(LawPoint &p) const
  {
    const double J = Determinant(p.F), inverse_J = 1 / J;
    return (mu * inverse_J) * (SymmetricProduct(p.F, p.F) - Sphere(1)) + Sphere(lambda * Log(J) * inverse_J);
  }
  /// mu (tr B - 3 - 2 ln J)/2 + lambda (ln J)^2/2 by the invariants of h = F - I, without the parts of first order, which cancel:
  /// they would leave nothing of the energy of strains of 1e-8.
  double Energy(const LawPoint &p) const
  {
    const Mat3 h = {p.F.xx - 1, p.F.xy, p.F.xz, p.F.yx, p.F.yy - 1, p.F.yz, p.F.zx, p.F.zy, p.F.zz - 1};
    const double square = Trace(SymmetricProduct(h, h)), third = Determinant(h);
    const double second = h.xx * h.yy + h.yy * h.zz + h.zz * h.xx - h.xy * h.yx - h.yz * h.zy - h.xz * h.zx;
    const double growth = h.xx + h.yy + h.zz + second + third, log_J = Log1p(growth);
    return mu * (0.5 * square - second - third + (growth - log_J)) + 0.5 * lambda * log_J * log_J;
  }
  double WaveSpeedSquared(const Mat3 &F, double stretch2) const
  {
    return (lambda * std::max(1 - Log(Determinant(F)), 0.0) + mu * (1 + stretch2)) / density;
  }
};

/// S = lambda tr(E) I + 2 mu E, sigma = F S F^T/J: the large-strain elastic law of many finite-element codes.
struct StVenantKirchhoff : Elasticity {
  using Elasticity::Elasticity;

  static Sym3 GreenStrain(const Mat3 &F) { return 0.5 * (SymmetricProduct(Transposed(F), Transposed(F)) - Sphere(1)); }
  Sym3 Stress(LawPoint &p) const { return (1 / Determinant(p.F)) * Push(p.F, Hooke(GreenStrain(p.F))); }
  double Energy(const LawPoint &p) const { return HookeEnergy(GreenStrain(p.F)); }
  double WaveSpeedSquared(const Mat3 &, double stretch2) const
  {
    return (lambda + 2 * mu) / density * std::max(1.0, 0.5 * stretch2 * (3 * stretch2 - 1));
  }
};

/// S = C:E with constants that need not be isotropic. lambda and mu are those of the mean over all orientations.
struct Anisotropic : Elasticity {
  /// With the constants of an isotropic body where there are none of a crystal.
  explicit Anisotropic(const MaterialConstants &c)
      : Elasticity(c), stiffness(c.crystal.stiffness.Given() ? c.crystal.stiffness : IsotropicStiffness(lambda, mu))
  {
    mu = MeanShear(stiffness);
    lambda = MeanBulk(stiffness) - 2 * mu / 3;
    fastest = FastestModulus(stiffness);
    plane_modulus = IndentationModulus({stiffness, c.crystal.up});
  }
  LawTraits Traits() const
  {
    LawTraits traits;
    for (int axis = 0; axis < 3; ++axis) traits.skew_axes |= IsSkew(stiffness, axis) ? 1 << axis : 0;
    return traits;
  }
  Sym3 Stress(LawPoint &p) const { return (1 / Determinant(p.F)) * Push(p.F, stiffness * StVenantKirchhoff::GreenStrain(p.F)); }
  double Energy(const LawPoint &p) const
  {
    const Sym3 strain = StVenantKirchhoff::GreenStrain(p.F);
    return 0.5 * Contract(stiffness * strain, strain);
  }
  /// rho c^2 = u F C:(NN) F^T u + N S N for N = F^T n: stretch2^2 times that at no strain, and rows of the Kirchhoff stress.
  double WaveSpeedSquared(const Mat3 &F, double stretch2) const
  {
    const Sym3 tau = Push(F, stiffness * StVenantKirchhoff::GreenStrain(F));
    const double xy = std::abs(tau.xy), yz = std::abs(tau.yz), xz = std::abs(tau.xz);
    const double tension = std::max(std::max(tau.xx + xy + xz, tau.yy + xy + yz), std::max(tau.zz + yz + xz, 0.0));
    return (stretch2 * stretch2 * fastest + tension) / density;
  }

  Stiffness stiffness;
};

/// Small strain: sigma = lambda tr(e) I + 2 mu e, e = sym(F) - I. For verification at small deformation.
struct LinearElastic : Elasticity {
  using Elasticity::Elasticity;

  static Sym3 Strain(const Mat3 &F) { return SymmetricPart(F) - Sphere(1); }
  Sym3 Stress(LawPoint &p) const { return Hooke(Strain(p.F)); }
  double Energy(const LawPoint &p) const { return HookeEnergy(Strain(p.F)); }
  double WaveSpeedSquared(const Mat3 &, double stretch2) const { return (lambda + 2 * mu) / density * std::max(1.0, stretch2); }
};

/// Jaumann rate of the Cauchy stress: sigma <- Q sigma Q^T + lambda tr(d) I + 2 mu d with d = sym(dt L), and
/// Q = (I - w/2)^-1 (I + w/2), w = dt L - d, the rotation of Hughes & Winget (1980).
struct Hypoelastic : Elasticity {
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
  double Energy(const LawPoint &p) const { return Determinant(p.F) * EnergyOf(p.stress); }
  double WaveSpeedSquared(const Mat3 &F, double) const { return (lambda + 2 * mu) * Determinant(F) / density; }
};

} // namespace mlgimp
