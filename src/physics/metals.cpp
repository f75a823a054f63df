// The law j2: multiplicative von Mises plasticity with logarithmic elastic strain and radial return (Simo 1992) of the Cauchy
// stress, with the hardening laws of hardening.hpp, in loops over blocks of points.
#include "physics/creep.hpp"
#include "physics/log_strain.hpp"
#include "physics/material.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace mlgimp
{

namespace
{

/// The elastic strain is what the stress says: its deviator e' is that of J sigma over 2 mu, its trace ln J, as flow keeps the
/// volume. So b_e is exp(2 e') J^(2/3) and no field. Internal variables: the equivalent plastic strain and, where the law knows
/// it, the temperature.
template <class Hardening, class Geometry> class Metal : public Material
{
  static constexpr int kS = Geometry::kStress, kStrain = 0, kHeat = 1, kHistory = 1 + Hardening::kThermal; // size
  static constexpr bool kInPlane = Geometry::kDim == 2;
  /// Whether there is a stress at which it yields, at any rate.
  static constexpr bool kYields = !std::is_same_v<Hardening, NortonCreep> && !std::is_same_v<Hardening, GarofaloCreep>;

public:
  explicit Metal(const MaterialConstants &c)
      : Material(Elasticity(c), TraitsOf(c)), hardening_(c), elasticity_(c), initial_temperature_(c.initial_temperature),
        heating_(c.adiabatic ? kHeatShare / (c.density * c.heat_capacity) : 0)
  {
  }

  double FlowStress(double plastic_strain) const override
  {
    if constexpr (kYields)
      return hardening_.At(plastic_strain, 0, initial_temperature_).stress;
    else
      return HUGE_VAL;
  }

  double CreepExponent() const override
  {
    if constexpr (kYields)
      return 0;
    else
      return hardening_.exponent;
  }

  void UpdateStress(const MaterialBatch &batch, double *dissipated) const override
  {
    Flow flow;
    alignas(64) Row history[kHistory], stress[kS];
    const MaterialBatch b = batch;
    const Elasticity law = elasticity_;
    LoadRows<kS>(b.stress, b.count, stress);
    LoadRows<kHistory>(b.history, b.count, history, b.history_stride);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) TakeStrain(b, p, law.mu, stress, flow);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) Trial(b, p, law.mu, flow);
    const bool any_large = AnyLarge(b.count, flow.norm2);
    for (int p = 0; any_large && p < b.count; ++p)
      if (IsLarge(flow.norm2[p])) TrialOfLarge(b, p, law.mu, flow);
    Return(b, history, flow, dissipated);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) FinishStress(p, law, flow, stress);
    StoreRows<kS>(stress, b.count, b.stress);
    StoreRows<kHistory>(history, b.count, b.history, b.history_stride);
  }

  void StoredEnergy(int count, const double *F, const double *hoop, const double *stress, const double *, int,
                    double *energy) const override
  {
    const Elasticity law = elasticity_;
#pragma omp simd
    for (int p = 0; p < count; ++p)
      energy[p] = law.EnergyOf(Determinant(GradientOf<Geometry>(F, hoop, p)) * LoadStress<Geometry>(stress + kS * p));
  }

  void WaveSpeedSquared(int count, const double *, const double *, double *speed2) const override
  {
    std::fill_n(speed2, count, SpeedOfSound() * SpeedOfSound());
  }

  void InitialHistory(double *history) const override
  {
    history[kStrain] = 0;
    if constexpr (Hardening::kThermal) history[kHeat] = initial_temperature_;
  }
  int PlaceOf(InternalVariable variable) const override
  {
    return variable == kPlasticStrain ? kStrain : Hardening::kThermal ? kHeat : -1;
  }

