// The plan of a slow test: -quasi_static chooses the schedule, the damping and the pace.
#pragma once

#include "program/case/case.hpp"

namespace mlgimp
{

/// -quasi_static and what goes with it; has_indenter: there is one that it could move.
void ReadQuasiStatic(OptionReader &reader, bool has_indenter, QuasiStaticPlan *plan);
/// Time of a wave from the contact to the support, or to any end of the bodies where nothing holds them, s.
double TransitOf(const Case &c);
/// Puts a slow schedule with the same turns in place of the one that was read; end_time: what the user gave, or infinity.
void PlanQuasiStatic(OptionReader &reader, double end_time, Case *c);

} // namespace mlgimp
