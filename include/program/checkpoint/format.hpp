// What the writer and the reader of checkpoints share: the names of groups and datasets, and the order of numbers.
#pragma once

#include "program/checkpoint/checkpoint.hpp"
#include "program/system/hdf5_file.hpp"

#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace mlgimp
{

inline constexpr int kFormatVersion = 23;

inline std::string LevelName(int l) { return Format("/level_{}", l); }

/// Numbers of a level's clock.
inline constexpr int kOfClock = 10;

/// Group of the copies of points that the next coarser (0) or finer level (1) owns.
inline std::string CopiesName(int l, int origin) { return Format("{}/copies_{}", LevelName(l), origin); }

/// Numbers of nodes of a level's blocks along each axis.
inline constexpr const char *kWidthNames[3] = {"/columns", "/rows", "/layers"};

inline std::string BorderName(int b) { return Format("/border_state_{}", b); }

/// The members of a state that are numbers, in the order of the file.
template <class State> auto NumbersOf(State &s)
{
  return std::tie(s.time, s.time_step, s.step_settings[0], s.step_settings[1], s.step_settings[2], s.wave_speed, s.step, s.frames,
                  s.initial_mass, s.initial_points, s.initial_created, s.impulse_at_row, s.time_at_row, s.friction_at_row[0],
                  s.friction_at_row[1], s.friction_at_row[2]);
}
inline std::vector<double> StateAsNumbers(const RunState &state)
{
  return std::apply([](auto... x) { return std::vector<double>{static_cast<double>(x)...}; }, NumbersOf(state));
}
/// The numbers must have been found sensible.
inline RunState StateFromNumbers(const std::vector<double> &numbers)
{
  RunState state;
  const double *next = numbers.data();
  std::apply([&](auto &...x) { ((x = static_cast<std::decay_t<decltype(x)>>(*next++)), ...); }, NumbersOf(state));
  return state;
}

/// What follows, and what has moved: active levels, half width, reach, the boxes, and the moves.
std::vector<double> FollowingAsNumbers(const FollowState &now, const std::vector<LevelMove> &moves);
/// False where the numbers are not such, for so many levels.
bool FollowingFromNumbers(const std::vector<double> &numbers, int levels, FollowState *now, std::vector<LevelMove> *moves);

} // namespace mlgimp
