// The coupled step of a level and the next finer one: one composite grid, without copies of points.
//
// Each nodal force acts on one momentum, since the functions of fine nodes and of interface nodes add up to one (see
// border_geometry.hpp). Interface nodes advance with the fine step; fine nodes with beta = 0 are constrained. See docs/levels.md.
#pragma once

#include "hierarchy/coupling/border_contact.hpp"

#include <optional>
#include <vector>

namespace mlgimp
{

class LevelInterface
{
public:
  LevelInterface() = default;
  LevelInterface(const LevelInterface &) = delete;
  LevelInterface &operator=(const LevelInterface &) = delete;

  /// The levels are kept by reference. Collective on `world`.
  PetscErrorCode Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, double blend_width);

  /// Brings mass, momentum and force of the coarse points to the interface nodes. Starts a coarse step. Collective on all.
  PetscErrorCode CoarseToFine();
  /// Advances the interface nodes by the fine step number `substep`, and sets the velocities (v, dv) of the band from
  /// theirs; the free part of the velocities must be there. On the fine level's ranks.
  PetscErrorCode Advance(int substep, double dt);
  /// Brings the mean velocity and the whole change of the interface nodes to the coarse level. Collective on all.
  PetscErrorCode FineToCoarse();
  /// Takes what contact on the coarser level leaves to the finer level's points; they get it in the next step. Collective on all.
  PetscErrorCode TakeContact();

  BorderContact &Contact() { return *contact_; }
  /// Mass that the finer level's points give its interface nodes by their hats, by place, as of the last step: such nodes are
  /// light where both levels' points give them little. Infinite where it is not known yet, 0 elsewhere.
  const double *FinerMasses() const { return finer_masses_.data(); }
  const InterfaceNodes &Nodes() const { return nodes_; }
  /// Number of interface nodes on all ranks.
  std::size_t Count() const { return border_.Count(); }

  /// Adds to the coarse forces of the step before those of points that have changed levels, which are no change to
  /// extrapolate: what is in `sums` of the coarse level, or of the fine level's constrained nodes. Collective on all.
  PetscErrorCode ShiftForces(bool from_fine);

  /// Takes what the last step left to the next from the border before a change of layout, with the same nodes. Collective on all.
  PetscErrorCode TakeState(const LevelInterface &before);
  /// The same as numbers for a restart, [interface nodes][kState], on the first rank; empty where there has been no step.
  /// Collective on all.
  PetscErrorCode GatherState(std::vector<double> *state) const;
  /// Collective on all.
  PetscErrorCode RestoreState(const std::vector<double> &state);
  /// Of an interface node: the coarse force, what its contact keeps, and its finer mass.
  static constexpr int kState = 3 + BorderContact::kState + 1; ///< size

  /// What the border adds up on this rank.
  Budgets &Totals() { return budgets_; }

private:
  /// What an interface node keeps from step to step.
  struct NodeState {
    Index at;
    double values[kState];
  };

  PetscErrorCode SendFinerMasses();
  std::vector<NodeState> States() const;
  void SetState(const NodeState &state);
  PetscErrorCode Restrict();
  void AdvanceInterface(int substep, double dt);
  void Prolong();

  MPI_Comm world_ = MPI_COMM_NULL;
  Level *coarse_ = nullptr, *fine_ = nullptr;
  BorderGeometry border_;
  InterfaceNodes nodes_;
  LightInterface light_;
  InterfaceFields fields_;
  std::optional<BorderContact> contact_;
  std::vector<Vec3> previous_force_; ///< [owned]: of the coarse points, in the coarse step before
  bool has_previous_ = false;
  std::vector<double> by_hats_;      ///< [owned]: FinerMasses
  std::vector<double> finer_masses_; ///< by place on the coarse level
  Budgets budgets_;
};

} // namespace mlgimp
