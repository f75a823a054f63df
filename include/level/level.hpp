// One grid level: its grid, its points, and one explicit step of both.
#pragma once

#include "base/time_step.hpp"
#include "level/level_contact.hpp"
#include "level/level_parts.hpp"
#include "level/point_stores.hpp"

#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// How a level advances, beside its model.
struct LevelSettings {
  XpicSchedule xpic;
  int sort_interval = 50;       ///< steps
  std::vector<int> body_groups; ///< see NodeBodies::SetGroups
};

/// The loops over points, and what they know of the bodies.
struct LevelSweeps {
  std::unique_ptr<Kernels> kernels;
  BodyTable bodies;
};

class Level
{
public:
  /// The model is kept by reference and must outlive the level.
  Level(const Model &model, const LogEvents &events) : model_(model), events_(events) {}

  PetscErrorCode Create(MPI_Comm world, const LevelGeometry &geometry, const GridLayout &layout,
                        const LevelSettings &settings = {});

  // One explicit step is these calls, in this order. Between them the nodes of neighbouring levels
  // are coupled (see hierarchy/coupling/level_interface.hpp). Nothing happens on ranks that hold no part of the grid.

  /// Mass, momentum and forces of the points on owned nodes.
  PetscErrorCode GatherForces(TimeStep step);
  /// New velocities of owned nodes from the level's own points.
  PetscErrorCode UpdateNodes(double dt);
  /// Holds the velocities at the domain's sides; contact; sends them to ghost nodes.
  PetscErrorCode FinishNodes(TimeStep step, const TipStep &tip);
  /// Velocities, positions, strain and stress of the points.
  PetscErrorCode AdvancePoints(double dt);
  /// Counts the step; migrates and sorts where due.
  PetscErrorCode EndStep();

  /// The neighbouring levels have a part in the velocities of these nodes, until the level gets another layout.
  void Couple(CoupledLevel coupled);
  /// Moves the level to another place; its points must lie there. Contact starts from nothing. Collective on all ranks.
  PetscErrorCode Move(const LevelGeometry &geometry, const GridLayout &layout);
  /// Replaces the grid by one with another layout and moves points and copies to their new owners. Collective on all ranks.
  PetscErrorCode Repartition(const GridLayout &layout);
  /// Whether the level has points, which have come with an unknown speed: they migrate, and contact searches them, in every step
  /// until speeds are measured again. Nothing touches a level without points. Collective on all ranks.
  PetscErrorCode SetActive(bool active);
  /// Shows the level to PETSc's viewers: the grid, the points, and what these put on the nodes at `time`, where options named
  /// PREFIXdm_view, PREFIXpoints_view and PREFIXnodes_view ask for it. Collective on all ranks.
  PetscErrorCode View(const std::string &prefix, double time);

  Grid &Mesh() { return *grid_; }
  const LevelGeometry &Geometry() const { return geometry_; }
  /// Its own points on this rank; and with them copies of others, and the owners of both.
  Points &PointStore() { return stores_.Own(); }
  PointStores &Stores() { return stores_; }
  LevelContact &Contact() { return contact_; }
  LevelStep &Step() { return step_; }
  /// All that the level adds up on this rank but what SumPoints does.
  Budgets &Totals() { return budgets_; }
  LevelParts Parts()
  {
    return {model_, events_, geometry_, nodal_, *sweeps_.kernels, sweeps_.bodies, light_, *grid_, stores_.Own(), step_};
  }

private:
  /// A new grid by the layout, in the place of the one before.
  PetscErrorCode CreateGrid(const GridLayout &layout);
  PetscErrorCode StrainBeforeForces(double dt);
  PetscErrorCode PointsToGrid(double time);
  PetscErrorCode FindLightNodes();
  /// What the step adds to the momenta of points, and what XPIC projects, on all nodes; the growth of cells.
  PetscErrorCode SpreadChange(const SpreadPlan &plan);
  /// Velocities and strain rates of the nodes for the points; the budgets that need momenta after the step.
  PetscErrorCode FindRates(const SpreadPlan &spread, double xpic);
  PetscErrorCode AddWorkOfLoads(const SpreadPlan &spread);
  PetscErrorCode GridToPoints(const GridToPointsPlan &plan);
  /// Calls sweep(view, budgets, failure) for the level's own points and for both stores of copies, where there are any;
  /// what copies do is not added up. flops: of a point.
  template <class Sweep> PetscErrorCode ForEachStore(double flops, Sweep sweep);

  const Model &model_;
  LogEvents events_;
  MPI_Comm world_ = MPI_COMM_NULL;
  LevelGeometry geometry_{};
  LevelSettings settings_;
  NodalSettings nodal_; ///< of the model, with the masses of this level's nodes
  std::unique_ptr<Grid> grid_;
  LevelStep step_;
  PointStores stores_{events_, step_};
  LevelSweeps sweeps_;
  CoupledLevel coupled_;
  NodeBodies node_bodies_;
  LightNodes light_;
  Budgets budgets_;
  LevelContact contact_{budgets_};
};

} // namespace mlgimp
