// A case: everything that options say, validated.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/case/slow_schedule.hpp"
#include "program/case/test_legs.hpp"
#include "program/options/options.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mlgimp
{

/// Steps between two checks of what all ranks must know: speeds, balance, failures, rows.
inline constexpr int kControlInterval = 10;

/// Steps above this fraction of h/(c + |v|) are refused as unstable.
inline constexpr double kLargestCfl = 1;

// How far from a line of cells a place counts as on it, in cells.
inline constexpr double kOnLine = 1e-6;       ///< rounding: of what the program has put there
inline constexpr double kGivenOffLine = 1e-5; ///< rounding: of a box that the user gives: its grid is shifted by so much
inline constexpr double kMovedOffLine = 1e-4; ///< rounding: of a box in a checkpoint, which has moved

/// When a run ends and how long its steps are.
struct TimeSettings {
  double end_time = HUGE_VAL;      ///< s
  int max_steps = 0;               ///< of level 0; 0 = no limit
  double time_step = 0;            ///< s; 0 = from cfl
  double cfl = 0.4;                ///< fraction of h/(c + |v|)
  double max_wall_time = HUGE_VAL; ///< by the clock, s
  double rate_scale = 1;           ///< simulated time over that of the test, where no clock of the test runs

  /// Whether the run ends with a step that leads to a time; of a test with a clock, that of its schedule.
  bool IsEnd(long step, double time) const { return (max_steps > 0 && step >= max_steps) || time >= end_time * (1 - 1e-12); }
  /// Share of the run that is done then.
  double Done(long step, double time) const
  {
    const double by_steps = max_steps > 0 ? static_cast<double>(step) / max_steps : 0;
    return IsEnd(step, time) ? 1 : std::max(by_steps, time / end_time);
  }
};

/// The test that a slow one stands for, where the user gives its times.
struct TestPlan {
  std::vector<double> times, loads; ///< given, s; N, where it is by loads
  double creep = 0.025;             ///< way of a tip that creeps in a transit of waves, of its depth
  std::vector<TestLeg> legs;        ///< none without times
  bool On() const { return !legs.empty(); }
  /// The leg that a time of the schedule is in, or behind; -1 before the first, or without any.
  int LegAt(double schedule) const
  {
    constexpr double kSmall = 1e-12; // rounding: of the schedule
    const double now = On() ? schedule + kSmall * legs.back().end : 0;
    return static_cast<int>(std::count_if(legs.begin(), legs.end(), [&](const TestLeg &leg) { return leg.begin <= now; })) - 1;
  }
  /// Begin and end of each leg in the schedule, s.
  void Place(const std::vector<std::pair<double, double>> &in_schedule)
  {
    for (std::size_t k = 0; k < legs.size(); ++k) legs[k].begin = in_schedule[k].first, legs[k].end = in_schedule[k].second;
  }
};

/// A slow test: what -quasi_static has chosen.
struct QuasiStaticPlan {
  bool on = false;
  double tolerance = 0.01;                      ///< share of the load that inertia and damping may add
  TestPlan test;                                ///< its own time
  std::vector<double> turns;                    ///< depths that -indenter_depths gives, m
  int unloadings = 0;                           ///< small ones, on the way of the first loading
  bool own_damping = true;                      ///< none was given
  bool own_step = true;                         ///< neither -cfl nor -time_step was given
  bool own_xpic = true;                         ///< no fraction of XPIC was given
  double distance = 0;                          ///< from the contact to the farthest end of the bodies along an axis, m
  SlowPace pace;                                ///< of depths, or of roots of the load
  double rise = 0;                              ///< time in which loads and gravity rise before the tip starts, s
  double damping_ratio = 0;                     ///< of the body's lowest mode
  double largest_speed = 0;                     ///< of the tip, m/s; 0 under load control
  double wave_speed = 0;                        ///< distance over transit, m/s
  double depth = 0, load = 0;                   ///< largest that is wanted, m or N, the other 0
  double exponent = 1;                          ///< of the load over depth, elastic
  double end_time = 0;                          ///< of the schedule, s
  std::vector<std::pair<double, double>> holds; ///< begin and end, s
};

/// What is written, and where.
struct OutputSettings {
  std::string directory;
  bool overwrite = false, monitor = false;
  int history_interval = 1, frames = 20, checkpoint_interval = 0;
  bool single_precision = false; ///< of the frames' real numbers
  std::string restart;           ///< checkpoint to go on from; empty for none
  std::string check;             ///< how the case is described in place of being run, "text" or "json"; empty: it is run
};

struct Case {
  std::string name; ///< given before the options are read
  Box domain;
  double cell_size = 0; ///< of level 0, m
  int levels = 1;
  std::vector<Box> boxes;                    ///< of the levels; the first is the domain
  double least_blend_width = kMinBlendWidth; ///< what boxes must leave room for, cells of the coarser level
  HierarchySettings hierarchy;               ///< where the levels lie, and how they are coupled and kept
  Model model;
  TimeSettings time;
  OutputSettings output;
  QuasiStaticPlan quasi_static;
  std::vector<std::string> load_names; ///< in the order of model.loads
  std::vector<std::string> identity;   ///< options that a restart must share
  std::vector<std::string> notes;      ///< lines for people: what was chosen

  /// The finest level whose box holds a place. A place on a side of the domain is inside it, also where boxes end there.
  int LevelAt(Vec3 x) const
  {
    for (int axis = 0; axis < Dim(); ++axis)
      if (std::abs(x[axis] - domain.upper[axis]) < kRounding * cell_size)
        x[axis] = domain.upper[axis] - kRounding * CellSize(levels - 1);
    int level = 0;
    while (level + 1 < levels && boxes[level + 1].Contains(x)) ++level;
    return level;
  }
  /// The finest level whose box holds all of a box.
  int LevelAround(const Box &box) const
  {
    for (int level = levels - 1; level > 0; --level) {
      bool inside = true;
      for (int d = 0; d < Dim(); ++d)
        inside = inside && box.lower[d] >= boxes[level].lower[d] && box.upper[d] <= boxes[level].upper[d];
      if (inside) return level;
    }
    return 0;
  }
  /// The finest level at the surface that the indenter's tip meets.
  int LevelAtTip() const
  {
    Vec3 x = model.indenter->tip;
    x[model.indenter->up] = model.indenter->initial_surface - 1e-6 * CellSize(levels - 1);
    return LevelAt(x);
  }
  /// The side of the domain across a horizontal axis that the indenter's tip is on.
  std::optional<Side> SideAtTip(int axis) const
  {
    for (const Side side : SidesAcross(axis))
      if (std::abs(model.indenter->tip[axis] - domain.At(side)) < kRounding * cell_size) return side;
    return {};
  }
  /// Whether that is a side of symmetry, so that the indenter is a half of one.
  bool MirrorsTip(int axis) const
  {
    const std::optional<Side> side = SideAtTip(axis);
    return side && model.sides[*side] == BoundaryKind::kSymmetry;
  }
  /// How many models like this make the whole tip: two for each side of symmetry that it is on.
  int PartsOfTip() const
  {
    int parts = 1;
    for (int axis = 0; axis < model.indenter->up; ++axis)
      if (MirrorsTip(axis) && !(axis == 0 && model.geometry.HasHoop())) parts *= 2;
    return parts;
  }
  int Dim() const { return model.geometry.Dim(); }
  /// Points that splitting has made, less those that merging has taken.
  static double PointsCreated(const Budgets &b) { return b.points_made - b.points_spent; }
  /// What a level needs between the tip and its borders, m.
  double BorderMargin(int k) const { return k == 0 ? 0 : least_blend_width * CellSize(k - 1) + kBorderCells * CellSize(k); }
  /// The lowest place that the tip may come to while it is on a level.
  double LowestTip(int k) const
  {
    if (hierarchy.follow.kind == FollowKind::kContact) return domain.lower[model.indenter->up]; // no box holds it back
    const Side below = static_cast<Side>(2 * model.indenter->up);
    return boxes[k].At(below) + (IsBorder(k, below) ? BorderMargin(k) : 0);
  }
  double CellSize(int level) const { return cell_size / std::pow(hierarchy.ratio, level); }
  /// True where a side of a level's box lies within the domain, as a border to the next coarser level.
  bool IsBorder(int level, Side side) const { return IsBorder(boxes[level], level, side); }
  bool IsBorder(const Box &box, int level, Side side) const
  {
    return std::abs(box.At(side) - domain.At(side)) > kOnLine * CellSize(level);
  }
  int Cells(int axis) const { return static_cast<int>(std::lround((domain.upper[axis] - domain.lower[axis]) / cell_size)); }
};

/// Boxes of all levels at a time, s.
struct BoxesAtTime {
  double time;
  std::vector<Box> boxes;
};
/// Those on paths, at the beginning and end of the run and at times between.
std::vector<BoxesAtTime> BoxesAlongPaths(const Case &c);

} // namespace mlgimp
