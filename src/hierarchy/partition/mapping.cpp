// The graph of blocks for METIS, and the repair of its partition.
#include "hierarchy/partition/mapping.hpp"

#include <algorithm>
#include <metis.h>

namespace mlgimp
{

namespace
{

/// Blocks of all levels with their neighbours, as many on each level as there are ranks: those that a level has not exchange
/// nothing. Without them METIS may find no block for a part, and prints so.
struct BlockGraph {
  int levels, ranks;
  std::vector<std::vector<std::pair<int, double>>> neighbours; ///< [levels * ranks], with bytes

  BlockGraph(const std::vector<BlockTraffic> &traffic, int level_count, int rank_count)
      : levels(level_count), ranks(rank_count), neighbours(levels * ranks)
  {
    for (const BlockTraffic &t : traffic) {
      const int a = First(t.level) + t.coarse, b = First(t.level + 1) + t.fine;
      neighbours[a].emplace_back(b, t.bytes);
      neighbours[b].emplace_back(a, t.bytes);
    }
  }
  int First(int level) const { return level * ranks; }
};

/// METIS's part of each block; all in part 0 where it finds no answer.
std::vector<idx_t> Partition(const BlockGraph &graph)
{
  idx_t vertices = graph.First(graph.levels), levels = graph.levels, count = graph.ranks, cut = 0;
  std::vector<idx_t> starts{0}, ends, weights, constraints(static_cast<std::size_t>(vertices) * levels, 0), part(vertices, 0);
  constexpr double kLargestWeight = 1e4; // size: METIS takes whole numbers
  double largest = 1;
  for (const auto &list : graph.neighbours)
    for (const auto &[to, bytes] : list) largest = std::max(largest, bytes);
  for (const auto &list : graph.neighbours) {
    for (const auto &[to, bytes] : list) {
      ends.push_back(to);
      weights.push_back(1 + static_cast<idx_t>(kLargestWeight * bytes / largest));
    }
    starts.push_back(static_cast<idx_t>(ends.size()));
  }
  for (idx_t v = 0; v < vertices; ++v) constraints[static_cast<std::size_t>(v) * levels + v / count] = 1;
  const int status = METIS_PartGraphKway(&vertices, &levels, starts.data(), ends.data(), constraints.data(), nullptr,
                                         weights.data(), &count, nullptr, nullptr, nullptr, &cut, part.data());
  if (status != METIS_OK) std::fill(part.begin(), part.end(), 0);
  return part;
}

/// Bytes that a block exchanges with the blocks that rank holds.
double Affinity(const BlockGraph &graph, const std::vector<PetscMPIInt> &rank_of, int block, PetscMPIInt rank)
{
  double sum = 0;
  for (const auto &[to, bytes] : graph.neighbours[block])
    if (rank_of[to] == rank) sum += bytes;
  return sum;
}

/// Gives each block of a level a rank of its own: its part's, or the free one that it exchanges most with.
void Repair(const BlockGraph &graph, int level, std::vector<PetscMPIInt> &rank_of)
{
  std::vector<int> holder(graph.ranks, -1), unassigned;
  for (int v = graph.First(level); v < graph.First(level + 1); ++v) {
    if (holder[rank_of[v]] < 0)
      holder[rank_of[v]] = v;
    else
      unassigned.push_back(v);
  }
  for (int v : unassigned) {
    int best = -1;
    double most = -1;
    for (int rank = 0; rank < graph.ranks; ++rank) {
      const double affinity = holder[rank] < 0 ? Affinity(graph, rank_of, v, rank) : -1;
      if (affinity > most) most = affinity, best = rank;
    }
    holder[best] = v;
    rank_of[v] = best;
  }
}

/// Swaps the ranks of two blocks of a level while that saves bytes.
void Refine(const BlockGraph &graph, int level, std::vector<PetscMPIInt> &rank_of)
{
  constexpr int kSweeps = 8, kMaxRanks = 1024; // size: speed only; the search is quadratic in ranks
  if (graph.ranks > kMaxRanks) return;
  bool changed = true;
  for (int sweep = 0; sweep < kSweeps && changed; ++sweep) {
    changed = false;
    for (int v = graph.First(level); v < graph.First(level + 1); ++v)
      for (int other = graph.First(level); other < v; ++other) {
        const PetscMPIInt mine = rank_of[v], theirs = rank_of[other];
        const double gain = Affinity(graph, rank_of, v, theirs) - Affinity(graph, rank_of, v, mine) +
                            Affinity(graph, rank_of, other, mine) - Affinity(graph, rank_of, other, theirs);
        if (gain <= 0) continue;
        std::swap(rank_of[v], rank_of[other]);
        changed = true;
      }
  }
}

} // namespace

double BytesBetweenRanks(const std::vector<BlockTraffic> &traffic, const RankMap &map)
{
  double sum = 0;
  for (const BlockTraffic &t : traffic)
    if (map[t.level][t.coarse] != map[t.level + 1][t.fine]) sum += t.bytes;
  return sum;
}

RankMap ImproveMap(const std::vector<BlockTraffic> &traffic, int ranks, const RankMap &map)
{
  if (ranks == 1 || map.size() == 1) return map; // METIS divides by zero for one part
  const BlockGraph graph(traffic, static_cast<int>(map.size()), ranks);
  const std::vector<idx_t> part = Partition(graph);
  std::vector<PetscMPIInt> rank_of(part.begin(), part.end());
  for (int level = 0; level < graph.levels; ++level) Repair(graph, level, rank_of);
  for (int level = graph.levels - 1; level >= 0; --level) Refine(graph, level, rank_of);
  RankMap better = map;
  for (int level = 0; level < graph.levels; ++level)
    std::copy_n(rank_of.begin() + graph.First(level), better[level].size(), better[level].begin());
  return BytesBetweenRanks(traffic, better) < BytesBetweenRanks(traffic, map) ? better : map;
}

} // namespace mlgimp
