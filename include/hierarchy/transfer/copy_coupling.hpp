// Coupling of levels by copies of points, as the paper prints it: kept for comparison.
#pragma once

#include "hierarchy/transfer/point_copies.hpp"
#include "level/level.hpp"

#include <memory>
#include <vector>

namespace mlgimp
{

/// What the coupling by points carries from step to step beside the copies.
struct CopyState {
  bool ready = false;   ///< there are copies
  Vec3 momentum_left{}; ///< momentum less the impulses since the start, that the coupling should keep
};

class CopyCoupling
{
public:
  CopyCoupling(MPI_Comm comm, int ratio, const CopyRepairs &repairs) : comm_(comm), ratio_(ratio), repairs_(repairs) {}
  /// The next border, between two levels; ghost_cells: see HierarchySettings. Collective.
  PetscErrorCode Add(Level &coarse, Level &fine, int ghost_cells);
  /// Before a step of level 0: makes the first copies. Collective.
  PetscErrorCode Begin(double dt);
  /// Points of levels l and l + 1 that the box has come over become the other level's, as printed, where the repair is off.
  PetscErrorCode DecideByPlace(int l);
  /// After the steps of level l + 1 within one of level l: renews the copies of both.
  PetscErrorCode Exchange(int l, double dt) { return borders_[l]->Exchange(dt); }
  /// After a step of level 0: gives the momentum that copies have lost or won in it to the points that have copies. Collective.
  PetscErrorCode Finish();
  const CopyState &State() const { return state_; }
  void SetState(const CopyState &state) { state_ = state; }

private:
  PetscErrorCode MeasureMomentum(Vec3 *left) const;

  MPI_Comm comm_;
  int ratio_;
  CopyRepairs repairs_;
  std::vector<Level *> levels_;
  std::vector<std::unique_ptr<CopyBorder>> borders_; ///< [b]: of levels b and b + 1
  CopyState state_;
};

} // namespace mlgimp
