// Frames of points for pictures and other tools: points_FFFFFF.h5 and the time series points.xdmf.
#pragma once

#include "levels/hierarchy.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class FrameWriter
{
public:
  FrameWriter(std::string directory, const Model &model) : directory_(std::move(directory)), model_(model) {}

  /// Finds the frames up to number `written` that an interrupted run left, so that the series goes on; removes others.
  PetscErrorCode Resume(MPI_Comm comm, int written);
  /// Writes frame `number` (the first is 1) and the series with it. Collective.
  PetscErrorCode Write(Hierarchy &hierarchy, int number, double time, long step);

private:
  struct Frame {
    int number;
    double time;
    std::vector<unsigned long long> counts; ///< points of each level
  };
  std::string FileName(int number) const;
  PetscErrorCode WriteSeries(MPI_Comm comm) const;

  std::string directory_;
  const Model &model_;
  std::vector<Frame> frames_;
};

/// This rank's rows among those of all ranks.
PetscErrorCode MakeSlab(MPI_Comm comm, int count, struct Slab *slab);

/// Writes a text file under another name and renames it when it is complete; false where that fails. One rank.
bool ReplaceFile(const std::string &path, const std::string &text);

} // namespace mlgimp
