// Frames of points for pictures and other tools: points_FFFFFF.h5 and the time series points.xdmf.
#pragma once

#include "hierarchy/hierarchy.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class FrameWriter
{
public:
  FrameWriter(std::string directory, const Model &model) : directory_(std::move(directory)), model_(model) {}

  /// Finds the frames up to number `written` that an interrupted run left, so that the series goes on.
  /// Returns nothing, or what could not be written; here and below.
  std::string Resume(MPI_Comm comm, int written);
  /// Writes frame `number` (the first is 1) and the series with it. Collective.
  std::string Write(Hierarchy &hierarchy, int number, double time, long step);
  /// Number of the last frame that was written, or found by Resume; 0 for none. First rank.
  int Last() const { return frames_.empty() ? 0 : frames_.back().number; }
  std::string PathOf(int number) const { return directory_ + "/" + FileName(number); }

private:
  struct Frame {
    int number;
    double time;
    std::vector<unsigned long long> counts; ///< points of each level
  };
  std::string FileName(int number) const;
  std::string WriteSeries(MPI_Comm comm) const;

  std::string directory_;
  const Model &model_;
  std::vector<Frame> frames_;
};

} // namespace mlgimp
