// A run: set-up from a case, the loop over steps, and all that is written on the way.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/advice/warnings.hpp"
#include "program/case/case.hpp"
#include "program/checkpoint/checkpoint.hpp"
#include "program/output/frames.hpp"
#include "program/output/history.hpp"
#include "program/output/output_folder.hpp"
#include "program/slow_test/watch.hpp"
#include "program/system/wall_time.hpp"

#include <string>

namespace mlgimp
{

/// Steps between two checks of what all ranks must know: speeds, balance, failures, rows.
inline constexpr int kControlInterval = 10;

class Simulation
{
public:
  /// The case is kept by reference and must outlive the simulation.
  explicit Simulation(const Case &settings)
      : case_(settings), folder_(settings.output), frames_(settings.output.directory, settings.model),
        watch_(settings.quasi_static), wall_(settings.time.max_wall_time)
  {
  }

  /// Creates levels and points, or reads them from a checkpoint, and checks what only levels and points show. Collective.
  void SetUp(MPI_Comm comm);
  /// Takes warnings that are known before the first step; Run prints them after all checks have passed.
  void WarnAtStart(const std::vector<std::string> &lines) { at_start_.insert(at_start_.end(), lines.begin(), lines.end()); }
  /// Prepares the output folder and runs to the end, or until a signal or the clock asks to stop. Returns the signal that has
  /// asked, else 0.
  int Run();

private:
  void Begin();
  void PrepareOutputFolder();
  void Step();
  void ControlStep();
  void FollowBoxes();
  void CheckPace();
  /// When boxes may move again.
  double NextCheck() const { return state_.time + case_.hierarchy.follow.interval * state_.time_step; }
  void WriteFrameDue();
  void WriteDue(); ///< rows of the history, checkpoint
  void ObeyOrders();
  void ReportStop();
  void RecordRow();
  std::string WriteRows();
  void SetFrictionForce(double time);
  void WriteState();
  std::string WriteSummary(const std::string &status);
  [[noreturn]] void Fail(const std::string &message);
  /// Ends the run where something could not be written.
  void CheckWritten(const std::string &problem)
  {
    if (!problem.empty()) Fail(problem);
  }
  std::string FindKept() const;
  std::array<double, 3> StepSettings() const { return {case_.time.end_time, case_.time.time_step, case_.time.cfl}; }
  void ShowProgress(bool last);
  void CheckFailure();
  std::string DescribeTip();
  void CheckState();
  /// Whether the run ends, or a row of the history is written, after a step that ends at a time.
  bool IsEnd(long step, double time) const;
  bool IsRowDue(long step, double time) const;
  bool AtEnd() const { return IsEnd(state_.step, state_.time); }
  double Done() const; ///< share of the run
  /// Frames behind that of the start that this case would have written by now.
  int FramesDue() const;
  double TimeScale(double speed) const;
  double StepLength(double speed) const;
  double FastestSignal(const SpeedCheck &speeds) const;
  void CheckStep(double speed);
  [[noreturn]] void FailOrRefuse(const std::string &message);

  /// A row of the history that waits for the next check: what all ranks know of it.
  struct Row {
    long step;
    double time;
    Vec3 tip;
  };
  void Complete(const Row &row);

  const Case &case_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  LogEvents events_{};
  Hierarchy hierarchy_;
  RunState state_;
  Budgets budgets_{};             ///< of the last history row
  std::vector<Row> rows_;         ///< that wait
  std::vector<Budgets> row_sums_; ///< this rank's part of each
  OutputFolder folder_;
  History history_;
  FrameWriter frames_;
  QuasiStaticWatch watch_;
  WallTime wall_;
  std::string stopped_; ///< why the run stops before its end
  int stop_signal_ = 0; ///< that has asked for it
  double start_wall_ = 0, last_shown_ = 0, level_seconds_ = 0, point_steps_ = 0;
  long start_step_ = 0, last_checkpoint_ = -1;
  std::size_t shown_ = 0; ///< characters of the progress line
  int frames_before_ = 0; ///< more than FramesDue() at the start: a restart with another end, or number of frames, counts on
  double start_progress_ = 0, load_ = 0, friction_force_ = 0;
  std::vector<std::string> at_start_; ///< warnings
  Warnings warnings_;
};

} // namespace mlgimp
