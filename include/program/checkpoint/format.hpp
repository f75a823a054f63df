// What the writer and the reader of checkpoints share: the names of groups and datasets, and the order of numbers.
#pragma once

#include "program/checkpoint/checkpoint.hpp"
#include "program/system/hdf5_file.hpp"
#include "program/system/numbers.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

inline constexpr int kFormatVersion = 25; // size

inline std::string LevelName(int l) { return Format("/level_{}", l); }

/// Numbers of a level's clock.
inline constexpr int kOfClock = 10; // size

/// Group of the copies of points that the next coarser (0) or finer level (1) owns.
inline std::string CopiesName(int l, int origin) { return Format("{}/copies_{}", LevelName(l), origin); }

/// Numbers of nodes of a level's blocks along each axis.
inline constexpr const char *kWidthNames[3] = {"/columns", "/rows", "/layers"};

inline std::string BorderName(int b) { return Format("/border_state_{}", b); }

/// What follows, and what has moved: active levels, half width, reach, the boxes, and the moves.
std::vector<double> FollowingAsNumbers(const FollowState &now, const std::vector<LevelMove> &moves);
/// False where the numbers are not such, for so many levels.
bool FollowingFromNumbers(const std::vector<double> &numbers, int levels, FollowState *now, std::vector<LevelMove> *moves);

} // namespace mlgimp
