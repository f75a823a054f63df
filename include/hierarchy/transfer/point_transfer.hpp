// Points that change levels: which level a place belongs to, splitting on the way in, merging after the way out.
#pragma once

#include "hierarchy/coupling/level_interface.hpp"
#include "hierarchy/transfer/splitting.hpp"

namespace mlgimp
{

/// The box of a level, moved outwards by a distance in m where its sides are borders, open where they are the domain's.
Box WidenedBox(const LevelGeometry &geometry, double distance);

/// The points inside or outside a box.
std::vector<int> PointsIn(const PointArrays &points, const Box &box, bool inside);
/// How far the nearest point outside a box (or the nearest inside one) may move and stay there, m; not above zero where a point
/// is already inside (outside).
double MinDistance(const PointArrays &points, const Box &box, bool inside);

/// Distances from the finer level's box where points change levels that are coupled through nodes, its cells; not one, where
/// points may lie at the start.
inline constexpr double kEnter = 0.999, kLeave = 1.25;

/// When points change levels, and what happens to them then.
struct PointTransferRule {
  double enter, leave; ///< distances from the finer level's box, its cells: points nearer than `enter` go to it, points
                       ///< farther than `leave` go from it; between them they stay, so that none goes to and fro
  int ring;            ///< cells outside the box in which the coarser level has points of the finer one's size; 0: none
  bool velocity_shift; ///< velocities move from one level's half step to the other's
  bool merge;          ///< points that leave become their parent again
  double most_loss;    ///< share of their strain energy that may be lost by it
};

/// Moves points between two neighbouring levels.
class PointTransfer
{
public:
  /// The levels are kept by reference.
  PointTransfer(MPI_Comm world, Level &coarse, Level &fine, int ratio, const PointNumbers &numbers, const PointTransferRule &rule)
      : world_(world), coarse_(coarse), fine_(fine), ratio_(ratio), numbers_(numbers), rule_(rule)
  {
  }

  /// Sends every point to the level it belongs to by its place. Points of coarse size that enter are split into ratio^dim,
  /// each with the parent's F and stress and the velocity v + L dx. dt: the coarse step, s; border: the one that couples
  /// the levels through nodes, or null. Collective on all ranks; while all are too far away to change levels, none asks another.
  PetscErrorCode Transfer(double dt, LevelInterface *border);
  /// Must be called by all ranks when points have come or boxes have moved: the clearance is no longer known.
  void InvalidateClearance() { clearance_ = 0; }
  /// Splits the points of coarse size in the ring around the box; they stay where they are.
  PetscErrorCode SplitRing(); // collective on the coarser level's ranks

  /// What changed levels, on this rank.
  Budgets &Totals() { return budgets_; }

private:
  /// The finer level's box, wider by so many of its cells.
  Box BoxAt(double cells) const { return WidenedBox(fine_.Geometry(), cells * fine_.Geometry().grid.spacing); }
  /// Those of some points of the coarser level that are of its size.
  std::vector<int> ParentsAmong(const std::vector<int> &points)
  {
    return FindParents(coarse_, points, fine_.Geometry().grid.spacing, ratio_, numbers_, &budgets_);
  }
  PetscErrorCode FindClearance(double clearance[2]);
  PetscErrorCode Enter(std::vector<int> points, double dt, double shift, LevelInterface *border);
  PetscErrorCode Split(const std::vector<int> &parents, const std::vector<VelocitySample> &samples, std::vector<int> *points);
  PetscErrorCode Send(Level &from, Level &to, const std::vector<int> &points, double step, double shift);

  MPI_Comm world_;
  Level &coarse_, &fine_;
  int ratio_;
  PointNumbers numbers_;
  PointTransferRule rule_;
  double clearance_ = 0; ///< that points of all ranks may still move before one changes levels, m; the same on every rank
  Budgets budgets_;
};

} // namespace mlgimp
