// Point frames in HDF5, and their series.
#include "program/frames.hpp"

#include "program/agree.hpp"
#include "program/errors.hpp"
#include "program/files.hpp"
#include "program/hdf5_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <sstream>

namespace mlgimp
{

static const std::string kVertex = "vertex"; ///< dataset of a level

std::string FrameWriter::FileName(int number) const
{
  char name[32];
  std::snprintf(name, sizeof name, "points_%06d.h5", number);
  return name;
}

/// A dataset that is not a field of the points: what it has of a point.
struct DerivedField {
  const char *name;
  int components;
  std::function<void(const PointArrays &points, int p, const Material &material, double *values)> evaluate;
};

static Sym3 StressOf(const PointArrays &points, int p)
{
  const double *const s = points.stress + PointArrays::At(p, points.stress_components);
  return points.dim == 3 ? LoadStress<Spatial>(s) : LoadStress<PlaneStrain>(s);
}

static double VonMisesStress(const Sym3 &stress)
{
  const Sym3 deviator = stress - Sphere(Trace(stress) / 3);
  return std::sqrt(1.5 * Contract(deviator, deviator));
}

/// Displacement since the start; current volume and half size; measures of the stress; stretch around the axis; pressures of
/// contact, [points] Pa; internal variables that any material has; the others have what that starts from.
static std::vector<DerivedField> DerivedFields(const Model &model, const std::vector<double> &pressures)
{
  using Points = const PointArrays &;
  std::vector<DerivedField> fields = {
      {"displacement", model.geometry.Dim(),
       [](Points a, int p, const Material &, double *displacement) {
         for (int axis = 0; axis < a.dim; ++axis) {
           const std::ptrdiff_t at = PointArrays::At(p, a.dim) + axis;
           displacement[axis] = a.position[at] - a.initial_position[at];
         }
       }},
      {"volume", 1,
       [](Points a, int p, const Material &material, double *volume) {
         *volume = a.VolumeRatio(p) * a.mass[p] / material.Density();
       }},
      {"half_size", model.geometry.Dim(),
       [](Points a, int p, const Material &, double *size) {
         for (int axis = 0; axis < a.dim; ++axis) size[axis] = CurrentHalfSize(a, p, axis);
       }},
      {"pressure", 1, [](Points a, int p, const Material &, double *value) { *value = -Trace(StressOf(a, p)) / 3; }},
      {"von_mises_stress", 1, [](Points a, int p, const Material &, double *value) { *value = VonMisesStress(StressOf(a, p)); }},
  };
  if (model.geometry.HasHoop())
    fields.push_back({kHoopStretch, 1, [](Points a, int p, const Material &, double *value) { *value = a.HoopStretch(p); }});
  if (model.indenter && FindsPressures(model.contact))
    fields.push_back(
        {"contact_pressure", 1, [&pressures](Points, int p, const Material &, double *value) { *value = pressures[p]; }});
  for (int k = 0; k < kInternalVariables; ++k) {
    const auto variable = static_cast<InternalVariable>(k);
    const auto has = [&](const auto &material) { return material->PlaceOf(variable) >= 0; };
    const auto first = std::find_if(model.materials.begin(), model.materials.end(), has);
    if (first == model.materials.end()) continue;
    std::vector<double> history((*first)->HistorySize());
    (*first)->InitialHistory(history.data());
    const double at_start = history[(*first)->PlaceOf(variable)];
    fields.push_back({kInternalVariableNames[k], 1, [=](Points a, int p, const Material &material, double *value) {
                        const int place = material.PlaceOf(variable);
                        *value = place < 0 ? at_start : a.history[PointArrays::At(p, a.history_components) + place];
                      }});
  }
  return fields;
}

static void AddDerived(H5Writer &file, const std::string &group, const PointArrays &points, const Model &model,
                       const std::vector<double> &pressures, const Slab &slab)
{
  const BodyTable bodies = model.Table();
  for (const DerivedField &field : DerivedFields(model, pressures)) {
    std::vector<double> values(static_cast<std::size_t>(field.components) * points.count);
    for (int p = 0; p < points.count; ++p)
      field.evaluate(points, p, bodies.Of(points, p), &values[PointArrays::At(p, field.components)]);
    file.Dataset(group + "/" + field.name, H5T_NATIVE_DOUBLE, field.components, slab, values.data());
  }
}

/// A number for each point, 0, 1, 2, ..., of the vertex that shows it: see MakeXdmf.
static void AddVertices(H5Writer &file, const std::string &group, const Slab &slab)
{
  std::vector<int> numbers(slab.count);
  std::iota(numbers.begin(), numbers.end(), static_cast<int>(slab.start));
  file.Dataset(group + "/" + kVertex, H5T_NATIVE_INT, 1, slab, numbers.data());
}

std::string FrameWriter::Write(Hierarchy &hierarchy, int number, double time, long step)
{
  H5Writer file;
  Frame frame{number, time, FileName(number), {}};
  std::vector<double> pressures;
  Budgets budgets;
  EndOn(hierarchy.ReduceBudgets(&budgets));
  file.Open(hierarchy.Comm(), PathOf(number), false);
  file.Attribute("/", "time", {time});
  file.Attribute("/", "step", {static_cast<double>(step)});
  file.Attribute("/", budgets.contact_area.name, {budgets.contact_area.value[0]}); // there may be no row of the history now
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    const std::string group = "/level_" + std::to_string(l);
    const PointArrays points = hierarchy.At(l).PointStore().Arrays();
    const Slab slab = MakeSlab(hierarchy.Comm(), points.count);
    file.Group(group);
    for (int k = 0; k < kPointFields; ++k) {
      const PointFieldInfo &field = hierarchy.At(l).PointStore().Table()[k];
      if (!field.in_frames || field.components == 0) continue;
      void *const data = hierarchy.At(l).PointStore().Field(static_cast<PointField>(k));
      file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
    }
    EndOn(hierarchy.At(l).FindContactPressures(hierarchy.Tip().At(time), &pressures));
    AddDerived(file, group, points, model_, pressures, slab);
    AddVertices(file, group, slab);
    frame.counts.push_back(slab.total);
  }
  std::string problem = file.Finish();
  if (!problem.empty()) return problem;
  frames_.push_back(frame);
  return WriteSeries(hierarchy.Comm(), false);
}

