// What a run tells of itself while it goes on, each once: results that the user's input makes doubtful.
#pragma once

#include "grid/budgets.hpp"
#include "program/case.hpp"
#include "program/motion_watch.hpp"
#include "program/quasi_static.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class Warnings
{
public:
  /// Tells lines that are known before the first step; those of a run that goes on are not kept twice.
  void Tell(MPI_Comm comm, const std::vector<std::string> &lines);
  /// Looks at the budgets of all ranks, which are the same on each, and warns of what is new; some are for the end
  /// of a run. Collective.
  void Look(MPI_Comm comm, const Case &c, const Budgets &budgets, const QuasiStaticWatch &slow, bool ended);
  /// The lines so far, for summary.json; and those that a run which goes on keeps: what is told at an end may be no more true.
  std::vector<std::string> Lines() const;
  std::vector<std::string> KeptLines() const;

  /// What it keeps from row to row; whether these may be a state with its lines.
  std::vector<double> State() const;
  void SetState(const std::vector<double> &state, const std::vector<std::string> &lines);
  static bool IsState(const std::vector<double> &state, const std::vector<std::string> &lines);

private:
  static constexpr std::size_t kAtStart = 99; ///< kind of those before the first step
  struct Told {
    std::size_t kind;
    bool at_end;
    std::string line;
  };
  /// Energies in J: the bodies' less all works when first looked at, and the most that they had or were given; the rest are the
  /// largest so far: the indenter's work, the noise, and loads that it was to carry and has carried, N.
  enum Kept { kLooked, kHadAtStart, kGiven, kIndenterWork, kNoise, kAsked, kCarried, kNumbers };
  std::vector<double> numbers_ = std::vector<double>(kNumbers, 0.0);
  MotionWatch motion_;
  std::vector<Told> told_;
};

} // namespace mlgimp
