// The constitutive laws, each a class of its own, and the table that finds them by name.
#include "pointwise/material.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>

namespace mlgimp
{

Material::Material(const MaterialConstants &c)
    : density_(c.density), lambda_(c.youngs_modulus * c.poissons_ratio / ((1 + c.poissons_ratio) * (1 - 2 * c.poissons_ratio))),
      mu_(c.youngs_modulus / (2 * (1 + c.poissons_ratio)))
{
}

double Material::SpeedOfSound() const { return std::sqrt((lambda_ + 2 * mu_) / density_); }

double AdvanceDeformation(int count, double dt, const double (*L)[4], double (*increment)[4], double *F)
{
  double largest = 0;
#pragma omp simd reduction(max : largest)
  for (int p = 0; p < count; ++p) {
    const double xx = dt * L[p][0], xy = dt * L[p][1], yx = dt * L[p][2], yy = dt * L[p][3];
    const double gxx = 1 + xx, gxy = xy, gyx = yx, gyy = 1 + yy;
    increment[p][0] = gxx, increment[p][1] = gxy, increment[p][2] = gyx, increment[p][3] = gyy;
    const double Fxx = F[4 * p], Fxy = F[4 * p + 1], Fyx = F[4 * p + 2], Fyy = F[4 * p + 3];
    F[4 * p] = gxx * Fxx + gxy * Fyx;
    F[4 * p + 1] = gxx * Fxy + gxy * Fyy;
    F[4 * p + 2] = gyx * Fxx + gyy * Fyx;
    F[4 * p + 3] = gyx * Fxy + gyy * Fyy;
    const double row = std::max(std::abs(xx) + std::abs(xy), std::abs(yx) + std::abs(yy));
    largest = std::max(largest, row);
  }
  return largest;
}

namespace
{

inline double Determinant(const double *F) { return F[0] * F[3] - F[1] * F[2]; }

/// ln x of a positive normal x, to round-off: without branches or calls, so that loops over points vectorise.
/// x = 2^k m with m between sqrt(1/2) and sqrt(2); ln m from the odd series in s = (m - 1)/(m + 1), with the
/// coefficients of the C library of Sun Microsystems (1993).
inline double Log(double x)
{
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcd, kBias = 1024, kTwoTo52 = 0x4330000000000000;
  constexpr double kLn2Upper = 6.93147180369123816490e-01, kLn2Lower = 1.90821492927058770002e-10;
  std::uint64_t bits;
  std::memcpy(&bits, &x, 8);
  const std::uint64_t biased = (bits - kRootHalf + (kBias << 52)) >> 52, k_bits = kTwoTo52 | biased;
  const std::uint64_t m_bits = bits - ((biased - kBias) << 52);
  double k, m;
  std::memcpy(&k, &k_bits, 8);
  std::memcpy(&m, &m_bits, 8);
  k -= 4503599627370496.0 + kBias;
  const double f = m - 1, s = f / (2 + f), z = s * s, zz = z * z;
  const double odd = z * (6.666666666666735130e-01 +
                          zz * (2.857142874366239149e-01 + zz * (1.818357216161805012e-01 + zz * 1.479819860511658591e-01)));
  const double even = zz * (3.999999999940941908e-01 + zz * (2.222219843214978396e-01 + zz * 1.531383769920937332e-01));
  return k * kLn2Upper - ((s * (f - (odd + even)) - k * kLn2Lower) - f);
}

/// Upper bound of the largest eigenvalue of B = F F^T, the squared stretch.
inline double LargestStretchSquared(const double *F)
{
  const double xx = F[0] * F[0] + F[1] * F[1], yy = F[2] * F[2] + F[3] * F[3], xy = F[0] * F[2] + F[1] * F[3];
  return std::max(xx, yy) + std::abs(xy);
}

/// sigma = (mu/J)(B - I) + (lambda ln J/J) I.
class NeoHookean : public Material
{
public:
  using Material::Material;

  void UpdateStress(const MaterialBatch &b, double *) const override
  {
    const double lambda = lambda_, mu = mu_;
    const double *F = b.F;
    double *stress = b.stress;
#pragma omp simd
    for (int p = 0; p < b.count; ++p) {
      const double Fxx = F[4 * p], Fxy = F[4 * p + 1], Fyx = F[4 * p + 2], Fyy = F[4 * p + 3];
      const double J = Fxx * Fyy - Fxy * Fyx, inverse_J = 1 / J, m = mu * inverse_J, pressure = lambda * Log(J) * inverse_J;
      stress[4 * p] = m * (Fxx * Fxx + Fxy * Fxy - 1) + pressure;
      stress[4 * p + 1] = m * (Fyx * Fyx + Fyy * Fyy - 1) + pressure;
      stress[4 * p + 2] = pressure;
      stress[4 * p + 3] = m * (Fxx * Fyx + Fxy * Fyy);
    }
  }

