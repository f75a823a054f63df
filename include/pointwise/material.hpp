// Materials: stress, energy and wave speed of batches of points in plane strain.
//
// Points are stored interleaved: F [count][4] as xx, xy, yx, yy (F_zz = 1) and Cauchy stress [count][4] as xx, yy, zz,
// xy in Pa. A material registers by name in materials.cpp; docs/extend.md shows how to add one.
#pragma once

#include "pointwise/shape.hpp"

#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

inline constexpr int kStressComponents = 4, kGradientComponents = 4;

/// What a user gives for a material; NaN where nothing was given.
struct MaterialConstants {
  double youngs_modulus;    ///< Pa
  double poissons_ratio;    ///< -
  double density;           ///< initial, kg/m3
  double yield_stress;      ///< Pa
  double hardening_modulus; ///< d(yield stress)/d(equivalent plastic strain), Pa
};

/// The points of one material in a block, after F was advanced by `increment`.
struct MaterialBatch {
  int count;                    ///< number of points, <= kBlock
  double dt;                    ///< s
  const double (*L)[4];         ///< [count] velocity gradient xx, xy, yx, yy, 1/s
  const double (*increment)[4]; ///< [count] I + dt L
  const double *F;              ///< [count][4] new deformation gradient
  double *stress;               ///< [count][4] overwritten with the new stress, Pa
  double *history;              ///< [count][history_stride] internal variables, updated in place
  int history_stride;           ///< >= HistorySize(): the most that any material of the run has
};

class Material
{
public:
  explicit Material(const MaterialConstants &constants);
  virtual ~Material() = default;

  double Density() const { return density_; } ///< initial density, kg/m3
  double Lambda() const { return lambda_; }   ///< first Lame constant, Pa
  double Mu() const { return mu_; }           ///< shear modulus, Pa
  double SpeedOfSound() const;                ///< sqrt((lambda + 2 mu)/rho0), m/s

  /// Stress at the end of a step. Returns nothing; adds the plastic work per initial volume (J/m3) to dissipated[p].
  virtual void UpdateStress(const MaterialBatch &batch, double *dissipated) const = 0;

  /// Recoverable energy per initial volume, J/m3, into energy [count].
  virtual void StoredEnergy(int count, const double *F, const double *stress, const double *history, int history_stride,
                            double *energy) const = 0;

  /// Square of the current pressure-wave speed, an upper bound over directions, (m/s)^2, into speed2 [count].
  virtual void WaveSpeedSquared(int count, const double *F, double *speed2) const = 0;

  /// Number of internal variables per point, and their values in the undeformed body.
  virtual int HistorySize() const { return 0; }
  virtual void InitialHistory(double *) const {}

protected:
  double density_, lambda_, mu_;
};

/// Names that -NAME_model accepts.
std::vector<std::string> MaterialModels();

/// True where the model reads the constants of plasticity.
bool ModelHasYield(const std::string &model);

std::unique_ptr<Material> CreateMaterial(const std::string &model, const MaterialConstants &constants);

/// Advances F <- (I + dt L) F and leaves I + dt L in increment; returns the largest |dt L| met (row sums).
/// L, increment, F [count][4]: xx, xy, yx, yy. As L is taken where the points are before they move, this is
/// the exact gradient of the step's motion x + dt v(x); exp(dt L) would be off by a first-order error.
/// det F stays positive while |dt L| < 1/2.
double AdvanceDeformation(int count, double dt, const double (*L)[4], double (*increment)[4], double *F);

} // namespace mlgimp
