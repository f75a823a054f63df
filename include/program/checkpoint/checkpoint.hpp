// Checkpoints: all that a restart needs, on any number of ranks.
#pragma once

#include "program/case/case.hpp"

#include <array>
#include <string>
#include <tuple>
#include <vector>

namespace mlgimp
{

/// The state of a run beside its points.
struct RunState {
  double time = 0, time_step = 0;
  std::array<double, 3> step_settings{}; ///< what time_step follows from beside the wave speed: -end_time, -time_step, -cfl
  double wave_speed = 0;                 ///< that the time step follows, m/s
  long step = 0;
  int frames = 0; ///< written so far
  double initial_mass = 0, initial_points = 0;
  double initial_created = 0;                 ///< points created by splitting before the first step
  double impulse_at_row = 0, time_at_row = 0; ///< contact impulse and time at the last history row
  TestState test;                             ///< that a slow run stands for
  Vec3 friction_at_row{};                     ///< impulse of friction then, N s
  std::vector<double> quasi_static;           ///< of the watch over a slow test
  std::vector<double> watched;                ///< of the warnings
  std::vector<std::string> warnings;          ///< issued so far
  std::vector<LevelMove> moves;               ///< of boxes that follow

  /// Where the indenter's schedule is, s.
  double Schedule() const { return time - test.delay; }

  /// Those that are numbers, in the order of the file.
  template <class State> static auto Members(State &s)
  {
    return std::tie(s.time, s.time_step, s.step_settings[0], s.step_settings[1], s.step_settings[2], s.wave_speed, s.step,
                    s.frames, s.initial_mass, s.initial_points, s.initial_created, s.impulse_at_row, s.time_at_row,
                    s.friction_at_row[0], s.friction_at_row[1], s.friction_at_row[2], s.test.time, s.test.delay);
  }
};

/// directory/checkpoint_SSSSSS.h5
std::string CheckpointPath(const std::string &directory, long step);

/// Writes the checkpoint of a step. Returns nothing, or why that failed, the same on every rank. Collective.
std::string WriteCheckpoint(const std::string &directory, const std::vector<std::string> &identity, Hierarchy &hierarchy,
                            const RunState &state);

/// Fills the empty levels of a hierarchy from -restart; ends the run with one line where the file is not whole, of another
/// format or of another case, or means nothing that a run can go on from. same_ranks: as many ranks wrote it, and each has
/// got its own back, so that the run goes on to the last bit as if it had not been interrupted. Collective.
void ReadCheckpoint(const Case &settings, Hierarchy &hierarchy, RunState *state, bool *same_ranks);

} // namespace mlgimp
