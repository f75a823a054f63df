// What -check prints of a case: what it is, how many steps it takes and what these cost.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/case/case.hpp"
#include "program/checkpoint/checkpoint.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// What a few steps have shown.
struct MeasuredSteps {
  long steps = 0;     ///< of level 0
  double seconds = 0; ///< that they took, by the clock
};

/// The lines of -check text, or the JSON of -check json, in which all is in SI units. state: at the start; warnings: all that are
/// known before the first step. The same on every rank. Collective.
std::string DescribeCase(const Case &c, Hierarchy &hierarchy, const RunState &state, const MeasuredSteps &measured,
                         const std::vector<std::string> &warnings);

} // namespace mlgimp
