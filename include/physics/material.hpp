// Materials: stress, energy and wave speed of batches of points of one geometry.
//
// Points are stored interleaved, with the components that geometry.hpp gives. A law is an equation in laws.hpp and
// registers by name in materials.cpp; docs/extend.md shows how to add one.
#pragma once

#include "physics/geometry.hpp"
#include "physics/laws.hpp"
#include "physics/shape.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// The points of one material in a block, after F was advanced by I + dt L.
struct MaterialBatch {
  int count;                ///< number of points, at most kBlock
  double dt;                ///< s
  double scale;             ///< simulated time over that of the test, which goes on by dt/scale
  const Row *L;             ///< [kGradient] velocity gradient, 1/s
  const Row *F;             ///< [kGradient] new deformation gradient
  const double *hoop;       ///< [count] new F_zz = r/R; null but in axisymmetry
  const double *hoop_ratio; ///< [count] r over that of before the step; likewise
  double *stress;           ///< [count][kStress] Cauchy stress, Pa, updated in place
  double *history;          ///< [count][history_stride] internal variables, updated in place
  int history_stride;       ///< >= LawTraits::history: the most that any material of the run has
};

/// Internal variables that frames show.
enum InternalVariable : int { kPlasticStrain, kTemperature, kInternalVariables };
inline constexpr const char *kInternalVariableNames[kInternalVariables] = {"equivalent_plastic_strain", "temperature"};

class Material
{
public:
  Material(const Elasticity &elasticity, const LawTraits &traits) : elasticity_(elasticity), traits_(traits) {}
  virtual ~Material() = default;

  const Elasticity &Elastic() const { return elasticity_; }
  const LawTraits &Traits() const { return traits_; }
  double Density() const { return elasticity_.density; } ///< initial density, kg/m3
  double SpeedOfSound() const;                           ///< of the fastest wave at small strain, m/s

  /// Against locking, the growth of volume of points is the mean over those of a cell, but for the share of their own.
  bool AveragesVolume() const { return own_growth_ < 1; }
  double KeptVolumeShare() const { return own_growth_; }
  void AverageVolume(double own_growth) { own_growth_ = own_growth; }
  /// Whether points are halved that flow has drawn out longer than a cell.
  bool SplitsStretched() const { return splits_stretched_; }
  void SplitStretched(bool splits) { splits_stretched_ = splits; }

  /// Stress at the end of a step. Returns nothing; adds the plastic work per initial volume (J/m3) to dissipated[p].
  virtual void UpdateStress(const MaterialBatch &batch, double *dissipated) const = 0;

  /// Recoverable energy per initial volume, J/m3, into energy [count]. Arrays as in MaterialBatch.
  virtual void StoredEnergy(int count, const double *F, const double *hoop, const double *stress, const double *history,
                            int history_stride, double *energy) const = 0;

  /// Square of the current pressure-wave speed, an upper bound over directions, (m/s)^2, into speed2 [count].
  virtual void WaveSpeedSquared(int count, const double *F, const double *hoop, double *speed2) const = 0;

  /// Internal variables in the undeformed body, [LawTraits::history].
  virtual void InitialHistory(double *) const {}
  /// Flow stress at an equivalent plastic strain, without a rate and heat, Pa; infinite where nothing flows.
  virtual double FlowStress(double /*plastic_strain*/) const { return HUGE_VAL; }
  /// Exponent of the rate of creep over stress, of a law that has no yield stress; 0 of others.
  virtual double CreepExponent() const { return 0; }
  /// Place of an internal variable with a name of its own, or -1.
  virtual int PlaceOf(InternalVariable) const { return -1; }

private:
  Elasticity elasticity_;
  LawTraits traits_;
  double own_growth_ = 1;
  bool splits_stretched_ = false;
};

/// Names that -NAME_model accepts.
std::vector<std::string> MaterialModels();

/// model: one of them; see HardeningLaws for what a metal needs.
std::unique_ptr<Material> CreateMaterial(const std::string &model, const MaterialConstants &constants, GeometryKind geometry);

/// A constant of a hardening law: the option, what it means, and the interval it must lie in (open at 0).
struct HardeningConstant {
  const char *name, *help, *unit;
  double MaterialConstants::*value;
  double least, most;
  bool may_be_least, required;
};
using CreateJ2 = std::unique_ptr<Material> (*)(const MaterialConstants &, GeometryKind);
struct HardeningLaw {
  const char *name;
  std::vector<HardeningConstant> constants;
  CreateJ2 create;                    ///< j2 with it; null for a rate law that needs a hardening
  CreateJ2 with_overstress = nullptr; ///< j2 with it and -NAME_rate_law perzyna; null where it has a rate of its own
};
/// What -NAME_rate_law accepts, each with its constants.
const std::vector<HardeningLaw> &RateLaws();

