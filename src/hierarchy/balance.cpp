// Weighted ownership ranges.
#include "hierarchy/balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

/// Points per node of a whole grid, with their sums over all boxes from the first node.
class PointMap
{
public:
  PointMap(const std::vector<double> &points, const GridGeometry &grid) : dim_(grid.dim)
  {
    for (int axis = 0; axis < 3; ++axis) size_[axis] = grid.Nodes(axis);
    sums_.assign(static_cast<std::size_t>(size_[0] + 1) * (size_[1] + 1) * (size_[2] + 1), 0.0);
    std::size_t next = 0;
    ForEach({{}, size_}, [&](Index at) { Sum(at + Index{1, 1, 1}) = points[next++]; });
    for (int axis = 0; axis < 3; ++axis) {
      Index step{};
      step[axis] = 1;
      ForEach({{1, 1, 1}, size_ + Index{1, 1, 1}}, [&](Index at) { Sum(at) += Sum(at - step); });
    }
  }
  int Dim() const { return dim_; }
  int Size(int axis) const { return size_[axis]; }
  IndexBox All() const { return {{}, size_}; }
  /// Number of points in a box of nodes.
  double In(const IndexBox &box) const
  {
    double points = 0;
    ForEach({{}, {2, 2, 2}}, [&](Index upper) {
      Index corner;
      int sign = 1;
      for (int axis = 0; axis < 3; ++axis) {
        corner[axis] = upper[axis] ? box.upper[axis] : box.lower[axis];
        if (!upper[axis]) sign = -sign;
      }
      points += sign * Sum(corner);
    });
    return points;
  }
  /// Points of each layer of nodes normal to an axis.
  std::vector<double> Marginal(int axis) const
  {
    std::vector<double> sums;
    IndexBox layer = All();
    for (int k = 0; k < size_[axis]; ++k) {
      layer.lower[axis] = k, layer.upper[axis] = k + 1;
      sums.push_back(In(layer));
    }
    return sums;
  }

private:
  double Sum(Index at) const { return sums_[Place(at)]; }
  double &Sum(Index at) { return sums_[Place(at)]; }
  std::size_t Place(Index at) const
  {
    return at[0] + (size_[0] + 1) * (at[1] + (size_[1] + 1) * static_cast<std::size_t>(at[2]));
  }
  int dim_;
  Index size_{};
  std::vector<double> sums_;
};

void Divide(const PointMap &map, const std::array<int, 3> &blocks, GridLayout *layout)
{
  for (int axis = 0; axis < map.Dim(); ++axis)
    layout->widths[axis] = DivideByWeight(map.Marginal(axis), blocks[axis], kHaloWidth);
}

/// Work of a block in points: a halo node costs about as much as a point.
double Work(const PointMap &map, const IndexBox &block)
{
  double halo = 0;
  for (int axis = 0; axis < map.Dim(); ++axis) {
    if (block.Size(axis) == map.Size(axis)) continue;
    double area = 1;
    for (int other = 0; other < map.Dim(); ++other) area *= other == axis ? 1 : block.Size(other);
    halo += 2.0 * kHaloWidth * area;
  }
  return halo + map.In(block);
}

/// Work of the busiest of the blocks that a layout makes of a box of nodes, along the axes from `axis` on but for `fixed`.
double LargestWork(const PointMap &map, const GridLayout &layout, int fixed, IndexBox box, int axis = 0)
{
  if (axis == map.Dim() || axis > 2) return Work(map, box);
  if (axis == fixed) return LargestWork(map, layout, fixed, box, axis + 1);
  double largest = 0;
  int start = 0;
  for (const PetscInt width : layout.widths[axis]) {
    box.lower[axis] = start, box.upper[axis] = start + width;
    largest = std::max(largest, LargestWork(map, layout, fixed, box, axis + 1));
    start += width;
  }
  return largest;
}

double LargestWork(const PointMap &map, const GridLayout &layout) { return LargestWork(map, layout, -1, map.All()); }

/// Work of the layers [start, start + width) along an axis in the busiest of the blocks that `layout` makes of them.
double LargestWork(const PointMap &map, const GridLayout &layout, int axis, int start, int width)
{
  IndexBox box = map.All();
  box.lower[axis] = start, box.upper[axis] = start + width;
  return LargestWork(map, layout, axis, box);
}

/// Cuts along an axis into as many ranges as `layout` has, none with more work than `limit`; false where that cannot be.
bool CutWithin(const PointMap &map, int axis, double limit, GridLayout *layout)
{
  const int nodes = map.Size(axis);
  std::vector<PetscInt> widths;
  int start = 0;
  for (int left = static_cast<int>(layout->widths[axis].size()) - 1; left >= 0; --left) {
    const int most = nodes - start - left * kHaloWidth; // leaves room for the ranges to come
    int width = std::min(kHaloWidth, most);
    while (width < most && LargestWork(map, *layout, axis, start, width + 1) <= limit) ++width;
    if (LargestWork(map, *layout, axis, start, width) > limit) return false;
    widths.push_back(width);
    start += width;
  }
  if (start < nodes) return false;
  layout->widths[axis] = widths;
  return true;
}

