// The frames as one series in the format VTKHDF (https://docs.vtk.org), which ParaView recommends.
//
// points.vtkhdf holds no numbers of the points: its datasets are virtual, pieces of those in the files points_FFFFFF.h5 beside
// it, which HDF5 reads as if they were one. So no number is on the disk twice, the file is small enough to be replaced as a
// whole with every frame, and it names complete frames alone, however a run ends.
#pragma once

#include "program/hdf5_file.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// A dataset of each level's group in a frame.
struct FrameField {
  std::string name;
  hid_t type;
  int components;
};

/// Name of the field F_zz = r/R that the deformation gradient of the plane has in axisymmetry.
inline constexpr char kHoopStretch[] = "hoop_stretch";

/// A frame that has been written.
struct Frame {
  int number;
  double time;                 ///< s
  std::string file;            ///< without folder
  std::vector<hsize_t> counts; ///< points of each level
};

/// The bytes of a VTKHDF file of PolyData, a vertex for each point, with frames as time steps and levels as partitions. Vectors
/// get three components and tensors six or nine, as VTK's filters take them; those that a geometry has not are zero, but for the
/// stretch out of the plane: kHoopStretch where that is a field, else one. Beside the fields each point has the number of its
/// level. Empty where HDF5 fails. Alone, without MPI.
std::string MakeVtkhdf(const std::vector<Frame> &frames, const std::vector<FrameField> &fields);

} // namespace mlgimp
