// What a run writes, and when: rows of the history, frames, checkpoints, the progress line, and the summary, at the start, with
// each frame and at the end.
#pragma once

#include "program/output/frames.hpp"
#include "program/output/output_folder.hpp"
#include "program/run/summary.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Functions that write return nothing, or why that failed, the same on every rank; they are collective.
class RunOutput
{
public:
  /// All are kept by reference and must outlive the output.
  RunOutput(const Case &settings, Hierarchy &hierarchy, RunState &state, const RunCost &cost)
      : case_(settings), hierarchy_(hierarchy), state_(state), cost_(cost), folder_(settings.output),
        frames_(settings.output.directory, settings.model, settings.output.single_precision), rows_(settings, hierarchy, state)
  {
  }

  /// Whether results may go into the folder, without changing anything.
  std::string CheckFolder() { return folder_.Check(hierarchy_.Comm()); }
  /// Claims and clears the folder, and starts the files that grow.
  std::string PrepareFolder();
  /// Prints warnings that are known before the first step; writes the row and the frame of the start, if the run has one,
  /// and the summary.
  std::string Begin(const std::vector<std::string> &warnings);

  /// What the last step asks for.
  bool IsFrameDue() const { return FrameNow() > state_.frames; }
  bool IsCheckpointDue() const;
  bool IsRowDue(long step, double schedule) const { return rows_.IsDue(step, schedule); }
  void KeepRow() { rows_.Keep(); }
  std::string WriteRows();
  std::string WriteFrame();
  std::string WriteCheckpoint();
  /// Of the last checkpoint; -1 for none.
  long CheckpointStep() const { return last_checkpoint_; }
  void TakeState() { rows_.TakeState(); }
  /// last: the line is not written over any more.
  void ShowProgress(bool last);

  /// Completes the series of frames, and writes the summary.
  std::string Finish(const std::string &status);
  /// Writes all that a run which fails leaves, as far as that can be; returns what is there, as the end of an error message.
  std::string EndFailed(const std::string &message);

private:
  int FramesDue() const;
  int FrameNow() const { return frames_before_ + FramesDue(); }
  double Done() const { return case_.time.Done(state_.step, state_.Schedule()); }
  std::string FindKept() const;
  std::string WriteSummarySoFar();

  const Case &case_;
  Hierarchy &hierarchy_;
  RunState &state_;
  const RunCost &cost_;
  OutputFolder folder_;
  FrameWriter frames_;
  RowWriter rows_;
  long last_checkpoint_ = -1;
  int frames_before_ = 0; ///< more than FramesDue() at the start: a restart with another end, or number of frames, counts on
  double start_progress_ = 0, last_shown_ = 0;
  std::size_t shown_ = 0; ///< characters of the progress line
};

} // namespace mlgimp
