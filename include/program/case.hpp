// A case: everything that options say, validated.
#pragma once

#include "levels/hierarchy.hpp"
#include "program/options.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Steps above this fraction of h/(c + |v|) are refused as unstable.
inline constexpr double kLargestCfl = 1;

/// When a run ends and how long its steps are.
struct TimeSettings {
  double end_time = HUGE_VAL; ///< s
  int max_steps = 0;          ///< of level 0; 0 = no limit
  double time_step = 0;       ///< s; 0 = from cfl
  double cfl = 0.4;           ///< fraction of h/(c + |v|)
};

/// What is written, and where.
struct OutputSettings {
  std::string directory;
  bool overwrite = false, monitor = false;
  int history_interval = 1, frames = 20, checkpoint_interval = 0;
  std::string restart; ///< checkpoint to go on from; empty for none
};

struct Case {
  std::string name;
  Box domain;
  double cell_size = 0; ///< of level 0, m
  int levels = 1;
  int refinement_ratio = 2;
  std::vector<Box> boxes;   ///< of the levels; the first is the domain
  std::vector<double> blend_widths; ///< of the levels' borders, from level 1 on, cells of the coarser level
  double least_blend_width = kLeastBlendWidth; ///< what boxes must leave room for
  bool merge_siblings = false;
  LevelCoupling coupling = LevelCoupling::kNodes;
  GhostRepairs repairs;     ///< of the coupling by points
  int ghost_cells = 4;      ///< of the coupling by points
  Model model;
  TimeSettings time;
  OutputSettings output;
  int sort_interval = 50;
  double rebalance_threshold = 1.1;
  int points_per_rank = 1000;
  std::vector<std::string> load_names; ///< in the order of model.loads
  std::vector<std::string> identity; ///< options that a restart must share

  double CellSize(int level) const { return cell_size / std::pow(refinement_ratio, level); }
  int Cells(int axis) const
  {
    return static_cast<int>(std::lround((domain.upper[axis] - domain.lower[axis]) / cell_size));
  }
};

/// Where the levels lie, and which of their sides are the domain's.
std::vector<LevelGeometry> MakeLevels(const Case &settings);

/// Reads and checks all options of a case. With -help nothing is required and nothing is checked.
PetscErrorCode ReadCase(OptionReader &reader, Case *settings);

} // namespace mlgimp
