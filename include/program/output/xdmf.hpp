// The same series in XDMF, for readers that do not know PolyData in VTKHDF: VTK before 9.3, ParaView before 5.12.
#pragma once

#include "program/output/vtkhdf.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Dataset of a group in a frame that numbers its points, 0, 1, 2, ...: the reader that ParaView takes by itself shows no cell
/// without a list of its points, and as text it would be the longest part of the file.
inline constexpr char kVertex[] = "vertex";

/// The text of an XDMF file that shows a series. name: of what it shows; dim: components of positions.
std::string MakeXdmf(const std::string &name, const std::vector<VtkStep> &steps, const VtkSeries &series, int dim);

} // namespace mlgimp