  void StoredEnergy(int count, const double *F, const double *, const double *, int, double *energy) const override
  {
    const double lambda = lambda_, mu = mu_;
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const double *f = F + 4 * p, log_J = Log(Determinant(f));
      const double trace = f[0] * f[0] + f[1] * f[1] + f[2] * f[2] + f[3] * f[3];
      energy[p] = 0.5 * mu * (trace - 2 - 2 * log_J) + 0.5 * lambda * log_J * log_J;
    }
  }

  void WaveSpeedSquared(int count, const double *F, double *speed2) const override
  {
    for (int p = 0; p < count; ++p) {
      const double *f = F + 4 * p;
      speed2[p] = (lambda_ * std::max(1 - Log(Determinant(f)), 0.0) + mu_ * (1 + LargestStretchSquared(f))) / density_;
    }
  }
};

/// S = lambda tr(E) I + 2 mu E, sigma = F S F^T/J: the large-strain elastic law of many finite-element codes.
class StVenantKirchhoff : public Material
{
public:
  using Material::Material;

  void UpdateStress(const MaterialBatch &b, double *) const override
  {
    for (int p = 0; p < b.count; ++p) {
      const double *f = b.F + 4 * p, J = Determinant(f);
      double *sigma = b.stress + 4 * p;
      const Strain E = GreenStrain(f);
      const double sphere = lambda_ * (E.xx + E.yy), Sxx = sphere + 2 * mu_ * E.xx, Syy = sphere + 2 * mu_ * E.yy,
                   Sxy = 2 * mu_ * E.xy;
      sigma[0] = (f[0] * f[0] * Sxx + 2 * f[0] * f[1] * Sxy + f[1] * f[1] * Syy) / J;
      sigma[1] = (f[2] * f[2] * Sxx + 2 * f[2] * f[3] * Sxy + f[3] * f[3] * Syy) / J;
      sigma[2] = sphere / J;
      sigma[3] = (f[0] * f[2] * Sxx + (f[0] * f[3] + f[1] * f[2]) * Sxy + f[1] * f[3] * Syy) / J;
    }
  }

  void StoredEnergy(int count, const double *F, const double *, const double *, int, double *energy) const override
  {
    for (int p = 0; p < count; ++p) {
      const Strain E = GreenStrain(F + 4 * p);
      const double trace = E.xx + E.yy;
      energy[p] = 0.5 * lambda_ * trace * trace + mu_ * (E.xx * E.xx + E.yy * E.yy + 2 * E.xy * E.xy);
    }
  }

  void WaveSpeedSquared(int count, const double *F, double *speed2) const override
  {
    for (int p = 0; p < count; ++p) {
      const double b = LargestStretchSquared(F + 4 * p);
      speed2[p] = (lambda_ + 2 * mu_) / density_ * std::max(1.0, 0.5 * b * (3 * b - 1));
    }
  }

private:
  struct Strain {
    double xx, yy, xy;
  };
  static Strain GreenStrain(const double *f)
  {
    return {0.5 * (f[0] * f[0] + f[2] * f[2] - 1), 0.5 * (f[1] * f[1] + f[3] * f[3] - 1), 0.5 * (f[0] * f[1] + f[2] * f[3])};
  }
};

/// Small strain: sigma = lambda tr(e) I + 2 mu e, e = sym(F - I). For verification at small deformation.
class LinearElastic : public Material
{
public:
  using Material::Material;

  void UpdateStress(const MaterialBatch &b, double *) const override
  {
    for (int p = 0; p < b.count; ++p) {
      const double *f = b.F + 4 * p, sphere = lambda_ * (f[0] + f[3] - 2);
      double *sigma = b.stress + 4 * p;
      sigma[0] = sphere + 2 * mu_ * (f[0] - 1);
      sigma[1] = sphere + 2 * mu_ * (f[3] - 1);
      sigma[2] = sphere;
      sigma[3] = mu_ * (f[1] + f[2]);
    }
  }

