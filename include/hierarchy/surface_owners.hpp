// Which level and which rank holds a patch of the surface.
#pragma once

#include "level/level.hpp"
#include "level/seeding.hpp"

#include <cmath>
#include <vector>

namespace mlgimp
{

/// Patches lie on the level that the points there belong to, on the rank that owns the node nearest to their centre.
class SurfaceOwners
{
public:
  /// The levels from the coarsest on, which must stay. ratio: of neighbouring levels' steps.
  void Create(MPI_Comm comm, const std::vector<Level *> &levels, int ratio) { comm_ = comm, levels_ = levels, ratio_ = ratio; }
  /// Makes the surface of the bodies at the start, halved as near to the tip as contact wants it. Collective.
  PetscErrorCode Seed(const std::vector<Seeding> &seedings, Vec3 tip);
  /// Before a step of level 0: gives patches to the levels and ranks where they are now, if they may have moved too far or nodes
  /// have other owners. active: number of levels with points. owner_changes: see ConnectedLevels. Collective.
  PetscErrorCode Watch(int active, int owner_changes);
  /// Halves patches of level l that have become too long for it, or too near to the indenter with its tip there.
  void Split(int l, Vec3 tip);
  /// Must be called by all ranks when points belong to other levels.
  void BoxesHaveMoved() { drift_ = HUGE_VAL; }

  /// The patches of a level in the order of their numbers, [patches][kOfPatch], on the first rank, and how they come back on any
  /// number of ranks. Collective.
  PetscErrorCode Gather(int l, std::vector<double> *numbers) const;
  PetscErrorCode Restore(int l, const std::vector<double> &numbers);
  static constexpr int kOfPatch = 17; // size
  double Drift() const { return drift_; }
  void SetDrift(double cells) { drift_ = cells; }

private:
  int Levels() const { return static_cast<int>(levels_.size()); }
  int LevelAt(Vec3 x, int now, int active) const;
  PetscErrorCode Assign(bool to_levels, int active);

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::vector<Level *> levels_;
  int ratio_ = 2;
  int owner_changes_ = -1; ///< when patches were last given to ranks
  double drift_ = 0;       ///< cells of their level that patches may have moved since they were given to levels
};

} // namespace mlgimp
