// The law viscoelastic: a generalized Maxwell solid at large strain (Simo 1987; Holzapfel, Nonlinear Solid Mechanics,
// 2000, 6.10), in loops over blocks of points.
//
// At once it is J tau = mu dev(B J^(-2/3)) + K ln J I, of which each term k takes shares g_k and h_k and forgets them within
// tau_k:
//   dQ_k/dt + Q_k/tau_k = g_k dS/dt,   dP_k/dt + P_k/tau_k = h_k dP/dt,
//   tau = (h_inf P + sum P_k) I + dev(F (g_inf S + sum Q_k) F^T),
// S the isochoric second Piola-Kirchhoff stress and P = K ln J. In a step S and P go along straight lines, for which the
// update is exact, however long it is beside tau_k.
#include "physics/material.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

/// What a term does in a step, for x = dt/tau: Q <- keeps Q + takes dS; it dissipates, but for the factor 1/(2 mu),
/// of_old Q:Q + of_both Q:dS + of_new dS:dS, as it is stressed by Q(t) from Q to its end.
struct TermStep {
  double keeps, takes, of_old, of_both, of_new;

  TermStep(double x, double share)
  {
    constexpr double kSmall = 0.02; // rounding: below, a series in the place of differences
    const double lost = -std::expm1(-x), part = x > 0 ? lost / x : 1, lost_twice = lost * (2 - lost); // 1 - exp(-2 x)
    keeps = 1 - lost, takes = share * part;
    of_old = share > 0 ? 0.5 * lost_twice / share : 0;
    of_both = x > 0 ? lost * lost / x : 0;
    of_new = share * (x < kSmall ? x * Series(x) : (x - 2 * lost + 0.5 * lost_twice) / (x * x));
  }

private:
  /// (x - 2 (1 - exp(-x)) + (1 - exp(-2 x))/2)/x^3 by the first terms of its series.
  static double Series(double x)
  {
    constexpr double kTerms[] = {1.0 / 3, -1.0 / 4, 7.0 / 60, -1.0 / 24, 31.0 / 2520}; // exact
    return kTerms[0] + x * (kTerms[1] + x * (kTerms[2] + x * (kTerms[3] + x * kTerms[4])));
  }
};

