// The levels, the borders that connect them, and which rank holds which part of each.
#pragma once

#include "hierarchy/coupling/level_interface.hpp"
#include "hierarchy/following.hpp"
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
  bool CouplesNodes() const { return levels.size() > 1 && coupling == LevelCoupling::kNodes; }
};

class ConnectedLevels
{
public:
  /// Creates the grids, without points, and connects them. seedings: of the levels, from the coarsest on. Collective.
  PetscErrorCode Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings, const LogEvents &events,
                        const std::vector<Seeding> &seedings);

  MPI_Comm Comm() const { return comm_; }
  const HierarchySettings &Settings() const { return settings_; }
  const LogEvents &Events() const { return events_; }
  int Count() const { return static_cast<int>(levels_.size()); }
  Level &At(int l) { return *levels_[l]; }
  /// Border b, of levels b and b + 1, and the points that cross it.
  LevelInterface &Border(int b) { return *borders_[b]; }
  PointTransfer &Transfer(int b) { return *transfers_[b]; }
  /// The border of level l to the next coarser level, and to the next finer one; null where no level with points is there.
  LevelInterface *Coarser(int l) { return l > 0 ? borders_[l - 1].get() : nullptr; }
  LevelInterface *Finer(int l) { return l + 1 < active_ ? borders_[l].get() : nullptr; }
  /// Of points that are split from now on.
  PointNumbers &Numbers() { return *numbers_; }

  /// The boxes of the levels have moved, and the first `active` levels have points; to be followed by Reconnect.
  void SetBoxes(const std::vector<LevelGeometry> &boxes, int active) { settings_.levels = boxes, active_ = active; }
  /// Connects the levels as their layouts are now. keeps_state: the borders have the same nodes as before. Collective.
  PetscErrorCode Reconnect(bool keeps_state);
  /// The same border by border, the last one last, with the state from LevelInterface::GatherState. Collective.
  PetscErrorCode RestoreBorder(int b, const std::vector<double> &state);
  /// How often nodes have got other owners; the same on all ranks.
  int OwnerChanges() const { return owner_changes_; }

  /// Gives the blocks of all levels to the ranks that save most messages between levels. Collective.
  PetscErrorCode MapRanks();
  /// Cuts level l anew where that is better for its points. Collective.
  PetscErrorCode Rebalance(int l);
  /// The same for each level of which a rank has too many points, or which has too many or too few for its ranks. Collective.
  PetscErrorCode Balance();
  /// Points of each level, in all and on the rank that has most. Collective.
  PetscErrorCode CountPoints(std::vector<double> *total, std::vector<double> *largest) const;
  /// Bytes that the coupling of levels sends between ranks in a step of level 0, with the ranks that METIS chose for the
  /// blocks and with the first ranks in order. Collective.
  PetscErrorCode BytesBetweenLevels(double *mapped, double *unmapped) const;

private:
  PetscErrorCode CreateLevel(const Model &model, int l, const Seeding &seeding, const std::vector<int> &groups);
  PetscErrorCode CreateBorders(std::int64_t seeds);
  PetscErrorCode RenewBorder(int b, bool keeps_state);
  void CoupleNodes(int l);
  PetscErrorCode FindTraffic(std::vector<BlockTraffic> *traffic) const;
  RankMap RanksInUse() const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  HierarchySettings settings_;
  LogEvents events_{};
  std::vector<std::unique_ptr<Level>> levels_;
  std::vector<std::unique_ptr<LevelInterface>> borders_; ///< [b]: of levels b and b + 1
  std::vector<std::unique_ptr<PointTransfer>> transfers_;
  std::optional<PointNumbers> numbers_;
  int active_ = 1; ///< levels with points
  int owner_changes_ = 0;
};

} // namespace mlgimp
