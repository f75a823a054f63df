// What a run writes on its way: rows of the history, frames, checkpoints and the progress line.
#include "program/run/simulation.hpp"

#include "program/system/agree.hpp"
#include "program/system/progress.hpp"

#include <algorithm>
#include <unistd.h>
#include <utility>

namespace mlgimp
{

void Simulation::WriteFrameDue()
{
  const int frame = frames_before_ + FramesDue();
  if (frame <= state_.frames) return;
  CheckWritten(WriteRows());
  CheckFailure();
  CheckState();
  ExitOnError(PetscLogEventBegin(events_.output, 0, 0, 0, 0));
  state_.frames = frame;
  CheckWritten(frames_.Write(hierarchy_, frame, state_.time, state_.step));
  ExitOnError(PetscLogEventEnd(events_.output, 0, 0, 0, 0));
}

void Simulation::WriteDue()
{
  const OutputSettings &out = case_.output;
  const bool checkpoint_due = out.checkpoint_interval > 0 && state_.step % out.checkpoint_interval == 0;
  ExitOnError(PetscLogEventBegin(events_.output, 0, 0, 0, 0));
  if (IsRowDue(state_.step, state_.time)) RecordRow();
  if (state_.step % kControlInterval == 0 || AtEnd() || checkpoint_due) {
    CheckWritten(WriteRows());
    CheckFailure();
  }
  if (checkpoint_due) CheckState();
  if (checkpoint_due) WriteState();
  ExitOnError(PetscLogEventEnd(events_.output, 0, 0, 0, 0));
}

/// Ends the run, with what it has written so far.
void Simulation::Fail(const std::string &message)
{
  WriteRows();
  frames_.Finish(comm_);
  WriteSummary("failed: " + message); // an error in writing it is less important than `message`
  Refuse(message + "; " + FindKept());
}

/// Lists the complete files in the output folder, as the end of an error message. Files that were removed are left out.
std::string Simulation::FindKept() const
{
  std::vector<std::string> parts;
  const auto is_there = [](const std::string &path) { return access(path.c_str(), F_OK) == 0; };
  const std::string checkpoint = CheckpointPath(case_.output.directory, last_checkpoint_);
  if (history_.Last() >= 0 && history_.IsThere()) parts.push_back(Format("history to step {}", history_.Last()));
  if (frames_.Last() >= 0 && is_there(frames_.PathOf(frames_.Last()))) parts.push_back(Format("frames to {}", frames_.Last()));
  if (last_checkpoint_ >= 0 && is_there(checkpoint)) parts.push_back(Format("checkpoint {}", last_checkpoint_));
  const std::string last = parts.empty() ? "nothing" : parts.back();
  if (!parts.empty()) parts.pop_back();
  return ShareText(comm_, parts.empty() ? last + " is kept" : Format("{} and {} are kept", Join(parts, ", "), last));
}

void Simulation::WriteState()
{
  state_.quasi_static = watch_.State();
  state_.watched = warnings_.State();
  state_.warnings = warnings_.KeptLines();
  const double begin = MPI_Wtime();
  CheckWritten(WriteCheckpoint(case_.output.directory, case_.identity, hierarchy_, state_));
  wall_.RecordWriting(MPI_Wtime() - begin);
  last_checkpoint_ = state_.step;
}

/// The mean force of tractions from the last row to one at a time: on the body along the indenter's sideways motion, along x
/// without one.
void Simulation::SetFrictionForce(double time)
{
  const auto &indenter = case_.model.indenter;
  const Vec3 impulse = budgets_.friction_impulse, last = state_.friction_at_row;
  const double passed = time - state_.time_at_row;
  if (!indenter) return;
  const Vec3 moved = indenter->Sideways(time) - indenter->Sideways(state_.time_at_row);
  const Vec3 along = Norm(moved) > 0 ? (1 / Norm(moved)) * moved : Vec3{1, 0, 0};
  if (passed > 0) friction_force_ = Dot(impulse - last, along) / passed;
  state_.friction_at_row = impulse;
  budgets_.friction_force = friction_force_;
}

/// Keeps this rank's part of a row until the next check, so that rows need no messages in their steps.
void Simulation::RecordRow()
{
  row_sums_.push_back(hierarchy_.SumBudgets());
  rows_.push_back({state_.step, state_.time, hierarchy_.Tip().At(state_.time)});
}

/// Fills the columns that follow from the sums of all ranks and from the row before.
void Simulation::Complete(const Row &row)
{
  const double passed = row.time - state_.time_at_row, impulse = budgets_.contact_impulse[case_.Dim() - 1];
  if (passed > 0) load_ = -(impulse - state_.impulse_at_row) / passed;
  SetFrictionForce(row.time);
  state_.impulse_at_row = impulse;
  state_.time_at_row = row.time;
  budgets_.time = row.time;
  budgets_.depth = case_.model.indenter ? case_.model.indenter->Depth(row.tip) : 0;
  budgets_.load = load_;
  for (int axis = 0; axis < case_.Dim(); ++axis) budgets_.tip[axis] = row.tip[axis];
  watch_.Record(budgets_);
  warnings_.Check(comm_, case_, budgets_, watch_, IsEnd(row.step, row.time));
}

/// Writes the rows that wait, up to the first step in which something has failed. Returns as History::Write.
std::string Simulation::WriteRows()
{
  const std::vector<Row> rows = std::exchange(rows_, {}); // where writing fails, Fail comes here again
  std::vector<Budgets> sums = std::exchange(row_sums_, {});
  if (rows.empty()) return "";
  ExitOnError(AddRanks(comm_, &sums));
  for (std::size_t k = 0; k < rows.size() && sums[k].failed == 0; ++k) {
    budgets_ = sums[k];
    Complete(rows[k]);
    history_.Add(rows[k].step, budgets_);
  }
  return history_.Write();
}

void Simulation::ShowProgress(bool last)
{
  if (!case_.output.monitor) return;
  const double now = MPI_Wtime();
  int due = last || now - last_shown_ >= 1; // clocks differ, so the first rank's decides
  MPI_Bcast(&due, 1, MPI_INT, 0, comm_);
  if (!due) return;
  last_shown_ = now;
  const double done = Done() - start_progress_, elapsed = now - start_wall_;
  const double left = done > 0 ? elapsed * (1 - Done()) / done : 0;
  double points = point_steps_;
  MPI_Allreduce(MPI_IN_PLACE, &points, 1, MPI_DOUBLE, MPI_SUM, comm_);
  const auto &indenter = case_.model.indenter;
  const double depth = indenter ? indenter->Depth(hierarchy_.Tip().At(state_.time)) : 0, rate = points / std::max(elapsed, 1e-9);
  const std::size_t columns = TerminalColumns();
  std::string line = ProgressLine({state_.step, state_.time, bool(indenter), depth, load_, rate, Done(), left}, columns);
  const std::size_t length = line.size();
  line.resize(std::max(length, std::min(shown_, columns - 1)), ' '); // over what is left of the line before
  shown_ = length;
  ExitOnError(PetscPrintf(comm_, "\r%s%s", line.c_str(), last ? "\n" : ""));
}

} // namespace mlgimp
