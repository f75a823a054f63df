// What drag and inertia add to a test that is not slow, from the budgets, row by row of the history.
#pragma once

#include "grid/budgets.hpp"

#include <tuple>

namespace mlgimp
{

/// Two figures, each an estimate within a factor of about two, of bodies whose flow does not forget:
///
/// Of the load at the largest depth, with z the depth, D the work of -damping, E the kinetic energy and W the indenter's work,
///   drag = dD/dW,  inertia = 2 dE/dW,  as sums over the rows that brought the tip deeper, each weighted by (z/z_now)^4,
/// over what is left, 1 - (dD + dE)/dW. The factor of E is that of waves, which have as much strain energy as kinetic.
///
/// Of the plastic work under pressures: work that is neither stored nor plastic, X = E + D + viscous, grows as long as pressures
/// are more than the bodies bear at rest, and falls where they have gone beyond. What flows after the largest X, while pressures
/// do not rise, would not have flowed in a slow test.
class MotionWatch
{
public:
  /// pressure: sum of the magnitudes of the pressures now, Pa.
  void Record(const Budgets &row, double pressure);

  double DragOfLoad() const { return ShareOfLoad(state_.drag); }           ///< share of the load without it
  double InertiaOfLoad() const { return ShareOfLoad(2 * state_.inertia); } ///< the same
  double ShareOfPlasticWork() const;                                       ///< share of the plastic work without it

  /// What it keeps from row to row.
  struct State {
    double depth = 0;                                      ///< the largest so far, m
    double work = 0, drag = 0, inertia = 0;                ///< weighted sums, J
    double last_work = 0, last_drag = 0, last_inertia = 0; ///< of the last row, J
    double pressure = 0;                                   ///< the largest so far, Pa
    double unspent = 0, flowed_then = 0; ///< the largest X since pressures rose, and the plastic work by then, J
    double flowed = 0;                   ///< plastic work of the last row under the largest pressures, J

    /// In the order of the file.
    template <class S> static auto Members(S &s)
    {
      return std::tie(s.depth, s.work, s.drag, s.inertia, s.last_work, s.last_drag, s.last_inertia, s.pressure, s.unspent,
                      s.flowed_then, s.flowed);
    }
  };
  const State &Now() const { return state_; }
  void SetState(const State &state) { state_ = state; }

private:
  double ShareOfLoad(double energy) const;
  void RecordTip(const Budgets &row);
  void RecordFlow(const Budgets &row, double pressure);

  State state_;
};

} // namespace mlgimp
