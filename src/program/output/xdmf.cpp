// XDMF, a grid for each group of each frame.
#include "program/output/vtkhdf.hpp"

#include <sstream>

namespace mlgimp
{

/// Topology by the kind of cells.
static const char *TopologyOf(const VtkSeries &series)
{
  return series.corners == 1 ? "Polyvertex" : series.corners == 2 ? "Polyline" : "Quadrilateral";
}

static void AddField(std::ostringstream &xml, const FrameField &field, const std::string &place, hsize_t count,
                     const char *center)
{
  xml << "<Attribute Name=\"" << field.name << "\" AttributeType=\"" << (field.components > 1 ? "Matrix" : "Scalar")
      << "\" Center=\"" << center << "\"><DataItem Dimensions=\"" << count;
  if (field.components > 1) xml << " " << field.components;
  xml << "\" NumberType=\"" << (H5Tget_class(field.type) == H5T_FLOAT ? "Float" : "Int") << "\" Precision=\""
      << H5Tget_size(field.type) << "\" Format=\"HDF\">" << place << field.name << "</DataItem></Attribute>\n";
}

static void AddGrid(std::ostringstream &xml, const VtkPart &part, const VtkSeries &series, int dim)
{
  const std::string place = part.file + ":" + part.group + "/";
  const hsize_t n = part.count, cells = n / static_cast<hsize_t>(series.corners);
  xml << "<Grid Name=\"" << part.group.substr(1) << "\" GridType=\"Uniform\">\n"
      << "<Topology TopologyType=\"" << TopologyOf(series) << "\" NumberOfElements=\"" << cells << "\" NodesPerElement=\""
      << series.corners << "\"><DataItem Dimensions=\"" << n << "\" NumberType=\"Int\" Precision=\"4\" Format=\"HDF\">" << place
      << kVertex << "</DataItem></Topology>\n"
      << "<Geometry GeometryType=\"" << (dim == 3 ? "XYZ" : "XY") << "\"><DataItem Dimensions=\"" << n << " " << dim
      << "\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">" << place << "position</DataItem></Geometry>\n";
  for (const FrameField &field : series.point_fields)
    if (field.name != "position") AddField(xml, field, place, n, "Node");
  for (const FrameField &field : series.cell_fields) AddField(xml, field, place, cells, "Cell");
  xml << "</Grid>\n";
}

std::string MakeXdmf(const std::string &name, const std::vector<VtkStep> &steps, const VtkSeries &series, int dim)
{
  std::ostringstream xml;
  xml.precision(17);
  xml << "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
      << "<Grid Name=\"" << name << "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const VtkStep &step : steps) {
    xml << "<Grid Name=\"frame\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"" << step.time << "\"/>\n";
    for (const VtkPart &part : step.parts) AddGrid(xml, part, series, dim);
    xml << "</Grid>\n";
  }
  xml << "</Grid>\n</Domain>\n</Xdmf>\n";
  return xml.str();
}

} // namespace mlgimp