private:
  static constexpr double kHeatShare = 0.9; ///< of plastic work (Taylor & Quinney)

  static LawTraits TraitsOf(const MaterialConstants &c)
  {
    LawTraits traits{true, true, true, Hardening::kCreeps, Hardening::kCreeps, kHistory};
    if constexpr (Hardening::kOfRate && !Hardening::kCreeps) { // with the user's constants it may still not depend on the rate
      constexpr double kSomeStrain = 0.1, kFastRate = 1e30;    // size: any strain; 1/s, far beyond all
      const Hardening hardening(c);
      const auto stress_at = [&](double rate) { return hardening.At(kSomeStrain, rate, c.initial_temperature).stress; };
      traits.has_rate = stress_at(kFastRate) != stress_at(0);
    }
    return traits;
  }

  /// The state of a block; stress, before: von Mises' of the trial and at
  /// the start, which only creep reads, Pa; three_mu: 3 mu/J; kept: the part of the deviator that the flow leaves.
  struct Flow {
    alignas(64) Row elastic[kS], deviator[kS], J, inverse_J, norm2, stress, before, three_mu, kept;
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

  [[gnu::always_inline]] static void Set(const LogStrain &e, int p, double mu, Flow &flow)
  {
    PutStress<Geometry>(e.deviator, p, flow.deviator);
    flow.norm2[p] = e.norm2, flow.stress[p] = 2 * mu * flow.inverse_J[p] * std::sqrt(1.5 * Contract(e.deviator, e.deviator));
  }

  /// I + dt L, with the growth along z where the geometry has no L_zz.
  [[gnu::always_inline]] static Mat3 IncrementOf(const MaterialBatch &b, int p)
  {
    const double dt = b.dt, growth = Geometry::kHoop ? b.hoop_ratio[p] : 1;
    const Mat3 L = LoadGradient<Geometry>(b.L, p, 0);
    return {1 + dt * L.xx, dt * L.xy,     dt * L.xz,
            dt * L.yx,     1 + dt * L.yy, dt * L.yz,
            dt * L.zx,     dt * L.zy,     Geometry::kDim == 3 ? 1 + dt * L.zz : growth};
  }

  /// 2 e' of a stress, where det F is J.
  [[gnu::always_inline]] static Sym3 TwiceStrain(const Sym3 &stress, double J, double mu)
  {
    return J * (1 / mu) * (stress - Sphere(kThird * Trace(stress)));
  }

  /// exp(2 e') of before the step: b_e but for its volume.
  [[gnu::always_inline]] static void TakeStrain(const MaterialBatch &b, int p, double mu, const Row *stress, Flow &flow)
  {
    const double J = Determinant(GradientOf<Geometry>(b.F, b.hoop, p)), growth = Determinant(IncrementOf(b, p));
    const double inverse_both = 1 / (J * growth); // one division
    const Sym3 twice = TwiceStrain(StressIn<Geometry>(stress, p), J * J * inverse_both, mu);
    flow.J[p] = J, flow.inverse_J[p] = growth * inverse_both, flow.norm2[p] = Contract(twice, twice);
    flow.three_mu[p] = 3 * mu * flow.inverse_J[p];
    if constexpr (Hardening::kCreeps) flow.before[p] = mu * std::sqrt(1.5 * flow.norm2[p]) * growth * flow.inverse_J[p];
    PutStress<Geometry>(Exponential<kInPlane>(twice), p, flow.elastic);
  }

  /// e' of G b_e G^T, G = I + dt L.
  [[gnu::always_inline]] static void Trial(const MaterialBatch &b, int p, double mu, Flow &flow)
  {
    LogStrain e = LogarithmicStrain<kInPlane>(Push<kInPlane>(IncrementOf(b, p), StressIn<Geometry>(flow.elastic, p)));
    e.norm2 = std::max(e.norm2, flow.norm2[p]);
    Set(e, p, mu, flow);
  }
  static void TrialOfLarge(const MaterialBatch &b, int p, double mu, Flow &flow)
  {
    const Mat3 G = IncrementOf(b, p);
    const Sym3 twice = TwiceStrain(LoadStress<Geometry>(b.stress + kS * p), flow.J[p] / Determinant(G), mu);
    Set(LogarithmicStrainOfLarge(Push<kInPlane>(G, ExponentialOfLarge(twice))), p, mu, flow);
  }

  /// Finds what is kept of the deviators, and updates plastic strains, temperatures and work. All that it calls becomes part of
  /// it, so that loops over points vectorise whatever the law.
  [[gnu::flatten]] void Return(const MaterialBatch &b, Row *history, Flow &flow, double *dissipated) const
  {
    const std::conditional_t<std::is_trivially_copyable_v<Hardening>, Hardening, const Hardening &> law = hardening_;
    const double rate = b.scale / b.dt, heating = heating_;
    PlasticStep step;
    const FlowStates states = {b.count,
                               flow.stress,
                               history[kStrain],
                               Hardening::kThermal ? history[kHeat] : nullptr,
                               Hardening::kCreeps ? flow.before : nullptr,
                               flow.three_mu,
                               rate};
    if constexpr (Hardening::kCreeps)
      CreepOf(law, states, step);
    else
      FlowOf(law, states, step);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) {
      const double plastic = step.strain[p], work = flow.J[p] * step.work[p];
      flow.kept[p] = plastic > 0 ? 1 - flow.three_mu[p] * plastic / flow.stress[p] : 1;
      history[kStrain][p] += plastic;
      if constexpr (Hardening::kThermal) history[kHeat][p] += heating * work;
      dissipated[p] += work;
    }
  }

  /// Cauchy stress (2 mu kept e' + K ln J I)/J.
  [[gnu::always_inline]] static void FinishStress(int p, const Elasticity &law, const Flow &flow, Row *stress)
  {
    const double inverse_J = flow.inverse_J[p];
    const Sym3 pressure = Sphere(law.Bulk() * inverse_J * Log(flow.J[p]));
    PutStress<Geometry>((2 * law.mu * flow.kept[p] * inverse_J) * flow.Deviator(p) + pressure, p, stress);
  }

  Hardening hardening_;
  Elasticity elasticity_;
  double initial_temperature_;
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

} // namespace

