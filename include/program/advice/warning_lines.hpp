// The lines of warnings, one function each: empty where there is nothing to say. Those of energies and speeds are in
// warnings.cpp, those of contact and its cells in contact_warnings.cpp.
#pragma once

#include "grid/budgets.hpp"
#include "program/advice/motion_watch.hpp"
#include "program/case/case.hpp"
#include "program/slow_test/watch.hpp"

#include <string>

namespace mlgimp
{

/// What the rows of the history have shown so far. Energies in J: what bodies have that no work explains, the most that they had
/// or were given, what they had at the start, and the largest of the indenter's work and of the noise; floor: where rounding
/// begins.
struct Watched {
  const QuasiStaticWatch &slow;
  const MotionWatch &motion;
  double made, given, had, indenter_work, noise, floor;
  double asked, carried; ///< largest loads, N
  double deepest;        ///< depth so far, m
};

inline std::string When(const Budgets &budgets) { return Format(" by time {} s", budgets.time); }

std::string PenetrationWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string BorderWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string WidestContactWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string NarrowestContactWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string MirrorWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string TouchWarning(const Case &c, const Budgets &budgets, const Watched &watched);
std::string LoadWarning(const Case &c, const Budgets &budgets, const Watched &watched);

} // namespace mlgimp