  void StoredEnergy(int count, const double *F, const double *, const double *, int, double *energy) const override
  {
    for (int p = 0; p < count; ++p) {
      const double *f = F + 4 * p, xx = f[0] - 1, yy = f[3] - 1, xy = 0.5 * (f[1] + f[2]);
      energy[p] = 0.5 * lambda_ * (xx + yy) * (xx + yy) + mu_ * (xx * xx + yy * yy + 2 * xy * xy);
    }
  }

  void WaveSpeedSquared(int count, const double *F, double *speed2) const override
  {
    for (int p = 0; p < count; ++p) speed2[p] = (lambda_ + 2 * mu_) / density_ * std::max(1.0, LargestStretchSquared(F + 4 * p));
  }
};

/// Jaumann rate of the Cauchy stress, integrated with the rotation of Hughes & Winget (1980).
class Hypoelastic : public Material
{
public:
  using Material::Material;

  void UpdateStress(const MaterialBatch &b, double *) const override
  {
    for (int p = 0; p < b.count; ++p) {
      const double xx = b.dt * b.L[p][0], yy = b.dt * b.L[p][3], xy = 0.5 * b.dt * (b.L[p][1] + b.L[p][2]);
      const double w = 0.5 * b.dt * (b.L[p][2] - b.L[p][1]); // rotation from x to y within the step
      const double q = 0.25 * w * w, c = (1 - q) / (1 + q), s = w / (1 + q);
      double *sigma = b.stress + 4 * p;
      const double sxx = sigma[0], syy = sigma[1], sxy = sigma[3], sphere = lambda_ * (xx + yy);
      sigma[0] = c * c * sxx - 2 * c * s * sxy + s * s * syy + sphere + 2 * mu_ * xx;
      sigma[1] = s * s * sxx + 2 * c * s * sxy + c * c * syy + sphere + 2 * mu_ * yy;
      sigma[2] += sphere;
      sigma[3] = c * s * (sxx - syy) + (c * c - s * s) * sxy + 2 * mu_ * xy;
    }
  }

  void StoredEnergy(int count, const double *F, const double *stress, const double *, int, double *energy) const override
  {
    const double bulk = lambda_ + 2 * mu_ / 3;
    for (int p = 0; p < count; ++p) {
      const double *s = stress + 4 * p, mean = (s[0] + s[1] + s[2]) / 3;
      const double xx = s[0] - mean, yy = s[1] - mean, zz = s[2] - mean;
      energy[p] =
          Determinant(F + 4 * p) * (0.5 * mean * mean / bulk + (xx * xx + yy * yy + zz * zz + 2 * s[3] * s[3]) / (4 * mu_));
    }
  }

  void WaveSpeedSquared(int count, const double *F, double *speed2) const override
  {
    for (int p = 0; p < count; ++p) speed2[p] = (lambda_ + 2 * mu_) * Determinant(F + 4 * p) / density_;
  }
};

/// Von Mises plasticity with linear isotropic hardening: multiplicative, logarithmic elastic strain, radial return
/// (Simo 1992). History: elastic left Cauchy-Green tensor xx, yy, zz, xy and equivalent plastic strain.
class VonMises : public Material
{
public:
  explicit VonMises(const MaterialConstants &c)
      : Material(c), yield_stress_(c.yield_stress), hardening_modulus_(c.hardening_modulus)
  {
  }

  int HistorySize() const override { return 5; }
  void InitialHistory(double *history) const override
  {
    // No array of constants here: GCC 12 for AVX-512 copies 1, 1, 1, 0 as 1, 1, 1, 1.
    for (int k = 0; k < 5; ++k) history[k] = k < 3 ? 1 : 0;
  }