/// Takes work from the busiest block by the best cuts along each axis in turn, those along the others being kept.
void ImproveCuts(const PointMap &map, GridLayout *layout)
{
  constexpr double kTolerance = 1e-4;
  double before = HUGE_VAL, work = LargestWork(map, *layout);
  while (work < before) {
    before = work;
    for (int axis = 0; axis < map.Dim(); ++axis) {
      double lower = 0, upper = work;
      while (upper - lower > kTolerance * work) {
        const double middle = 0.5 * (lower + upper);
        (CutWithin(map, axis, middle, layout) ? upper : lower) = middle;
      }
      work = LargestWork(map, *layout);
    }
  }
}

bool FitsBlocks(int nodes, int blocks) { return blocks == 1 || nodes >= blocks * kHaloWidth; }

/// The best split into this many blocks; false where there is none.
bool BestSplit(const PointMap &map, int blocks, GridLayout *best)
{
  double least = HUGE_VAL;
  ForEach({{1, 1, 1}, {blocks + 1, blocks + 1, map.Dim() == 3 ? blocks + 1 : 2}}, [&](Index split) {
    GridLayout layout;
    bool fits = split[0] * split[1] * split[2] == blocks;
    for (int axis = 0; axis < map.Dim(); ++axis) fits = fits && FitsBlocks(map.Size(axis), split[axis]);
    if (!fits) return;
    Divide(map, split, &layout);
    ImproveCuts(map, &layout);
    if (const double work = LargestWork(map, layout); work < least) {
      least = work;
      *best = layout;
    }
  });
  return std::isfinite(least);
}

} // namespace

/// How many ranks suit a number of points.
static int SuitableRanks(double points, int ranks, double least_points)
{
  return static_cast<int>(std::clamp(points / least_points, 1.0, static_cast<double>(ranks)));
}

void FirstLayout(int ranks, double least_points, const std::vector<double> &points, const GridGeometry &grid, GridLayout *layout)
{
  const double total = std::accumulate(points.begin(), points.end(), 0.0);
  int blocks = SuitableRanks(total, ranks, least_points);
  const PointMap map(points, grid);
  while (!BestSplit(map, blocks, layout)) --blocks;
  layout->ranks.resize(blocks);
  std::iota(layout->ranks.begin(), layout->ranks.end(), 0);
}

bool NeedsOtherRanks(double points, int blocks, int ranks, double least_points)
{
  const double each = points / blocks;
  return (each < 0.5 * least_points || each > 2 * least_points) && SuitableRanks(points, ranks, least_points) != blocks;
}

/// Points of all ranks per node of a grid, the first axis fastest. Collective on `world`.
static PetscErrorCode CountByNode(MPI_Comm world, Points &store, const GridGeometry &grid, std::vector<double> *counts)
{
  const IndexBox nodes = grid.NodeBox();
  const PointArrays points = store.Arrays();
  PetscFunctionBeginUser;
  counts->assign(static_cast<std::size_t>(nodes.Count()), 0.0);
  for (int p = 0; p < points.count; ++p) {
    const Index at = grid.Nearest(points.Position(p)) - nodes.lower;
    ++(*counts)[at[0] + nodes.Size(0) * (at[1] + nodes.Size(1) * static_cast<std::size_t>(at[2]))];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts->data(), static_cast<int>(counts->size()), MPI_DOUBLE, MPI_SUM, world));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LayoutFor(MPI_Comm world, Points &points, const GridGeometry &grid, double least_points, GridLayout *layout)
{
  std::vector<double> counts;
  PetscFunctionBeginUser;
  PetscCall(CountByNode(world, points, grid, &counts));
  FirstLayout(RanksOf(world), least_points, counts, grid, layout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BetterLayout(MPI_Comm world, Level &level, double least_points, GridLayout *layout, bool *changed)
{
  constexpr double kWorthWhile = 0.98; // of the busiest block's work
  const Grid &grid = level.Mesh();
  const GridGeometry &geometry = grid.Geometry();
  const PetscMPIInt ranks = RanksOf(world);
  std::vector<double> counts;
  PetscFunctionBeginUser;
  PetscCall(CountByNode(world, level.PointStore(), geometry, &counts));
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  if (NeedsOtherRanks(total, grid.Layout().Blocks(), ranks, least_points)) {
    FirstLayout(ranks, least_points, counts, geometry, layout);
    *changed = layout->Blocks() != grid.Layout().Blocks();
    if (*changed) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PointMap map(counts, geometry);
  const auto &widths = grid.Layout().widths;
  Divide(map, {static_cast<int>(widths[0].size()), static_cast<int>(widths[1].size()), static_cast<int>(widths[2].size())},
         layout);
  ImproveCuts(map, layout);
  layout->ranks = grid.Layout().ranks;
  *changed = LargestWork(map, *layout) < kWorthWhile * LargestWork(map, grid.Layout());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
