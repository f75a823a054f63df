// Weighted ownership ranges.
#include "hierarchy/partition/balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

/// The points that cuts are chosen for: each rank knows where its own are, and all know how many are in each layer of nodes.
struct PointCloud {
  MPI_Comm comm;
  const std::vector<Index> &nodes;
  const GridGeometry &grid;
  std::array<std::vector<double>, 3> by_layer{}; ///< points of all ranks along each axis
  double total = 0;

  PetscErrorCode Count()
  {
    const int size[3] = {grid.Nodes(0), grid.Nodes(1), grid.Nodes(2)};
    std::vector<double> counts(size[0] + size[1] + size[2], 0.0);
    PetscFunctionBeginUser;
    for (const Index &node : nodes) ++counts[node[0]], ++counts[size[0] + node[1]], ++counts[size[0] + size[1] + node[2]];
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_DOUBLE, MPI_SUM, comm));
    auto next = counts.begin();
    for (int axis = 0; axis < 3; next += size[axis++]) by_layer[axis].assign(next, next + size[axis]);
    total = std::accumulate(by_layer[0].begin(), by_layer[0].end(), 0.0);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

/// The points of all ranks in layers of nodes normal to an axis, apart for each of the blocks that lie side by side across it.
class Layers
{
public:
  /// Of the blocks that a layout makes across the axis. Collective.
  PetscErrorCode Sum(const PointCloud &cloud, const GridLayout &layout, int axis)
  {
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    std::vector<std::size_t> row[2]; // of a node along the two axes across
    PetscFunctionBeginUser;
    count_ = cloud.grid.Nodes(axis);
    across_.clear();
    for (const PetscInt b : layout.widths[second])
      for (const PetscInt a : layout.widths[first]) {
        const int at_cuts = (a < cloud.grid.Nodes(first) ? b : 0) + (b < cloud.grid.Nodes(second) ? a : 0);
        across_.push_back({2.0 * kHaloWidth * a * b, 2.0 * kHaloWidth * at_cuts});
      }
    for (const int other : {first, second})
      for (std::size_t k = 0; k < layout.widths[other].size(); ++k)
        row[other == second].insert(row[other == second].end(), layout.widths[other][k], k);
    sums_.assign(across_.size() * (count_ + 1), 0.0);
    for (const Index &node : cloud.nodes) {
      const std::size_t block = row[0][node[first]] + layout.widths[first].size() * row[1][node[second]];
      ++sums_[block * (count_ + 1) + node[axis] + 1];
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums_.data(), static_cast<int>(sums_.size()), MPI_DOUBLE, MPI_SUM, cloud.comm));
    for (auto start = sums_.begin(); start != sums_.end(); start += count_ + 1)
      std::partial_sum(start, start + count_ + 1, start);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  int Count() const { return count_; }
  /// Work in points of the busiest of the blocks that so many layers are: a halo node costs about as much as a point.
  double Work(int start, int width) const
  {
    double largest = 0;
    for (std::size_t k = 0; k < across_.size(); ++k) {
      const double *const before = &sums_[k * (count_ + 1)];
      const double halo = (width < count_ ? across_[k].ends : 0) + width * across_[k].sides;
      largest = std::max(largest, halo + before[start + width] - before[start]);
    }
    return largest;
  }
  double LargestWork(const std::vector<PetscInt> &widths) const
  {
    double largest = 0;
    int start = 0;
    for (const PetscInt width : widths) largest = std::max(largest, Work(start, width)), start += width;
    return largest;
  }

private:
  struct Halo {
    double ends, sides; ///< nodes at both ends of a block; at the sides of a layer
  };
  int count_ = 0;
  std::vector<Halo> across_;
  std::vector<double> sums_; ///< [across_][count_ + 1]: points of the layers before
};

void Divide(const PointCloud &cloud, Index blocks, GridLayout *layout)
{
  for (int axis = 0; axis < cloud.grid.dim; ++axis)
    layout->widths[axis] = DivideByWeight(cloud.by_layer[axis], blocks[axis], kHaloWidth);
}

/// Cuts into as many ranges as there are, none with more work than `limit`; false where that cannot be.
bool CutWithin(const Layers &layers, double limit, std::vector<PetscInt> *cuts)
{
  std::vector<PetscInt> widths;
  int start = 0;
  for (int left = static_cast<int>(cuts->size()) - 1; left >= 0; --left) {
    const int most = layers.Count() - start - left * kHaloWidth; // leaves room for the ranges to come
    int width = std::min(kHaloWidth, most);
    while (width < most && layers.Work(start, width + 1) <= limit) ++width;
    if (layers.Work(start, width) > limit) return false;
    widths.push_back(width);
    start += width;
  }
  if (start < layers.Count()) return false;
  *cuts = widths;
  return true;
}

