// The hierarchy of levels: creation, the recursion of the paper's Fig. 8, and the budgets of the whole run.
#pragma once

#include "hierarchy/coupling/level_interface.hpp"
#include "hierarchy/following.hpp"
#include "hierarchy/surface_owners.hpp"
#include "hierarchy/tip_track.hpp"
#include "hierarchy/transfer/copy_coupling.hpp"
#include "hierarchy/transfer/point_transfer.hpp"
#include "level/level.hpp"
#include "level/seeding.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace mlgimp
{

/// How neighbouring levels act on each other: through their nodes (level_interface.hpp) or copies of points (point_copies.hpp).
enum class LevelCoupling { kNodes, kPoints };

/// Where the levels lie and how they are kept.
struct HierarchySettings {
  std::vector<LevelGeometry> levels;
  int sort_interval = 50;
  double rebalance_threshold = 1.1; ///< size: speed only
  int ratio = 2;                    ///< of neighbouring levels' cells and steps
  int tip_level = 0;                ///< the finest that holds the surface under the indenter's tip
  bool merge_siblings = false;      ///< points that leave a level become their parent again
  double most_loss = HUGE_VAL;      ///< share of their strain energy that may be lost by it, else they stay
  int points_per_rank = 1000;       ///< a level uses fewer ranks where it has fewer points
  LevelCoupling coupling = LevelCoupling::kNodes;
  CopyRepairs repairs; ///< of the coupling by points
  int ghost_cells = 4; ///< the coupling by points copies so far outside a level's box, cells of the level
  FollowSettings follow;
  LevelRules rules; ///< where boxes may lie; kBlendWidth where it has no widths of bands
};

/// The grid and the sides of level k in a box. padding: see GridGeometry.
LevelGeometry GeometryOf(const LevelRules &rules, const Model &model, const Box &box, int k, int padding);

/// A level's box that has moved, a level that has ended or one that has begun.
struct LevelMove {
  double step = 0, time = 0; ///< of level 0; s
  int level = 0;
  bool active = true; ///< false: the level has ended, and rests in its box
  Box box;
  double split = 0, merged = 0;                          ///< points on their way to the level, and from it
  double mass_error = 0, momentum_error = 0, energy = 0; ///< absolute changes of mass and momentum, kg and N s; J
};

/// Where the boxes of levels are, and how far the contact has come since the last check.
struct FollowState {
  BoxPlan plan;
  double half_width = 0, reach = 0; ///< see ContactPlace; m
};

/// Largest speeds over all points, and whether any level has failed.
struct SpeedCheck {
  double wave_speed = 0, point_speed = 0; ///< of c + |v| and |v|, m/s
  bool failed = false;
};

class Hierarchy
{
public:
  /// Creates the grids and fills them with points, or leaves them empty for a restart. Collective.
  PetscErrorCode Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings, const LogEvents &events, bool fill);

  /// One step of level 0, with all steps of the finer levels within it.
  PetscErrorCode Advance(TimeStep step);

  PetscErrorCode CheckSpeeds(SpeedCheck *speeds);
  /// What border b of levels b and b + 1 keeps from one step to the next, [interface nodes][LevelInterface::kState], on the
  /// first rank; empty before the first step. Collective.
  PetscErrorCode GatherInterfaceState(int b, std::vector<double> *state) { return borders_[b]->GatherState(state); }
  /// Number of interface nodes of border b.
  std::size_t InterfaceNodes(int b) const { return borders_[b]->InterfaceNodes(); }
  /// Connects the levels as their layouts are now, with the state from GatherInterfaceState: border by border, the last one last.
  /// Collective.
  PetscErrorCode RestoreInterfaceState(int b, const std::vector<double> &state);
  /// Prepares for the next `steps` steps of length dt from `time` on: migrates with intervals that suit the speeds, wakes
  /// contact on levels that the indenter can reach, and re-cuts ownership where points have become uneven.
  PetscErrorCode Adapt(const SpeedCheck &speeds, double time, double dt, int steps);
  /// After a step that ends at `time`: moves the boxes that follow where it is due and adds the moves to `moves`.
  /// problem: why a box cannot lie where it should; the same on every rank. next_check: when boxes may move again, s. Collective.
  PetscErrorCode Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem);
  /// Where boxes are now; while they follow, what the contact has reached since the last check.
  const FollowState &Following() const { return follow_; }
  /// Puts empty levels there. Collective.
  PetscErrorCode RestoreFollowing(const FollowState &state);
  /// The same with the largest reach of all ranks. Collective.
  PetscErrorCode ShareReach();
  /// The budgets of all levels on this rank, but what only a run knows.
  Budgets SumBudgets();
  /// Those of all ranks, on every rank. Collective.
  PetscErrorCode ReduceBudgets(Budgets *budgets);
  /// Whether the next steps measure the noise of velocities, a budget that costs.
  void MeasureNoise(bool measures);
  /// What this rank adds up: levels, borders, and points between levels.
  std::vector<Budgets *> Parts();
  /// One line about the first failure that this rank has met; empty where there is none.
  std::string DescribeFailure() const;

  int Levels() const { return static_cast<int>(levels_.size()); }
  Level &At(int l) { return *levels_[l]; }
  MPI_Comm Comm() const { return comm_; }
  TipTrack &Tip() { return tip_; }
  CopyState Copies() const { return copies_ ? copies_->State() : CopyState(); }
  void SetCopies(const CopyState &copies)
  {
    if (copies_) copies_->SetState(copies);
  }
  const std::vector<PetscLogStage> &Stages() const { return stages_; }
  /// Shows each level K to the viewers that the options -level_K_dm_view, _points_view and _nodes_view name. Collective.
  PetscErrorCode View(double time);
  /// Bytes that the coupling of levels sends between ranks in a step of level 0, with the ranks that METIS chose for the
  /// blocks and with the first ranks in order. Collective.
  PetscErrorCode BytesBetweenLevels(double *mapped, double *unmapped) const;
  /// Points of each level, in all and on the rank that has most. Collective.
  PetscErrorCode CountPoints(std::vector<double> *total, std::vector<double> *largest);

  SurfaceOwners &SurfaceOf() { return surface_; }

