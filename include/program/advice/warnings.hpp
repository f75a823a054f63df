// Warnings during a run, each printed once: results that the user's input makes doubtful.
#pragma once

#include "grid/budgets.hpp"
#include "program/advice/motion_watch.hpp"
#include "program/case/case.hpp"
#include "program/slow_test/watch.hpp"

#include <string>
#include <tuple>
#include <vector>

namespace mlgimp
{

/// What warnings keep from row to row.
struct WarningState {
  double begun = 0;              ///< 1 from the first row on
  double had_at_start = 0;       ///< energy of the bodies less all works in the first row, J
  double given = 0;              ///< the most energy that they had or were given, J
  double indenter_work = 0;      ///< the largest, J
  double noise = 0;              ///< the largest, J
  double asked = 0, carried = 0; ///< largest loads that the tip was to carry and has carried, N

  /// In the order of the file.
  template <class State> static auto Members(State &s)
  {
    return std::tie(s.begun, s.had_at_start, s.given, s.indenter_work, s.noise, s.asked, s.carried);
  }
};

/// What a run will warn of when its contact has a half width (m) at a time (s), as far as that follows from the case: few cells,
/// borders of levels, mirror images.
std::vector<std::string> ForeseenWarnings(const Case &c, double half_width, double time);

class Warnings
{
public:
  /// Prints lines that are known before the first step. A restarted run keeps such a line once.
  void Issue(MPI_Comm comm, const std::vector<std::string> &lines);
  /// Checks the budgets, which are the same on each rank, and prints new warnings; some are for the end
  /// of a run. Collective.
  void Check(MPI_Comm comm, const Case &c, const Budgets &budgets, const QuasiStaticWatch &slow, bool ended);
  /// The lines so far, for summary.json; and those that a restarted run keeps: a warning at an end need not hold after more
  /// steps.
  std::vector<std::string> Lines() const;
  std::vector<std::string> KeptLines() const;

  /// What it keeps from row to row; whether these may be a state with its lines.
  std::vector<double> State() const;
  void SetState(const std::vector<double> &state, const std::vector<std::string> &lines);
  static bool IsState(const std::vector<double> &state, const std::vector<std::string> &lines);

private:
  static constexpr std::size_t kAtStart = 99; ///< size: kind of those before the first step
  struct Issued {
    std::size_t kind;
    bool at_end;
    std::string line;
  };
  double Record(const Case &c, const Budgets &budgets);

  WarningState state_;
  MotionWatch motion_;
  std::vector<Issued> issued_;
};

} // namespace mlgimp
