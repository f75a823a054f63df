// Options of bodies and loads.
#include "program/input/read_case.hpp"

#include "program/advice/case_checks.hpp"

#include "base/index.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// Index of a name in a list that another option gave.
int FindName(OptionReader &reader, const std::string &option, const std::vector<std::string> &names, const std::string &list,
             const std::string &name)
{
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end() && !reader.Help()) reader.Refuse(option, name, "one of the names in {}: {}", list, Join(names, ", "));
  return found == names.end() ? 0 : static_cast<int>(found - names.begin());
}

const std::vector<NamedInGeometry> kShapes = {
    {"box", {true, true, true}},    {"disk", {true, true, false}},      {"polygon", {true, true, false}},
    {"ball", {false, false, true}}, {"cylinder", {false, false, true}},
};

void ReadBox(OptionReader &reader, int dim, const std::string &prefix, std::unique_ptr<Region> *region)
{
  Box box;
  reader.Read({prefix + "lower", "lower corner (box)", "m"}, &box.lower, kRequired);
  reader.Read({prefix + "upper", "upper corner (box)", "m"}, &box.upper, kRequired);
  for (int axis = 0; axis < dim && !reader.Help(); ++axis)
    if (!(box.upper[axis] > box.lower[axis]))
      reader.Refuse(prefix + "upper", box.upper, "above {}lower {}", prefix, reader.Text(box.lower));
  *region = CreateBoxRegion(box);
}

void ReadPolygon(OptionReader &reader, const std::string &prefix, std::unique_ptr<Region> *region)
{
  std::vector<double> numbers;
  std::vector<Vec3> vertices;
  reader.Read({prefix + "vertices", "x,y of the vertices in order (polygon)", "m", kAnyNumber, 6}, &numbers, kRequired);
  if (numbers.size() % 2) reader.Refuse(prefix + "vertices", Format("{} numbers", numbers.size()), "x,y pairs");
  for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices.push_back({numbers[k], numbers[k + 1]});
  if (reader.Help()) return;
  if (const std::string wrong = WrongPolygon(vertices); !wrong.empty())
    reader.Refuse(prefix + "vertices", "", "a polygon whose edges meet only at its vertices; {}", wrong);
  *region = CreatePolygonRegion(vertices);
}

void ReadRegion(OptionReader &reader, const Geometry &geometry, const std::string &name, std::string *shape,
                std::unique_ptr<Region> *region)
{
  const std::string prefix = "-" + name + "_";
  *shape = "box";
  ChooseInGeometry(reader, {prefix + "shape", "shape of the body"}, geometry.kind, kShapes, shape);
  const bool cylinder = *shape == "cylinder", round = cylinder || *shape == "disk" || *shape == "ball";
  if (*shape == "box" || reader.Help()) ReadBox(reader, geometry.Dim(), prefix, region);
  if (round || reader.Help()) {
    Vec3 center{};
    double radius = 0, height = 0;
    reader.Read({prefix + "center", "centre (disk, ball) or centre of the bottom (cylinder)", "m"}, &center, kRequired);
    reader.Read({prefix + "radius", "radius (disk, ball, cylinder)", "m", kPositive}, &radius, kRequired);
    if (cylinder || reader.Help())
      reader.Read({prefix + "height", "height along z (cylinder)", "m", kPositive}, &height, kRequired);
    *region = cylinder ? CreateCylinderRegion(center, radius, height) : CreateBallRegion(geometry.kind, center, radius);
  }
  if (*shape == "polygon" || reader.Help()) ReadPolygon(reader, prefix, region);
}

/// Cuts a round body at sides of the domain that hold it, as its image or what it stands on goes on beyond; not at the axis.
void CutAtHeldSides(const Case &c, std::unique_ptr<Region> *region)
{
  const Box bounds = (*region)->Bounds();
  Box part = kEverywhere;
  bool cuts = false;
  for (const Side side : SidesOf{c.Dim()}) {
    const double place = c.domain.At(side);
    const bool beyond = SignOf(side) * (bounds.At(side) - place) > 1e-9 * c.cell_size;
    if (!beyond || c.model.sides[side] == BoundaryKind::kFree || (c.model.geometry.HasHoop() && side == kXLower)) continue;
    (SignOf(side) < 0 ? part.lower : part.upper)[AxisOf(side)] = place;
    cuts = true;
  }
  if (cuts) *region = CreatePartOf(std::move(*region), part);
}

