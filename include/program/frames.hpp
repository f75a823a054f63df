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
  /// problem: empty, or what could not be written; here and below.
  PetscErrorCode Resume(MPI_Comm comm, int written, std::string *problem);
  /// Writes frame `number` (the first is 1) and the series with it. Collective.
  PetscErrorCode Write(Hierarchy &hierarchy, int number, double time, long step, std::string *problem);
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
  PetscErrorCode WriteSeries(MPI_Comm comm, std::string *problem) const;

  std::string directory_;
  const Model &model_;
  std::vector<Frame> frames_;
};

} // namespace mlgimp
