// One grid level: its grid, its points, and one explicit step of both.
#pragma once

#include "base/time_step.hpp"
#include "grid/light_nodes.hpp"
#include "level/following_nodes.hpp"
#include "level/level_contact.hpp"
#include "points/points.hpp"

#include <memory>

namespace mlgimp
{

/// Why a level cannot go on; the first reason that this rank met.
struct LevelFailure {
  enum Kind { kNone, kPoint, kContact } kind = kNone;
  PointFailure point;
  double time = 0;
};

/// What a level carries from step to step beside points, totals and contact pressures.
struct LevelClock {
  long steps = 0;
  double drift = 0;          ///< how far points may have moved since they were last sent to their owners, cells
  double drift_per_step = 1; ///< cells
};

/// How a level advances.
struct LevelSettings {
  NodalSettings nodal;
  XpicSchedule xpic;
  int sort_interval = 50;      ///< steps
  bool measures_noise = false; ///< of the points' velocities, for Level::Totals
};

/// Points of a level on this rank.
struct PointStores {
  Points own;
  Points copies[2]; ///< of points that the next coarser (0) or finer level (1) owns
};

/// The loops over points, and what they know of the bodies.
struct LevelSweeps {
  std::unique_ptr<Kernels> kernels;
  BodyTable bodies;
};

/// Nodes whose velocities neighbouring levels have a part in.
struct CoupledLevel {
  bool on = false;                ///< their exchange of energy is added up
  std::vector<CoupledNode> nodes; ///< owned ones
  CoupledPlaces places;           ///< all that this rank has
  FollowingNodes following;       ///< blended ones beside the indenter
  const BorderNodes *coarser = nullptr;
  const double *finer_masses = nullptr; ///< by place, what the next finer level's points give nodes, kg
};

/// What lasts for a step, and the first failure.
struct LevelStep {
  double time = 0;                    ///< at its start, s
  std::vector<FaceForce> applied;     ///< by loads
  std::vector<NodeChange> held_nodes; ///< by sides
  LevelFailure failure;
  double drift_path = 0; ///< sum of the clock's drift since the run began or went on, cells
};

class Level
{
public:
  /// The model is kept by reference and must outlive the level.
  Level(const Model &model, const LogEvents &events) : model_(model), events_(events) {}

  PetscErrorCode Create(MPI_Comm world, const LevelGeometry &geometry, const GridLayout &layout);

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

  /// Nodes whose velocities neighbouring levels have a part in: owned ones, and all that this rank has. From now on their
  /// exchange of energy is added up.
  void SetCoupledNodes(std::vector<CoupledNode> nodes, CoupledPlaces places)
  {
    coupled_.nodes = std::move(nodes), coupled_.on = true;
    SetCoupledPlaces(std::move(places));
  }
  /// What contact must know of them; finer_masses: by place, what the next finer level's points give nodes, or null.
  void SetBorders(const ContactBorders &borders, const double *finer_masses)
  {
    coupled_.coarser = borders.coarser, coupled_.finer_masses = finer_masses;
    contact_.SetBorders(borders);
  }
  /// Force of some points times a sign on the nodes, in `sums` of owned nodes, without loads and body forces. Collective
  /// on the level's ranks.
  PetscErrorCode GatherForcesOf(const std::vector<int> &points, double sign);
  /// The nodal velocity of the last step at some points of this rank.
  std::vector<VelocitySample> SampleVelocity(const std::vector<int> &points);
  /// F and stress of some points as the grid sees them: sum_i S_ip (sum_q m_q S_iq F_q)/(sum_q m_q S_iq), [points][8], in two
  /// dimensions. Collective on the level's ranks.
  PetscErrorCode SmoothTensors(const std::vector<int> &points, std::vector<double> *tensors);

  /// Sends points to the ranks that own their nearest nodes; `everywhere` where they may be on any rank. A point beyond the
  /// grid is a failure; it is put back to the grid's edge, so that it does no harm until the run ends. Collective.
  PetscErrorCode Migrate(bool everywhere = false);
  /// Sends copies to the ranks that own their nearest nodes, from any rank. Collective on all ranks.
  PetscErrorCode MigrateCopies();
  /// Puts points that lie more than a cell beyond where they may back among this rank's nodes. Such is the place of a child of a
  /// point that deforms without bound, which is a failure.
  void PutBack(const std::vector<int> &points);
  /// The rank, among all, that owns the node nearest to point p of some level's arrays; -1, and a failure, where no point of
  /// this level may be: its weights would reach beyond the grid.
  PetscMPIInt OwnerOf(const PointArrays &points, int p);
  /// Velocities of all nodes, p/m of the points where they are now, without a change. Collective on the level's ranks.
  PetscErrorCode FindVelocities();
  /// Moves the level to another place; its points must lie there. Contact starts from nothing. Collective on all ranks.
  PetscErrorCode Move(const LevelGeometry &geometry, const GridLayout &layout);
  /// Nothing touches the level while it has no points.
  void Deactivate();
  /// Called when points of unknown speed have come: they migrate, and contact searches them, in every step until speeds are
  /// measured again. Collective on all ranks.
  PetscErrorCode Activate();
  /// Replaces the grid by one with another layout and moves points and copies to their new owners. Collective on all ranks.
  PetscErrorCode Repartition(const GridLayout &layout);
  /// Orders the points by their nearest node.
  PetscErrorCode Sort();
  /// Bounds the drift of points in a step by the largest speed now: they migrate before they drift out of the halo.
  void BoundDrift(double largest_speed, double dt);

