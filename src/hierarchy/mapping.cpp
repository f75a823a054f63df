// The graph of blocks for METIS, and the repair of its partition.
#include "hierarchy/mapping.hpp"

#include <algorithm>
#include <metis.h>

namespace mlgimp
{

namespace
{

/// Blocks of all levels numbered one after the other, with their neighbours.
struct BlockGraph {
  std::vector<int> first; ///< [levels + 1]
  std::vector<std::vector<std::pair<int, double>>> neighbours;

  BlockGraph(const std::vector<BlockTraffic> &traffic, const RankMap &map) : first{0}
  {
    for (const auto &level : map) first.push_back(first.back() + static_cast<int>(level.size()));
    neighbours.resize(first.back());
    for (const BlockTraffic &t : traffic) {
      const int a = first[t.level] + t.coarse, b = first[t.level + 1] + t.fine;
      neighbours[a].emplace_back(b, t.bytes);
      neighbours[b].emplace_back(a, t.bytes);
    }
  }
};

/// METIS's part of each block; all in part 0 where it finds no answer, or would find fewer blocks than parts, and say so.
std::vector<idx_t> Partition(const BlockGraph &graph, int parts)
{
  idx_t vertices = graph.first.back(), levels = static_cast<idx_t>(graph.first.size()) - 1, count = parts, cut = 0;
  std::vector<idx_t> starts{0}, ends, weights, constraints(static_cast<std::size_t>(vertices) * levels, 0), part(vertices, 0);
  double largest = 1;
  if (vertices < count) return part;
  for (const auto &list : graph.neighbours)
    for (const auto &[to, bytes] : list) largest = std::max(largest, bytes);
  for (const auto &list : graph.neighbours) {
    for (const auto &[to, bytes] : list) {
      ends.push_back(to);
      weights.push_back(1 + static_cast<idx_t>(1e4 * bytes / largest));
    }
    starts.push_back(static_cast<idx_t>(ends.size()));
  }
  for (idx_t l = 0; l < levels; ++l)
    for (int v = graph.first[l]; v < graph.first[l + 1]; ++v) constraints[static_cast<std::size_t>(v) * levels + l] = 1;
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
void Repair(const BlockGraph &graph, int level, int ranks, std::vector<PetscMPIInt> &rank_of)
{
  std::vector<int> holder(ranks, -1), unassigned;
  for (int v = graph.first[level]; v < graph.first[level + 1]; ++v) {
    if (holder[rank_of[v]] < 0)
      holder[rank_of[v]] = v;
    else
      unassigned.push_back(v);
  }
  for (int v : unassigned) {
    int best = -1;
    double most = -1;
    for (int rank = 0; rank < ranks; ++rank) {
      const double affinity = holder[rank] < 0 ? Affinity(graph, rank_of, v, rank) : -1;
      if (affinity > most) most = affinity, best = rank;
    }
    holder[best] = v;
    rank_of[v] = best;
  }
}

/// Swaps the ranks of two blocks of a level, or moves one to a free rank, while that saves bytes.
void Refine(const BlockGraph &graph, int level, int ranks, std::vector<PetscMPIInt> &rank_of)
{
  constexpr int kSweeps = 8, kMostRanks = 1024; // the search is quadratic in ranks
  if (ranks > kMostRanks) return;
  std::vector<int> holder(ranks, -1);
  for (int v = graph.first[level]; v < graph.first[level + 1]; ++v) holder[rank_of[v]] = v;
  bool changed = true;
  for (int sweep = 0; sweep < kSweeps && changed; ++sweep) {
    changed = false;
    for (int v = graph.first[level]; v < graph.first[level + 1]; ++v)
      for (PetscMPIInt rank = 0; rank < ranks; ++rank) {
        const PetscMPIInt mine = rank_of[v];
        const int other = holder[rank];
        if (rank == mine) continue;
        double gain = Affinity(graph, rank_of, v, rank) - Affinity(graph, rank_of, v, mine);
        if (other >= 0) gain += Affinity(graph, rank_of, other, mine) - Affinity(graph, rank_of, other, rank);
        if (gain <= 0) continue;
        rank_of[v] = rank;
        if (other >= 0) rank_of[other] = mine;
        holder[rank] = v;
        holder[mine] = other;
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
  const BlockGraph graph(traffic, map);
  if (ranks == 1 || map.size() == 1) return map; // METIS divides by zero for one part
  const std::vector<idx_t> part = Partition(graph, ranks);
  std::vector<PetscMPIInt> rank_of(part.begin(), part.end());
  const int levels = static_cast<int>(map.size());
  for (int level = 0; level < levels; ++level) Repair(graph, level, ranks, rank_of);
  for (int level = levels - 1; level >= 0; --level) Refine(graph, level, ranks, rank_of);
  RankMap better = map;
  for (int level = 0; level < levels; ++level)
    std::copy(rank_of.begin() + graph.first[level], rank_of.begin() + graph.first[level + 1], better[level].begin());
  return BytesBetweenRanks(traffic, better) < BytesBetweenRanks(traffic, map) ? better : map;
}

} // namespace mlgimp
