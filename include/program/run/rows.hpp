// Rows of the history: each rank keeps its part until the next check; then they are added up, completed and written.
#pragma once

#include "program/advice/warnings.hpp"
#include "program/checkpoint/checkpoint.hpp"
#include "program/output/history.hpp"
#include "program/slow_test/watch.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class RowWriter
{
public:
  /// All are kept by reference and must outlive the writer. The state has what the next row needs of the last.
  RowWriter(const Case &settings, Hierarchy &hierarchy, RunState &state)
      : case_(settings), hierarchy_(hierarchy), state_(state), watch_(settings.quasi_static)
  {
  }

  /// Starts the file, or goes on with it. Returns as History::Open.
  std::string Open(bool goes_on);
  /// Whether a row is written after a step that ends at a time of the indenter's schedule.
  bool IsDue(long step, double schedule) const;
  /// Keeps this rank's part of a row, so that rows need no messages in their steps.
  void Keep();
  /// Writes the rows that wait, up to the first step in which something has failed. Returns as History::Write. Collective.
  std::string Write();

  /// Load of the last row, N.
  double Load() const { return load_; }
  const History &File() const { return history_; }
  const QuasiStaticWatch &Watch() const { return watch_; }
  Warnings &Advice() { return warnings_; }
  const Warnings &Advice() const { return warnings_; }
  /// What a restart goes on with, from the state and back to it.
  void TakeState();
  void KeepState();

private:
  /// What all ranks know of a row that waits.
  struct Row {
    long step;
    double time, schedule, test_time;
    Vec3 tip;
    double deflection, spring_energy;
  };
  void Complete(const Row &row, Budgets &budgets);
  void SetFrictionForce(double time, Budgets &budgets);

  const Case &case_;
  Hierarchy &hierarchy_;
  RunState &state_;
  History history_;
  std::vector<Row> rows_;
  std::vector<Budgets> sums_; ///< this rank's part of each
  double load_ = 0, friction_force_ = 0;
  QuasiStaticWatch watch_;
  Warnings warnings_;
};

} // namespace mlgimp
