// What a run tells of itself while it goes on, each once: results that the user's input makes doubtful.
#pragma once

#include "level/budgets.hpp"
#include "program/case.hpp"
#include "program/quasi_static.hpp"

#include <optional>
#include <set>
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

private:
  std::vector<std::string> lines_;
  std::set<std::size_t> told_; ///< kinds
  /// Of the bodies, J: their energy less all works when first looked at, by a restart anew; the most that they had or were given.
  std::optional<double> unexplained_at_start_;
  double given_ = 0, indenter_work_ = 0, noise_ = 0; ///< the last two: the largest so far, J
};

} // namespace mlgimp
