// Options of the indenter's surface.
#include "program/input/read_case.hpp"

#include "program/input/tip_files.hpp"

#include "contact/contact.hpp"
#include "physics/tips/area_function.hpp"
#include "physics/tips/half_spaces.hpp"
#include "physics/tips/profiles.hpp"
#include "physics/tips/tilted.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace mlgimp
{

const std::vector<NamedInGeometry> &IndenterKinds()
{
  static const std::vector<NamedInGeometry> kinds = {
      {"none", {true, true, true}},           {"wedge", {true, false, false}},       {"cylinder", {true, false, false}},
      {"flat_punch", {true, true, true}},     {"polygon", {true, false, false}},     {"cone", {false, true, true}},
      {"sphere", {false, true, true}},        {"pyramid", {false, false, true}},     {"berkovich", {false, false, true}},
      {"vickers", {false, false, true}},      {"cube_corner", {false, false, true}}, {"knoop", {false, false, true}},
      {"area_function", {false, true, true}}, {"profile", {true, true, true}},       {"height_map", {false, false, true}},
  };
  return kinds;
}

namespace
{

/// Regular pyramids that have a name: angle of a face from the axis, degrees.
struct NamedPyramid {
  const char *name;
  int faces;
  double half_angle;
};
constexpr NamedPyramid kPyramids[] = {{"berkovich", 3, 65.27}, {"vickers", 4, 68}, {"cube_corner", 3, 35.264389682754654}};
constexpr double kKnoopLong = 172.5, kKnoopShort = 130; ///< exact: between opposite edges, degrees

const NamedPyramid *FindPyramid(const std::string &kind)
{
  const auto *found = std::find_if(std::begin(kPyramids), std::end(kPyramids), [&](auto &one) { return kind == one.name; });
  return found == std::end(kPyramids) ? nullptr : found;
}

/// A reader of the options of one kind; with -help of all kinds.
class TipReader
{
public:
  TipReader(OptionReader &reader, const std::string &kind, const Case &c)
      : reader_(reader), kind_(kind), geometry_(c.model.geometry.kind), c_(c)
  {
  }

  std::unique_ptr<IndenterSurface> Cone() const
  {
    const double angle = HalfAngle(), radius = TipRadius();
    return Made([&] { return CreateCone(geometry_, angle, radius); });
  }
  std::unique_ptr<IndenterSurface> Sphere() const
  {
    const double radius = Radius();
    return Made([&] { return CreateSphere(geometry_, radius); });
  }

  std::unique_ptr<IndenterSurface> Punch() const
  {
    double radius = NAN, width = NAN, edge = 0;
    if (reader_.Help() || geometry_ == GeometryKind::kPlaneStrain) {
      Read({"-indenter_width", "width of a flat punch in plane strain", "m", kPositive}, &width, kRequired);
      radius = 0.5 * width;
    }
    if (geometry_ != GeometryKind::kPlaneStrain) radius = Radius();
    Read({"-indenter_edge_radius", "radius of the rounded edge of a flat punch", "m", kNotNegative}, &edge);
    if (edge > radius) reader_.Refuse("-indenter_edge_radius", edge, "at most {}, half the width of the punch", radius);
    return Made([&] { return CreateFlatPunch(geometry_, radius, edge); });
  }

  std::unique_ptr<IndenterSurface> Polygon() const
  {
    std::vector<double> numbers;
    std::vector<Vec3> vertices;
    Read({"-indenter_vertices", "x,y of a convex polygon; its lowest vertex is put at the tip", "m", kAnyNumber, 6}, &numbers,
         kRequired);
    for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices.push_back({numbers[k], numbers[k + 1]});
    vertices = CornersOf(vertices);
    if (!reader_.Help() && (numbers.size() % 2 || !IsConvex(vertices)))
      reader_.Refuse("-indenter_vertices", Format("{} numbers", numbers.size()), "x,y pairs of a convex polygon");
    return Made([&] { return CreatePolygonIndenter(vertices); });
  }

  std::unique_ptr<IndenterSurface> NamedPyramidTip() const
  {
    const double radius = TipRadius(), turn = Turn();
    if (kind_ == "knoop") return CreateRhombicPyramid(kKnoopLong, kKnoopShort, turn, radius);
    const NamedPyramid *named = FindPyramid(kind_);
    return CreatePyramid(named->half_angle, named->faces, turn, radius);
  }
  std::unique_ptr<IndenterSurface> Pyramid() const
  {
    const double angle = HalfAngle(), radius = TipRadius(), turn = Turn();
    const int faces = Faces(3);
    return Made([&] { return CreatePyramid(angle, faces, turn, radius); });
  }

  /// notes: what people should know of the tip.
  std::unique_ptr<IndenterSurface> AreaTip(std::vector<std::string> *notes) const
  {
    std::vector<double> coefficients, range;
    const char *name = "-indenter_area_coefficients";
    Read({name, "C0,C1,C2,... of an area function C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) ...", "m^2 of h in m", kAnyNumber},
         &coefficients, kRequired);
    const bool bounded =
        Read({"-indenter_area_depths", "least and largest depth for which the function holds", "m", kNotNegative, 2, 2}, &range);
    int faces = 0;
    double turn = 0;
    if (geometry_ == GeometryKind::kSpatial || reader_.Help()) faces = Faces(0);
    if (faces > 0 || reader_.Help()) turn = Turn();
    if (reader_.Help()) return nullptr;
    if (bounded && !(range[0] < range[1]))
      reader_.Refuse("-indenter_area_depths", range[1], "above the least depth {}", range[0]);
    const double height = Height(), largest = bounded ? range[1] : height;
    const auto area = AreaFunction::Create(coefficients, bounded ? range[0] : 0, largest);
    if (!area)
      reader_.Refuse(
          name, coefficients.front(),
          "such that the area grows with the depth by a power of 1 to 2 somewhere below {} m; coefficients of nm are those of m "
          "times 1, 1e9, 10^13.5, 10^15.75, ...",
          largest);
    if (area->Begin() > 0)
      notes->push_back(Format("area function: taken from {} m on; below, the area falls like a power of the depth, to none at 0",
                              area->Begin()));
    const double shape = faces > 0 ? faces * std::tan(M_PI / faces) : M_PI;
    const HeightRange known{area->Begin(), bounded || area->End() < height ? area->End() : HUGE_VAL};
    const HeightProfile profile = area->ProfileOf(shape);
    return faces > 0 ? CreateProfilePyramid(profile, faces, turn, known) : CreateProfileTip(geometry_, profile, known);
  }

  std::unique_ptr<IndenterSurface> ProfileFromFile() const
  {
    std::string path;
    Read({"-indenter_profile", "file with two columns, distances from the axis and heights above the tip, from 0 0 on", "m"},
         &path, kRequired);
    if (reader_.Help()) return nullptr;
    const ProfileTable table = ReadProfileFile(reader_, "-indenter_profile", path);
    return CreateProfileTip(geometry_, ProfileThrough(table.distances, table.heights), {0, table.heights.back()});
  }

  std::unique_ptr<IndenterSurface> Map() const
  {
    std::string path;
    std::vector<double> size;
    Read({"-indenter_map",
          "file of a tip's heights over x and y, the tip down: a Gwyddion Simple Field (.gsf), or rows of "
          "numbers, the first row at the largest y",
          "m"},
         &path, kRequired);
    const bool sized =
        Read({"-indenter_map_size", "extents of a map of rows of numbers along x and y", "m", kPositive, 2, 2}, &size);
    if (reader_.Help()) return nullptr;
    return CreateMapTip(ReadMapFile(reader_, {"-indenter_map", path}, sized ? MapSize{size[0], size[1]} : MapSize{}));
  }

private:
  /// What is made of options that have been read; nothing with -help.
  template <class Make> std::unique_ptr<IndenterSurface> Made(Make make) const { return reader_.Help() ? nullptr : make(); }
  /// Reads an option; -help lists each once.
  template <class Value> bool Read(const Option &option, Value *value, bool required = false) const
  {
    return (!reader_.Help() || listed_.insert(option.name).second) && reader_.Read(option, value, required);
  }
  double Height() const { return c_.domain.upper[UpAxis(geometry_)] - c_.domain.lower[UpAxis(geometry_)]; }

  double HalfAngle() const
  {
    double angle = NAN;
    Read({"-indenter_half_angle", "angle of a face of a wedge, a cone or a pyramid from the axis", "degrees", Open(0, 90)},
         &angle, kRequired);
    if (!reader_.Help() && std::sin(angle * M_PI / 180) <= kMinFacing)
      reader_.Refuse("-indenter_half_angle", angle,
                     "above 5.74 degrees; contact acts on faces that lean toward the surface, and misses steeper ones");
    return angle;
  }
  double TipRadius() const
  {
    double radius = 0;
    Read({"-indenter_tip_radius", "radius of the rounded tip of a wedge, a cone or a pyramid", "m", kNotNegative}, &radius);
    return radius;
  }
  double Radius() const
  {
    double radius = NAN;
    Read({"-indenter_radius", "radius of a cylinder, a sphere or a round flat punch", "m", kPositive}, &radius, kRequired);
    return radius;
  }
  /// least: 3 for pyramids, 0 for what may also be a tip of revolution.
  int Faces(int least) const
  {
    const char *name = "-indenter_faces";
    int count = least == 0 ? 0 : 4;
    Read({name, "number of a pyramid's faces; 0 is a tip of revolution, of an area function", "", Closed(least, 360)}, &count);
    if (count == 1 || count == 2) reader_.Refuse(name, std::to_string(count), "0 for a tip of revolution, or at least 3");
    return count;
  }
  double Turn() const
  {
    double turn = 0;
    Read({"-indenter_turn",
          "angle of the normal of a pyramid's first face about the axis, from x; of knoop that of the long diagonal", "degrees"},
         &turn);
    return turn;
  }

  OptionReader &reader_;
  const std::string &kind_;
  GeometryKind geometry_;
  const Case &c_;
  mutable std::set<std::string> listed_; ///< by -help
};

/// Leans the tip, in space.
std::unique_ptr<IndenterSurface> Leant(OptionReader &reader, const std::string &kind, std::unique_ptr<IndenterSurface> upright)
{
  const char *name = "-indenter_tilt";
  std::vector<double> tilt;
  const bool given = reader.Read(
      {name, "angle of the indenter's axis from z, and the direction toward which it leans, from x", "degrees", kAnyNumber, 2, 2},
      &tilt);
  if (!given || reader.Help()) return upright;
  if (!(tilt[0] >= 0 && tilt[0] < 90)) reader.Refuse(name, tilt[0], "an angle in [0, 90), and a direction");
  if (tilt[0] == 0) return upright;
  auto leant = CreateTilted(std::move(upright), tilt[0], tilt[1]);
  if (!leant) reader.Refuse(name, tilt[0], "so small that a tip of kind {} still has a lowest point", kind);
  return leant;
}

} // namespace

double EquivalentHalfAngle(const std::string &kind)
{
  const NamedPyramid *pyramid = FindPyramid(kind);
  if (!pyramid) return 0;
  const double area =
      pyramid->faces * std::tan(M_PI / pyramid->faces); // of the polygon around a circle, over the circle's radius squared
  return std::atan(std::tan(pyramid->half_angle * M_PI / 180) * std::sqrt(area / M_PI)) * 180 / M_PI;
}

void ReadTip(OptionReader &reader, const std::string &kind, Case *c)
{
  using Read = std::unique_ptr<IndenterSurface> (*)(const TipReader &, std::vector<std::string> *);
  const Read cone = [](const TipReader &tip, auto *) { return tip.Cone(); };
  const Read sphere = [](const TipReader &tip, auto *) { return tip.Sphere(); };
  const Read named = [](const TipReader &tip, auto *) { return tip.NamedPyramidTip(); };
  const std::pair<const char *, Read> readers[] = {
      {"wedge", cone},
      {"cone", cone},
      {"cylinder", sphere},
      {"sphere", sphere},
      {"vickers", named},
      {"berkovich", named},
      {"knoop", named},
      {"cube_corner", named},
      {"flat_punch", [](const TipReader &tip, auto *) { return tip.Punch(); }},
      {"polygon", [](const TipReader &tip, auto *) { return tip.Polygon(); }},
      {"pyramid", [](const TipReader &tip, auto *) { return tip.Pyramid(); }},
      {"area_function", [](const TipReader &tip, auto *notes) { return tip.AreaTip(notes); }},
      {"profile", [](const TipReader &tip, auto *) { return tip.ProfileFromFile(); }},
      {"height_map", [](const TipReader &tip, auto *) { return tip.Map(); }},
  };
  const TipReader tip(reader, kind, *c);
  std::unique_ptr<IndenterSurface> surface;
  for (const auto &[name, read] : readers)
    if (kind == name || (reader.Help() && read != named)) surface = read(tip, &c->notes);
  if (c->model.geometry.kind == GeometryKind::kSpatial || reader.Help()) surface = Leant(reader, kind, std::move(surface));
  if (!surface && !reader.Help()) reader.Refuse("-indenter", kind, "a kind that ReadTip makes a surface for");
  c->model.indenter->surface = std::move(surface);
}

} // namespace mlgimp
