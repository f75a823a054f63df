// The law j2: multiplicative von Mises plasticity with logarithmic elastic strain and radial return of the Kirchhoff stress
// (Simo 1992), with the hardening laws of hardening.hpp, in loops over blocks of points.
#include "pointwise/log_strain.hpp"
#include "pointwise/material.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace mlgimp
{

namespace
{

/// Internal variables: the elastic left Cauchy-Green tensor b_e, the equivalent plastic strain and, where the law knows it, the
/// temperature.
template <class Hardening, class Geometry> class Metal : public Material
{
  static constexpr int kS = Geometry::kStress, kStrain = kS, kHeat = kS + 1;
  static constexpr int kHistory = kS + 1 + Hardening::kThermal;
  static constexpr bool kInPlane = Geometry::kDim == 2;

public:
  explicit Metal(const MaterialConstants &c)
      : Material(Elasticity(c)), hardening_(c), elasticity_(c), rate_scale_(c.rate_scale),
        initial_temperature_(c.initial_temperature), heating_(c.adiabatic ? kHeatShare / (c.density * c.heat_capacity) : 0)
  {
  }

  double FlowStress(double plastic_strain) const override
  {
    return hardening_.At(plastic_strain, 0, initial_temperature_).stress;
  }
  double RateScale() const override
  {
    constexpr double kStrain = 0.1, kFast = 1e30; // 1/s
    return hardening_.At(kStrain, kFast, initial_temperature_).stress == FlowStress(kStrain) ? 0 : rate_scale_;
  }

  void UpdateStress(const MaterialBatch &batch, double *dissipated) const override
  {
    Flow flow;
    alignas(64) Row history[kHistory], stress[kS]; // internal variables, of which b_e are the first; Cauchy's stress
    const MaterialBatch b = batch;
    const double mu2 = 2 * elasticity_.mu, bulk3 = 3 * elasticity_.lambda + mu2;
    LoadRows<kHistory>(b.history, b.count, history, b.history_stride);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) Trial(b, p, mu2, history, flow);
    flow.large = AnyLarge(b.count, flow.norm2);
    for (int p = 0; flow.large && p < b.count; ++p)
      if (IsLarge(flow.norm2[p])) Set(LogarithmicStrainOfLarge(StressIn<Geometry>(history, p), 1), p, mu2, flow);
    const bool flows = Return(b, history, flow, dissipated);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) FinishStress(b, p, mu2, bulk3, flow, stress);
    if (flows) UpdateElastic(b.count, flow, history);
    StoreRows<kS>(stress, b.count, b.stress);
    StoreRows<kHistory>(history, b.count, b.history, b.history_stride);
  }

  void StoredEnergy(int count, const double *, const double *, const double *, const double *history, int stride,
                    double *energy) const override
  {
    const Elasticity law = elasticity_;
#pragma omp simd
    for (int p = 0; p < count; ++p) energy[p] = EnergyOf(law, history + stride * p);
    for (int p = 0; p < count; ++p)
      if (energy[p] < 0) energy[p] = Energy(law, LogarithmicStrainOfLarge(LoadStress<Geometry>(history + stride * p), 1));
  }

  void WaveSpeedSquared(int count, const double *, const double *, double *speed2) const override
  {
    std::fill_n(speed2, count, SpeedOfSound() * SpeedOfSound());
  }

  int HistorySize() const override { return kHistory; }
  void InitialHistory(double *history) const override
  {
    // No array of constants here: GCC 12 for AVX-512 copies 1, 1, 1, 0 as 1, 1, 1, 1.
    for (int k = 0; k < kHistory; ++k) history[k] = k < 3 ? 1 : 0;
    if constexpr (Hardening::kThermal) history[kHeat] = initial_temperature_;
  }
  int PlaceOf(InternalVariable variable) const override
  {
    return variable == kPlasticStrain ? kStrain : Hardening::kThermal ? kHeat : -1;
  }

private:
  static constexpr double kHeatShare = 0.9; ///< of plastic work (Taylor & Quinney)

  /// The trial state of a block, by components; stress: von Mises', Pa; kept: the part of the deviator that the flow leaves.
  struct Flow {
    alignas(64) Row deviator[kS], mean, norm2, stress, kept;
    bool large; ///< whether any strain is too large for the series
    Sym3 Deviator(int p) const { return StressIn<Geometry>(deviator, p); }
  };

  /// Also true of what is no number.
  static bool IsLarge(double norm2) { return !(norm2 <= kLargestNorm2); }
  static bool AnyLarge(int count, const double *norm2)
  {
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int p = 0; p < count; ++p) any |= IsLarge(norm2[p]);
    return any;
  }

  [[gnu::always_inline]] static void Set(const LogStrain &e, int p, double mu2, Flow &flow)
  {
    PutStress<Geometry>(e.deviator, p, flow.deviator);
    flow.mean[p] = e.mean, flow.norm2[p] = e.norm2;
    flow.stress[p] = mu2 * std::sqrt(1.5 * Contract(e.deviator, e.deviator)), flow.kept[p] = 1;
  }

  /// I + dt L, with the growth along z where the geometry has no L_zz.
  [[gnu::always_inline]] static Mat3 Increment(double dt, const Mat3 &L, double growth)
  {
    return {1 + dt * L.xx, dt * L.xy,     dt * L.xz,
            dt * L.yx,     1 + dt * L.yy, dt * L.yz,
            dt * L.zx,     dt * L.zy,     Geometry::kDim == 3 ? 1 + dt * L.zz : growth};
  }

  /// b_e := (I + dt L) b_e (I + dt L)^T, and its logarithm.
  [[gnu::always_inline]] static void Trial(const MaterialBatch &b, int p, double mu2, Row *elastic, Flow &flow)
  {
    const Mat3 increment = Increment(b.dt, LoadGradient<Geometry>(b.L, p, 0), Geometry::kHoop ? b.hoop_ratio[p] : 1);
    const Sym3 trial = Push<kInPlane>(increment, StressIn<Geometry>(elastic, p));
    PutStress<Geometry>(trial, p, elastic);
    Set(LogarithmicStrain<kInPlane>(trial), p, mu2, flow);
  }

  /// Finds what is kept of the deviators, and updates plastic strains, temperatures and work; true where any point flows. All
  /// that it calls becomes part of it, so that loops over points vectorise whatever the law.
  [[gnu::flatten]] bool Return(const MaterialBatch &b, Row *history, Flow &flow, double *dissipated) const
  {
    const std::conditional_t<std::is_trivially_copyable_v<Hardening>, Hardening, const Hardening &> law = hardening_;
    const double mu3 = 3 * elasticity_.mu, rate = rate_scale_ / b.dt, heating = heating_;
    PlasticStep step;
    FlowOf(law, mu3, {b.count, flow.stress, history[kStrain], Hardening::kThermal ? history[kHeat] : nullptr, rate}, step);
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int p = 0; p < b.count; ++p) {
      const double plastic = step.strain[p], work = step.work[p];
      flow.kept[p] = plastic > 0 ? 1 - mu3 * plastic / flow.stress[p] : 1;
      history[kStrain][p] += plastic;
      if constexpr (Hardening::kThermal) history[kHeat][p] += heating * work;
      dissipated[p] += work;
      any |= plastic > 0;
    }
    return any;
  }

  /// Cauchy stress (2 mu kept e' + (3 lambda + 2 mu) mean I)/J.
  [[gnu::always_inline]] static void FinishStress(const MaterialBatch &b, int p, double mu2, double bulk3, const Flow &flow,
                                                  Row *stress)
  {
    const double inverse_J = 1 / Determinant(GradientOf<Geometry>(b.F, b.hoop, p));
    const double shear = mu2 * flow.kept[p] * inverse_J;
    PutStress<Geometry>(shear * flow.Deviator(p) + Sphere(bulk3 * flow.mean[p] * inverse_J), p, stress);
  }

  /// b_e := b_e exp(-2 (1 - kept) e'): the mean strain stays.
  static void UpdateElastic(int count, const Flow &flow, Row *elastic)
  {
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const double lost = IsLarge(flow.norm2[p]) ? 0 : 1 - flow.kept[p];
      Multiply(Exponential<kInPlane>(-2 * lost * flow.Deviator(p)), p, elastic);
    }
    for (int p = 0; flow.large && p < count; ++p)
      if (IsLarge(flow.norm2[p])) Multiply(ExponentialOfLarge(-2 * (1 - flow.kept[p]) * flow.Deviator(p)), p, elastic);
  }
  [[gnu::always_inline]] static void Multiply(const Sym3 &factor, int p, Row *elastic)
  {
    PutStress<Geometry>(CoaxialProduct<kInPlane>(StressIn<Geometry>(elastic, p), factor), p, elastic);
  }

  static double Energy(const Elasticity &law, const LogStrain &e)
  {
    return 0.5 * (3 * law.lambda + 2 * law.mu) * 3 * e.mean * e.mean + law.mu * Contract(e.deviator, e.deviator);
  }
  /// -1 where the strain is too large for the series.
  [[gnu::always_inline]] static double EnergyOf(const Elasticity &law, const double *history)
  {
    const LogStrain e = LogarithmicStrain<kInPlane>(LoadStress<Geometry>(history));
    return e.norm2 <= kLargestNorm2 ? Energy(law, e) : -1;
  }

  Hardening hardening_;
  Elasticity elasticity_;
  double rate_scale_, initial_temperature_;
  double heating_; ///< rise of temperature by plastic work, K m3/J
};