  /// Widens a box by the places of this rank's surface points that are nearer than `range` to the indenter with its tip there.
  void FindNearIndenter(Vec3 tip, double range, Box *near);
  /// See LevelContact::Watch. Collective on all ranks.
  PetscErrorCode WatchContact(bool within_reach, const IndexBox &zone)
  {
    return contact_.Watch(world_, *grid_, within_reach, zone);
  }
  LevelContact &Contact() { return contact_; }
  const LevelContact &Contact() const { return contact_; }
  ContactSite Site() { return {model_, geometry_, *grid_, stores_.own, sweeps_.bodies, light_, settings_.nodal.mass_cutoff}; }
  /// Whether the next steps measure the noise of their points' velocities, for Totals.
  void MeasureNoise(bool measures) { settings_.measures_noise = measures; }
  /// Shows the level to PETSc's viewers: the grid, the points, and what these put on the nodes at `time`, where options named
  /// PREFIXdm_view, PREFIXpoints_view and PREFIXnodes_view ask for it. Collective on all ranks.
  PetscErrorCode View(const std::string &prefix, double time);
  /// Adds mass, momentum, energies and number of all points on this rank; and those of some.
  void SumPoints(Budgets *sums);
  Budgets SumPoints(const std::vector<int> &points);
  /// Largest of c + |v| and of |v| over this rank's points, m/s.
  void LargestSpeeds(double *wave, double *point);

  Points &PointStore() { return stores_.own; }
  /// Copies of points that the next coarser (0) or finer level (1) owns. They move and act with the level's own points,
  /// but do not count in any budget.
  Points &CopyStore(int origin) { return stores_.copies[origin]; }
  const Grid &Mesh() const { return *grid_; }
  Grid &Mesh() { return *grid_; }
  void SetBodyGroups(std::vector<int> groups) { node_bodies_.SetGroups(std::move(groups)); }
  const LightNodes &Light() const { return light_; }
  const LevelGeometry &Geometry() const { return geometry_; }
  /// Halves what has become too long of it, or too near to the indenter with its tip there.
  void SplitSurface(Vec3 tip) { contact_.Patches().Split(model_.geometry, *model_.indenter, tip, geometry_.grid.spacing); }
  const Model &Physics() const { return model_; }
  const LogEvents &Events() const { return events_; }
  const NodalSettings &Nodal() const { return settings_.nodal; }
  const LevelFailure &Failure() const { return step_.failure; }
  /// All that the level adds up on this rank but what SumPoints does.
  Budgets &Totals() { return budgets_; }
  long Steps() const { return clock_.steps; }
  const LevelClock &Clock() const { return clock_; }
  void SetClock(const LevelClock &clock) { clock_ = clock; }
  void SetXpic(const XpicSchedule &schedule) { settings_.xpic = schedule; }
  void SetSortInterval(int interval) { settings_.sort_interval = interval; }

private:
  /// A new grid by the layout, in the place of the one before.
  PetscErrorCode CreateGrid(const GridLayout &layout);
  void SetCoupledPlaces(CoupledPlaces places);
  PetscErrorCode StrainBeforeForces(double dt);
  PetscErrorCode PointsToGrid(double time);
  PetscErrorCode FindLightNodes();
  PetscErrorCode ExchangeRates(double dt, double xpic);
  PetscErrorCode AddWorkOfLoads(bool rates, double dt);
  /// Kinetic energy of the points less that of the nodes, at the start of a step, J.
  double NoiseEnergy();
  /// Calls sweep(view, budgets, failure) for the level's own points and for both stores of copies, where there are any;
  /// what copies do is not added up. flops: of a point.
  template <class Sweep> PetscErrorCode ForEachStore(double flops, Sweep sweep);
  void RecordFailure(const PointFailure &failure, double time);

  const Model &model_;
  LogEvents events_;
  MPI_Comm world_ = MPI_COMM_NULL;
  LevelGeometry geometry_{};
  LevelSettings settings_;
  std::unique_ptr<Grid> grid_;
  PointStores stores_;
  LevelSweeps sweeps_;
  CoupledLevel coupled_;
  NodeBodies node_bodies_;
  LightNodes light_;
  Budgets budgets_;
  LevelContact contact_{events_, budgets_};
  LevelStep step_;
  LevelClock clock_;
};

} // namespace mlgimp
