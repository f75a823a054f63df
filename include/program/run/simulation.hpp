// A run: set-up from a case, and the loop over steps of level 0.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/case/case.hpp"
#include "program/checkpoint/checkpoint.hpp"
#include "program/run/limits.hpp"
#include "program/run/run_output.hpp"
#include "program/slow_test/clock.hpp"
#include "program/system/wall_time.hpp"

#include <string>

namespace mlgimp
{

class Simulation
{
public:
  /// The case is kept by reference and must outlive the simulation.
  explicit Simulation(const Case &settings)
      : case_(settings), clock_(settings, state_.test), output_(settings, hierarchy_, state_, cost_),
        wall_(settings.time.max_wall_time)
  {
  }

  /// Creates levels and points, or reads them from a checkpoint, and checks what only levels and points show. Collective.
  void SetUp(MPI_Comm comm);
  /// Takes warnings that are known before the first step; Run prints them after all checks have passed.
  void WarnAtStart(const std::vector<std::string> &lines) { at_start_.insert(at_start_.end(), lines.begin(), lines.end()); }
  /// Prepares the output folder and runs to the end, or until a signal or the clock asks to stop. Returns the signal that has
  /// asked, else 0.
  int Run();
  /// In place of Run, with -check: takes a few steps and prints what the case is. Writes nothing. Collective.
  void Check();

private:
  void Begin();
  void Step();
  void WriteFrameDue();
  void FollowBoxes();
  void ControlStep();
  void Control();
  void WriteDue(); ///< rows of the history, checkpoint
  void WriteState();
  void ObeyOrders();
  void ReportStop() const;

  bool AtEnd() const { return case_.time.IsEnd(state_.step, state_.Schedule()); }
  bool IsCheckDue() const { return state_.step % kControlInterval == 0 && !AtEnd(); }
  /// When boxes may move again.
  double NextCheck() const { return state_.time + case_.hierarchy.follow.interval * state_.time_step; }
  std::array<double, 3> StepSettings() const { return {case_.time.end_time, case_.time.time_step, case_.time.cfl}; }

  /// Ends the run with what it has written so far.
  [[noreturn]] void Fail(const std::string &message);
  /// Each ends the run where there is a problem; the second, before the first step, as one with wrong input.
  void FailIf(const std::string &problem)
  {
    if (!problem.empty()) Fail(problem);
  }
  void FailOrRefuseIf(const std::string &problem);
  void CheckFailure() { FailIf(FindFailure(case_, hierarchy_, state_.time)); }

  const Case &case_;
  Hierarchy hierarchy_;
  RunState state_;
  RunCost cost_;
  TestClock clock_;
  RunOutput output_;
  WallTime wall_;
  std::vector<std::string> at_start_; ///< warnings
  std::string stopped_;               ///< why the run stops before its end
  int stop_signal_ = 0;               ///< that has asked for it
  long start_step_ = 0;
};

} // namespace mlgimp
