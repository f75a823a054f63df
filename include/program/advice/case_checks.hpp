// Checks of a case once all of its options have been read, and before its first step: what is refused, and what is only warned
// of.
//
// The lists of all checks, each with the options that it names: at the foot of indenter_checks.cpp, times.cpp, cells.cpp and
// gaps.cpp for those of options, of start_checks.cpp for those that need points, and of warnings.cpp (kRunWarnings) for those of
// a run.
#pragma once

#include "program/case/case.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

inline constexpr double kLargestSpeed = 0.1; ///< of an indenter, of the speed of waves; no indentation is as fast

/// Warns where less than a cell lies between a body and others, or a side that holds it: they have nodes in common, and move as
/// if they touched.
void WarnOfGaps(OptionReader &reader, const Case &c, const Body &body);
/// Refuses or warns of what is wrong with an indenter of that kind once all of it has been read.
void CheckIndenterInput(OptionReader &reader, const Case &c, const std::string &kind);
/// A level that the tip meets must hold it with the band of its border for the whole run, also where its box follows a path.
void CheckLevelsHoldTip(OptionReader &reader, const Case &c);
/// Warns of bodies with fewer than two cells in their thickness where a load or the indenter presses them, and of a finest level
/// whose box does not hold the surface under the tip.
void WarnOfCells(OptionReader &reader, const Case &c);
/// Warns of a run that is too long, of loads after its end, and of an indenter or a load that is fast beside waves.
void CheckTimes(OptionReader &reader, const Case &c);

/// What grids and points of a case take on all ranks together, bytes; an estimate.
double BytesNeeded(const Case &c);
/// Ends the run where a rank would need more memory than its machine has for it. Collective.
void CheckMemory(MPI_Comm comm, const Case &c);
/// Ends the run where a body has no points, where its mass or its outer faces are not those of its shape, or where a load acts
/// on no face. Returns lines that warn where a load acts on a part of its side only, and of points too thin for the steps.
/// Collective.
std::vector<std::string> CheckBodies(Hierarchy &hierarchy, const Case &c);
/// Ends the run where the indenter starts inside a body. Collective.
void CheckIndenter(Hierarchy &hierarchy, const Case &c);

} // namespace mlgimp