/// What -NAME_hardening accepts, each with its constants; the table has its lists beside.
const std::vector<HardeningLaw> &HardeningLaws();

/// The law j2: von Mises plasticity with the hardening that the constants name.
std::unique_ptr<Material> CreateMetal(const MaterialConstants &constants, GeometryKind geometry);

/// The law viscoelastic: a generalized Maxwell solid, with the terms that the constants have.
std::unique_ptr<Material> CreateViscoelastic(const MaterialConstants &constants, GeometryKind geometry);

/// An upper bound of the largest eigenvalue of B = F F^T; without z, as in plane strain, of those in the plane, where waves
/// travel.
template <bool with_z> inline double LargestStretchSquared(const Mat3 &F)
{
  const Sym3 B = SymmetricProduct(F, F);
  const double xy = std::abs(B.xy), yz = std::abs(B.yz), xz = std::abs(B.xz);
  return std::max(std::max(B.xx + xy + xz, B.yy + xy + yz), with_z ? B.zz + yz + xz : 0);
}

/// The tensor of a point in rows [kGradient], as by the other LoadGradient.
template <class Geometry> inline Mat3 LoadGradient(const Row *a, int p, double zz)
{
  return LoadGradient<Geometry, sizeof(Row) / sizeof(double)>(a[0] + p, zz);
}

/// The symmetric tensor of a point in rows [kStress].
template <class Geometry> inline Sym3 StressIn(const Row *a, int p)
{
  if constexpr (Geometry::kDim == 3)
    return {a[0][p], a[1][p], a[2][p], a[3][p], a[4][p], a[5][p]};
  else
    return {a[0][p], a[1][p], a[2][p], a[3][p], 0, 0};
}
template <class Geometry> inline void PutStress(const Sym3 &s, int p, Row *a)
{
  a[0][p] = s.xx, a[1][p] = s.yy, a[2][p] = s.zz, a[3][p] = s.xy;
  if constexpr (Geometry::kDim == 3) a[4][p] = s.yz, a[5][p] = s.xz;
}

/// The deformation gradient of a point in an array [count][kGradient], or in rows, with F_zz = hoop[p] in axisymmetry.
template <class Geometry> inline Mat3 GradientOf(const double *F, const double *hoop, int p)
{
  return LoadGradient<Geometry>(F + Geometry::kGradient * p, Geometry::kHoop ? hoop[p] : 1);
}
template <class Geometry> inline Mat3 GradientOf(const Row *F, const double *hoop, int p)
{
  return LoadGradient<Geometry>(F, p, Geometry::kHoop ? hoop[p] : 1);
}

/// The determinant of a point's tensor in rows, but for a zz that the geometry does not store.
template <class Geometry> inline double Determinant(const Row *F, int p)
{
  if constexpr (Geometry::kDim == 2)
    return F[0][p] * F[3][p] - F[1][p] * F[2][p];
  else
    return Determinant(LoadGradient<Geometry>(F, p, 1));
}

/// Advances F <- (I + dt L) F; returns the largest |dt L| met (row sums), no number where any of L is none. L, F: rows of `count`
/// points.
/// As L is taken where the points are before they move, this is the exact gradient of the step's motion x + dt v(x);
/// exp(dt L) would be off by a first-order error. det F stays positive while |dt L| < 1/2.
template <class Geometry> double AdvanceDeformation(int count, double dt, const Row *L, Row *F)
{
  constexpr int n = Geometry::kDim;
  double largest = 0, total = 0; // a maximum loses what is no number
#pragma omp simd reduction(max : largest) reduction(+ : total)
  for (int p = 0; p < count; ++p) {
    double old[n * n];
#pragma GCC unroll 9
    for (int k = 0; k < n * n; ++k) old[k] = F[k][p];
#pragma GCC unroll 3
    for (int i = 0; i < n; ++i) {
      double row = 0;
#pragma GCC unroll 3
      for (int j = 0; j < n; ++j) {
        double sum = 0;
#pragma GCC unroll 3
        for (int k = 0; k < n; ++k) sum += L[n * i + k][p] * old[n * k + j];
        F[n * i + j][p] = old[n * i + j] + dt * sum;
        row += std::abs(L[n * i + j][p]);
      }
      largest = std::max(largest, row);
      total += row;
    }
  }
  return std::isfinite(total) ? dt * largest : NAN;
}

/// Mean pressure of a contact under which a material flows, 2.8 times its flow stress at a strain of 8 % (Tabor 1951), Pa;
/// infinite where it does not flow.
inline double ContactPressureOfFlow(const Material &material)
{
  constexpr double kTabor = 2.8, kStrain = 0.08;
  return kTabor * material.FlowStress(kStrain);
}

} // namespace mlgimp
