// Where the indenter's tip is in a run: on its schedule or, where it is free, where contact has let it come.
#pragma once

#include "level/level_contact.hpp"

#include <vector>

namespace mlgimp
{

/// The way of a free tip (Indenter::IsFree) one level finds in each of its steps: the finest that holds the surface under the
/// tip. Coarser levels, whose steps end later, take that way as given; finer ones, which the indenter may touch beside its tip,
/// go on with the last speed. What these carried in their last step is left out of the load that the tip's level has to meet.
///
/// What gives way between the tip and what moves it (IndenterCompliance) takes its part of the way by the radius of the contact
/// in the step before, which it follows as fast as a wave crosses the contact.
class TipTrack
{
public:
  /// What the clock of a test does to the schedule.
  struct Clock {
    double delay = 0;     ///< time by which the schedule waits, s
    double more_load = 0; ///< beside that of the schedule, N
  };

  /// indenter: null for none; it must outlive this. tip_level: the level that finds the way, of so many.
  void Create(const Indenter *indenter, int tip_level, int levels);

  /// From now on, until it changes.
  void SetClock(const Clock &clock) { clock_ = clock; }
  /// Another level finds the way from now on.
  void SetLevel(int tip_level);

  /// The tip at a time; of a free one at the end of the last step of its level, or not long before or after.
  Vec3 At(double time) const;
  /// What the schedule has under load control, N.
  double LoadAt(double time) const { return indenter_->by_load->Value(time - clock_.delay); }
  /// The tip and the load in a step of level l; start: the tip when the step began.
  TipStep Step(int l, Vec3 start, TimeStep step) const;
  /// Takes up what level l did in that step. Collective on all ranks.
  PetscErrorCode Follow(MPI_Comm comm, int l, const LevelContact &contact, TimeStep step);

  /// How far the tip can come within some steps, m.
  double Reach(double time, double dt, int steps) const;
  /// By how much the place whose depth an instrument measures is deeper than the tip at a time, m.
  double Deflection(double time) const;
  /// What it stores, F^2 C/2 of its compliance now, J.
  double SpringEnergy(double time) const;
  /// How far the tip has come down at its largest speed without meeting its load, m.
  double Overrun() const { return overrun_; }

  /// What it keeps from step to step, the same on every rank; nothing unless it is free.
  std::vector<double> State() const;
  void SetState(const std::vector<double> &state);

private:
  double Load(TimeStep step) const; ///< in the mean, N
  bool IsFree() const { return indenter_ && indenter_->IsFree(); }
  double OnOtherLevels() const;
  /// Way down since the start of what moves a tip that gives way, m.
  double Driven(double time) const { return indenter_->motion.Travel(time - clock_.delay); }
  void Stretch(const TipReport &tip, TimeStep step);

  const Indenter *indenter_ = nullptr;
  int tip_level_ = 0;
  double time_ = 0, travel_ = 0; ///< end of the last step, s; way down since the start, m
  double speed_ = 0;             ///< in that step, downward, m/s
  double overrun_ = 0;
  Clock clock_;
  double radius_ = 0;                        ///< of the contact, as the tip's strain knows it, m
  double deflection_ = 0;                    ///< under load control, m
  std::vector<double> load_on_other_levels_; ///< load on each other level in its last step, N
};

} // namespace mlgimp
