// Contact of one level with the indenter: the surface, the method, and the ranks that it concerns.
#pragma once

#include "base/time_step.hpp"
#include "contact/border_nodes.hpp"
#include "contact/contact.hpp"
#include "contact/strain_under.hpp"
#include "grid/light_nodes.hpp"
#include "level/events.hpp"
#include "level/level_geometry.hpp"
#include "surface/surface.hpp"
#include "surface/surface_motion.hpp"

#include <memory>
#include <vector>

namespace mlgimp
{

/// What contact acts on in a level.
struct ContactSite {
  const Model &model; ///< with an indenter
  const LevelGeometry &geometry;
  Grid &grid;
  Points &points;
  const BodyTable &bodies;
  const LightNodes &light;
  double mass_cutoff; ///< nodes with less are empty, kg
  SurfaceInputs Of(const Surface &surface) const { return {grid, model.geometry, surface, points, bodies, *model.indenter}; }
};

/// The borders of a level as contact sees them; null where there is no such level.
struct ContactBorders {
  BorderNodes *coarser = nullptr;
  SharedNode *finer = nullptr; ///< by place, nodes that also move the next finer level's
};

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
  LevelContact(const LogEvents &events, Budgets &budgets) : events_(events), budgets_(budgets) {}

  /// Chooses the method that the model names, or none.
  PetscErrorCode Create(const Model &model);
  bool Exists() const { return method_ != nullptr; }
  /// Whether there may be contact in the steps until the next check; the same on all ranks.
  bool IsActive() const { return method_ && reach_.active; }

  // The ranks that contact concerns: those with nodes in a zone, which holds all that points near the indenter may touch.

  /// While the indenter is out of reach, contact is left out of the steps. Collective on all ranks, `world`.
  PetscErrorCode Watch(MPI_Comm world, const Grid &grid, bool within_reach, const IndexBox &zone);
  bool WithinReach() const { return reach_.active; }
  const IndexBox &Zone() const { return reach_.nodes; }
  /// The grid has another layout. Collective on all ranks.
  PetscErrorCode Regroup(const Grid &grid);
  /// Brings the pressures from the first rank of the group to all, whichever will be in the next. Collective on all ranks.
  PetscErrorCode SharePressures(MPI_Comm world, const Grid &grid);
  /// Number of ranks that contact concerns, and the first of them, among all.
  int Ranks() const { return static_cast<int>(group_.Blocks().size()); }
  PetscMPIInt Root(const Grid &grid) const
  {
    return group_.Blocks().empty() ? 0 : grid.Nodes().Layout().ranks[group_.Blocks()[0]];
  }
  /// Pressures that the next step starts from, the same on every rank of the group.
  ContactPressures Pressures() const { return method_ ? method_->Pressures() : ContactPressures(); }
  void SetPressures(const ContactPressures &pressures);

  // A step.

  void SetBorders(const ContactBorders &borders) { borders_ = borders; }
  /// Decides whether anything may touch in the step; drift: how far points may have moved since the last one, m.
  void Begin(const TipStep &tip, double drift);
  /// Contact changes the velocities of nodes; a solver that does not converge is in HasFailed. coupled: see SharedNode.
  /// Collective on the level's ranks.
  PetscErrorCode Solve(const ContactSite &site, TimeStep step, const TipStep &tip, std::vector<CoupledNode> *coupled);
  /// Before points move: finds how corners of the surface will move. path: a bound of how far points have moved since any time,
  /// m.
  PetscErrorCode PrepareSurface(const ContactSite &site, double path);
  /// After it: moves the surface. rates: points that do not average their volume are strained by the second velocity.
  PetscErrorCode MoveSurface(const ContactSite &site, bool rates, double dt);
  /// The level has no points: nothing touches it.
  void Rest();

  bool HasFailed() const { return failed_; }
  /// What contact did to the tip in the last step.
  const TipReport &Tip() const { return tip_; }
  /// Changes of the velocities of nodes by contact in the step.
  const std::vector<NodeChange> &Changes() const { return changes_; }
  Surface &Patches() { return surface_; }
  const Surface &Patches() const { return surface_; }
  /// Must be called by all ranks when points or ranks have come: the next step searches the surface for contact.
  void InvalidateClearance() { clearance_.left = 0; }
  /// Pressure of contact in the last step on this rank's points, with the tip as it is now; see Contact::PressuresOnPoints.
  PetscErrorCode PressuresOnPoints(const ContactSite &site, Vec3 tip, std::vector<double> *pressures);
  /// The same on its patches of the surface; see Contact::PressuresOnPatches.
  PetscErrorCode PressuresOnPatches(const ContactSite &site, Vec3 tip, std::vector<double> *pressures);

private:
  void Record(const ContactReport &report, double area);
  void AddUp(const ContactReport &report, const Indenter &indenter, TimeStep step, const TipStep &tip, double spacing);
  void TakeShared(const ContactSite &site, std::vector<CoupledNode> *coupled);
  PetscErrorCode Apply(const ContactSite &site, TimeStep step, const TipStep &tip);

  LogEvents events_;
  Budgets &budgets_;
  std::unique_ptr<Contact> method_;
  ContactGroup group_; ///< empty without contact
  ContactBorders borders_;
  Surface surface_;
  SurfaceMotion surface_motion_;
  StrainUnder strain_under_;
  struct Reach {
    bool active = true; ///< until the next check
    IndexBox nodes = kAllNodes;
  } reach_;
  bool touches_ = false, failed_ = false; ///< in the step; for good
  bool reaches_coarser_level_ = true;     ///< contact in the step may have changed nodes of the coarser level
  std::vector<NodeChange> changes_;
  TipReport tip_;
  struct Clearance {
    double left = 0; ///< of that in ContactReport, m; the same on all ranks of the group
    Vec3 tip{};      ///< with which it was found, m
  } clearance_;
};

} // namespace mlgimp
