// The frames as series in the format VTKHDF (https://docs.vtk.org), which ParaView recommends: of the points, and of the surface.
//
// Such a file holds no numbers of the frames: its datasets are virtual, pieces of those in the files points_FFFFFF.h5 beside it,
// which HDF5 reads as if they were one. So no number is on the disk twice, the file is small enough to be replaced as a whole
// with every frame, and it names complete frames alone, however a run ends.
#pragma once

#include "program/system/hdf5_file.hpp"

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

/// A group of a frame's file that a series shows.
struct VtkPart {
  std::string file;  ///< without folder
  std::string group; ///< as "/level_0"
  hsize_t count;     ///< points, also those that are corners of cells
  int level;         ///< that all its points have, or -1
};

/// A time step of a series.
struct VtkStep {
  double time; ///< s
  std::vector<VtkPart> parts;
};

/// What a series shows: a kind of cells, as VTKHDF names it, of so many points each, one after the other; and the fields of
/// points and of cells.
struct VtkSeries {
  std::string kind;
  int corners;
  std::vector<FrameField> point_fields, cell_fields;
};

/// The bytes of a VTKHDF file of PolyData over time. Vectors get three components and tensors six or nine, as VTK's filters take
/// them; those that a geometry has not are zero, but for the stretch out of the plane: kHoopStretch where that is a field, else
/// one. Beside the fields each point has the number of its level where parts have one. Empty where HDF5 fails. Alone, without
/// MPI.
std::string MakeVtkhdf(const std::vector<VtkStep> &steps, const VtkSeries &series);

/// Dataset of a group in a frame that numbers its points, 0, 1, 2, ...: the XDMF reader that ParaView takes by itself shows no
/// cell without a list of its points, and as text it would be the longest part of the file.
inline constexpr char kVertex[] = "vertex";

/// The same in XDMF, for readers that do not know PolyData in VTKHDF: VTK before 9.3, ParaView before 5.12. name: of what it
/// shows; dim: components of positions.
std::string MakeXdmf(const std::string &name, const std::vector<VtkStep> &steps, const VtkSeries &series, int dim);

} // namespace mlgimp
