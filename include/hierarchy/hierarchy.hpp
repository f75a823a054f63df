// The hierarchy of levels: the recursion of the paper's Fig. 8, and what it does between steps of level 0.
#pragma once

#include "hierarchy/connected_levels.hpp"
#include "hierarchy/regrid.hpp"
#include "hierarchy/run_budgets.hpp"
#include "hierarchy/surface_owners.hpp"
#include "hierarchy/tip_track.hpp"

#include <optional>
#include <string>
#include <vector>

namespace mlgimp
{

/// Largest speeds over all points, and whether any level has failed.
struct SpeedCheck {
  double wave_speed = 0, point_speed = 0; ///< of c + |v| and |v|, m/s
  bool failed = false;
};

class Hierarchy
{
public:
  /// Creates the grids and fills them with points, or leaves them empty for a restart. The model must outlive this. Collective.
  PetscErrorCode Create(MPI_Comm comm, const Model &model, const HierarchySettings &settings, const LogEvents &events, bool fill);

  /// One step of level 0, with all steps of the finer levels within it.
  PetscErrorCode Advance(TimeStep step);

  PetscErrorCode CheckSpeeds(SpeedCheck *speeds);
  /// Prepares for the next `steps` steps of length dt from `time` on: migrates with intervals that suit the speeds, wakes
  /// contact on levels that the indenter can reach, and re-cuts ownership where points have become uneven.
  PetscErrorCode Adapt(const SpeedCheck &speeds, double time, double dt, int steps);
  /// Moves the boxes that follow, see Regrid::Follow. Collective.
  PetscErrorCode Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem);
  /// The budgets of all levels, see SumBudgets and ReduceBudgets.
  Budgets SumBudgets() { return mlgimp::SumBudgets(levels_, *model_); }
  PetscErrorCode ReduceBudgets(Budgets *budgets) { return mlgimp::ReduceBudgets(levels_, *model_, budgets); }
  std::string DescribeFailure() { return mlgimp::DescribeFailure(levels_, model_->geometry.Dim()); }
  /// Whether the next steps measure the noise of velocities, a budget that costs.
  void MeasureNoise(bool measures);

  MPI_Comm Comm() const { return levels_.Comm(); }
  int Levels() const { return levels_.Count(); }
  Level &At(int l) { return levels_.At(l); }
  ConnectedLevels &Connected() { return levels_; }
  TipTrack &Tip() { return tip_; }
  Regrid &Boxes() { return regrid_; }
  SurfaceOwners &SurfaceOf() { return surface_; }
  CopyState Copies() const { return copies_ ? copies_->State() : CopyState(); }
  void SetCopies(const CopyState &copies)
  {
    if (copies_) copies_->SetState(copies);
  }
  const std::vector<PetscLogStage> &Stages() const { return stages_; }
  /// Shows each level K to the viewers that the options -level_K_dm_view, _points_view and _nodes_view name. Collective.
  PetscErrorCode View(double time);

private:
  PetscErrorCode AdvanceLevel(int l, TimeStep step, int substep);
  PetscErrorCode RecordTip(int l, TimeStep step);
  PetscErrorCode RefineStretched(int l, double time);
  PetscErrorCode AdvanceLevelWithCopies(int l, TimeStep step);
  PetscErrorCode WatchContact(double time, double travel, double drift);

  const Model *model_ = nullptr;
  std::vector<PetscLogStage> stages_;
  ConnectedLevels levels_;
  std::optional<CopyCoupling> copies_; ///< where the coupling is by points
  TipTrack tip_;
  Regrid regrid_{levels_, tip_};
  SurfaceOwners surface_;
};

} // namespace mlgimp
