// VTKHDF 2.0, PolyData over time, by HDF5's virtual datasets.
#include "program/output/vtkhdf.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

namespace mlgimp
{

namespace
{

/// A dataset with rows of `stored` components, which lie in the row that VTK takes from `first` on: blocks of so many, one every
/// `stride`. of(part): file and name of the dataset, the first rows of which the part takes.
struct Source {
  hsize_t stored, first, block, stride;
  std::function<std::pair<std::string, std::string>(const VtkPart &part)> of;
};

/// The same dataset for every part, in this file.
Source Own(const std::string &dataset, hsize_t first = 0)
{
  return {1, first, 1, 1, [=](const VtkPart &) { return std::pair<std::string, std::string>(".", dataset); }};
}

/// A field of each level's group in the frames.
Source FromFrames(const FrameField &field, hsize_t first, hsize_t block, hsize_t stride)
{
  const auto of = [name = field.name](const VtkPart &part) { return std::pair(part.file, part.group + "/" + name); };
  return {static_cast<hsize_t>(field.components), first, block, stride, of};
}

/// A file in memory; after any failure it has no bytes.
class VtkhdfFile
{
public:
  VtkhdfFile()
  {
    constexpr std::size_t kGrowth = 1 << 20; // size: bytes
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_fapl_core(access, kGrowth, false);
    file_ = H5Handle(H5Fcreate("series.vtkhdf", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
    Record(file_);
  }

  void Group(const std::string &name) { Record(H5Handle(H5Gcreate2(file_, name.c_str(), 0, 0, 0), H5Gclose)); }

  template <class Number>
  void Attribute(const std::string &object, const char *name, hid_t type, const H5Handle &space, Number *value)
  {
    const H5Handle attribute(H5Acreate_by_name(file_, object.c_str(), name, type, space, 0, 0, 0), H5Aclose);
    good_ = good_ && attribute.Valid() && H5Awrite(attribute, type, value) >= 0;
  }

  /// Rows of `width` numbers each.
  template <class Number> void List(const std::string &name, hid_t type, const std::vector<Number> &values, hsize_t width = 1)
  {
    const H5Handle set = Create(name, type, Space(values.size() / width, width), H5Handle());
    good_ = good_ && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
  }
  void List(const std::string &name, const std::vector<hsize_t> &values, hsize_t width = 1)
  {
    List(name, H5T_NATIVE_INT64, values, width);
  }

  /// `count` times the same number, which takes no room.
  void Constant(const std::string &name, int value, hsize_t count)
  {
    const H5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_fill_value(layout, H5T_NATIVE_INT, &value);
    Create(name, H5T_NATIVE_INT, Space(count, 1), layout);
  }

  /// Rows of `width` numbers that lie in other datasets, part by part, `more` than a part has cells of so many points; zero where
  /// no source is.
  void Virtual(const std::string &name, hid_t type, hsize_t width, const std::vector<VtkPart> &parts, hsize_t corners,
               hsize_t more, const std::vector<Source> &sources)
  {
    const H5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const int zero = 0;
    hsize_t rows = 0, at = 0;
    for (const VtkPart &part : parts) rows += part.count / corners + more;
    H5Pset_fill_value(layout, H5T_NATIVE_INT, &zero);
    for (const VtkPart &part : parts) {
      const hsize_t count = part.count / corners + more;
      for (const Source &source : sources) {
        const hsize_t start[2] = {at, source.first}, stride[2] = {count, source.stride};
        const hsize_t times[2] = {1, source.stored / source.block}, block[2] = {count, source.block};
        const H5Handle target = Space(rows, width), stored = Space(count, source.stored);
        const auto [file, dataset] = source.of(part);
        good_ = good_ && H5Sselect_hyperslab(target, H5S_SELECT_SET, start, stride, times, block) >= 0 &&
                H5Pset_virtual(layout, target, file.c_str(), dataset.c_str(), stored) >= 0;
      }
      at += count;
    }
    Create(name, type, Space(rows, width), layout);
  }

  std::string Bytes()
  {
    std::string bytes;
    good_ = good_ && H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0;
    if (good_) bytes.resize(static_cast<std::size_t>(H5Fget_file_image(file_, nullptr, 0)));
    if (good_ && H5Fget_file_image(file_, bytes.data(), bytes.size()) < 0) bytes.clear();
    return bytes;
  }

private:
  void Record(const H5Handle &object) { good_ = good_ && object.Valid(); }
  static H5Handle Space(hsize_t rows, hsize_t width)
  {
    const hsize_t size[2] = {rows, width};
    return {H5Screate_simple(width > 1 ? 2 : 1, size, nullptr), H5Sclose};
  }
  H5Handle Create(const std::string &name, hid_t type, const H5Handle &space, const H5Handle &layout)
  {
    H5Handle set(H5Dcreate2(file_, name.c_str(), type, space, 0, layout.Valid() ? hid_t(layout) : H5P_DEFAULT, 0), H5Dclose);
    Record(set);
    return set;
  }

  H5Handle file_;
  bool good_ = true;
};

constexpr char kCells[][10] = {"Vertices", "Lines", "Polygons", "Strips"};

void AddHeader(VtkhdfFile &file)
{
  const hsize_t two = 2;
  const std::int64_t version[2] = {2, 0};
  const char type[] = "PolyData";
  const H5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text, sizeof type - 1);
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  file.Group("/VTKHDF");
  file.Attribute("/VTKHDF", "Version", H5T_NATIVE_INT64, H5Handle(H5Screate_simple(1, &two, nullptr), H5Sclose), version);
  file.Attribute("/VTKHDF", "Type", text, H5Handle(H5Screate(H5S_SCALAR), H5Sclose), type);
}

/// Cells of points that follow each other: in each part their lists are 0, 1, 2, ... and 0, corners, 2 corners, ... None of the
/// other kinds.
void AddCells(VtkhdfFile &file, const std::vector<VtkPart> &parts, const VtkSeries &series)
{
  const auto corners = static_cast<hsize_t>(series.corners);
  const std::vector<hsize_t> none(parts.size(), 0);
  std::vector<hsize_t> points, cells, numbers(1), starts;
  for (const VtkPart &part : parts) {
    points.push_back(part.count), cells.push_back(part.count / corners);
    numbers.resize(std::max<std::size_t>(numbers.size(), 1 + part.count));
  }
  std::iota(numbers.begin(), numbers.end(), hsize_t{0});
  for (hsize_t first = 0; first < numbers.size(); first += corners) starts.push_back(first);
  file.List("/VTKHDF/NumberOfPoints", points);
  file.List("/numbers", numbers);
  if (corners > 1) file.List("/starts", starts);
  for (const std::string kind : kCells) {
    const std::string group = "/VTKHDF/" + kind;
    const bool has = kind == series.kind;
    file.Group(group);
    file.List(group + "/NumberOfCells", has ? cells : none);
    file.List(group + "/NumberOfConnectivityIds", has ? points : none);
    if (has)
      file.Virtual(group + "/Offsets", H5T_NATIVE_INT64, 1, parts, corners, 1, {Own(corners > 1 ? "/starts" : "/numbers")});
    if (has) file.Virtual(group + "/Connectivity", H5T_NATIVE_INT64, 1, parts, 1, 0, {Own("/numbers")});
    if (!has) file.List(group + "/Offsets", none);
    if (!has) file.List(group + "/Connectivity", std::vector<hsize_t>());
  }
}

/// Where the parts, points and cells of each time step begin.
void AddSteps(VtkhdfFile &file, const std::vector<VtkStep> &steps, const VtkSeries &series,
              const std::vector<std::string> &point_data, const std::vector<std::string> &cell_data)
{
  const auto count = static_cast<std::int64_t>(steps.size());
  std::vector<double> times;
  std::vector<hsize_t> parts, first_part, first_point, first_cell, first_of_kinds, first_ids;
  hsize_t part = 0, point = 0;
  for (const VtkStep &step : steps) {
    times.push_back(step.time);
    parts.push_back(step.parts.size());
    first_part.push_back(part);
    first_point.push_back(point);
    first_cell.push_back(point / static_cast<hsize_t>(series.corners));
    for (const char *kind : kCells) {
      first_of_kinds.push_back(kind == series.kind ? first_cell.back() : 0);
      first_ids.push_back(kind == series.kind ? point : 0);
    }
    part += step.parts.size();
    for (const VtkPart &one : step.parts) point += one.count;
  }
  const std::string group = "/VTKHDF/Steps";
  file.Group(group);
  file.Attribute(group, "NSteps", H5T_NATIVE_INT64, H5Handle(H5Screate(H5S_SCALAR), H5Sclose), &count);
  file.List(group + "/Values", H5T_NATIVE_DOUBLE, times);
  file.List(group + "/NumberOfParts", parts);
  file.List(group + "/PartOffsets", first_part);
  file.List(group + "/PointOffsets", first_point);
  file.List(group + "/CellOffsets", first_of_kinds, std::size(kCells));
  file.List(group + "/ConnectivityIdOffsets", first_ids, std::size(kCells));
  file.Group(group + "/PointDataOffsets");
  for (const std::string &name : point_data) file.List(group + "/PointDataOffsets/" + name, first_point);
  file.Group(group + "/CellDataOffsets");
  for (const std::string &name : cell_data) file.List(group + "/CellDataOffsets/" + name, first_cell);
}

/// The field as VTK takes it: three components of vectors, six of symmetric tensors, nine of others. Out of the plane the
/// deformation gradient has the hoop's stretch, or one.
void AddField(VtkhdfFile &file, const std::string &name, const FrameField &field, const std::vector<FrameField> &fields,
              const std::vector<VtkPart> &parts, hsize_t corners)
{
  const auto stored = static_cast<hsize_t>(field.components);
  if (field.name == "deformation_gradient" && stored == 4) {
    constexpr hsize_t kOutOfPlane = 8; // size
    const auto hoop = std::find_if(fields.begin(), fields.end(), [](const FrameField &one) { return one.name == kHoopStretch; });
    const Source stretch = hoop == fields.end() ? Own("/ones", kOutOfPlane) : FromFrames(*hoop, kOutOfPlane, 1, 1);
    file.Virtual(name, field.type, 9, parts, corners, 0, {FromFrames(field, 0, 2, 3), stretch}); // xx, xy, yx, yy, zz
    return;
  }
  const hsize_t shown = stored == 4 ? 6 : stored == 2 ? 3 : stored;
  file.Virtual(name, field.type, shown, parts, corners, 0, {FromFrames(field, 0, stored, shown)});
}

/// The number of its level for each point; of each level the file has a list of as many as the largest part. Whether there is
/// one.
bool AddLevels(VtkhdfFile &file, const std::vector<VtkPart> &parts)
{
  std::vector<hsize_t> largest_part;
  for (const VtkPart &part : parts) {
    if (part.level < 0) return false;
    largest_part.resize(std::max(largest_part.size(), std::size_t(part.level) + 1));
    largest_part[part.level] = std::max(largest_part[part.level], part.count);
  }
  file.Constant("/ones", 1, largest_part.empty() ? 0 : *std::max_element(largest_part.begin(), largest_part.end()));
  for (std::size_t l = 0; l < largest_part.size(); ++l)
    file.Constant("/level_" + std::to_string(l), static_cast<int>(l), largest_part[l]);
  const auto own = [](const VtkPart &part) { return std::pair(std::string("."), "/level_" + std::to_string(part.level)); };
  file.Virtual("/VTKHDF/PointData/level", H5T_NATIVE_INT, 1, parts, 1, 0, {{1, 0, 1, 1, own}});
  return true;
}

} // namespace

std::string MakeVtkhdf(const std::vector<VtkStep> &steps, const VtkSeries &series)
{
  std::vector<VtkPart> parts;
  std::vector<std::string> point_data, cell_data;
  VtkhdfFile file;
  AddHeader(file);
  for (const VtkStep &step : steps) parts.insert(parts.end(), step.parts.begin(), step.parts.end());
  AddCells(file, parts, series);
  file.Group("/VTKHDF/PointData");
  if (AddLevels(file, parts)) point_data.emplace_back("level");
  for (const FrameField &field : series.point_fields) {
    const bool place = field.name == "position";
    AddField(file, place ? "/VTKHDF/Points" : "/VTKHDF/PointData/" + field.name, field, series.point_fields, parts, 1);
    if (!place) point_data.push_back(field.name);
  }
  file.Group("/VTKHDF/CellData");
  for (const FrameField &field : series.cell_fields) {
    AddField(file, "/VTKHDF/CellData/" + field.name, field, {}, parts, static_cast<hsize_t>(series.corners));
    cell_data.push_back(field.name);
  }
  AddSteps(file, steps, series, point_data, cell_data);
  return file.Bytes();
}

} // namespace mlgimp
