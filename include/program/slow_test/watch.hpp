// What inertia and damping add to the load of a slow test, watched row by row of the history.
#pragma once

#include "grid/budgets.hpp"
#include "program/case/case.hpp"

#include <tuple>
#include <vector>

namespace mlgimp
{

/// The load less what inertia and damping add to it, by their power: with E_k the kinetic energy of nodes, W the work of
/// -damping, z the depth, as changes over the last transit of a wave,
///   P_qs = P - (dE_k + dW) dz/(dz^2 + (0.05 z/N)^2),   z/N: the way in a transit of a loading to z,
/// so that a tip at rest has P_qs = P. The difference is at most P: loads, gravity and waves that come later have energy too.
class QuasiStaticWatch
{
public:
  /// The plan is kept by reference.
  explicit QuasiStaticWatch(const QuasiStaticPlan &plan) : plan_(plan) {}

  /// Takes up a row of the history and sets its load_quasi_static. Without a plan it does nothing.
  void Record(Budgets &row);

  /// The largest so far, from a fifth of the depth on and above a fifth of the largest load.
  struct Largest {
    double speed = 0;         ///< of the tip, mean over a transit, m/s
    double load = 0;          ///< N
    double load_share = 0;    ///< |P/P_qs - 1|
    double kinetic_share = 0; ///< of the body's energy, under loads of the indenter's work
    double noise_share = 0;   ///< of the indenter's work
    double hold_drift = 0; ///< range of the load, under load control of the depth, in the last transit of a hold, of its largest
    double hold_end = 0, hold_least = 0, hold_most = 0; ///< of the hold now: its end, s, and that range
    double leg = -1; ///< of the test, in the last row: what moved in another one does not count

    /// In the order of the file.
    template <class State> static auto Members(State &s)
    {
      return std::tie(s.speed, s.load, s.load_share, s.kinetic_share, s.noise_share, s.hold_drift, s.hold_end, s.hold_least,
                      s.hold_most, s.leg);
    }
  };
  const Largest &SoFar() const { return largest_; }

  /// What it keeps from row to row; empty without a plan.
  std::vector<double> State() const;
  void SetState(const std::vector<double> &state);
  /// Whether these numbers may be a state.
  bool IsState(const std::vector<double> &state) const;

private:
  /// A row that was.
  struct Sample {
    double time, depth, spent; ///< s, m, E_k + W, J
  };
  static constexpr int kSample = sizeof(Sample) / sizeof(double);

  double Added(const Sample &now, double load);
  void CheckHold(double time, double value);
  bool IsLoaded(const Budgets &row) const;

  const QuasiStaticPlan &plan_;
  Largest largest_;
  std::vector<Sample> window_; ///< of the last transit
  double speed_ = 0;           ///< mean over it, of the last row, m/s
};

} // namespace mlgimp