/// Takes work from the busiest block by the best cuts along each axis in turn, those along the others being kept. Collective.
PetscErrorCode ImproveCuts(const PointCloud &cloud, GridLayout *layout, double *work)
{
  constexpr double kTolerance = 1e-4; // size: speed only
  Layers layers;
  double before = 0;
  PetscFunctionBeginUser;
  *work = 0;
  do {
    for (int axis = 0; axis < cloud.grid.dim; ++axis) {
      PetscCall(layers.Sum(cloud, *layout, axis));
      *work = layers.LargestWork(layout->widths[axis]);
      if (axis == 0) before = *work;
      double lower = 0, upper = *work;
      while (upper - lower > kTolerance * *work) {
        const double middle = 0.5 * (lower + upper);
        (CutWithin(layers, middle, &layout->widths[axis]) ? upper : lower) = middle;
      }
      *work = layers.LargestWork(layout->widths[axis]);
    }
  } while (*work < (1 - kTolerance) * before);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Numbers of blocks along each axis, and the mean work of these blocks, than which the busiest has no less.
struct Split {
  Index blocks;
  double mean;
};

/// All that fit the grid, those with the least mean first.
std::vector<Split> FindSplits(const PointCloud &cloud, int blocks)
{
  std::vector<Split> splits;
  const auto nodes = [&](int axis) { return cloud.grid.Nodes(axis); };
  for (int a = 1; a <= blocks; ++a)
    for (int b = 1; blocks % a == 0 && b <= blocks / a; ++b) {
      const Index split{a, b, blocks / a / b};
      double halo = 0;
      bool fits = blocks / a % b == 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double layer = static_cast<double>(nodes(0)) * nodes(1) * nodes(2) / nodes(axis);
        fits = fits && (split[axis] == 1 || (axis < cloud.grid.dim && nodes(axis) >= split[axis] * kHaloWidth));
        halo += split[axis] > 1 ? 2 * kHaloWidth * split[axis] * layer : 0;
      }
      if (fits) splits.push_back({split, (cloud.total + halo) / blocks});
    }
  std::stable_sort(splits.begin(), splits.end(), [](const Split &s, const Split &t) { return s.mean < t.mean; });
  return splits;
}

/// The best split into this many blocks; without blocks where there is none. Collective.
PetscErrorCode BestSplit(const PointCloud &cloud, int blocks, GridLayout *best)
{
  double least = HUGE_VAL;
  PetscFunctionBeginUser;
  best->widths = {};
  for (const Split &split : FindSplits(cloud, blocks)) {
    GridLayout layout;
    double work;
    if (split.mean >= least) break;
    Divide(cloud, split.blocks, &layout);
    PetscCall(ImproveCuts(cloud, &layout, &work));
    if (work < least) least = work, *best = layout;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How many ranks suit a number of points.
int SuitableRanks(double points, int ranks, double least_points)
{
  return static_cast<int>(std::clamp(points / least_points, 1.0, static_cast<double>(ranks)));
}

/// The nodes nearest to this rank's points.
std::vector<Index> NodesOf(Points &store, const GridGeometry &grid)
{
  const PointArrays points = store.Arrays();
  std::vector<Index> nodes;
  for (int p = 0; p < points.count; ++p) nodes.push_back(grid.Nearest(points.Position(p)) - grid.NodeBox().lower);
  return nodes;
}

} // namespace

std::vector<PetscInt> DivideByWeight(const std::vector<double> &weights, int parts, int minimum)
{
  const int count = static_cast<int>(weights.size());
  double total = 0, sum = 0;
  for (double w : weights) total += w;
  std::vector<PetscInt> widths;
  int start = 0, end = 0;
  for (int part = 1; part <= parts; ++part) {
    const int last = count - (parts - part) * minimum; // leaves room for the parts to come
    while (end < last && (end < start + minimum || sum + 0.5 * weights[end] < total * part / parts)) sum += weights[end++];
    if (part == parts) end = count;
    widths.push_back(end - start);
    start = end;
  }
  return widths;
}

PetscErrorCode FirstLayout(MPI_Comm world, int ranks, double least_points, const std::vector<Index> &nodes,
                           const GridGeometry &grid, GridLayout *layout)
{
  PointCloud cloud{world, nodes, grid};
  PetscFunctionBeginUser;
  PetscCall(cloud.Count());
  int blocks = SuitableRanks(cloud.total, ranks, least_points);
  do PetscCall(BestSplit(cloud, blocks, layout));
  while (layout->Blocks() != blocks--);
  layout->ranks.resize(layout->Blocks());
  std::iota(layout->ranks.begin(), layout->ranks.end(), 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool NeedsOtherRanks(double points, int blocks, int ranks, double least_points)
{
  constexpr double kMinPoints = 0.5, kMaxPoints = 2; // size: speed only; of the points asked for a rank
  const double each = points / blocks;
  return (each < kMinPoints * least_points || each > kMaxPoints * least_points) &&
         SuitableRanks(points, ranks, least_points) != blocks;
}

PetscErrorCode LayoutFor(MPI_Comm world, Points &points, const GridGeometry &grid, double least_points, GridLayout *layout)
{
  PetscFunctionBeginUser;
  PetscCall(FirstLayout(world, RanksOf(world), least_points, NodesOf(points, grid), grid, layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BetterLayout(MPI_Comm world, Level &level, double least_points, GridLayout *layout, bool *changed)
{
  constexpr double kWorthWhile = 0.98; // size: speed only; of the busiest block's work
  const GridLayout &present = level.Mesh().Nodes().Layout();
  const GridGeometry &grid = level.Mesh().Geometry();
  const std::vector<Index> nodes = NodesOf(level.PointStore(), grid);
  PointCloud cloud{world, nodes, grid};
  Layers layers;
  double work;
  PetscFunctionBeginUser;
  PetscCall(cloud.Count());
  if (NeedsOtherRanks(cloud.total, present.Blocks(), RanksOf(world), least_points)) {
    PetscCall(LayoutFor(world, level.PointStore(), grid, least_points, layout));
    *changed = layout->Blocks() != present.Blocks();
    if (*changed) PetscFunctionReturn(PETSC_SUCCESS);
  }
  Index blocks;
  for (int axis = 0; axis < 3; ++axis) blocks[axis] = static_cast<int>(present.widths[axis].size());
  Divide(cloud, blocks, layout);
  PetscCall(ImproveCuts(cloud, layout, &work));
  layout->ranks = present.ranks;
  PetscCall(layers.Sum(cloud, present, 0));
  *changed = work < kWorthWhile * layers.LargestWork(present.widths[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
