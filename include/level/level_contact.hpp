// Contact of one level with the indenter: the surface, the method, and the ranks that it concerns.
#pragma once

#include "base/time_step.hpp"
#include "contact/contact.hpp"
#include "contact/strain_under.hpp"
#include "level/level_parts.hpp"
#include "surface/surface.hpp"
#include "surface/surface_motion.hpp"

#include <memory>
#include <vector>

namespace mlgimp
{

/// What contact did to the indenter's tip in a step, and how wide it was; the same on all ranks of its group.
struct TipReport {
  double travel = 0;                ///< of a free tip, downward, m
  bool limited = false;             ///< it would have had to travel farther to carry its load
  double load = 0;                  ///< this rank's part, N
  double half_width = 0, reach = 0; ///< see ContactReport, m
};

class LevelContact
{
public:
  /// Impulses, works and the width of the contact are added to the budgets, which must stay.
  explicit LevelContact(Budgets &budgets) : budgets_(budgets) {}

  /// Chooses the method that the model names, or none.
  PetscErrorCode Create(const Model &model);
  /// Whether there may be contact in the steps until the next check; the same on all ranks.
  bool IsActive() const { return method_ && within_reach_; }

  /// While the indenter is out of reach, contact is left out of the steps. Collective on all ranks, `world`.
  PetscErrorCode Watch(MPI_Comm world, const Grid &grid, bool within_reach, const IndexBox &zone);
  bool WithinReach() const { return within_reach_; }
  /// The ranks that contact concerns: those with nodes in its zone, which holds all that points near the indenter may touch.
  const ContactGroup &Group() const { return group_; }
  /// Another group, where the zone or the grid's layout has changed. Collective on all ranks.
  PetscErrorCode Regroup(MPI_Comm world, const Grid &grid);
  /// Pressures that the next step starts from, the same on every rank of the group.
  ContactPressures Pressures() const { return method_ ? method_->Pressures() : ContactPressures(); }
  void SetPressures(const ContactPressures &pressures);

  // A step.

  /// Decides whether anything may touch in the step; drift: how far points may have moved since the last one, m.
  void Begin(const TipStep &tip, double drift);
  /// Contact changes the velocities of nodes; a solver that does not converge is a failure of the level. coupled: see SharedNode.
  /// Collective on the level's ranks.
  PetscErrorCode Solve(const LevelParts &level, TimeStep step, const TipStep &tip, CoupledLevel *coupled);
  /// Before points move: finds how corners of the surface will move. path: a bound of how far points have moved since any time,
  /// m.
  PetscErrorCode PrepareSurface(const LevelParts &level, double path);
  /// After it: moves the surface. second: points that do not average their volume are strained by the second velocity.
  PetscErrorCode MoveSurface(const LevelParts &level, bool second, double dt);
  /// The level has no points: nothing touches it.
  void Deactivate();

  /// What contact did to the tip in the last step.
  const TipReport &Tip() const { return tip_; }
  /// Changes of the velocities of nodes by contact in the step.
  const std::vector<NodeChange> &Changes() const { return changes_; }
  Surface &Patches() { return surface_; }
  /// Must be called by all ranks when points or ranks have come: the next step searches the surface for contact.
  void InvalidateClearance() { clearance_.left = 0; }
  /// Pressure of contact in the last step on this rank's points, with the tip as it is now; see Contact::PressuresOnPoints.
  PetscErrorCode PressuresOnPoints(const LevelParts &level, Vec3 tip, std::vector<double> *pressures);
  /// The same on its patches of the surface; see Contact::PressuresOnPatches.
  PetscErrorCode PressuresOnPatches(const LevelParts &level, Vec3 tip, std::vector<double> *pressures);

private:
  PetscErrorCode SharePressures(MPI_Comm world);
  void Record(const ContactReport &report, double area);
  void AddUp(const ContactReport &report, const Indenter &indenter, TimeStep step, const TipStep &tip, double spacing);
  void TakeShared(const LevelParts &level, CoupledLevel *coupled);
  PetscErrorCode Apply(const LevelParts &level, TimeStep step, const TipStep &tip, const CoupledLevel &coupled);

  Budgets &budgets_;
  std::unique_ptr<Contact> method_;
  ContactGroup group_; ///< empty without contact
  Surface surface_;
  SurfaceMotion surface_motion_;
  StrainUnder strain_under_;
  bool within_reach_ = true;          ///< until the next check
  bool touches_ = false;              ///< in the step
  bool reaches_coarser_level_ = true; ///< contact in the step may have changed nodes of the coarser level
  std::vector<NodeChange> changes_;
  TipReport tip_;
  struct Clearance {
    double left = 0; ///< of that in ContactReport, m; the same on all ranks of the group
    Vec3 tip{};      ///< with which it was found, m
  } clearance_;
};

} // namespace mlgimp
