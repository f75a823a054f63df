// Checks that the contents of an intact checkpoint are consistent: it may have been edited, or written by another program.
//
// Each function returns an empty string, or what is wrong, for a line "-restart FILE: must be a whole checkpoint; ...".
#pragma once

#include "program/checkpoint/checkpoint.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Points that no run can go on from, wherever they are: values that are not finite, det F or mass not above zero, and the like.
std::string WrongValues(const PointArrays &points, int bodies);
/// Points that the nodes of this rank cannot serve; allowed: the nearest nodes that points of the level may have; `own` where
/// they must be near the rank's own part of the grid.
std::string WrongPlaces(const PointArrays &points, const Grid &grid, IndexBox allowed, bool own);

std::string WrongState(const std::vector<double> &numbers, const Case &settings);
/// numbers: TipTrack::State, of a run that has `count` of them and is at a time.
std::string WrongTip(const std::vector<double> &numbers, std::size_t count, double time);
/// Boxes off the cell lines, or where no run has them.
std::string WrongBoxes(const FollowState &now, const Case &settings);
/// numbers: as the attribute "pace" of level l has them, at a step of level 0.
std::string WrongClock(const std::vector<double> &numbers, long step, const Case &settings, int l);
/// counts: of the points of each rank that wrote, which must add up to `rows`.
std::string WrongCounts(const std::vector<double> &counts, std::size_t ranks, double rows);
/// The layout of a level among so many ranks.
std::string WrongLayout(const std::array<std::vector<double>, 3> &widths, const std::vector<double> &owners,
                        const GridGeometry &grid, std::size_t ranks);
/// per_column: numbers of a column, of which the first is a pressure.
std::string WrongPressures(const std::vector<double> &keys, const std::vector<double> &pressures, int per_column);

/// Searches for identity numbers that two points have. Collective; a rank has the answer of its part of the numbers.
std::string FindRepeated(MPI_Comm comm, std::vector<std::int64_t> ids);

} // namespace mlgimp
