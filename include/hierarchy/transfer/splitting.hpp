// Splitting of points: the children's numbers and states, and points of metals that flow has drawn out too far.
#pragma once

#include "level/level.hpp"

#include <cstdint>

namespace mlgimp
{

/// Numbers of points: every split gives numbers in a new range, from the parent's alone, so that no counter is shared.
///   child c of the point `id` of generation g has start(g + 1) + (id - start(g)) children + c,  start(g + 1) = start(g) + N
///   children^g
class PointNumbers
{
public:
  /// seeds: N, one more than the largest number of a point at the start; children: of a split.
  PointNumbers(std::int64_t seeds, int children) : seeds_(seeds), children_(children) {}
  /// False where a point has been split too often for the numbers to fit.
  bool CanSplit(std::int64_t id) const;
  std::int64_t Child(std::int64_t id, int child) const;
  /// The number of the point that was split; -1 for one that was not made by splitting.
  std::int64_t Parent(std::int64_t id) const;
  int ChildIndex(std::int64_t id) const;

private:
  struct Range {
    std::int64_t start, count;
  };
  Range RangeOf(std::int64_t id) const;
  std::int64_t seeds_;
  int children_;
};

/// Adds up by how much splitting or merging changed mass, momentum and energy.
void AddChange(const Budgets &before, const Budgets &after, Budgets *budgets);

/// How points are split.
struct PointSplit {
  Index parts; ///< children along each axis of the undeformed box, 1 along axes that stay whole
  const PointNumbers &numbers;
  int Children() const { return parts[0] * parts[1] * parts[2]; }
};

/// Replaces points of a level by their children, each with the parent's F and stress and the velocity v + L dx; `samples` has the
/// nodal velocity at each. Appends the children beyond the first, which takes the parent's place, to `points`, which holds the
/// parents too; what the points' sums change by goes to the budgets.
PetscErrorCode SplitPoints(Level &level, const PointSplit &split, const std::vector<int> &parents,
                           const std::vector<VelocitySample> &samples, std::vector<int> *points, Budgets *budgets);

/// Those of some points that are of the size usual on levels coarser than one with cells of `spacing`, so that they have to be
/// split there; counts those that cannot.
std::vector<int> FindParents(Level &level, const std::vector<int> &points, double spacing, int ratio, const PointNumbers &numbers,
                             Budgets *budgets);

/// Splits points of materials that want it where an edge has grown longer than a cell: halves it, so that the
/// surface and the stress of metal that flows far are still carried by points that see the nodes at their ends. Collective on
/// `world`.
PetscErrorCode SplitStretched(MPI_Comm world, Level &level, const PointNumbers &numbers);

} // namespace mlgimp
