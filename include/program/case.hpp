// A case: everything that options say, validated.
#pragma once

#include "hierarchy/hierarchy.hpp"
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
  std::string name; ///< given before the options are read
  Box domain;
  double cell_size = 0; ///< of level 0, m
  int levels = 1;
  std::vector<Box> boxes;                      ///< of the levels; the first is the domain
  double least_blend_width = kLeastBlendWidth; ///< what boxes must leave room for, cells of the coarser level
  HierarchySettings hierarchy;                 ///< where the levels lie, and how they are coupled and kept
  Model model;
  TimeSettings time;
  OutputSettings output;
  std::vector<std::string> load_names; ///< in the order of model.loads
  std::vector<std::string> identity;   ///< options that a restart must share

  /// The finest level whose box holds a place.
  int LevelAt(Vec3 x) const
  {
    int level = 0;
    while (level + 1 < levels && boxes[level + 1].Contains(x)) ++level;
    return level;
  }
  /// The finest level at the surface that the indenter's tip meets.
  int LevelAtTip() const
  {
    Vec3 x = model.indenter->tip;
    x[model.indenter->up] = model.indenter->initial_surface - 1e-6 * CellSize(levels - 1);
    return LevelAt(x);
  }
  int Dim() const { return model.geometry.Dim(); }
  /// Points that splitting has made, less those that merging has taken.
  static double PointsCreated(const Budgets &b) { return b.points_made - b.points_spent; }
  /// What a level needs between the tip and its borders, m.
  double BorderMargin(int k) const { return k == 0 ? 0 : least_blend_width * CellSize(k - 1) + kBorderCells * CellSize(k); }
  /// The lowest place that the tip may come to while it is on a level.
  double LowestTip(int k) const
  {
    const Side below = static_cast<Side>(2 * model.indenter->up);
    return boxes[k].At(below) + (IsBorder(k, below) ? BorderMargin(k) : 0);
  }
  double CellSize(int level) const { return cell_size / std::pow(hierarchy.ratio, level); }
  /// True where a side of a level's box lies within the domain, as a border to the next coarser level.
  bool IsBorder(int level, Side side) const { return std::abs(boxes[level].At(side) - domain.At(side)) > 1e-6 * CellSize(level); }
  int Cells(int axis) const { return static_cast<int>(std::lround((domain.upper[axis] - domain.lower[axis]) / cell_size)); }
};

/// Reads and checks all options of a case. With -help nothing is required and nothing is checked.
void ReadCase(OptionReader &reader, Case *settings);

} // namespace mlgimp
