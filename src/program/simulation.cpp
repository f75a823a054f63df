// The loop over level-0 steps.
#include "program/simulation.hpp"

#include "program/agree.hpp"
#include "program/checkpoint_checks.hpp"
#include "program/memory.hpp"
#include "program/summary.hpp"

#include <algorithm>
#include <cmath>
#include <unistd.h>

namespace mlgimp
{

static constexpr int kControlInterval = 10; ///< steps between looks at the wave speed, the balance and failures

PetscErrorCode Simulation::SetUp(MPI_Comm comm)
{
  const bool restart = !case_.output.restart.empty();
  bool same_ranks = false;
  std::string problem;
  PetscFunctionBeginUser;
  comm_ = comm;
  PetscCall(CheckMemory(comm, case_));
  PetscCall(RegisterLogEvents(&events_));
  PetscCall(hierarchy_.Create(comm, case_.model, case_.hierarchy, events_, !restart));
  if (restart) {
    PetscCall(ReadCheckpoint(case_, hierarchy_, &state_, &same_ranks));
    if (AtEnd())
      PetscCall(Refuse(comm, "-restart " + Shortened(case_.output.restart) +
                                 ": must be from before the end of the run; it is at time " + FormatNumber(state_.time) +
                                 ", step " + std::to_string(state_.step)));
    hierarchy_.At(0).Contacts().penetration = state_.penetration;
    start_step_ = state_.step;
  } else {
    PetscCall(CheckBodies());
    PetscCall(CheckIndenter());
    PetscCall(hierarchy_.ReduceBooks(&books_));
    state_.initial_mass = books_.mass;
    state_.initial_points = books_.points;
    state_.initial_created = books_.points_split * (std::pow(case_.hierarchy.ratio, 2) - 1);
  }
  PetscCall(folder_.Check(comm, &problem));
  if (!problem.empty()) PetscCall(Refuse(comm, problem));
  // A run that goes on as it was keeps the step and the pace of its levels until it would have looked at them.
  if (!same_ranks || state_.step_settings != StepSettings()) PetscCall(ControlStep());
  state_.step_settings = StepSettings();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::CheckBodies()
{
  const Model &model = case_.model;
  std::vector<double> points(model.bodies.size(), 0.0), faces(model.loads.size(), 0.0);
  PetscFunctionBeginUser;
  for (int l = 0; l < hierarchy_.Levels(); ++l) {
    PointArrays a;
    PetscCall(hierarchy_.At(l).PointStore().Arrays(&a));
    for (int p = 0; p < a.count; ++p) {
      ++points[a.body[p]];
      for (std::size_t k = 0; k < faces.size(); ++k) faces[k] += (a.faces[p] & LoadBit(static_cast<int>(k))) != 0;
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, points.data(), static_cast<int>(points.size()), MPI_DOUBLE, MPI_SUM, comm_));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, faces.data(), static_cast<int>(faces.size()), MPI_DOUBLE, MPI_SUM, comm_));
  for (std::size_t b = 0; b < points.size(); ++b)
    PetscCheck(points[b] > 0, comm_, PETSC_ERR_USER_INPUT,
               "-bodies %s: must hold at least one material point; it is too small for -cell_size %s",
               model.bodies[b].name.c_str(), FormatNumber(case_.cell_size).c_str());
  for (std::size_t k = 0; k < faces.size(); ++k)
    PetscCheck(faces[k] > 0, comm_, PETSC_ERR_USER_INPUT, "-loads %s: must cover a free face of body %s; see its side and span",
               case_.load_names[k].c_str(), model.bodies[model.loads[k].body].name.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::CheckIndenter()
{
  double deepest = 0;
  PetscFunctionBeginUser;
  if (!case_.model.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  for (int l = 0; l < hierarchy_.Levels(); ++l) {
    PointArrays a;
    const std::vector<int> *surface = nullptr;
    PetscCall(hierarchy_.At(l).PointStore().Arrays(&a));
    PetscCall(hierarchy_.At(l).PointStore().SurfacePoints(&surface));
    for (int p : *surface)
      for (int corner = 0; corner < 4; ++corner) {
        const Vec2 x = {a.position[2 * p] + (corner % 2 ? 1 : -1) * a.half_size[2 * p],
                        a.position[2 * p + 1] + (corner / 2 ? 1 : -1) * a.half_size[2 * p + 1]};
        deepest = std::max(deepest, -case_.model.indenter->Gap(x, 0).distance);
      }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, comm_));
  const Vec2 tip = case_.model.indenter->tip;
  PetscCheck(deepest <= 1e-6 * case_.cell_size, comm_, PETSC_ERR_USER_INPUT,
             "-indenter_tip %s: must leave the indenter outside every body; it starts %s m inside one", FormatVector(tip).c_str(),
             FormatRounded(deepest).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::PrepareOutputFolder()
{
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(folder_.Claim(comm_, &problem));
  const bool goes_on = problem.empty() && folder_.GoesOn();
  if (goes_on) last_checkpoint_ = state_.step;
  if (goes_on) PetscCall(frames_.Resume(comm_, state_.frames, &problem)); // the series, before frames go that it may name
  if (problem.empty()) PetscCall(folder_.Clear(comm_, state_.step, frames_.Last(), &problem));
  if (problem.empty()) PetscCall(history_.Open(comm_, case_.output.directory, goes_on ? state_.step : -1, &problem));
  if (!problem.empty()) PetscCall(Refuse(comm_, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool Simulation::AtEnd() const
{
  const TimeSettings &time = case_.time;
  return (time.max_steps > 0 && state_.step >= time.max_steps) || state_.time >= time.end_time * (1 - 1e-12);
}

double Simulation::Progress() const
{
  const TimeSettings &time = case_.time;
  const double by_steps = time.max_steps > 0 ? static_cast<double>(state_.step) / time.max_steps : 0;
  return AtEnd() ? 1 : std::max(by_steps, state_.time / time.end_time);
}

/// The user's step or that of the CFL number, shortened so that a whole number of steps leads to the end.
double Simulation::StepLength(double wave_speed) const
{
  const TimeSettings &time = case_.time;
  const double longest = time.time_step > 0 ? time.time_step : time.cfl * case_.cell_size / wave_speed;
  const double left = time.end_time - state_.time;
  return std::isfinite(left) ? left / std::max(1.0, std::ceil(left / longest - 1e-6)) : longest;
}

PetscErrorCode Simulation::ControlStep()
{
  Pulse pulse;
  PetscFunctionBeginUser;
  PetscCall(hierarchy_.MeasurePulse(state_.time, &pulse));
  if (pulse.failed) PetscFunctionReturn(PETSC_SUCCESS);
  const double limit = kLargestCfl * case_.cell_size / pulse.wave_speed;
  if (case_.time.time_step > limit) {
    const std::string message = "-time_step " + FormatNumber(case_.time.time_step) + ": must be <= " + FormatRounded(limit) +
                                ", the cell size over the wave speed" + (state_.step > start_step_ ? " by now" : "");
    PetscCheck(state_.step > start_step_, comm_, PETSC_ERR_USER_INPUT, "%s", message.c_str());
    PetscCall(Fail(message));
  }
  // A restart goes on with the wave speed that its run last looked at, so that its steps are the same.
  if (state_.wave_speed == 0 || state_.step > start_step_) state_.wave_speed = pulse.wave_speed;
  state_.time_step = StepLength(state_.wave_speed);
  PetscCall(hierarchy_.Adapt(pulse, state_.time, state_.time_step, 2 * kControlInterval));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::Run()
{
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(PrepareOutputFolder());
  if (case_.model.indenter && case_.model.contact == "point_pressure")
    PetscCall(PetscFPrintf(comm_, PETSC_STDERR,
                           "mlgimp: warning: -contact point_pressure: is rank deficient, its diagonal is raised by "
                           "1 %%; single pressures mean little and contact comes late\n"));
  start_wall_ = last_shown_ = MPI_Wtime();
  start_progress_ = Progress();
  if (state_.step == 0) PetscCall(WriteHistoryRow());
  while (!AtEnd()) {
    const double begin = MPI_Wtime();
    PetscCall(hierarchy_.Advance(state_.time, state_.time_step));
    level_seconds_ += MPI_Wtime() - begin;
    for (int l = 0; l < hierarchy_.Levels(); ++l)
      point_steps_ += hierarchy_.At(l).PointStore().Count() * std::pow(case_.hierarchy.ratio, l);
    state_.time += state_.time_step;
    ++state_.step;
    if (AtEnd() && std::isfinite(case_.time.end_time) && case_.time.max_steps == 0) state_.time = case_.time.end_time;
    if (state_.step % kControlInterval == 0 && !AtEnd()) PetscCall(ControlStep());
    PetscCall(WriteDue());
    PetscCall(ShowProgress(false));
  }
  PetscCall(ShowProgress(true));
  PetscCall(WriteSummary("completed", &problem));
  PetscCall(CheckWritten(problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::WriteDue()
{
  const OutputSettings &out = case_.output;
  const bool last = AtEnd();
  const int frame = last ? out.frames : static_cast<int>(std::floor(Progress() * out.frames * (1 + 1e-9)));
  const bool row_due = state_.step % out.history_interval == 0 || last, frame_due = frame > state_.frames;
  const bool checkpoint_due = out.checkpoint_interval > 0 && state_.step % out.checkpoint_interval == 0;
  std::string problem;
  PetscFunctionBeginUser;
  if (state_.step % kControlInterval == 0 || row_due || frame_due || checkpoint_due) PetscCall(SettleFailure());
  if (frame_due || checkpoint_due) PetscCall(SettleState());
  PetscCall(PetscLogEventBegin(events_.output, 0, 0, 0, 0));
  if (row_due) PetscCall(WriteHistoryRow());
  if (frame_due) {
    state_.frames = frame;
    PetscCall(frames_.Write(hierarchy_, frame, state_.time, state_.step, &problem));
    PetscCall(CheckWritten(problem));
  }
  if (checkpoint_due) PetscCall(WriteState());
  PetscCall(PetscLogEventEnd(events_.output, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::SettleFailure()
{
  std::string message;
  PetscFunctionBeginUser;
  PetscCall(hierarchy_.DescribeFailure(&message));
  if (!message.empty()) PetscCall(Fail(message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the run before a state is written that nothing can go on from, although no step has failed by it yet.
PetscErrorCode Simulation::SettleState()
{
  std::string message;
  PetscFunctionBeginUser;
  for (int l = 0; l < hierarchy_.Levels() && message.empty(); ++l) {
    PointArrays points;
    PetscCall(hierarchy_.At(l).PointStore().Arrays(&points));
    const std::string wrong = WrongValues(points, static_cast<int>(case_.model.bodies.size()));
    if (!wrong.empty()) message = "level " + std::to_string(l) + ": " + wrong + "; try a smaller -cfl or -time_step";
  }
  PetscCall(Agree(comm_, "state", &message));
  if (!message.empty()) PetscCall(Fail("time " + FormatRounded(state_.time) + ", " + message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the run, with what it has written so far.
PetscErrorCode Simulation::Fail(const std::string &message)
{
  std::string problem, kept; // of the summary, which is less than what is told here
  PetscFunctionBeginUser;
  PetscCall(WriteSummary("failed: " + message, &problem));
  PetscCall(FindKept(&kept));
  PetscCall(Refuse(comm_, message + "; " + kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the output folder holds whole, as the end of a sentence; what somebody has removed is not told.
PetscErrorCode Simulation::FindKept(std::string *text)
{
  std::vector<std::string> parts;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  if (rank == 0) {
    const auto is_there = [](const std::string &path) { return access(path.c_str(), F_OK) == 0; };
    const std::string checkpoint = CheckpointPath(case_.output.directory, last_checkpoint_);
    if (history_.Last() >= 0 && history_.IsThere()) parts.push_back("history to step " + std::to_string(history_.Last()));
    if (frames_.Last() > 0 && is_there(frames_.PathOf(frames_.Last())))
      parts.push_back("frames to " + std::to_string(frames_.Last()));
    if (last_checkpoint_ >= 0 && is_there(checkpoint)) parts.push_back("checkpoint " + std::to_string(last_checkpoint_));
    const std::string last = parts.empty() ? "nothing" : parts.back();
    if (!parts.empty()) parts.pop_back();
    *text = parts.empty() ? last + " is kept" : Join(parts, ", ") + " and " + last + " are kept";
  }
  PetscCall(ShareText(comm_, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the run where something could not be written.
PetscErrorCode Simulation::CheckWritten(const std::string &problem)
{
  PetscFunctionBeginUser;
  if (!problem.empty()) PetscCall(Fail(problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What contact reports as largest values, over levels and ranks.
PetscErrorCode Simulation::LargestContact(HistoryRow *row)
{
  double largest[3] = {};
  PetscFunctionBeginUser;
  for (int l = 0; l < hierarchy_.Levels(); ++l) {
    const ContactTotals &contact = hierarchy_.At(l).Contacts();
    largest[0] = std::max(largest[0], contact.last.half_width);
    largest[1] = std::max(largest[1], contact.penetration);
    largest[2] = std::max(largest[2], contact.last.peak_pressure);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPI_DOUBLE, MPI_MAX, comm_));
  row->half_width = largest[0];
  row->penetration = largest[1];
  row->peak_pressure = largest[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::WriteState()
{
  HistoryRow row{};
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(LargestContact(&row));
  state_.penetration = row.penetration;
  PetscCall(WriteCheckpoint(case_.output.directory, case_.identity, hierarchy_, state_, &problem));
  PetscCall(CheckWritten(problem));
  last_checkpoint_ = state_.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::WriteHistoryRow()
{
  const auto &indenter = case_.model.indenter;
  HistoryRow row{};
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(hierarchy_.ReduceBooks(&books_));
  const double passed = state_.time - state_.time_at_row;
  if (passed > 0) load_ = -(books_.contact_impulse[1] - state_.impulse_at_row) / passed;
  state_.impulse_at_row = books_.contact_impulse[1];
  state_.time_at_row = state_.time;
  row.step = state_.step;
  row.time = state_.time;
  row.depth = indenter ? indenter->Depth(state_.time) : 0;
  row.load = load_;
  row.books = books_;
  PetscCall(LargestContact(&row));
  PetscCall(history_.Write(row, &problem));
  PetscCall(CheckWritten(problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::ShowProgress(bool last)
{
  PetscFunctionBeginUser;
  if (!case_.output.monitor) PetscFunctionReturn(PETSC_SUCCESS);
  const double now = MPI_Wtime();
  int due = last || now - last_shown_ >= 1; // clocks differ, so the first rank's decides
  PetscCallMPI(MPI_Bcast(&due, 1, MPI_INT, 0, comm_));
  if (!due) PetscFunctionReturn(PETSC_SUCCESS);
  last_shown_ = now;
  const double done = Progress() - start_progress_, elapsed = now - start_wall_;
  const double left = done > 0 ? elapsed * (1 - Progress()) / done : 0;
  double points = point_steps_;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &points, 1, MPI_DOUBLE, MPI_SUM, comm_));
  const double depth = case_.model.indenter ? case_.model.indenter->Depth(state_.time) : 0;
  PetscCall(PetscPrintf(comm_, "\rstep %ld  time %.4e s  depth %.4e m  load %.4e N  %.2e points/s  %3.0f %%  %.0f s left   %s",
                        state_.step, state_.time, depth, load_, points / std::max(elapsed, 1e-9), 100 * Progress(), left,
                        last ? "\n" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Simulation::WriteSummary(const std::string &status, std::string *problem)
{
  SummaryInput input{status,
                     case_,
                     state_,
                     hierarchy_,
                     MPI_Wtime() - start_wall_,
                     level_seconds_,
                     point_steps_,
                     events_,
                     state_.step - start_step_};
  PetscFunctionBeginUser;
  PetscCall(mlgimp::WriteSummary(input, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
