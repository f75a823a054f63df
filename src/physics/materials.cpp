// The loops over points that all laws share, and the table that finds laws by name.
#include "physics/material.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mlgimp
{

double Material::SpeedOfSound() const { return std::sqrt(elasticity_.fastest / elasticity_.density); }

namespace
{

/// Loops that call a law for points stored in the way of a geometry.
template <class Law, class Geometry> class BatchMaterial : public Material
{
  static constexpr int kS = Geometry::kStress;

public:
  explicit BatchMaterial(const MaterialConstants &c) : BatchMaterial(Law(c)) {}
  explicit BatchMaterial(const Law &law) : Material(law, law.Traits()), law_(law) {}

  void UpdateStress(const MaterialBatch &batch, double *) const override
  {
    const MaterialBatch b = batch; // copies: stores of points cannot change them
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < b.count; ++p) UpdatePoint(law, b, p);
  }

  void StoredEnergy(int count, const double *F, const double *hoop, const double *stress, const double *, int,
                    double *energy) const override
  {
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < count; ++p) energy[p] = EnergyOf(law, F, hoop, stress, p);
  }

  void WaveSpeedSquared(int count, const double *F, const double *hoop, double *speed2) const override
  {
    const Law law = law_;
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const Mat3 f = GradientOf<Geometry>(F, hoop, p);
      speed2[p] = law.WaveSpeedSquared(f, LargestStretchSquared < Geometry::kDim == 3 || Geometry::kHoop > (f));
    }
  }

private:
  // The bodies of the loops are functions: the compiler vectorises those, and not a loop with structs declared in it.
  static void UpdatePoint(const Law &law, const MaterialBatch &b, int p)
  {
    LawPoint point;
    point.F = GradientOf<Geometry>(b.F, b.hoop, p);
    point.strain = Strain(b.dt, LoadGradient<Geometry>(b.L, p, 0), Geometry::kHoop ? b.hoop_ratio[p] : 1);
    point.stress = LoadStress<Geometry>(b.stress + kS * p);
    StoreStress<Geometry>(law.Stress(point), b.stress + kS * p);
  }
  static double EnergyOf(const Law &law, const double *F, const double *hoop, const double *stress, int p)
  {
    return law.Energy({GradientOf<Geometry>(F, hoop, p), {}, LoadStress<Geometry>(stress + kS * p)});
  }
  /// dt L, with the logarithm of its growth along the hoop.
  static Mat3 Strain(double dt, const Mat3 &L, double growth)
  {
    return {dt * L.xx, dt * L.xy, dt * L.xz,
            dt * L.yx, dt * L.yy, dt * L.yz,
            dt * L.zx, dt * L.zy, Geometry::kHoop ? Log(growth) : dt * L.zz};
  }

  Law law_;
};

template <class Law> std::unique_ptr<Material> Create(const MaterialConstants &c, GeometryKind kind)
{
  return WithGeometry(kind, [&](auto geometry) -> std::unique_ptr<Material> {
    return std::make_unique<BatchMaterial<Law, decltype(geometry)>>(c);
  });
}

struct Model {
  const char *name;
  std::unique_ptr<Material> (*create)(const MaterialConstants &, GeometryKind);
};
constexpr Model kModels[] = {
    {"neo_hookean", Create<NeoHookean>},
    {"hypoelastic", Create<Hypoelastic>},
    {"j2", CreateMetal},
    {"st_venant_kirchhoff", Create<StVenantKirchhoff>},
    {"linear", Create<LinearElastic>},
    {"viscoelastic", CreateViscoelastic},
    {"anisotropic", Create<Anisotropic>},
};

} // namespace

std::vector<std::string> MaterialModels()
{
  std::vector<std::string> names;
  for (const Model &model : kModels) names.emplace_back(model.name);
  return names;
}

std::unique_ptr<Material> CreateMaterial(const std::string &model, const MaterialConstants &constants, GeometryKind geometry)
{
  const auto *const found = std::find_if(std::begin(kModels), std::end(kModels), [&](const Model &m) { return model == m.name; });
  return found->create(constants, geometry);
}

} // namespace mlgimp