std::string FrameWriter::Resume(MPI_Comm comm, int written)
{
  for (int number = 0; number <= written && RankIn(comm) == 0; ++number) { // some are absent where steps are fewer than frames
    H5Reader file;
    Frame frame{number, 0, FileName(number), {}};
    std::vector<double> time(1);
    if (!file.Open(PathOf(number)) || !file.Attribute("/", "time", &time)) continue;
    frame.time = time[0];
    for (int l = 0; file.Has("level_" + std::to_string(l)); ++l) {
      hsize_t rows = 0;
      file.Rows("/level_" + std::to_string(l) + "/id", H5T_NATIVE_INT64, 1, &rows);
      frame.counts.push_back(rows);
    }
    frames_.push_back(frame);
  }
  int found = static_cast<int>(frames_.size());
  MPI_Bcast(&found, 1, MPI_INT, 0, comm);
  return found > 0 ? WriteSeries(comm, true) : "";
}

std::vector<FrameField> FrameWriter::Fields() const
{
  std::vector<FrameField> fields;
  for (const DerivedField &field : DerivedFields(model_, {})) fields.push_back({field.name, H5T_NATIVE_DOUBLE, field.components});
  for (const PointFieldInfo &field : PointFieldTable(model_.geometry.kind, 0, 0))
    if (field.in_frames && field.components > 0) fields.push_back({field.name, H5Type(field.type), field.components});
  return fields;
}

std::string FrameWriter::WriteSeries(MPI_Comm comm, bool whole)
{
  return OnFirstRank(comm, "series", [&]() -> std::string {
    constexpr std::size_t kFew = 32, kShare = 16;
    const std::size_t count = frames_.size(), due = whole || count <= kFew ? in_series_ + 1 : in_series_ + in_series_ / kShare;
    if (count < due) return "";
    const std::vector<FrameField> fields = Fields();
    const std::string path = directory_ + "/points.vtkhdf", bytes = MakeVtkhdf(frames_, fields);
    const std::string problem = bytes.empty() ? CannotWrite(path, 0) : ReplaceFile(path, bytes);
    in_series_ = count;
    return problem.empty() ? ReplaceFile(directory_ + "/points.xdmf", MakeXdmf(fields)) : problem;
  });
}

/// For readers that do not know PolyData in VTKHDF: VTK before 9.3, ParaView before 5.12. The one that ParaView takes by itself
/// shows no point without a list of vertices; as text it would be the longest part of the file.
std::string FrameWriter::MakeXdmf(const std::vector<FrameField> &fields) const
{
  const int dim = model_.geometry.Dim();
  std::ostringstream xml;
  xml.precision(17);
  xml << "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
      << "<Grid Name=\"points\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const Frame &frame : frames_) {
    xml << "<Grid Name=\"frame\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"" << frame.time << "\"/>\n";
    for (std::size_t l = 0; l < frame.counts.size(); ++l) {
      const auto n = frame.counts[l];
      if (n == 0) continue;
      const std::string place = frame.file + ":/level_" + std::to_string(l) + "/";
      xml << "<Grid Name=\"level_" << l << "\" GridType=\"Uniform\">\n"
          << "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"" << n
          << "\" NodesPerElement=\"1\"><DataItem Dimensions=\"" << n << "\" NumberType=\"Int\" Precision=\"4\" Format=\"HDF\">"
          << place << kVertex << "</DataItem></Topology>\n"
          << "<Geometry GeometryType=\"" << (dim == 3 ? "XYZ" : "XY") << "\"><DataItem Dimensions=\"" << n << " " << dim
          << "\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">" << place << "position</DataItem></Geometry>\n";
      for (const FrameField &field : fields) {
        if (field.name == "position") continue;
        xml << "<Attribute Name=\"" << field.name << "\" AttributeType=\"" << (field.components > 1 ? "Matrix" : "Scalar")
            << "\" Center=\"Node\"><DataItem Dimensions=\"" << n;
        if (field.components > 1) xml << " " << field.components;
        xml << "\" NumberType=\"" << (H5Tget_class(field.type) == H5T_FLOAT ? "Float" : "Int") << "\" Precision=\""
            << H5Tget_size(field.type) << "\" Format=\"HDF\">" << place << field.name << "</DataItem></Attribute>\n";
      }
      xml << "</Grid>\n";
    }
    xml << "</Grid>\n";
  }
  xml << "</Grid>\n</Domain>\n</Xdmf>\n";
  return xml.str();
}

} // namespace mlgimp