/// Whether two regions overlap: exact for two boxes; otherwise a lattice over the common part of their bounds is tested, with
/// points a tenth of a cell apart, up to kMaxPlaces along an axis.
bool Overlap(const Region &a, const Region &b, bool boxes, double cell, int dim)
{
  const double kPlaces = 10, kMinPlaces = dim == 3 ? 32 : 64, kMaxPlaces = dim == 3 ? 100 : 500; // size: in a cell; along an axis
  const Box A = a.Bounds(), B = b.Bounds();
  Vec3 lower{}, size{};
  IndexBox places{{0, 0, 0}, {1, 1, 1}};
  for (int d = 0; d < dim; ++d) {
    lower[d] = std::max(A.lower[d], B.lower[d]);
    size[d] = std::min(A.upper[d], B.upper[d]) - lower[d];
    if (size[d] <= 1e-9 * (A.upper[d] - A.lower[d])) return false;
    places.upper[d] = static_cast<int>(std::clamp(std::ceil(kPlaces * size[d] / cell), kMinPlaces, kMaxPlaces));
  }
  bool overlap = boxes;
  ForEach(places, [&](Index place) {
    Vec3 x{};
    for (int d = 0; d < dim; ++d) x[d] = lower[d] + (place[d] + 0.5) / places.upper[d] * size[d];
    overlap = overlap || (a.Contains(x, -kRounding * cell) && b.Contains(x, -kRounding * cell)); // outlines may meet
  });
  return overlap;
}

/// The option that places the side of a body that lies outside the domain; a region knows its bounds alone.
std::string PlaceOption(const std::string &shape, bool upper)
{
  if (shape == "polygon") return "vertices";
  if (shape == "box") return upper ? "upper" : "lower";
  return "center";
}

/// A body must lie inside the domain and clear of those before it.
void CheckPlace(OptionReader &reader, const Case &c, const Body &body, const std::string &shape,
                const std::vector<std::string> &shapes)
{
  const Box bounds = body.region->Bounds();
  const double tolerance = 1e-9 * c.cell_size;
  for (int d = 0; d < c.Dim(); ++d)
    for (const bool upper : {false, true}) {
      const double beyond = upper ? bounds.upper[d] - c.domain.upper[d] : c.domain.lower[d] - bounds.lower[d];
      if (beyond <= tolerance) continue;
      const std::string option = Format("-{}_{}", body.name, PlaceOption(shape, upper));
      reader.Refuse(option, shape == "box" ? reader.Text(upper ? bounds.upper : bounds.lower) : "",
                    "inside the domain, {} to {}; body {} reaches from {} to {}", reader.Text(c.domain.lower),
                    reader.Text(c.domain.upper), body.name, reader.Text(bounds.lower), reader.Text(bounds.upper));
    }
  if (c.model.geometry.HasHoop() && body.region->Bounds().lower[0] <= 0 && body.velocity[0] != 0)
    reader.Refuse(Format("-{}_velocity", body.name), body.velocity, "0 along x: the body reaches the axis, which stays");
  for (std::size_t k = 0; k < c.model.bodies.size(); ++k) {
    const Body &other = c.model.bodies[k];
    if (Overlap(*body.region, *other.region, shape == "box" && shapes[k] == "box", c.CellSize(c.levels - 1), c.Dim()))
      reader.Refuse("-bodies", body.name, "clear of body {}: they overlap", other.name);
  }
  WarnOfGaps(reader, c, body);
}

/// Leaves out materials that no body has, so that no default hangs on them.
void KeepMaterialsOfBodies(OptionReader &reader, const std::vector<std::string> &names, Model *model)
{
  std::vector<std::unique_ptr<Material>> kept;
  std::vector<int> place(names.size(), -1);
  for (Body &body : model->bodies) {
    int &to = place[body.material];
    if (to < 0) {
      to = static_cast<int>(kept.size());
      kept.push_back(std::move(model->materials[body.material]));
    }
    body.material = to;
  }
  for (std::size_t m = 0; m < names.size(); ++m)
    if (place[m] < 0) reader.WarnLater("-materials {}: no body has it, and it has no effect", names[m]);
  model->materials = std::move(kept);
}

} // namespace

void ChooseInGeometry(OptionReader &reader, const Option &option, GeometryKind geometry,
                      const std::vector<NamedInGeometry> &values, std::string *value)
{
  std::vector<std::string> all, here;
  const int place = static_cast<int>(geometry);
  for (const NamedInGeometry &one : values) {
    all.emplace_back(one.name);
    if (one.has[place]) here.emplace_back(one.name);
  }
  reader.Choice(option, all, value);
  if (std::find(here.begin(), here.end(), *value) == here.end())
    reader.Refuse(option.name, *value, "one of {} in -geometry {}", Join(here, ", "), kGeometryNames[place]);
}

