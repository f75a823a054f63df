// Which rank takes which block of each level, so that neighbouring levels talk within ranks where they can.
#pragma once

#include "base/petsc.hpp"

#include <vector>

namespace mlgimp
{

/// A level's block and a finer level's block that exchange data, and how much.
struct BlockTraffic {
  int level;        ///< of the coarser block
  int coarse, fine; ///< blocks
  double bytes;     ///< per step of level 0
};

/// Ranks of the blocks: [level][block], on each level every rank at most once.
using RankMap = std::vector<std::vector<PetscMPIInt>>;

/// Bytes that pass between different ranks.
double BytesBetweenRanks(const std::vector<BlockTraffic> &traffic, const RankMap &map);

/// Partitions the graph of all levels' blocks, joined by their traffic, among the ranks by METIS with one constraint per
/// level, and repairs the answer to at most one block per rank and level. Returns `map` where that is no worse.
RankMap ImproveMap(const std::vector<BlockTraffic> &traffic, int ranks, const RankMap &map);

} // namespace mlgimp
