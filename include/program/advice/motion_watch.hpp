// What drag and inertia add to a test that is not slow, from the budgets, row by row of the history.
#pragma once

#include "grid/budgets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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

  double DragOfLoad() const { return ShareOfLoad(kDrag, 1); }       ///< share of the load without it
  double InertiaOfLoad() const { return ShareOfLoad(kInertia, 2); } ///< the same
  double Deepest() const { return numbers_[kDepth]; }               ///< of the tip, m
  double ShareOfPlasticWork() const;                                ///< share of the plastic work without it

  static constexpr std::size_t kSize = 11; ///< numbers that it keeps from row to row
  std::vector<double> State() const { return {numbers_.begin(), numbers_.end()}; }
  /// state [kSize]
  void SetState(const double *state) { std::copy_n(state, kSize, numbers_.begin()); }

private:
  enum Kept {
    kDepth, ///< the largest so far, m
    kWork,
    kDrag,
    kInertia, ///< weighted sums, J
    kLastWork,
    kLastDrag,
    kLastInertia, ///< of the last row, J
    kPressure,    ///< the largest so far, Pa
    kUnspent,
    kFlowedThen, ///< the largest X since pressures rose, and the plastic work by then, J
    kFlowed      ///< plastic work of the last row under the largest pressures, J
  };
  static_assert(kFlowed + 1 == kSize);
  double ShareOfLoad(Kept part, double factor) const;
  void RecordTip(const Budgets &row);
  void RecordFlow(const Budgets &row, double pressure);

  std::array<double, kSize> numbers_{};
};

} // namespace mlgimp
