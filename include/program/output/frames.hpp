// Frames for pictures and other tools: points_FFFFFF.h5, and their time series, points.vtkhdf and points.xdmf of the points,
// surface.vtkhdf and surface.xdmf of the surface that contact presses on.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "program/output/vtkhdf.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class FrameWriter
{
public:
  /// single_precision: of real numbers other than places, which are doubles else.
  FrameWriter(std::string directory, const Model &model, bool single_precision)
      : directory_(std::move(directory)), model_(model), single_precision_(single_precision)
  {
  }

  /// Finds the frames up to number `written` that an interrupted run left, so that the series goes on; of the same precision.
  /// Returns nothing, or what could not be written; here and below.
  std::string Resume(MPI_Comm comm, int written);
  /// Writes frame `number` (0 is the state at the start), and the series with it: with every frame while they are few, then after
  /// each sixteenth more of them, as its length is that of all frames. Collective.
  std::string Write(Hierarchy &hierarchy, int number, double time, long step);
  /// Writes the series if frames are missing in it. Collective.
  std::string Finish(MPI_Comm comm) { return WriteSeries(comm, true); }
  /// Number of the last frame that was written, or found by Resume; -1 for none. First rank.
  int Last() const { return frames_.empty() ? -1 : frames_.back().number; }
  std::string PathOf(int number) const { return directory_ + "/" + FileName(number); }

private:
  /// A frame that has been written.
  struct Frame {
    int number;
    double time;                 ///< s
    std::vector<hsize_t> counts; ///< points of each level
    hsize_t corners;             ///< of all patches of the surface
  };
  /// Whether frames have the surface: where patches of it are pressed.
  bool HasSurface() const { return model_.indenter && model_.contact.method == "pressure"; }
  /// The type of such numbers in the files, in HDF5.
  hid_t Real() const { return single_precision_ ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE; }
  bool IsSingle(int field) const;
  void AddReals(H5Writer &file, const std::string &name, int components, const Slab &slab, const double *values) const;
  void AddDerived(H5Writer &file, const std::string &group, const PointArrays &points, const std::vector<double> &pressures,
                  const Slab &slab) const;
  std::string FindFrames(int written);
  void AddSurface(H5Writer &file, Hierarchy &hierarchy, double time, hsize_t *total);
  std::string FileName(int number) const;
  VtkSeries Points() const;
  VtkSeries Patches() const;
  std::string ReplaceSeries(const std::string &name, const std::vector<VtkStep> &steps, const VtkSeries &series) const;
  std::string WriteSeries(MPI_Comm comm, bool whole);

  std::string directory_;
  const Model &model_;
  bool single_precision_;
  std::vector<Frame> frames_;
  std::size_t in_series_ = 0; ///< frames; first rank
};

} // namespace mlgimp
