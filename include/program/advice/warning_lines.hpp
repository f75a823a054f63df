// The lines of warnings, one function each: empty where there is nothing to say. Those of energies and speeds are in
// warnings.cpp, those of contact and its cells in contact_warnings.cpp.
#pragma once

#include "program/advice/warnings.hpp"

#include <string>

namespace mlgimp
{

/// What the rows of the history have shown so far.
struct Watched : WarningState {
  const QuasiStaticWatch &slow;
  const MotionWatch &motion;
  double made;  ///< energy that bodies have now and that no work explains, J
  double floor; ///< energies below it may be rounding, J
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
