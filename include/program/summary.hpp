// summary.json: what a run was, how it ended and what it cost.
#pragma once

#include "program/case.hpp"
#include "program/checkpoint.hpp"

#include <string>

namespace mlgimp
{

inline constexpr const char *kVersion = "0.2";

struct SummaryInput {
  const std::string &status;
  const Case &settings;
  const RunState &state;
  Hierarchy &hierarchy;
  double wall_seconds; ///< since the loop began
  double step_seconds; ///< of them in steps, on this rank
  double point_steps;  ///< points times steps on this rank
  const LogEvents &events;
  long steps; ///< of level 0 in this run
};

/// Writes summary.json in the output folder. problem: empty, or why that failed, the same on every rank. Collective.
PetscErrorCode WriteSummary(const SummaryInput &input, std::string *problem);

} // namespace mlgimp