const std::vector<HardeningLaw> &HardeningLaws()
{
  static const std::vector<HardeningLaw> laws = {
      {"linear", {kYield, kModulus}, Create<LinearHardening>, Create<PerzynaFlow<LinearHardening>>},
      {"swift", {kYield, kExponent, kStrain}, Create<SwiftHardening>, Create<PerzynaFlow<SwiftHardening>>},
      {"voce",
       {kYield,
        {"saturation_stress", "ss of ss - (ss - sy) exp(-a/ec) (voce)", "Pa", &C::saturation_stress, 0, HUGE_VAL, false, true},
        {"saturation_strain", "ec of it (voce)", "", &C::saturation_strain, 0, HUGE_VAL, false, true}},
       Create<VoceHardening>,
       Create<PerzynaFlow<VoceHardening>>},
      {"ludwik", {kYield, kModulus, kExponent}, Create<LudwikHardening>, Create<PerzynaFlow<LudwikHardening>>},
      {"power", {kYield, kExponent}, Create<SwiftHardening>, Create<PerzynaFlow<SwiftHardening>>},
      {"table", {}, Create<TableHardening>, Create<PerzynaFlow<TableHardening>>},
      {"johnson_cook",
       {kYield,
        kModulus,
        kExponent,
        {"rate_sensitivity", "C of 1 + C ln(rate/r0) (johnson_cook)", "", &C::rate_sensitivity, 0, HUGE_VAL, true, true},
        {"reference_rate", "r0 of it (johnson_cook)", "1/s", &C::reference_rate, 0, HUGE_VAL, false, true},
        {"thermal_exponent", "m of 1 - ((T - T0)/(Tm - T0))^m (johnson_cook)", "", &C::thermal_exponent, 0, HUGE_VAL, false,
         true},
        {"melting_temperature", "Tm of it (johnson_cook)", "K", &C::melting_temperature, 0, HUGE_VAL, false, true},
        {"reference_temperature", "T0 of it, where it is not -initial_temperature (johnson_cook)", "K", &C::reference_temperature,
         0, HUGE_VAL, false, false},
        {"heat_capacity", "heat capacity, required with -NAME_adiabatic (johnson_cook)", "J/kg/K", &C::heat_capacity, 0, HUGE_VAL,
         false, false}},
       Create<JohnsonCookHardening>},
  };
  return laws;
}

const std::vector<HardeningLaw> &RateLaws()
{
  static const HardeningConstant
      stress = {"creep_stress",
                "s0 of (q/s0)^n (norton), of sinh(q/s0)^n (garofalo, eyring), D of ((q - flow)/D)^n (perzyna)",
                "Pa",
                &C::creep_stress,
                0,
                HUGE_VAL,
                false,
                true},
      rate = {"creep_rate", "a0, the rate of flow where that is 1", "1/s", &C::creep_rate, 0, HUGE_VAL, false, true},
      exponent = {"creep_exponent", "n (norton, perzyna, garofalo)", "", &C::creep_exponent, 1, HUGE_VAL, true, true};
  static const std::vector<HardeningLaw> laws = {
      {"none", {}, nullptr},
      {"norton", {stress, rate, exponent}, Create<NortonCreep>},
      {"perzyna", {stress, rate, exponent}, nullptr},
      {"garofalo",
       {stress,
        rate,
        exponent,
        {"activation_energy", "Q of the rate a0 exp(-Q/(R T)) at -initial_temperature (garofalo)", "J/mol", &C::activation_energy,
         0, HUGE_VAL, true, false}},
       Create<GarofaloCreep>},
      {"eyring", {stress, rate}, Create<GarofaloCreep>},
  };
  return laws;
}

static const HardeningLaw &Find(const std::vector<HardeningLaw> &laws, const std::string &name)
{
  return *std::find_if(laws.begin(), laws.end(), [&](const auto &law) { return name == law.name; });
}

std::unique_ptr<Material> CreateMetal(const MaterialConstants &constants, GeometryKind geometry)
{
  if (const auto create = Find(RateLaws(), constants.rate_law).create) return create(constants, geometry);
  const HardeningLaw &hardening = Find(HardeningLaws(), constants.hardening);
  return (constants.rate_law == "none" ? hardening.create : hardening.with_overstress)(constants, geometry);
}

} // namespace mlgimp
