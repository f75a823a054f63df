// summary.json: what a run was, how it ended and what it cost.
#pragma once

#include "level/events.hpp"
#include "program/run/rows.hpp"

#include <string>

namespace mlgimp
{

/// What a run has cost so far, on this rank.
struct RunCost {
  LogEvents events{};
  double begin = 0;         ///< of its steps, by the clock, s
  double level_seconds = 0; ///< in steps
  double point_steps = 0;   ///< points moved, over all steps
};

/// Writes it. Returns nothing, or why that failed, the same on every rank. Collective.
std::string WriteSummary(const Case &c, Hierarchy &hierarchy, const RunState &state, const RunCost &cost, const RowWriter &rows,
                         const std::string &status);

} // namespace mlgimp
