// One grid level: its grid, its points, and one explicit step of both.
#pragma once

#include "level/contact.hpp"
#include "level/events.hpp"
#include "level/model.hpp"
#include "level/points.hpp"

#include <functional>
#include <memory>

namespace mlgimp
{

/// Where a level lies.
struct LevelGeometry {
  GridGeometry grid;
  Sides sides;
};

/// What contact did since the run began, booked on the first rank of the level, and in the last step.
struct ContactTotals {
  Vec2 impulse{};            ///< on the body, N s
  double indenter_work = 0;  ///< J
  double penetration = 0;    ///< deepest so far, m
  double steps = 0, set_updates = 0, fallbacks = 0;
  ContactReport last;
};

/// Sums over a level's points on this rank.
struct PointTally {
  double kinetic_energy = 0, strain_energy = 0, mass = 0; ///< J, J, kg
  Vec2 momentum{};                                        ///< kg m/s
  double count = 0;
};

/// Why a level cannot go on; the first reason that this rank met.
struct LevelFailure {
  enum Kind { kNone, kPoint, kContact } kind = kNone;
  PointFailure point;
  double time = 0;
};

class Level
{
public:
  /// The model is kept by reference and must outlive the level.
  Level(const Model &model, const LogEvents &events) : model_(model), events_(events) {}

  PetscErrorCode Create(MPI_Comm comm, const LevelGeometry &geometry, const GridLayout &layout);

  /// One explicit step from `time` to `time + dt`.
  PetscErrorCode Step(double time, double dt);

  /// Sends points to the ranks that own their nearest nodes. Collective.
  PetscErrorCode Migrate();
  /// Replaces the grid by one with another layout and moves the points to their new owners. Collective.
  PetscErrorCode Recut(const GridLayout &layout);
  /// Orders the points by their nearest node.
  PetscErrorCode Sort();
  /// Steps between calls of Migrate that keep the drift of points within the halo, from the largest speed now.
  void PlanMigration(double largest_speed, double dt);

  PetscErrorCode Tally(PointTally *tally);
  /// Largest of c + |v| and of |v| over this rank's points, m/s.
  PetscErrorCode LargestSpeeds(double *wave, double *point);

  Points &PointStore() { return points_; }
  const Grid &Mesh() const { return *grid_; }
  const LevelGeometry &Geometry() const { return geometry_; }
  const LevelFailure &Failure() const { return failure_; }
  NodalTotals &Nodal() { return nodal_totals_; }
  SweepTotals &Sweeps() { return sweep_totals_; }
  ContactTotals &Contacts() { return contact_totals_; }
  long Steps() const { return steps_; }
  void SetSteps(long steps) { steps_ = steps; }
  void SetSortInterval(int interval) { sort_interval_ = interval; }

private:
  PetscErrorCode GatherForces(double time);
  PetscErrorCode AdvanceNodes(double time, double dt);
  PetscErrorCode ApplyContact(double time, double dt);
  PetscErrorCode AdvancePoints(double dt);
  PetscErrorCode StrainBeforeForces(double dt);
  PetscErrorCode KeepOrder();
  PetscErrorCode PointsToGrid(double time);
  PetscErrorCode ExchangeRates();
  void NoteFailure(const PointFailure &failure, double time);

  const Model &model_;
  LogEvents events_;
  LevelGeometry geometry_{};
  NodalSettings nodal_;
  BodyTable bodies_;
  std::unique_ptr<Grid> grid_;
  Points points_;
  std::unique_ptr<Transfer> transfer_;
  std::unique_ptr<Contact> contact_;
  std::vector<double> grid_velocity_; ///< [points][2] between two sweeps of a step
  NodalTotals nodal_totals_;
  SweepTotals sweep_totals_;
  ContactTotals contact_totals_;
  LevelFailure failure_;
  double time_ = 0;
  long steps_ = 0;
  int migration_interval_ = 1, sort_interval_ = 50;
};

} // namespace mlgimp