template <class Geometry> class Viscoelastic : public Material
{
  static constexpr int kS = Geometry::kStress, kPart = kS + 1; // size: of S or Q_k, and P or P_k behind it

public:
  explicit Viscoelastic(const MaterialConstants &c) : Material(Elasticity(c), TraitsOf(c)), constants_(c) {}

  void UpdateStress(const MaterialBatch &batch, double *dissipated) const override
  {
    const MaterialBatch b = batch;
    const Elasticity law = Elastic();
    alignas(64) Row now[kPart], change[kPart], pushed[kS], sum[kPart];
    PrefetchBlock(b.history + static_cast<std::ptrdiff_t>(b.history_stride) * b.count, b.count * b.history_stride);
    LoadRows<kPart>(b.history, b.count, change, b.history_stride);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) AtOnce(law, b, p, now);
    const double deviator = 1 - Sum(constants_.relaxation_shares), volume = 1 - Sum(constants_.relaxation_bulk_shares);
    for (int k = 0; k < kPart; ++k) {
      const double left = k < kS ? deviator : volume;
#pragma omp simd
      for (int p = 0; p < b.count; ++p) change[k][p] = now[k][p] - change[k][p], sum[k][p] = left * now[k][p];
    }
    StoreRows<kPart>(now, b.count, b.history, b.history_stride);
#pragma omp simd
    for (int p = 0; p < b.count; ++p)
      PutStress<Geometry>(PushedDeviator(GradientOf<Geometry>(b.F, b.hoop, p), StressIn<Geometry>(change, p)), p, pushed);
    for (std::size_t term = 0; term < constants_.relaxation_times.size(); ++term)
      Relax(b, law, static_cast<int>(term), change, pushed, sum, dissipated);
#pragma omp simd
    for (int p = 0; p < b.count; ++p) Push(b, p, sum);
  }

  void StoredEnergy(int count, const double *F, const double *hoop, const double *, const double *history, int history_stride,
                    double *energy) const override
  {
    const Elasticity law = Elastic();
    const double deviator = 1 - Sum(constants_.relaxation_shares), volume = 1 - Sum(constants_.relaxation_bulk_shares);
#pragma omp simd
    for (int p = 0; p < count; ++p) energy[p] = EnergyAtOnce(law, GradientOf<Geometry>(F, hoop, p), deviator, volume);
    for (std::size_t term = 0; term < constants_.relaxation_times.size(); ++term) {
      const double g = constants_.relaxation_shares[term], h = constants_.relaxation_bulk_shares[term];
      const double shear = g > 0 ? 1 / (4 * law.mu * g) : 0, bulk = h > 0 ? 1 / (2 * law.Bulk() * h) : 0;
      const double *const parts = history + kPart * (term + 1);
      for (int p = 0; p < count; ++p) {
        const double *const part = parts + static_cast<std::ptrdiff_t>(history_stride) * p;
        const Sym3 Q = PushedDeviator(GradientOf<Geometry>(F, hoop, p), LoadStress<Geometry>(part));
        energy[p] += shear * Contract(Q, Q) + bulk * part[kS] * part[kS];
      }
    }
  }

  /// Of the law at once: (K max(1 - ln J, 0) + mu (5 b - 1/b^2)/3)/rho0, b the largest square of a stretch without the growth of
  /// volume: J times the acoustic tensor has mu (5 tr b/9 - b_n/3) along a principal axis.
  void WaveSpeedSquared(int count, const double *F, const double *hoop, double *speed2) const override
  {
    const Elasticity law = Elastic();
    const double inverse = 1 / law.density;
#pragma omp simd
    for (int p = 0; p < count; ++p) {
      const Mat3 f = GradientOf<Geometry>(F, hoop, p);
      const double log_J = Log(Determinant(f)), b = std::max(LargestStretchSquared<true>(f) * Exp(-2 * kThird * log_J), 1.0);
      speed2[p] = (law.Bulk() * std::max(1 - log_J, 0.0) + kThird * law.mu * (5 * b - 1 / (b * b))) * inverse;
    }
  }

  void InitialHistory(double *history) const override { std::fill_n(history, Traits().history, 0.0); }

