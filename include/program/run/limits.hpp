// How long the steps of a run are, and what ends it before its time.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/case/case.hpp"

#include <string>

namespace mlgimp
{

/// The fastest signal: waves, or points and the indenter that come toward each other, m/s.
double FastestSignal(const Case &c, double time, const SpeedCheck &speeds);
/// The user's step or that of the CFL number, shortened so that a whole number of steps leads to the end, s.
double StepLength(const Case &c, double time, double speed);

// Why a run cannot go on, in one line that is the same on all ranks; an empty string where it can.

/// Steps that are too long to be stable, or too short to lead anywhere. begun: these are not the first.
std::string WrongStep(const Case &c, double time, double speed, bool begun);
/// A tip that would leave the finest level's box before boxes are checked again.
std::string WrongPace(const Case &c, Hierarchy &hierarchy, double time, double next_check);
/// What has failed in a step, or a tip that cannot carry its load. Collective.
std::string FindFailure(const Case &c, Hierarchy &hierarchy, double time);
/// Points that no restart could use, although no step has failed yet. Collective.
std::string FindBadPoints(const Case &c, Hierarchy &hierarchy, double time);

} // namespace mlgimp