  void UpdateStress(const MaterialBatch &b, double *dissipated) const override
  {
    for (int p = 0; p < b.count; ++p) {
      double *be = b.history + b.history_stride * p, *sigma = b.stress + 4 * p;
      const double gxx = b.increment[p][0], gxy = b.increment[p][1], gyx = b.increment[p][2], gyy = b.increment[p][3];
      const double txx = gxx * gxx * be[0] + 2 * gxx * gxy * be[3] + gxy * gxy * be[1];
      const double tyy = gyx * gyx * be[0] + 2 * gyx * gyy * be[3] + gyy * gyy * be[1];
      const double txy = gxx * gyx * be[0] + (gxx * gyy + gxy * gyx) * be[3] + gxy * gyy * be[1];
      Principal e = LogStrain(txx, tyy, be[2], txy);
      const double mean = (e.value[0] + e.value[1] + e.value[2]) / 3;
      double deviator[3], norm2 = 0;
      for (int k = 0; k < 3; ++k) {
        deviator[k] = 2 * mu_ * (e.value[k] - mean);
        norm2 += deviator[k] * deviator[k];
      }
      const double equivalent = std::sqrt(1.5 * norm2), yield = yield_stress_ + hardening_modulus_ * be[4];
      double plastic = 0;
      if (equivalent > yield) {
        plastic = (equivalent - yield) / (3 * mu_ + hardening_modulus_);
        const double shrink = 1 - 3 * mu_ * plastic / equivalent;
        for (int k = 0; k < 3; ++k) {
          deviator[k] *= shrink;
          e.value[k] = mean + deviator[k] / (2 * mu_);
        }
        be[4] += plastic;
        dissipated[p] += plastic * (yield + 0.5 * hardening_modulus_ * plastic);
      }
      const double J = Determinant(b.F + 4 * p), pressure = (3 * lambda_ + 2 * mu_) * mean;
      const double tau[3] = {deviator[0] + pressure, deviator[1] + pressure, deviator[2] + pressure};
      e.Compose(tau, 1 / J, sigma);
      const double stretch2[3] = {std::exp(2 * e.value[0]), std::exp(2 * e.value[1]), std::exp(2 * e.value[2])};
      e.Compose(stretch2, 1, be);
    }
  }

  void StoredEnergy(int count, const double *, const double *, const double *history, int stride, double *energy) const override
  {
    for (int p = 0; p < count; ++p) {
      const double *be = history + stride * p;
      const Principal e = LogStrain(be[0], be[1], be[2], be[3]);
      const double trace = e.value[0] + e.value[1] + e.value[2];
      energy[p] = 0.5 * lambda_ * trace * trace;
      for (double value : e.value) energy[p] += mu_ * value * value;
    }
  }

  void WaveSpeedSquared(int count, const double *, double *speed2) const override
  {
    std::fill_n(speed2, count, (lambda_ + 2 * mu_) / density_);
  }

private:
  /// Principal values (two in the plane, one along z) and the direction (c, s) of the first.
  struct Principal {
    double value[3], c, s;
    /// A tensor with these directions, as xx, yy, zz, xy.
    void Compose(const double v[3], double scale, double t[4]) const
    {
      t[0] = scale * (c * c * v[0] + s * s * v[1]);
      t[1] = scale * (s * s * v[0] + c * c * v[1]);
      t[2] = scale * v[2];
      t[3] = scale * c * s * (v[0] - v[1]);
    }
  };

  static Principal LogStrain(double xx, double yy, double zz, double xy)
  {
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy), centre = 0.5 * (xx + yy);
    const double radius = std::hypot(0.5 * (xx - yy), xy);
    return {
        {0.5 * std::log(centre + radius), 0.5 * std::log(centre - radius), 0.5 * std::log(zz)}, std::cos(angle), std::sin(angle)};
  }

  double yield_stress_, hardening_modulus_;
};

struct Model {
  const char *name;
  bool has_yield;
  std::function<std::unique_ptr<Material>(const MaterialConstants &)> create;
};

template <class Law> std::unique_ptr<Material> Create(const MaterialConstants &c) { return std::make_unique<Law>(c); }

const std::vector<Model> &Models()
{
  static const std::vector<Model> models = {
      {"neo_hookean", false, Create<NeoHookean>},
      {"hypoelastic", false, Create<Hypoelastic>},
      {"j2", true, Create<VonMises>},
      {"st_venant_kirchhoff", false, Create<StVenantKirchhoff>},
      {"linear", false, Create<LinearElastic>},
  };
  return models;
}

const Model &FindModel(const std::string &name)
{
  for (const Model &model : Models())
    if (name == model.name) return model;
  return Models().front();
}

} // namespace

std::vector<std::string> MaterialModels()
{
  std::vector<std::string> names;
  for (const Model &model : Models()) names.emplace_back(model.name);
  return names;
}

bool ModelHasYield(const std::string &model) { return FindModel(model).has_yield; }

std::unique_ptr<Material> CreateMaterial(const std::string &model, const MaterialConstants &constants)
{
  return FindModel(model).create(constants);
}

} // namespace mlgimp