private:
  /// Asks the memory for so many numbers, those of the block that is likely to come next; there may be none.
  static void PrefetchBlock(const double *numbers, int count)
  {
    constexpr int kLine = 8; // size: numbers of a cache line
    for (int k = 0; k < count; k += kLine) __builtin_prefetch(numbers + k);
  }
  static double Sum(const std::vector<double> &shares) { return std::accumulate(shares.begin(), shares.end(), 0.0); }
  static LawTraits TraitsOf(const MaterialConstants &c)
  {
    return {false, false, false, true, true, kPart * (static_cast<int>(c.relaxation_times.size()) + 1)};
  }

  /// S and P of the law at once: S = mu J^(-2/3) (I - tr C/3 C^-1).
  [[gnu::always_inline]] static void AtOnce(const Elasticity &law, const MaterialBatch &b, int p, Row *now)
  {
    const Mat3 F = GradientOf<Geometry>(b.F, b.hoop, p);
    const Sym3 C = SymmetricProduct(Transposed(F), Transposed(F));
    const double J = Determinant(F), log_J = Log(J), isochoric = law.mu * Exp(-2 * kThird * log_J);
    PutStress<Geometry>(isochoric * (Sphere(1) - (kThird * Trace(C) / (J * J)) * Adjugate(C)), p, now);
    now[kS][p] = law.Bulk() * log_J;
  }

  /// A term forgets and takes up, of a change of S that is pushed forward, too; its stresses are added to the sums.
  void Relax(const MaterialBatch &b, const Elasticity &law, int term, const Row *change, const Row *pushed, Row *sum,
             double *dissipated) const
  {
    const double x = b.dt / (b.scale * constants_.relaxation_times[term]);
    const TermStep of_shear(x, constants_.relaxation_shares[term]), of_bulk(x, constants_.relaxation_bulk_shares[term]);
    const double shear = 1 / (2 * law.mu), bulk = 1 / law.Bulk();
    double *const history = b.history + kPart * (term + 1);
    alignas(64) Row part[kPart];
    LoadRows<kPart>(history, b.count, part, b.history_stride);
#pragma omp simd
    for (int p = 0; p < b.count; ++p)
      dissipated[p] += shear * OfShear(of_shear, b, p, part, pushed) + bulk * OfBulk(of_bulk, part[kS][p], change[kS][p]);
#pragma GCC unroll 7
    for (int k = 0; k < kPart; ++k) {
      const double keeps = k < kS ? of_shear.keeps : of_bulk.keeps, takes = k < kS ? of_shear.takes : of_bulk.takes;
#pragma omp simd
      for (int p = 0; p < b.count; ++p) part[k][p] = keeps * part[k][p] + takes * change[k][p], sum[k][p] += part[k][p];
    }
    StoreRows<kPart>(part, b.count, history, b.history_stride);
  }

  /// dev(F S F^T): energies of a term are those of its Kirchhoff stress.
  [[gnu::always_inline]] static Sym3 PushedDeviator(const Mat3 &F, const Sym3 &S)
  {
    const Sym3 pushed = mlgimp::Push<Geometry::kDim == 2>(F, S);
    return pushed - Sphere(kThird * Trace(pushed));
  }

  // The bodies of the loops are functions: the compiler vectorises those.
  /// What a term dissipates in a step, but for the modulus.
  [[gnu::always_inline]] static double OfShear(const TermStep &step, const MaterialBatch &b, int p, const Row *part,
                                               const Row *pushed)
  {
    const Sym3 Q = PushedDeviator(GradientOf<Geometry>(b.F, b.hoop, p), StressIn<Geometry>(part, p)),
               dS = StressIn<Geometry>(pushed, p);
    return step.of_old * Contract(Q, Q) + step.of_both * Contract(Q, dS) + step.of_new * Contract(dS, dS);
  }
  [[gnu::always_inline]] static double OfBulk(const TermStep &step, double P, double dP)
  {
    return step.of_old * P * P + step.of_both * P * dP + step.of_new * dP * dP;
  }

  /// Cauchy stress (P I + dev(F S F^T))/J.
  [[gnu::always_inline]] static void Push(const MaterialBatch &b, int p, const Row *sum)
  {
    const Mat3 F = GradientOf<Geometry>(b.F, b.hoop, p);
    const Sym3 tau = PushedDeviator(F, StressIn<Geometry>(sum, p)) + Sphere(sum[kS][p]);
    StoreStress<Geometry>((1 / Determinant(F)) * tau, b.stress + kS * p);
  }

  /// mu (tr B J^(-2/3) - 3)/2 and K (ln J)^2/2, by h = F - I as in NeoHookean, with these parts of each.
  [[gnu::always_inline]] static double EnergyAtOnce(const Elasticity &law, const Mat3 &F, double deviator, double volume)
  {
    const Mat3 h = {F.xx - 1, F.xy, F.xz, F.yx, F.yy - 1, F.yz, F.zx, F.zy, F.zz - 1};
    const double square = Trace(SymmetricProduct(h, h)), trace = h.xx + h.yy + h.zz, third = Determinant(h);
    const double second = h.xx * h.yy + h.yy * h.zz + h.zz * h.xx - h.xy * h.yx - h.yz * h.zy - h.xz * h.zx;
    const double growth = trace + second + third, log_J = Log1p(growth), y = -2 * kThird * log_J;
    const double shrinks = std::abs(y) < kSmallGrowth ? SmallGrowth(y) : Exp(y) - 1;
    const double excess = 2 * (growth - log_J - second - third) + square + 3 * (shrinks - y) + (2 * trace + square) * shrinks;
    return 0.5 * deviator * law.mu * excess + 0.5 * volume * law.Bulk() * log_J * log_J;
  }

  static constexpr double kSmallGrowth = 0.003; // rounding: as far as SmallGrowth reaches
  MaterialConstants constants_;
};

} // namespace

std::unique_ptr<Material> CreateViscoelastic(const MaterialConstants &constants, GeometryKind kind)
{
  return WithGeometry(kind, [&](auto geometry) -> std::unique_ptr<Material> {
    return std::make_unique<Viscoelastic<decltype(geometry)>>(constants);
  });
}

} // namespace mlgimp
