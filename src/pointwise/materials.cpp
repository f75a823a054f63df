// The loops over points that all laws share, and the table that finds laws by name.
#include "pointwise/material.hpp"

#include <cmath>

namespace mlgimp
{

double Material::SpeedOfSound() const { return std::sqrt((Lambda() + 2 * Mu()) / Density()); }

namespace
{

/// Loops that call a law for points stored in the way of a geometry. History: the elastic tensor and the plastic strain.
template <class Law, class Geometry> class BatchMaterial : public Material
{
  static constexpr int kF = Geometry::kGradient, kS = Geometry::kStress;

public:
  explicit BatchMaterial(const MaterialConstants &c) : Material(Law(c)), law_(c) {}

  void UpdateStress(const MaterialBatch &batch, double *dissipated) const override
  {
    const MaterialBatch b = batch; // copies: stores of points cannot change them
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < b.count; ++p) UpdatePoint(law, b, p, dissipated);
  }

  void StoredEnergy(int count, const double *F, const double *hoop, const double *stress, const double *history, int stride,
                    double *energy) const override
  {
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < count; ++p) energy[p] = EnergyOf(law, F, hoop, stress, history + stride * p, p);
  }

  void WaveSpeedSquared(int count, const double *F, const double *hoop, double *speed2) const override
  {
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const Mat3 f = Gradient(F, hoop, p);
      speed2[p] = law.WaveSpeedSquared(f, LargestStretchSquared(f));
    }
  }

  int HistorySize() const override { return Law::kPlastic ? kS + 1 : 0; }
  void InitialHistory(double *history) const override
  {
    // No array of constants here: GCC 12 for AVX-512 copies 1, 1, 1, 0 as 1, 1, 1, 1.
    for (int k = 0; k < HistorySize(); ++k) history[k] = k < 3 ? 1 : 0;
  }

private:
  // The bodies of the loops are functions: the compiler vectorises those, and not a loop with structs declared in it.
  static void UpdatePoint(const Law &law, const MaterialBatch &b, int p, double *dissipated)
  {
    LawPoint point;
    const double growth = Geometry::kHoop ? b.hoop_ratio[p] : 1;
    point.F = Gradient(b.F, b.hoop, p);
    point.strain = Strain(b.dt, LoadGradient<Geometry>(b.L + kF * p, 0), growth);
    point.increment = LoadGradient<Geometry>(b.increment + kF * p, growth);
    point.stress = LoadStress<Geometry>(b.stress + kS * p);
    if constexpr (Law::kPlastic) LoadHistory(b.history + b.history_stride * p, point);
    StoreStress<Geometry>(law.Stress(point), b.stress + kS * p);
    if constexpr (Law::kPlastic) {
      StoreHistory(point, b.history + b.history_stride * p);
      dissipated[p] += point.dissipated;
    }
  }
  static double EnergyOf(const Law &law, const double *F, const double *hoop, const double *stress, const double *history, int p)
  {
    LawPoint point;
    point.F = Gradient(F, hoop, p);
    point.stress = LoadStress<Geometry>(stress + kS * p);
    if constexpr (Law::kPlastic) LoadHistory(history, point);
    return law.Energy(point);
  }
  static Mat3 Gradient(const double *F, const double *hoop, int p)
  {
    return LoadGradient<Geometry>(F + kF * p, Geometry::kHoop ? hoop[p] : 1);
  }
  /// An upper bound of the largest eigenvalue of B = F F^T; in plane strain of those in the plane, where waves travel.
  static double LargestStretchSquared(const Mat3 &F)
  {
    constexpr bool kStretchesZ = Geometry::kDim == 3 || Geometry::kHoop;
    const Sym3 B = SymmetricProduct(F, F);
    const double xy = std::abs(B.xy), yz = std::abs(B.yz), xz = std::abs(B.xz);
    return std::max(std::max(B.xx + xy + xz, B.yy + xy + yz), kStretchesZ ? B.zz + yz + xz : 0);
  }
  /// dt L, with the logarithm of its growth along the hoop.
  static Mat3 Strain(double dt, const Mat3 &L, double growth)
  {
    return {dt * L.xx, dt * L.xy, dt * L.xz,
            dt * L.yx, dt * L.yy, dt * L.yz,
            dt * L.zx, dt * L.zy, Geometry::kHoop ? Log(growth) : dt * L.zz};
  }
  static void LoadHistory(const double *history, LawPoint &point)
  {
    point.elastic = LoadStress<Geometry>(history);
    point.plastic_strain = history[kS];
    point.dissipated = 0;
  }
  static void StoreHistory(const LawPoint &point, double *history)
  {
    StoreStress<Geometry>(point.elastic, history);
    history[kS] = point.plastic_strain;
  }

  Law law_;
};

struct Model {
  const char *name;
  bool has_yield;
  std::unique_ptr<Material> (*create)(const MaterialConstants &, GeometryKind);
};

template <class Law> std::unique_ptr<Material> Create(const MaterialConstants &c, GeometryKind kind)
{
  return WithGeometry(kind, [&](auto geometry) -> std::unique_ptr<Material> {
    return std::make_unique<BatchMaterial<Law, decltype(geometry)>>(c);
  });
}

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

std::unique_ptr<Material> CreateMaterial(const std::string &model, const MaterialConstants &constants, GeometryKind geometry)
{
  return FindModel(model).create(constants, geometry);
}

} // namespace mlgimp
