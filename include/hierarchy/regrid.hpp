// Levels whose boxes move: where the contact is, where boxes go, and the points to the levels they belong to then.
#pragma once

#include "hierarchy/connected_levels.hpp"
#include "hierarchy/tip_track.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

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

class Regrid
{
public:
  /// Both are kept by reference.
  Regrid(ConnectedLevels &levels, TipTrack &tip) : levels_(levels), tip_(tip) {}

  Regrid(const Regrid &) = delete;
  Regrid &operator=(const Regrid &) = delete;

  /// The boxes are where they start. The model must outlive this.
  void Begin(const Model &model)
  {
    model_ = &model;
    state_.plan = {levels_.Settings().follow.start, levels_.Count()};
  }
  /// Number of levels with points.
  int Active() const { return state_.plan.active; }
  /// Takes up how wide the contact was in a step of a level.
  void Widen(const TipReport &contact);
  /// After a step that ends at `time`: moves the boxes that follow where it is due and adds the moves to `moves`.
  /// problem: why a box cannot lie where it should; the same on every rank. next_check: when boxes may move again, s. moved:
  /// whether any has. Collective.
  PetscErrorCode Follow(double step, double time, double next_check, std::vector<LevelMove> *moves, std::string *problem,
                        bool *moved);

  /// Where boxes are now; while they follow, what the contact has reached since the last check.
  const FollowState &State() const { return state_; }
  /// The same with the largest reach of all ranks. Collective.
  PetscErrorCode ShareReach();
  /// Puts empty levels there. Collective.
  PetscErrorCode Restore(const FollowState &state);

private:
  bool FollowsContact() const { return levels_.Settings().follow.kind == FollowKind::kContact; }
  bool IsActive(int l) const { return l < state_.plan.active; }
  std::vector<LevelGeometry> GeometriesOf(const std::vector<Box> &boxes) const;
  PetscErrorCode FindContact(double time, double next_check, ContactPlace *place);
  PetscErrorCode MoveLevels(const BoxPlan &next);
  PetscErrorCode SplitIntoBoxes(const std::vector<LevelGeometry> &next, int active);
  PetscErrorCode SortIntoBoxes(const std::vector<LevelGeometry> &next, int active);
  PetscErrorCode PlaceLevel(int l, const LevelGeometry &geometry);
  PetscErrorCode MergeLeft();

  ConnectedLevels &levels_;
  TipTrack &tip_;
  const Model *model_ = nullptr;
  FollowState state_;
};

} // namespace mlgimp
