// Where the boxes of levels lie that follow the contact or a path: a plan, from places and times alone.
#pragma once

#include "base/piecewise_linear.hpp"
#include "physics/region.hpp"

#include <array>
#include <vector>

namespace mlgimp
{

enum class FollowKind { kNone, kContact, kPath };

/// What a level keeps free between its border and what it holds, in its own cells; below zero where nothing is given.
struct BoxMargin {
  double sideways = -1, down = -1;
};

/// How the boxes of levels move.
struct FollowSettings {
  FollowKind kind = FollowKind::kNone;
  int interval = 1;                      ///< level-0 steps between two checks
  double cells_max = 64, cells_min = 12; ///< of the finest level in half the contact's width: with more it ends, with fewer a
                                         ///< finer one begins
  std::vector<BoxMargin> margins;        ///< [levels]
  std::vector<std::array<PiecewiseLinear, 3>> paths; ///< [levels]: how far the box has moved along each axis, m
  std::vector<Box> start;                            ///< [levels]: the boxes at the start, the first the domain
};

/// The grids that boxes are placed on.
struct LevelRules {
  Box domain;
  double cell_size = 0; ///< of level 0, m
  int ratio = 2, dim = 2, levels = 1;
  std::vector<double> blend_widths; ///< of the bands inside the borders of level 1 and so on, cells of the coarser level
  double border_cells = 0;          ///< that a border needs free beside its band, of the level itself
  double CellSize(int k) const;
  /// What a level needs free inside each of its borders: its band and some cells, m.
  double Border(int k) const;
};

/// Where the contact is.
struct ContactPlace {
  Vec3 tip{};            ///< of the indenter, m
  double half_width = 0; ///< of the contact, m
  double reach = 0;      ///< from the tip to the farthest place under pressure, along a horizontal axis, m
  double surface = 0;    ///< height of the undeformed surface under the tip, m
  double top = 0;        ///< of the highest point around the tip, m
};

/// Boxes of all levels, the domain first, and how many levels have points: the finer ones rest at the tip, without any.
struct BoxPlan {
  std::vector<Box> boxes;
  int active = 1;
};

/// A box on the nearest lines of cells of a size, as a grid beside the lines would have its points elsewhere; on the domain's
/// sides as they were given.
Box OnNearestLines(const LevelRules &rules, Box box, double cell);

/// The least boxes that hold a contact: from the tip its reach and 1.6 half widths of the whole, or the margin, sideways and
/// down; each at least so far inside the next coarser one as its border needs; on cell lines of the next coarser level, and at a
/// side of the domain where they would come nearer to it than four coarser cells.
std::vector<Box> BoxesAround(const LevelRules &rules, const FollowSettings &settings, const ContactPlace &place, int active);

/// What to do now: whether levels end or begin, or boxes no longer hold the contact, or are far too large for it. New boxes leave
/// room for a contact a quarter larger, so that they seldom move. Returns whether `next` differs from `now`.
bool FollowContact(const LevelRules &rules, const FollowSettings &settings, const ContactPlace &place, const BoxPlan &now,
                   BoxPlan *next);

/// The first boxes moved by their paths at a time, on cell lines. Returns whether `next` differs from `now`.
bool FollowPath(const LevelRules &rules, const FollowSettings &settings, double time, const BoxPlan &now, BoxPlan *next);

/// The first level whose box does not lie in the next coarser one as deep as its border needs; 0 where there is none.
int FindMisplaced(const LevelRules &rules, const std::vector<Box> &boxes);

} // namespace mlgimp