template <class Hardening> std::unique_ptr<Material> Create(const MaterialConstants &c, GeometryKind kind)
{
  return WithGeometry(kind, [&](auto geometry) -> std::unique_ptr<Material> {
    return std::make_unique<Metal<Hardening, decltype(geometry)>>(c);
  });
}

using C = MaterialConstants;
constexpr HardeningConstant
    kYield = {"yield_stress", "initial yield stress (j2)", "Pa", &C::yield_stress, 0, HUGE_VAL, false, true},
    kModulus = {"hardening_modulus",
                "H of sy + H a (linear), B of sy + B a^n (ludwik, johnson_cook)",
                "Pa",
                &C::hardening_modulus,
                0,
                HUGE_VAL,
                true,
                true},
    kExponent = {"hardening_exponent", "n (swift, ludwik, power, johnson_cook)", "", &C::hardening_exponent, 0, 1, true, true},
    kStrain = {"hardening_strain", "e0 of sy (1 + a/e0)^n (swift)", "", &C::hardening_strain, 0, HUGE_VAL, false, true};

struct NamedLaw {
  HardeningLaw law;
  std::unique_ptr<Material> (*create)(const MaterialConstants &, GeometryKind);
};

const std::vector<NamedLaw> &NamedLaws()
{
  static const std::vector<NamedLaw> laws = {
      {{"linear", {kYield, kModulus}}, Create<LinearHardening>},
      {{"swift", {kYield, kExponent, kStrain}}, Create<SwiftHardening>},
      {{"voce",
        {kYield,
         {"saturation_stress", "ss of ss - (ss - sy) exp(-a/ec) (voce)", "Pa", &C::saturation_stress, 0, HUGE_VAL, false, true},
         {"saturation_strain", "ec of it (voce)", "", &C::saturation_strain, 0, HUGE_VAL, false, true}}},
       Create<VoceHardening>},
      {{"ludwik", {kYield, kModulus, kExponent}}, Create<LudwikHardening>},
      {{"power", {kYield, kExponent}}, Create<SwiftHardening>},
      {{"table", {}}, Create<TableHardening>},
      {{"johnson_cook",
        {kYield,
         kModulus,
         kExponent,
         {"rate_sensitivity", "C of 1 + C ln(rate/r0) (johnson_cook)", "", &C::rate_sensitivity, 0, HUGE_VAL, true, true},
         {"reference_rate", "r0 of it (johnson_cook)", "1/s", &C::reference_rate, 0, HUGE_VAL, false, true},
         {"thermal_exponent", "m of 1 - ((T - T0)/(Tm - T0))^m (johnson_cook)", "", &C::thermal_exponent, 0, HUGE_VAL, false,
          true},
         {"melting_temperature", "Tm of it (johnson_cook)", "K", &C::melting_temperature, 0, HUGE_VAL, false, true},
         {"reference_temperature", "T0 of it, where it is not -initial_temperature (johnson_cook)", "K",
          &C::reference_temperature, 0, HUGE_VAL, false, false},
         {"heat_capacity", "heat capacity, required with -NAME_adiabatic (johnson_cook)", "J/(kg K)", &C::heat_capacity, 0,
          HUGE_VAL, false, false}}},
       Create<JohnsonCookHardening>},
  };
  return laws;
}

} // namespace

const std::vector<HardeningLaw> &HardeningLaws()
{
  static const std::vector<HardeningLaw> laws = [] {
    std::vector<HardeningLaw> all;
    for (const NamedLaw &named : NamedLaws()) all.push_back(named.law);
    return all;
  }();
  return laws;
}

std::unique_ptr<Material> CreateMetal(const MaterialConstants &constants, GeometryKind geometry)
{
  const auto &laws = NamedLaws();
  const auto found =
      std::find_if(laws.begin(), laws.end(), [&](const NamedLaw &one) { return constants.hardening == one.law.name; });
  return found->create(constants, geometry);
}

} // namespace mlgimp
