// The test's clock: how much of the test's time passes in a step, and how long holds last.
#pragma once

#include "program/case/case.hpp"

#include <vector>

namespace mlgimp
{

/// The time theta of the test is not that of the simulation, t. While the tip is driven, theta is that at which the test passes
/// the depth or load that the schedule has reached. In a hold it goes at a rate r = d theta/dt that follows the tip,
///   r <- r clip(v*/v, 1/2, 2)^(dt/T),   v* = eps h/T,
/// v the tip's mean speed over the last transit T of waves and h its largest depth so far, so that it creeps as slowly as a
/// loading in 1/eps transits goes; in a hold of the depth dP/dt and the largest P take their places. What began to relax when the
/// hold did has changed by a tenth and no more in a transit: r is at most 4 eps (theta - theta_hold + theta_leg)/T. The schedule
/// waits until the hold's time is up. Under load control the drag of damping on a tip that creeps, its work over the tip's way in
/// the last transit, is added to the load. Nothing of it changes but at checks, every kControlInterval steps.
class TestClock
{
public:
  /// All are kept by reference.
  TestClock(const Case &settings, TestState &state) : case_(settings), state_(state) {}

  bool On() const { return case_.quasi_static.test.On(); }
  /// The next step of level 0, and the test's time after it. Without a clock of the test time goes by -rate_scale.
  TimeStep Step(double time, double dt);
  /// A check at a time before steps of length dt. Collective.
  void Check(Hierarchy &hierarchy, double time, double dt);
  /// Goes on from the state of a checkpoint.
  void TakeState(Hierarchy &hierarchy);
  /// How many transits of a wave a leg has taken so far, of a state.
  static double TransitsOf(const std::vector<double> &state, std::size_t leg);
  /// Whether such numbers are a state of a test with so many legs.
  static bool IsState(const std::vector<double> &state, std::size_t legs);

private:
  /// What the clock looks back at.
  struct Sample {
    double time, depth, impulse, drag; ///< s, m, of contact, N s, work of damping, J
  };

  /// Mean load between two samples, N.
  static double MeanLoad(const Sample &from, const Sample &to) { return (to.impulse - from.impulse) / (to.time - from.time); }
  double ValueAt(double schedule) const;
  void Look(Hierarchy &hierarchy, double time);
  double StartRate(int leg) const;
  double ReferenceTime(int leg) const;
  double AllowedOverSpeed() const;
  double Drag(double schedule) const;
  void KeepState();

  const Case &case_;
  TestState &state_;
  double rate_ = 0;            ///< r in a hold; 0 elsewhere
  double largest_ = 0;         ///< depth so far, m; in tests by depths the load, N
  double more_load_ = 0;       ///< N
  std::vector<Sample> window_; ///< of the last transit, at checks
};

} // namespace mlgimp
