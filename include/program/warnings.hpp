// What a run tells of itself while it goes on, each once: results that the user's input makes doubtful.
#pragma once

#include "level/budgets.hpp"
#include "program/case.hpp"
#include "program/quasi_static.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class Warnings
{
public:
  /// Looks at the budgets of all ranks, which are the same on each, and warns of what is new; some are for the end
  /// of a run. Collective.
  void Look(MPI_Comm comm, const Case &c, const Budgets &budgets, const QuasiStaticWatch &slow, bool ended);
  /// The lines so far, for summary.json.
  const std::vector<std::string> &Lines() const { return lines_; }

  /// What it keeps from row to row, and the lines; whether these may be such.
  std::vector<double> State() const;
  void SetState(const std::vector<double> &state, const std::vector<std::string> &lines);
  static bool IsState(const std::vector<double> &state, const std::vector<std::string> &lines);

private:
  /// Energies in J: the bodies' less all works when first looked at, and the most that they had or were given; the rest are the
  /// largest so far: the indenter's work, the noise, and loads that it was to carry and has carried, N.
  enum Kept { kLooked, kAtStart, kGiven, kIndenterWork, kNoise, kAsked, kCarried, kNumbers };
  std::vector<double> numbers_ = std::vector<double>(kNumbers, 0.0);
  std::vector<std::size_t> told_; ///< kinds, as their lines
  std::vector<std::string> lines_;
};

} // namespace mlgimp
