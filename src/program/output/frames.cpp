// Point frames in HDF5, and their series.
#include "program/output/frames.hpp"

#include "base/text.hpp"
#include "program/system/agree.hpp"
#include "program/system/errors.hpp"
#include "program/system/files.hpp"
#include "program/system/hdf5_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <sstream>

namespace mlgimp
{

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
    std::vector<double> history((*first)->Traits().history);
    (*first)->InitialHistory(history.data());
    const double at_start = history[(*first)->PlaceOf(variable)];
    fields.push_back({kInternalVariableNames[k], 1, [=](Points a, int p, const Material &material, double *value) {
                        const int place = material.PlaceOf(variable);
                        *value = place < 0 ? at_start : a.history[PointArrays::At(p, a.history_components) + place];
                      }});
  }
  return fields;
}

/// Places keep eight bytes: with four those of a body of 1 mm would be off by .06 nm.
bool FrameWriter::IsSingle(int field) const
{
  return single_precision_ && field != kPosition && PointFieldTable(model_.geometry.kind, 0, 0)[field].type == FieldType::kReal;
}

void FrameWriter::AddReals(H5Writer &file, const std::string &name, int components, const Slab &slab, const double *values) const
{
  if (!single_precision_) return file.Dataset(name, Real(), components, slab, values);
  const std::vector<float> rounded(values, values + static_cast<std::size_t>(components) * slab.count);
  file.Dataset(name, Real(), components, slab, rounded.data());
}

void FrameWriter::AddDerived(H5Writer &file, const std::string &group, const PointArrays &points,
                             const std::vector<double> &pressures, const Slab &slab) const
{
  const BodyTable bodies = model_.Table();
  for (const DerivedField &field : DerivedFields(model_, pressures)) {
    std::vector<double> values(static_cast<std::size_t>(field.components) * points.count);
    for (int p = 0; p < points.count; ++p)
      field.evaluate(points, p, bodies.Of(points, p), &values[PointArrays::At(p, field.components)]);
    AddReals(file, group + "/" + field.name, field.components, slab, values.data());
  }
}

static const std::string kSurface = "/surface"; ///< group of the patches

/// A number for each point, 0, 1, 2, ...: see kVertex.
static void AddVertices(H5Writer &file, const std::string &group, const Slab &slab)
{
  std::vector<int> numbers(slab.count);
  std::iota(numbers.begin(), numbers.end(), static_cast<int>(slab.start));
  file.Dataset(group + "/" + kVertex, H5T_NATIVE_INT, 1, slab, numbers.data());
}

std::string FrameWriter::Write(Hierarchy &hierarchy, int number, double time, long step)
{
  H5Writer file;
  Frame frame{number, time, {}, 0};
  std::vector<double> pressures;
  Budgets budgets;
  ExitOnError(hierarchy.ReduceBudgets(&budgets));
  file.Open(hierarchy.Comm(), PathOf(number), false);
  file.Attribute("/", "time", {time});
  file.Attribute("/", "step", {static_cast<double>(step)});
  file.Attribute("/", budgets.contact_area.name, {budgets.contact_area.value[0]}); // there may be no row of the history now
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    const std::string group = "/level_" + std::to_string(l);
    Level &level = hierarchy.At(l);
    const PointArrays points = level.PointStore().Arrays();
    const Slab slab = MakeSlab(hierarchy.Comm(), points.count);
    file.Group(group);
    for (int k = 0; k < kPointFields; ++k) {
      const PointFieldInfo &field = level.PointStore().Table()[k];
      if (!field.in_frames || field.components == 0) continue;
      void *const data = level.PointStore().Field(static_cast<PointField>(k));
      if (IsSingle(k))
        AddReals(file, group + "/" + field.name, field.components, slab, static_cast<const double *>(data));
      else
        file.Dataset(group + "/" + field.name, H5Type(field.type), field.components, slab, data);
    }
    ExitOnError(level.Contact().PressuresOnPoints(level.Parts(), hierarchy.Tip().At(time), &pressures));
    AddDerived(file, group, points, pressures, slab);
    AddVertices(file, group, slab);
    frame.counts.push_back(slab.total);
  }
  if (HasSurface()) AddSurface(file, hierarchy, time, &frame.corners);
  std::string problem = file.Finish();
  if (!problem.empty()) return problem;
  frames_.push_back(frame);
  return WriteSeries(hierarchy.Comm(), false);
}

/// On the first rank. Returns why the series cannot go on.
std::string FrameWriter::FindFrames(int written)
{
  const std::string first = "/level_0/mass";
  for (int number = 0; number <= written; ++number) { // some are absent where steps are fewer than frames
    H5Reader file;
    Frame frame{number, 0, {}, 0};
    std::vector<double> time(1);
    hsize_t rows = 0;
    if (!file.Open(PathOf(number)) || !file.Attribute("/", "time", &time)) continue;
    if (file.Rows(first, single_precision_ ? H5T_NATIVE_DOUBLE : H5T_NATIVE_FLOAT, 1, &rows))
      return Format("-frame_precision {}: {} has real numbers of the other kind", single_precision_ ? "single" : "double",
                    PathOf(number));
    frame.time = time[0];
    for (int l = 0; file.Has("level_" + std::to_string(l)); ++l) {
      file.Rows("/level_" + std::to_string(l) + "/id", H5T_NATIVE_INT64, 1, &rows);
      frame.counts.push_back(rows);
    }
    file.Rows(kSurface + "/" + kVertex, H5T_NATIVE_INT, 1, &frame.corners);
    frames_.push_back(frame);
  }
  return "";
}

