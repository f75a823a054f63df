// The loop over level-0 steps.
#include "program/run/simulation.hpp"

#include "program/advice/case_checks.hpp"
#include "program/run/check.hpp"
#include "program/system/signals.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>

namespace mlgimp
{

int Simulation::Run()
{
  Begin();
  while (!AtEnd() && stopped_.empty()) {
    Step();
    WriteFrameDue(); // with the levels, and the pressures of contact on them, that the step had
    if (!AtEnd()) FollowBoxes();
    if (IsCheckDue()) Control();
    WriteDue();
    output_.ShowProgress(false);
    if (IsCheckDue()) ObeyOrders();
  }
  output_.ShowProgress(true);
  FailIf(output_.Finish(stopped_.empty() ? "completed" : Format("stopped: {}", stopped_)));
  if (stopped_.empty())
    ExitOnError(hierarchy_.View(state_.time));
  else
    ReportStop();
  return stop_signal_;
}

void Simulation::Check()
{
  constexpr long kFewest = 3;    // size: steps
  constexpr double kLongest = 1; // size: s
  const RunState at_start = state_;
  MeasuredSteps measured;
  if (!AtEnd()) Step(); // the first fills caches
  const double begin = MPI_Wtime();
  for (int goes_on = 1; goes_on && !AtEnd();) {
    Step();
    if (IsCheckDue()) Control();
    measured = {measured.steps + 1, MPI_Wtime() - begin};
    goes_on = measured.steps < kFewest || measured.seconds < kLongest;
    MPI_Bcast(&goes_on, 1, MPI_INT, 0, hierarchy_.Comm());
  }
  CheckFailure();
  ExitOnError(PetscPrintf(hierarchy_.Comm(), "%s\n", DescribeCase(case_, hierarchy_, at_start, measured, at_start_).c_str()));
}

static void RefuseIf(const std::string &problem)
{
  if (!problem.empty()) Refuse(problem);
}

void Simulation::SetUp(MPI_Comm comm)
{
  const bool restart = !case_.output.restart.empty();
  bool same_ranks = false;
  CheckMemory(comm, case_);
  ExitOnError(RegisterLogEvents(&cost_.events));
  ExitOnError(hierarchy_.Create(comm, case_.model, case_.hierarchy, cost_.events, !restart));
  if (restart) {
    ReadCheckpoint(case_, hierarchy_, &state_, &same_ranks);
    if (AtEnd())
      Refuse("-restart {}: must be from before the end of the run; it is at time {}, step {}", Shortened(case_.output.restart),
             FormatNumber(state_.time), state_.step);
    start_step_ = state_.step;
    output_.TakeState();
  } else {
    Budgets budgets;
    WarnAtStart(CheckBodies(hierarchy_, case_));
    CheckIndenter(hierarchy_, case_);
    ExitOnError(hierarchy_.ReduceBudgets(&budgets));
    state_.initial_mass = budgets.mass;
    state_.initial_points = budgets.points;
    state_.initial_created = Case::PointsCreated(budgets);
  }
  clock_.TakeState(hierarchy_);
  if (case_.output.check.empty()) RefuseIf(output_.CheckFolder());
  // A run that goes on as it was keeps the step and the clock of its levels until its next check.
  if (!same_ranks || state_.step_settings != StepSettings()) ControlStep();
  state_.step_settings = StepSettings();
}

/// All between the set-up and the first step.
void Simulation::Begin()
{
  constexpr double kBytesPerPoint = 400, kSlowDisk = 100e6; // size: of a point in a checkpoint; of a slow disk in a second
  RefuseIf(output_.PrepareFolder());
  ListenToOrders();
  cost_.begin = MPI_Wtime();
  FailIf(output_.Begin(at_start_));
  wall_.RecordWriting(state_.initial_points * kBytesPerPoint / kSlowDisk); // until one has been written
  wall_.StartLooking();
}

/// A step of level 0, with those of the finer levels.
void Simulation::Step()
{
  const double begin = MPI_Wtime();
  hierarchy_.MeasureNoise(output_.IsRowDue(state_.step + 1, state_.Schedule() + state_.time_step));
  ExitOnError(hierarchy_.Advance(clock_.Step(state_.time, state_.time_step)));
  cost_.level_seconds += MPI_Wtime() - begin;
  for (int l = 0; l < hierarchy_.Levels(); ++l)
    cost_.point_steps += hierarchy_.At(l).PointStore().Count() * std::pow(case_.hierarchy.ratio, l);
  state_.time += state_.time_step;
  ++state_.step;
  if (AtEnd() && std::isfinite(case_.time.end_time) && case_.time.max_steps == 0)
    state_.time = case_.time.end_time + state_.test.delay;
}

void Simulation::WriteFrameDue()
{
  if (!output_.IsFrameDue()) return;
  FailIf(output_.WriteRows());
  CheckFailure();
  FailIf(FindBadPoints(case_, hierarchy_, state_.time));
  FailIf(output_.WriteFrame());
}

/// A line about a level that has moved, ended or begun.
static std::string Describe(const LevelMove &move, int dim)
{
  return Format("step {}  level {}{}, {} points split, {} merged", FormatNumber(move.step), FormatNumber(move.level),
                move.active ? Format(": box from {} to {}", FormatVector(move.box.lower, dim), FormatVector(move.box.upper, dim))
                            : " ends",
                FormatNumber(move.split), FormatNumber(move.merged));
}

/// Moves the boxes of levels where that is due, and prints what has changed.
void Simulation::FollowBoxes()
{
  const FollowSettings &follow = case_.hierarchy.follow;
  const std::size_t before = state_.moves.size();
  std::string problem;
  if (follow.kind == FollowKind::kNone || state_.step % follow.interval != 0) return;
  CheckFailure(); // points that have failed may be anywhere
  FailOrRefuseIf(WrongPace(case_, hierarchy_, state_.time, NextCheck()));
  ExitOnError(hierarchy_.Follow(static_cast<double>(state_.step), state_.time, NextCheck(), &state_.moves, &problem));
  if (!problem.empty()) Fail(Format("time {}: {}", state_.time, problem));
  for (std::size_t k = before; k < state_.moves.size() && case_.output.monitor; ++k)
    ExitOnError(
        PetscPrintf(hierarchy_.Comm(), "%s%s\n", k == before ? "\n" : "", Describe(state_.moves[k], case_.Dim()).c_str()));
}

/// Looks at the speeds on all ranks, and sets the step until the next look.
void Simulation::ControlStep()
{
  SpeedCheck speeds;
  const bool begun = state_.step > start_step_;
  ExitOnError(hierarchy_.CheckSpeeds(&speeds));
  if (speeds.failed) return;
  const double now = state_.Schedule(), speed = FastestSignal(case_, now, speeds);
  FailOrRefuseIf(WrongStep(case_, now, speed, begun));
  // A restart goes on with the speed and the step of its run's last check, so that its steps are the same.
  if (state_.wave_speed == 0 || begun) state_.wave_speed = speed;
  if (begun || state_.step_settings != StepSettings()) state_.time_step = StepLength(case_, now, state_.wave_speed);
  ExitOnError(hierarchy_.Adapt(speeds, state_.time, state_.time_step, 2 * kControlInterval));
  CheckFailure(); // points that have failed may be anywhere
  FailOrRefuseIf(WrongPace(case_, hierarchy_, state_.time, NextCheck()));
}

/// All that is looked at and set every kControlInterval steps.
void Simulation::Control()
{
  ControlStep();
  clock_.Check(hierarchy_, state_.time, state_.time_step);
}

void Simulation::WriteDue()
{
  if (output_.IsRowDue(state_.step, state_.Schedule())) output_.KeepRow();
  if (state_.step % kControlInterval == 0 || AtEnd() || output_.IsCheckpointDue()) {
    FailIf(output_.WriteRows());
    CheckFailure();
  }
  if (output_.IsCheckpointDue()) WriteState();
}

void Simulation::WriteState()
{
  FailIf(FindBadPoints(case_, hierarchy_, state_.time));
  const double begin = MPI_Wtime();
  FailIf(output_.WriteCheckpoint());
  wall_.RecordWriting(MPI_Wtime() - begin);
}

/// Writes a checkpoint where a signal on any rank or the clock asks for one, and stops where they ask for that. A signal comes to
/// the ranks at different steps, so that one to write counts once in two checks.
void Simulation::ObeyOrders()
{
  constexpr int kTimeIsShort = 4; // size: beside those of signals
  static_assert(kTimeIsShort > kWriteOrder + kEndOrder);
  const long last = output_.CheckpointStep();
  int orders = TakeOrders() | (wall_.IsShort() ? kTimeIsShort : 0);
  MPI_Allreduce(MPI_IN_PLACE, &orders, 1, MPI_INT, MPI_BOR, hierarchy_.Comm());
  const bool is_written = last >= 0 && state_.step <= last + kControlInterval;
  if (orders == 0 || (orders == kWriteOrder && is_written)) return;
  if (last != state_.step) WriteState();
  if (orders & kEndOrder) stop_signal_ = SIGTERM;
  if (orders > kWriteOrder)
    stopped_ = Format("{} at step {}; go on with -restart {}",
                      stop_signal_ ? "SIGTERM" : Format("-max_wall_time {}", FormatNumber(case_.time.max_wall_time)), state_.step,
                      CheckpointPath(case_.output.directory, state_.step));
}

/// One line: of a signal as of all that end a run, of the clock as of an end that was wanted.
void Simulation::ReportStop() const
{
  const std::string line = OneLine(Format("ended by {}", stopped_));
  if (RankIn(hierarchy_.Comm()) == 0)
    std::fprintf(stop_signal_ ? stderr : stdout, "mlgimp: %s%s\n", stop_signal_ ? "error: " : "", line.c_str());
}

void Simulation::Fail(const std::string &message) { Refuse("{}; {}", message, output_.EndFailed(message)); }

void Simulation::FailOrRefuseIf(const std::string &problem)
{
  if (state_.step == start_step_) RefuseIf(problem);
  FailIf(problem);
}

} // namespace mlgimp
