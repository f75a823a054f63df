// Writing of all that a run leaves, and of the progress line.
#include "program/run/run_output.hpp"

#include "program/system/agree.hpp"
#include "program/system/progress.hpp"

#include <algorithm>
#include <cmath>
#include <unistd.h>

namespace mlgimp
{

std::string RunOutput::PrepareFolder()
{
  const MPI_Comm comm = hierarchy_.Comm();
  std::string problem = folder_.Claim(comm);
  const bool goes_on = folder_.GoesOn();
  if (goes_on) last_checkpoint_ = state_.step;
  // The series comes first, before frames go that it may name.
  if (problem.empty() && goes_on) problem = frames_.Resume(comm, state_.frames);
  if (problem.empty()) problem = folder_.Clear(comm, state_.step, frames_.Last());
  return problem.empty() ? rows_.Open(goes_on) : problem;
}

std::string RunOutput::Begin(const std::vector<std::string> &warnings)
{
  rows_.Advice().Issue(hierarchy_.Comm(), warnings);
  if (!folder_.Warning().empty()) rows_.Advice().Issue(hierarchy_.Comm(), {folder_.Warning()});
  for (const std::string &line : case_.notes) ExitOnError(PetscPrintf(hierarchy_.Comm(), "%s\n", line.c_str()));
  last_shown_ = MPI_Wtime();
  start_progress_ = Done();
  frames_before_ = state_.frames - FramesDue();
  std::string problem;
  if (state_.step == 0) {
    KeepRow();
    problem = rows_.Write();
    if (problem.empty() && case_.output.frames > 0) problem = frames_.Write(hierarchy_, 0, state_.time, 0);
  }
  return problem.empty() ? WriteSummarySoFar() : problem;
}

int RunOutput::FramesDue() const
{
  const int all = case_.output.frames;
  return case_.time.IsEnd(state_.step, state_.Schedule()) ? all : static_cast<int>(std::floor(Done() * all * (1 + 1e-9)));
}

bool RunOutput::IsCheckpointDue() const
{
  return case_.output.checkpoint_interval > 0 && state_.step % case_.output.checkpoint_interval == 0;
}

std::string RunOutput::WriteRows()
{
  const LogScope scope(cost_.events.output);
  return rows_.Write();
}

std::string RunOutput::WriteFrame()
{
  const LogScope scope(cost_.events.output);
  state_.frames = FrameNow();
  const std::string problem = frames_.Write(hierarchy_, state_.frames, state_.time, state_.step);
  return problem.empty() ? WriteSummarySoFar() : problem;
}

std::string RunOutput::WriteCheckpoint()
{
  const LogScope scope(cost_.events.output);
  rows_.KeepState();
  std::string problem = mlgimp::WriteCheckpoint(case_.output.directory, case_.identity, hierarchy_, state_);
  if (problem.empty()) last_checkpoint_ = state_.step;
  return problem;
}

/// So that a folder can be read while the run goes on, and after it was killed.
std::string RunOutput::WriteSummarySoFar() { return WriteSummary(case_, hierarchy_, state_, cost_, rows_, "not ended"); }

std::string RunOutput::Finish(const std::string &status)
{
  const std::string problem = frames_.Finish(hierarchy_.Comm());
  return problem.empty() ? WriteSummary(case_, hierarchy_, state_, cost_, rows_, status) : problem;
}

std::string RunOutput::EndFailed(const std::string &message)
{
  rows_.Write();
  frames_.Finish(hierarchy_.Comm());
  WriteSummary(case_, hierarchy_, state_, cost_, rows_, Format("failed: {}", message)); // its errors matter less
  return FindKept();
}

/// The complete files in the output folder. Files that were removed are left out.
std::string RunOutput::FindKept() const
{
  std::vector<std::string> parts;
  const auto is_there = [](const std::string &path) { return access(path.c_str(), F_OK) == 0; };
  const std::string checkpoint = CheckpointPath(case_.output.directory, last_checkpoint_);
  const History &history = rows_.File();
  if (history.Last() >= 0 && history.IsThere()) parts.push_back(Format("history to step {}", history.Last()));
  if (frames_.Last() >= 0 && is_there(frames_.PathOf(frames_.Last()))) parts.push_back(Format("frames to {}", frames_.Last()));
  if (last_checkpoint_ >= 0 && is_there(checkpoint)) parts.push_back(Format("checkpoint {}", last_checkpoint_));
  const std::string last = parts.empty() ? "nothing" : parts.back();
  if (!parts.empty()) parts.pop_back();
  return ShareText(hierarchy_.Comm(),
                   parts.empty() ? Format("{} is kept", last) : Format("{} and {} are kept", Join(parts, ", "), last));
}

void RunOutput::ShowProgress(bool last)
{
  const MPI_Comm comm = hierarchy_.Comm();
  const double now = MPI_Wtime();
  int due = last || now - last_shown_ >= 1; // clocks differ, so the first rank's decides
  if (!case_.output.monitor) return;
  MPI_Bcast(&due, 1, MPI_INT, 0, comm);
  if (!due) return;
  last_shown_ = now;
  const double done = Done() - start_progress_, elapsed = now - cost_.begin;
  const double left = done > 0 ? elapsed * (1 - Done()) / done : 0;
  double points = cost_.point_steps;
  MPI_Allreduce(MPI_IN_PLACE, &points, 1, MPI_DOUBLE, MPI_SUM, comm);
  const auto &indenter = case_.model.indenter;
  const double depth = indenter ? indenter->Depth(hierarchy_.Tip().At(state_.time)) : 0, rate = points / std::max(elapsed, 1e-9);
  const std::size_t columns = TerminalColumns();
  std::string line = ProgressLine({state_.step, state_.time, bool(indenter), depth, rows_.Load(), rate, Done(), left}, columns);
  const std::size_t length = line.size();
  line.resize(std::max(length, std::min(shown_, columns - 1)), ' '); // over what is left of the line before
  shown_ = length;
  ExitOnError(PetscPrintf(comm, "\r%s%s", line.c_str(), last ? "\n" : ""));
}

} // namespace mlgimp