std::string FrameWriter::Resume(MPI_Comm comm, int written)
{
  const std::string problem = OnFirstRank(comm, "frames", [&] { return FindFrames(written); });
  int found = static_cast<int>(frames_.size());
  MPI_Bcast(&found, 1, MPI_INT, 0, comm);
  return problem.empty() && found > 0 ? WriteSeries(comm, true) : problem;
}

/// The surface of bodies in patches, with the pressures on them.
void FrameWriter::AddSurface(H5Writer &file, Hierarchy &hierarchy, double time, hsize_t *total)
{
  const int dim = model_.geometry.Dim(), corners = 1 << (dim - 1);
  std::vector<double> positions, pressures;
  std::vector<int> bodies, levels;
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    Level &level = hierarchy.At(l);
    std::vector<double> on_level;
    ExitOnError(level.Contact().PressuresOnPatches(level.Parts(), hierarchy.Tip().At(time), &on_level));
    pressures.insert(pressures.end(), on_level.begin(), on_level.end());
    for (const SurfacePatch &patch : level.Contact().Patches().Patches()) {
      for (int c = 0; c < corners; ++c) positions.insert(positions.end(), patch.corner[c].begin(), patch.corner[c].begin() + dim);
      bodies.push_back(patch.body), levels.push_back(l);
    }
  }
  const auto patches = static_cast<int>(bodies.size());
  const Slab of_patches = MakeSlab(hierarchy.Comm(), patches), of_corners = MakeSlab(hierarchy.Comm(), corners * patches);
  file.Group(kSurface);
  file.Dataset(kSurface + "/position", H5T_NATIVE_DOUBLE, dim, of_corners, positions.data());
  AddVertices(file, kSurface, of_corners);
  AddReals(file, kSurface + "/contact_pressure", 1, of_patches, pressures.data());
  file.Dataset(kSurface + "/body", H5T_NATIVE_INT, 1, of_patches, bodies.data());
  file.Dataset(kSurface + "/level", H5T_NATIVE_INT, 1, of_patches, levels.data());
  *total = of_corners.total;
}

VtkSeries FrameWriter::Points() const
{
  VtkSeries series{"Vertices", 1, {}, {}};
  std::vector<FrameField> &fields = series.point_fields;
  for (const DerivedField &field : DerivedFields(model_, {})) fields.push_back({field.name, Real(), field.components});
  const auto table = PointFieldTable(model_.geometry.kind, 0, 0);
  for (int k = 0; k < kPointFields; ++k)
    if (table[k].in_frames && table[k].components > 0)
      fields.push_back({table[k].name, IsSingle(k) ? H5T_NATIVE_FLOAT : H5Type(table[k].type), table[k].components});
  return series;
}

VtkSeries FrameWriter::Patches() const
{
  const int dim = model_.geometry.Dim();
  const FrameField position{"position", H5T_NATIVE_DOUBLE, dim}, pressure{"contact_pressure", Real(), 1},
      body{"body", H5T_NATIVE_INT, 1}, level{"level", H5T_NATIVE_INT, 1};
  return {dim == 2 ? "Lines" : "Polygons", 1 << (dim - 1), {position}, {pressure, body, level}};
}

std::string FrameWriter::ReplaceSeries(const std::string &name, const std::vector<VtkStep> &steps, const VtkSeries &series) const
{
  const std::string path = directory_ + "/" + name + ".vtkhdf", bytes = MakeVtkhdf(steps, series);
  std::string problem = bytes.empty() ? CannotWrite(path, 0) : ReplaceFile(path, bytes);
  if (!problem.empty()) return problem;
  return ReplaceFile(directory_ + "/" + name + ".xdmf", MakeXdmf(name, steps, series, model_.geometry.Dim()));
}

std::string FrameWriter::WriteSeries(MPI_Comm comm, bool whole)
{
  return OnFirstRank(comm, "series", [&]() -> std::string {
    constexpr std::size_t kEachFrame = 32, kOneIn = 16; // size
    const std::size_t count = frames_.size(),
                      due = whole || count <= kEachFrame ? in_series_ + 1 : in_series_ + in_series_ / kOneIn;
    if (count < due) return "";
    std::vector<VtkStep> points, patches;
    for (const Frame &frame : frames_) {
      const std::string file = FileName(frame.number);
      points.push_back({frame.time, {}}), patches.push_back({frame.time, {}});
      for (std::size_t l = 0; l < frame.counts.size(); ++l)
        if (frame.counts[l] > 0)
          points.back().parts.push_back({file, "/level_" + std::to_string(l), frame.counts[l], static_cast<int>(l)});
      if (frame.corners > 0) patches.back().parts.push_back({file, kSurface, frame.corners, -1});
    }
    in_series_ = count;
    const std::string problem = ReplaceSeries("points", points, Points());
    return problem.empty() && HasSurface() ? ReplaceSeries("surface", patches, Patches()) : problem;
  });
}

} // namespace mlgimp
