// The loop over level-0 steps.
#include "program/run/simulation.hpp"

#include "program/advice/memory.hpp"
#include "program/advice/start_checks.hpp"
#include "program/checkpoint/checks.hpp"
#include "program/system/agree.hpp"
#include "program/system/signals.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <unistd.h>

namespace mlgimp
{

void Simulation::SetUp(MPI_Comm comm)
{
  const bool restart = !case_.output.restart.empty();
  bool same_ranks = false;
  comm_ = comm;
  CheckMemory(comm, case_);
  ExitOnError(RegisterLogEvents(&events_));
  ExitOnError(hierarchy_.Create(comm, case_.model, case_.hierarchy, events_, !restart));
  if (restart) {
    ReadCheckpoint(case_, hierarchy_, &state_, &same_ranks);
    if (AtEnd())
      Refuse("-restart {}: must be from before the end of the run; it is at time {}, step {}", Shortened(case_.output.restart),
             FormatNumber(state_.time), state_.step);
    start_step_ = state_.step;
    watch_.SetState(state_.quasi_static);
    warnings_.SetState(state_.watched, state_.warnings);
  } else {
    WarnAtStart(CheckBodies(hierarchy_, case_));
    CheckIndenter(hierarchy_, case_);
    ExitOnError(hierarchy_.ReduceBudgets(&budgets_));
    state_.initial_mass = budgets_.mass;
    state_.initial_points = budgets_.points;
    state_.initial_created = Case::PointsCreated(budgets_);
  }
  if (const std::string problem = folder_.Check(comm); !problem.empty()) Refuse(problem);
  // A run that goes on as it was keeps the step and the clock of its levels until its next check.
  if (!same_ranks || state_.step_settings != StepSettings()) ControlStep();
  state_.step_settings = StepSettings();
}

void Simulation::PrepareOutputFolder()
{
  const auto check = [](const std::string &problem) {
    if (!problem.empty()) Refuse(problem);
  };
  check(folder_.Claim(comm_));
  if (!folder_.Warning().empty()) WarnAtStart({folder_.Warning()});
  const bool goes_on = folder_.GoesOn();
  if (goes_on) last_checkpoint_ = state_.step;
  if (goes_on) check(frames_.Resume(comm_, state_.frames)); // the series, before frames go that it may name
  check(folder_.Clear(comm_, state_.step, frames_.Last()));
  check(history_.Open(comm_, case_.output.directory, case_.model.geometry, case_.quasi_static.on, goes_on ? state_.step : -1));
}

bool Simulation::IsEnd(long step, double now) const
{
  const TimeSettings &time = case_.time;
  return (time.max_steps > 0 && step >= time.max_steps) || now >= time.end_time * (1 - 1e-12);
}

bool Simulation::IsRowDue(long step, double now) const { return step % case_.output.history_interval == 0 || IsEnd(step, now); }

double Simulation::Done() const
{
  const TimeSettings &time = case_.time;
  const double by_steps = time.max_steps > 0 ? static_cast<double>(state_.step) / time.max_steps : 0;
  return AtEnd() ? 1 : std::max(by_steps, state_.time / time.end_time);
}

/// What a step must be a fraction of: the time that the fastest signal takes through a cell, or that of the damping, which
/// the nodal update takes explicitly.
double Simulation::TimeScale(double speed) const
{
  const double damping = case_.model.nodal.damping, crossing = case_.cell_size / speed;
  return damping > 0 ? std::min(crossing, 1 / damping) : crossing;
}

/// The user's step or that of the CFL number, shortened so that a whole number of steps leads to the end.
double Simulation::StepLength(double speed) const
{
  const TimeSettings &time = case_.time;
  const double longest = time.time_step > 0 ? time.time_step : time.cfl * TimeScale(speed);
  const double left = time.end_time - state_.time;
  return std::isfinite(left) ? left / std::max(1.0, std::ceil(left / longest - 1e-6)) : longest;
}

/// The fastest signal: waves, or points and the indenter that come toward each other.
double Simulation::FastestSignal(const SpeedCheck &speeds) const
{
  if (!case_.model.indenter) return speeds.wave_speed;
  const double soon = state_.time + 2 * kControlInterval * StepLength(speeds.wave_speed);
  return std::max(speeds.wave_speed, speeds.point_speed + case_.model.indenter->Fastest(state_.time, soon));
}

/// Ends the run, before its first step as one with wrong input.
void Simulation::FailOrRefuse(const std::string &message)
{
  if (state_.step == start_step_) Refuse(message);
  Fail(message);
}

/// Ends the run where its steps are too long to be stable, or too short to lead anywhere.
void Simulation::CheckStep(double speed)
{
  const TimeSettings &time = case_.time;
  const double scale = TimeScale(speed), limit = kLargestCfl * scale, step = StepLength(speed),
               left = time.end_time - state_.time;
  const bool by_damping = scale < case_.cell_size / speed;
  const std::string end = "-end_time " + FormatNumber(time.end_time);
  constexpr double kMaxSteps = 1e15; // size: far fewer than a double counts, far more than a machine makes
  if (time.time_step > limit)
    FailOrRefuse(Format("-time_step {}: must be <= {}{}{}", FormatNumber(time.time_step), limit,
                        by_damping ? ", the inverse of -damping" : ", the cell size over the wave speed or the indenter's",
                        state_.step > start_step_ ? " by now" : ""));
  if (!(state_.time + step > state_.time) || (std::isfinite(left) && !(left < kMaxSteps * step)))
    FailOrRefuse(Format("{}; a step is {} s at time {} s, with a speed of {} m/s",
                        time.time_step > 0 ? Format("-time_step {}: must bring {} in reach", FormatNumber(time.time_step), end)
                                           : end + ": must be in reach",
                        step, state_.time, speed));
}

/// A line about a level that has moved, ended or begun.
static std::string Describe(const LevelMove &move, int dim)
{
  return Format("step {}  level {}{}, {} points split, {} merged", FormatNumber(move.step), FormatNumber(move.level),
                move.active ? Format(": box from {} to {}", FormatVector(move.box.lower, dim), FormatVector(move.box.upper, dim))
                            : " ends",
                FormatNumber(move.split), FormatNumber(move.merged));
}

void Simulation::ControlStep()
{
  SpeedCheck speeds;
  ExitOnError(hierarchy_.CheckSpeeds(&speeds));
  if (speeds.failed) return;
  const double speed = FastestSignal(speeds);
  CheckStep(speed);
  // A restart goes on with the speed of its run's last check, so that its steps are the same.
  if (state_.wave_speed == 0 || state_.step > start_step_) state_.wave_speed = speed;
  state_.time_step = StepLength(state_.wave_speed);
  ExitOnError(hierarchy_.Adapt(speeds, state_.time, state_.time_step, 2 * kControlInterval));
  CheckFailure(); // points that have failed may be anywhere
  CheckPace();
}

/// Ends the run where the tip would leave the finest level's box before boxes are checked again.
void Simulation::CheckPace()
{
  const FollowSettings &follow = case_.hierarchy.follow;
  if (follow.kind != FollowKind::kContact) return;
  const int finest = hierarchy_.Boxes().State().plan.active - 1;
  const double room = case_.hierarchy.rules.Border(finest), soon = NextCheck();
  const double distance = Norm(hierarchy_.Tip().At(soon) - hierarchy_.Tip().At(state_.time));
  if (finest > 0 && distance > room)
    FailOrRefuse(
        Format("-level_follow contact: the tip goes {} m until boxes are checked again, by time {} s, more than the {} m that "
               "level {} keeps free around the contact; try a slower indenter, fewer -levels or a smaller -regrid_interval",
               distance, soon, room, finest));
}

int Simulation::Run()
{
  Begin();
  while (!AtEnd() && stopped_.empty()) {
    Step();
    WriteFrameDue(); // with the levels, and the pressures of contact on them, that the step had
    if (!AtEnd()) FollowBoxes();
    if (state_.step % kControlInterval == 0 && !AtEnd()) ControlStep();
    WriteDue();
    ShowProgress(false);
    if (state_.step % kControlInterval == 0 && !AtEnd()) ObeyOrders();
  }
  ShowProgress(true);
  CheckWritten(frames_.Finish(comm_));
  CheckWritten(WriteSummary(stopped_.empty() ? "completed" : "stopped: " + stopped_));
  if (stopped_.empty())
    ExitOnError(hierarchy_.View(state_.time));
  else
    ReportStop();
  return stop_signal_;
}

/// All between the set-up and the first step.
void Simulation::Begin()
{
  constexpr double kBytesPerPoint = 400, kSlowDisk = 100e6; // size: of a point in a checkpoint; of a slow disk in a second
  PrepareOutputFolder();
  ListenToOrders();
  if (case_.model.indenter && case_.model.contact.method == "point_pressure")
    WarnAtStart({"-contact point_pressure: is rank deficient, its diagonal is raised by 1 %; single pressures mean little and "
                 "contact comes late"});
  warnings_.Issue(comm_, at_start_);
  for (const std::string &line : case_.quasi_static.lines) ExitOnError(PetscPrintf(comm_, "%s\n", line.c_str()));
  start_wall_ = last_shown_ = MPI_Wtime();
  start_progress_ = Done();
  frames_before_ = state_.frames - FramesDue();
  if (state_.step == 0) {
    RecordRow();
    CheckWritten(WriteRows());
  }
  if (state_.step == 0 && case_.output.frames > 0) CheckWritten(frames_.Write(hierarchy_, 0, state_.time, 0));
  wall_.RecordWriting(state_.initial_points * kBytesPerPoint / kSlowDisk); // until one has been written
  wall_.StartLooking();
}

/// A step of level 0, with those of the finer levels.
void Simulation::Step()
{
  const double begin = MPI_Wtime();
  hierarchy_.MeasureNoise(IsRowDue(state_.step + 1, state_.time + state_.time_step));
  ExitOnError(hierarchy_.Advance({state_.time, state_.time_step}));
  level_seconds_ += MPI_Wtime() - begin;
  for (int l = 0; l < hierarchy_.Levels(); ++l)
    point_steps_ += hierarchy_.At(l).PointStore().Count() * std::pow(case_.hierarchy.ratio, l);
  state_.time += state_.time_step;
  ++state_.step;
  if (AtEnd() && std::isfinite(case_.time.end_time) && case_.time.max_steps == 0) state_.time = case_.time.end_time;
}

/// Writes a checkpoint where a signal on any rank or the clock asks for one, and stops where they ask for that. A signal comes to
/// the ranks at different steps, so that one to write counts once in two checks.
void Simulation::ObeyOrders()
{
  constexpr int kTimeIsShort = 4; // size: beside those of signals
  static_assert(kTimeIsShort > kWriteOrder + kEndOrder);
  int orders = TakeOrders() | (wall_.IsShort() ? kTimeIsShort : 0);
  MPI_Allreduce(MPI_IN_PLACE, &orders, 1, MPI_INT, MPI_BOR, comm_);
  const bool is_written = last_checkpoint_ >= 0 && state_.step <= last_checkpoint_ + kControlInterval;
  if (orders == 0 || (orders == kWriteOrder && is_written)) return;
  if (last_checkpoint_ != state_.step) {
    CheckState();
    WriteState();
  }
  if (orders & kEndOrder) stop_signal_ = SIGTERM;
  if (orders > kWriteOrder)
    stopped_ = Format("{} at step {}; go on with -restart {}",
                      stop_signal_ ? "SIGTERM" : "-max_wall_time " + FormatNumber(case_.time.max_wall_time), state_.step,
                      CheckpointPath(case_.output.directory, state_.step));
}

/// One line: of a signal as of all that end a run, of the clock as of an end that was wanted.
void Simulation::ReportStop()
{
  const std::string line = OneLine("ended by " + stopped_);
  if (stop_signal_ && RankIn(comm_) == 0) std::fprintf(stderr, "mlgimp: error: %s\n", line.c_str());
  if (!stop_signal_) ExitOnError(PetscPrintf(comm_, "mlgimp: %s\n", line.c_str()));
}

/// Moves the boxes of levels where that is due, and prints what has changed.
void Simulation::FollowBoxes()
{
  const FollowSettings &follow = case_.hierarchy.follow;
  const std::size_t before = state_.moves.size();
  std::string problem;
  if (follow.kind == FollowKind::kNone || state_.step % follow.interval != 0) return;
  CheckFailure(); // points that have failed may be anywhere
  CheckPace();
  ExitOnError(hierarchy_.Follow(static_cast<double>(state_.step), state_.time, NextCheck(), &state_.moves, &problem));
  if (!problem.empty()) Fail(Format("time {}: {}", state_.time, problem));
  for (std::size_t k = before; k < state_.moves.size() && case_.output.monitor; ++k)
    ExitOnError(PetscPrintf(comm_, "%s%s\n", k == before ? "\n" : "", Describe(state_.moves[k], case_.Dim()).c_str()));
}

int Simulation::FramesDue() const
{
  const int all = case_.output.frames;
  return AtEnd() ? all : static_cast<int>(std::floor(Done() * all * (1 + 1e-9)));
}

/// Why a tip under load control cannot go on; empty where it can. The same on all ranks.
std::string Simulation::DescribeTip()
{
  constexpr double kMaxOverrun = 0.1; // of the body's height, for which waves take as long as the tip at its largest speed
  if (!case_.model.indenter || !case_.model.indenter->by_load) return "";
  const Indenter &indenter = *case_.model.indenter;
  const double height = hierarchy_.Tip().At(state_.time)[indenter.up], lowest = case_.LowestTip(case_.hierarchy.tip_level);
  const std::string when = Format("time {}: ", state_.time),
                    load = Format("-indenter_loads, {} N by now, ", indenter.by_load->force.Value(state_.time));
  if (hierarchy_.Tip().Overrun() > kMaxOverrun * (indenter.initial_surface - case_.domain.lower[indenter.up]))
    return Format(
        "{}{}are not met although the tip comes down at {} m/s, a tenth of the speed of waves; try smaller or slower ones", when,
        load, indenter.by_load->largest_speed);
  if (height < lowest)
    return Format("{}{}press the tip {} m below {}, to which level {} can hold it; try smaller ones or a larger box", when, load,
                  lowest - height, lowest, case_.hierarchy.tip_level);
  return "";
}

void Simulation::CheckFailure()
{
  std::string problem = hierarchy_.DescribeFailure();
  if (problem.empty()) problem = DescribeTip();
  const std::string message = Agree(comm_, "failure", problem);
  if (!message.empty()) Fail(message);
}

/// Ends the run before it writes a state that no restart could use, although no step has failed yet.
void Simulation::CheckState()
{
  std::string message;
  for (int l = 0; l < hierarchy_.Levels() && message.empty(); ++l) {
    const PointArrays points = hierarchy_.At(l).PointStore().Arrays();
    const std::string wrong = WrongValues(points, static_cast<int>(case_.model.bodies.size()));
    if (!wrong.empty()) message = Format("level {}: {}; try a smaller -cfl or -time_step", l, wrong);
  }
  message = Agree(comm_, "state", message);
  if (!message.empty()) Fail(Format("time {}, {}", state_.time, message));
}

} // namespace mlgimp