private:
  PetscErrorCode AdvanceLevel(int l, TimeStep step, int substep);
  PetscErrorCode RecordTip(int l, TimeStep step);
  PetscErrorCode RefineStretched(int l, double time);
  PetscErrorCode AdvanceLevelWithCopies(int l, TimeStep step);
  PetscErrorCode CreateInterfaces(std::int64_t seeds);
  PetscErrorCode CreateLevel(int l, const Seeding &seeding);
  PetscErrorCode MapRanks();
  PetscErrorCode FindTraffic(std::vector<BlockTraffic> *traffic) const;
  RankMap RanksInUse() const;
  PetscErrorCode RenewInterface(int b, bool keeps_state);
  PetscErrorCode Reconnect(bool keeps_state);
  bool CoupledByNodes() const { return Levels() > 1 && settings_.coupling == LevelCoupling::kNodes; }
  void CoupleNodes(int l);
  PetscErrorCode WatchContact(double time, double travel, double drift);
  IndexBox ZoneOf(int l, const Box &near, double drift) const;
  bool NeedsBalance(int l, double total, double largest) const;
  PetscErrorCode Rebalance(int l);
  PetscErrorCode FindContact(double time, double next_check, ContactPlace *place);
  PetscErrorCode MoveLevels(const BoxPlan &next);
  PetscErrorCode SplitIntoBoxes(const std::vector<LevelGeometry> &next, int active);
  PetscErrorCode SortIntoBoxes(const std::vector<LevelGeometry> &next, int active);
  PetscErrorCode PlaceLevel(int l, const LevelGeometry &geometry);
  PetscErrorCode MergeLeft();
  std::vector<LevelGeometry> GeometriesOf(const std::vector<Box> &boxes) const;
  /// Whether level l has points now.
  bool IsActive(int l) const { return l < follow_.plan.active; }

  MPI_Comm comm_ = MPI_COMM_NULL;
  const Model *model_ = nullptr;
  HierarchySettings settings_;
  LogEvents events_{};
  std::vector<PetscLogStage> stages_;
  std::vector<std::unique_ptr<Level>> levels_;
  std::vector<std::unique_ptr<LevelInterface>> borders_; ///< [b]: of levels b and b + 1
  std::vector<std::unique_ptr<PointTransfer>> transfers_;
  std::optional<PointNumbers> numbers_;
  std::optional<CopyCoupling> copies_; ///< where the coupling is by points
  TipTrack tip_;
  FollowState follow_;
  SurfaceOwners surface_;
};

} // namespace mlgimp