void ReadBodies(OptionReader &reader, const std::vector<std::string> &materials, Case *c, std::vector<std::string> *names)
{
  std::vector<std::string> shapes;
  reader.Read({"-bodies", "names of the bodies"}, names, kRequired);
  for (const std::string &name : *names) {
    const std::string prefix = "-" + name + "_";
    Body body{name, nullptr, 0, {}, 2};
    std::string shape, material = materials.size() == 1 ? materials[0] : "";
    ReadRegion(reader, c->model.geometry, name, &shape, &body.region);
    if (!reader.Help() && shape != "box" && shape != "polygon") CutAtHeldSides(*c, &body.region);
    reader.Read({prefix + "material", "name of its material (default: the only one, else required)"}, &material,
                materials.size() > 1);
    body.material = FindName(reader, prefix + "material", materials, "-materials", material);
    reader.Read({prefix + "velocity", "initial velocity", "m/s"}, &body.velocity);
    reader.Read({prefix + "points_per_cell", "material points per direction in a cell", "", Closed(1, 16)},
                &body.points_per_cell);
    ReadInitialStress(reader, c->model, &body);
    if (!reader.Help()) CheckPlace(reader, *c, body, shape, shapes);
    shapes.push_back(shape);
    c->model.bodies.push_back(std::move(body));
  }
  if (!reader.Help()) KeepMaterialsOfBodies(reader, materials, &c->model);
}

bool ReadTimes(OptionReader &reader, const std::string &name, bool required, std::vector<double> *times)
{
  const bool given = reader.Read({name, "times of the history, increasing", "s", kNotNegative}, times, required);
  for (std::size_t k = 1; k < times->size() && !reader.Help(); ++k)
    if ((*times)[k] <= (*times)[k - 1]) reader.Refuse(name, (*times)[k], "increasing");
  return given;
}

void ReadHistory(OptionReader &reader, const std::string &times_name, const Option &values_text, PiecewiseLinear *history)
{
  std::vector<double> times, values;
  ReadTimes(reader, times_name, true, &times);
  reader.Read(values_text, &values, kRequired);
  if (reader.Help()) return;
  if (times.size() != values.size())
    reader.Refuse(values_text.name, Format("{} values", values.size()), "as many as {} has: {}", times_name, times.size());
  *history = PiecewiseLinear(times, values);
}

void ReadLoads(OptionReader &reader, const std::vector<std::string> &bodies, Case *c)
{
  std::vector<std::string> names;
  const std::vector<std::string> sides(kSideNames, kSideNames + 2 * c->Dim());
  reader.Read({"-loads", "names of pressures on sides of bodies"}, &names);
  for (const std::string &name : names) {
    const std::string prefix = "-" + name + "_";
    Load load{0, kXLower, {{-HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, HUGE_VAL}}, {}};
    std::string body = bodies[0], side = sides[0];
    const std::size_t numbers = 2 * (c->Dim() - 1);
    std::vector<double> span(&load.span[0][0], &load.span[0][0] + numbers);
    reader.Read({prefix + "body", "name of the body (default: the only one, else required)"}, &body, bodies.size() > 1);
    load.body = FindName(reader, prefix + "body", bodies, "-bodies", body);
    load.side = static_cast<Side>(reader.Choice({prefix + "side", "side of the body"}, sides, &side));
    reader.Read({prefix + "span", "start,end along the side, in 3d two pairs (default: the whole side)", "m", kAnyNumber, numbers,
                 numbers},
                &span);
    std::copy_n(span.begin(), numbers, &load.span[0][0]);
    for (int k = 0; k < c->Dim() - 1; ++k)
      if (!(load.span[k][1] > load.span[k][0]))
        reader.Refuse(prefix + "span", Format("{},{}", FormatNumber(load.span[k][0]), FormatNumber(load.span[k][1])),
                      "start,end with end above start");
    ReadHistory(reader, prefix + "times", {prefix + "pressures", "pressure at the times, positive into the body", "Pa"},
                &load.pressure);
    c->model.loads.push_back(load);
    c->load_names.push_back(name);
  }
  Vec3 &gravity = c->model.nodal.gravity;
  reader.Read({"-gravity", "body acceleration", "m/s2"}, &gravity);
  if (c->model.geometry.HasHoop() && gravity[0] != 0)
    reader.Refuse("-gravity", gravity, "0 along x, which is away from the axis on all sides");
}

} // namespace mlgimp
