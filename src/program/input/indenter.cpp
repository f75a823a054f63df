// Options of the indenter and its motion.
#include "program/input/read_case.hpp"

#include "program/advice/case_checks.hpp"
#include "program/slow_test/plan.hpp"

#include "base/index.hpp"
#include "contact/contact.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

const std::vector<NamedInGeometry> kIndenters = {
    {"none", {true, true, true}},       {"wedge", {true, false, false}},       {"cylinder", {true, false, false}},
    {"flat_punch", {true, true, true}}, {"polygon", {true, false, false}},     {"cone", {false, true, true}},
    {"sphere", {false, true, true}},    {"pyramid", {false, false, true}},     {"berkovich", {false, false, true}},
    {"vickers", {false, false, true}},  {"cube_corner", {false, false, true}},
};

/// Pyramids that have a name: angle of a face from the axis, degrees.
struct NamedPyramid {
  const char *name;
  int faces;
  double half_angle;
};
constexpr NamedPyramid kPyramids[] = {{"berkovich", 3, 65.27}, {"vickers", 4, 68}, {"cube_corner", 3, 35.264389682754654}};

void ReadPolygon(OptionReader &reader, std::vector<Vec3> *vertices)
{
  std::vector<double> numbers;
  reader.Read({"-indenter_vertices", "x,y of a convex polygon; its lowest vertex is put at the tip", "m", kAnyNumber, 6},
              &numbers, kRequired);
  for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices->push_back({numbers[k], numbers[k + 1]});
  *vertices = CornersOf(*vertices);
  if (!reader.Help() && (numbers.size() % 2 || !IsConvex(*vertices)))
    reader.Refuse("-indenter_vertices", Format("{} numbers", numbers.size()), "x,y pairs of a convex polygon");
}

/// Sizes of a wedge, a cone or a pyramid, angles in degrees.
struct PointedShape {
  double half_angle = NAN, tip_radius = 0, turn = 0;
  int faces = 4;
};

/// For kinds that use all of it: an option that is read and not used would be taken without a word.
void ReadPointedShape(OptionReader &reader, const std::string &kind, bool pyramid, PointedShape *shape)
{
  for (const NamedPyramid &known : kPyramids)
    if (kind == known.name) shape->half_angle = known.half_angle, shape->faces = known.faces;
  if (std::isnan(shape->half_angle)) {
    reader.Read({"-indenter_half_angle", "angle of a face of a wedge, a cone or a pyramid from the axis", "degrees", Open(0, 90)},
                &shape->half_angle, kRequired);
    if (!reader.Help() && std::sin(shape->half_angle * M_PI / 180) <= kMinFacing)
      reader.Refuse("-indenter_half_angle", shape->half_angle,
                    "above 5.74 degrees; contact acts on faces that lean toward the surface, and misses steeper ones");
  }
  reader.Read({"-indenter_tip_radius", "radius of the rounded tip of a wedge, a cone or a pyramid", "m", kNotNegative},
              &shape->tip_radius);
  if (kind == "pyramid" || reader.Help())
    reader.Read({"-indenter_faces", "number of a pyramid's faces", "", Closed(3, 360)}, &shape->faces);
  if (pyramid || reader.Help())
    reader.Read({"-indenter_turn", "angle of the normal of a pyramid's first face about the axis, from x", "degrees"},
                &shape->turn);
}

void ReadSurface(OptionReader &reader, GeometryKind geometry, const std::string &kind, std::unique_ptr<IndenterSurface> *surface)
{
  const bool plane = geometry == GeometryKind::kPlaneStrain, punch = kind == "flat_punch";
  const bool cone = kind == "wedge" || kind == "cone", sphere = kind == "cylinder" || kind == "sphere";
  const bool named = std::any_of(std::begin(kPyramids), std::end(kPyramids), [&](auto &one) { return kind == one.name; });
  const bool pyramid = kind == "pyramid" || named;
  double radius = NAN, width = NAN;
  PointedShape shape;
  std::vector<Vec3> vertices;
  if (cone || pyramid || reader.Help()) ReadPointedShape(reader, kind, pyramid, &shape);
  if (sphere || (punch && !plane) || reader.Help())
    reader.Read({"-indenter_radius", "radius of a cylinder, a sphere or a round flat punch", "m", kPositive}, &radius, kRequired);
  if ((punch && plane) || reader.Help())
    reader.Read({"-indenter_width", "width of a flat punch in plane strain", "m", kPositive}, &width, kRequired);
  if (kind == "polygon" || reader.Help()) ReadPolygon(reader, &vertices);
  if (reader.Help()) return;
  if (cone) *surface = CreateCone(geometry, shape.half_angle, shape.tip_radius);
  if (sphere) *surface = CreateSphere(geometry, radius);
  if (punch) *surface = CreateFlatPunch(geometry, plane ? 0.5 * width : radius);
  if (pyramid) *surface = CreatePyramid(shape.half_angle, shape.faces, shape.turn, shape.tip_radius);
  if (kind == "polygon") *surface = CreatePolygonIndenter(vertices);
  if (!*surface) reader.Refuse("-indenter", kind, "a kind that ReadSurface makes a surface for");
}

/// Height of the highest body at the tip, also where that is on a body's side; of the highest of all where there is none.
double InitialSurface(const Case &c, const Indenter &indenter)
{
  double highest = -HUGE_VAL, found = -HUGE_VAL;
  for (const Body &body : c.model.bodies) {
    const Box bounds = body.region->Bounds();
    highest = std::max(highest, bounds.upper[indenter.up]);
    ForEach({{-1, indenter.up == 2 ? -1 : 0, 0}, {2, indenter.up == 2 ? 2 : 1, 1}}, [&](Index shift) {
      Vec3 x = indenter.tip;
      double height;
      for (int axis = 0; axis < indenter.up; ++axis) x[axis] += shift[axis] * 1e-6 * (bounds.upper[axis] - bounds.lower[axis]);
      if (SurfaceAbove(*body.region, x, indenter.up, &height)) found = std::max(found, height);
    });
  }
  return std::isfinite(found) ? found : highest;
}

/// Options that the other kind of control has are refused by name.
void RefuseGiven(OptionReader &reader, const std::string &option, const std::string &control)
{
  std::string text;
  if (reader.Read({option, "of another -indenter_control"}, &text))
    reader.Refuse(option, text, "left out with -indenter_control {}", control);
}

/// What load control asks of the rest of the case, and what follows from it.
void FinishLoadControl(OptionReader &reader, const PiecewiseLinear &force, Case *c)
{
  double wave_speed = 0;
  for (const char *option : {"-indenter_velocities", "-indenter_max_depth", "-indenter_unload_velocity"})
    RefuseGiven(reader, option, "load");
  if (c->model.contact.method != "pressure")
    reader.Refuse("-contact", c->model.contact.method, "pressure with -indenter_control load");
  if (c->levels > 1 && c->hierarchy.coupling == LevelCoupling::kPoints)
    reader.Refuse("-level_coupling", "points", "nodes with -indenter_control load");
  for (const auto &material : c->model.materials) wave_speed = std::max(wave_speed, material->SpeedOfSound());
  c->model.indenter->by_load = {force, kLargestSpeed * wave_speed};
  if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0) c->time.end_time = force.EndTime();
}

/// Sideways speeds, at the same times; an axis cannot move.
void ReadSideways(OptionReader &reader, const std::vector<double> &times, Case *c)
{
  const GeometryKind geometry = c->model.geometry.kind;
  for (int axis = 0; axis < (reader.Help() ? 2 : UpAxis(geometry)); ++axis) {
    const std::string name = Format("-indenter_velocities_{}", "xy"[axis]);
    std::vector<double> speeds;
    const bool given = reader.Read({name, "sideways speed at the times, with either -indenter_control", "m/s"}, &speeds);
    if (!given) continue;
    if (geometry == GeometryKind::kAxisymmetric) reader.Refuse(name, "", "left out with -geometry axisymmetric");
    if (speeds.size() != times.size())
      reader.Refuse(name, Format("{} values", speeds.size()), "as many as -indenter_times has: {}", times.size());
    if (c->MirrorsTip(axis))
      reader.Refuse(name, "", "left out where the tip is on a side of symmetry: the indenter's other half would move against it");
    c->model.indenter->sideways[axis] = PiecewiseLinear(times, speeds);
  }
}

/// The history of the speed or of the load.
void ReadControl(OptionReader &reader, Case *c)
{
  const std::vector<std::string> controls = {"displacement", "load"};
  const Option loads = {"-indenter_loads", "load at the times, of the part that is simulated, with -indenter_control load", "N",
                        kNotNegative};
  const bool by_test = !c->quasi_static.test.times.empty() && !reader.Help();
  std::string control = controls[by_test ? 1 : 0];
  PiecewiseLinear force;
  std::vector<double> none;
  reader.Choice({"-indenter_control", "what is given of the indenter, its speed or its load"}, controls, &control);
  if (by_test && control == "displacement")
    reader.Refuse("-indenter_control", control, "load with -test_times, or -indenter_depths given");
  if (by_test) {
    std::string times;
    reader.Read({"-indenter_times", "not used with -test_times"}, &times);
    reader.Read(loads, &c->quasi_static.test.loads, kRequired);
    FinishLoadControl(reader, PiecewiseLinear({0}, {0}), c);
  } else if (control == "displacement") {
    if (!reader.Help()) RefuseGiven(reader, loads.name, control);
    ReadHistory(reader, "-indenter_times", {"-indenter_velocities", "downward speed at the times, negative retracts", "m/s"},
                &c->model.indenter->motion.speed);
    if (reader.Help()) reader.Read(loads, &none, kRequired);
  } else {
    ReadHistory(reader, "-indenter_times", loads, &force);
    if (!reader.Help()) FinishLoadControl(reader, force, c);
  }
  ReadSideways(reader,
               by_test             ? std::vector<double>()
               : control == "load" ? force.Times()
                                   : c->model.indenter->motion.speed.Times(),
               c);
}

/// The turn at the largest depth, and the end of the run that follows from the motion.
void ReadTurningPoint(OptionReader &reader, Case *c)
{
  double depth = HUGE_VAL, unload = HUGE_VAL;
  Indenter &indenter = *c->model.indenter;
  const bool has_depth =
      reader.Read({"-indenter_max_depth", "tip depth below the body's initial surface that ends the run or turns to unloading",
                   "m", kPositive},
                  &depth);
  const bool has_unload =
      (has_depth || reader.Help()) &&
      reader.Read({"-indenter_unload_velocity", "speed of retraction from the largest depth on, until the tip is back", "m/s"},
                  &unload);
  if (has_unload && unload == 0) reader.Refuse("-indenter_unload_velocity", "0", "not zero");
  if (!has_depth || reader.Help()) return;
  const double travel = depth + indenter.tip[indenter.up] - indenter.initial_surface;
  if (travel <= 0)
    reader.Refuse("-indenter_tip", indenter.tip, "above {} = {}, the depth that -indenter_max_depth gives", "xyz"[indenter.up],
                  FormatNumber(indenter.initial_surface - depth));
  const double limit = std::isfinite(c->time.end_time) ? c->time.end_time : HUGE_VAL;
  const double reached = indenter.motion.speed.TimeOfIntegral(travel, limit);
  if (!std::isfinite(reached)) {
    if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0)
      reader.Refuse("-indenter_max_depth", depth, "reached by the indenter's motion, or -end_time given");
    if (std::isfinite(c->time.end_time))
      reader.WarnLater("-end_time {}: comes before the tip reaches -indenter_max_depth {}{}", FormatNumber(c->time.end_time),
                       FormatNumber(depth), has_unload ? ", so that it is never unloaded" : "");
    return;
  }
  if (has_unload) {
    indenter.motion.turning_time = reached;
    indenter.motion.unload_speed = std::abs(unload);
    c->time.end_time = std::min(c->time.end_time, reached + travel / std::abs(unload));
  } else {
    c->time.end_time = reached;
  }
}

} // namespace

void ReadIndenter(OptionReader &reader, Case *c)
{
  const GeometryKind geometry = c->model.geometry.kind;
  std::string kind = "none";
  std::vector<std::string> methods = ContactMethods(geometry);
  methods.push_back("none");
  ChooseInGeometry(reader, {"-indenter", "rigid indenter"}, geometry, kIndenters, &kind);
  reader.Choice({"-contact", "contact method"}, methods, &c->model.contact.method);
  ReadQuasiStatic(reader, kind != "none", &c->quasi_static);
  if (kind == "none" && !reader.Help()) return;
  ReadContact(reader, &c->model.contact);
  Indenter &indenter = c->model.indenter.emplace();
  indenter.up = UpAxis(geometry);
  ReadSurface(reader, geometry, kind, &indenter.surface);
  reader.Read({"-indenter_tip", "lowest point of the indenter at t = 0", "m"}, &indenter.tip, kRequired);
  const bool slow = c->quasi_static.on && !reader.Help();
  const double end_time = c->time.end_time;
  if (slow) c->time.end_time = HUGE_VAL; // it is of another clock than the schedule
  const bool by_depths = !c->quasi_static.turns.empty();
  if (!by_depths) ReadControl(reader, c);
  if (geometry == GeometryKind::kAxisymmetric && indenter.tip[0] != 0)
    reader.Refuse("-indenter_tip", indenter.tip, "on the axis, at x = 0, in -geometry axisymmetric");
  if (!reader.Help()) indenter.initial_surface = InitialSurface(*c, indenter);
  if (!indenter.by_load && !by_depths) ReadTurningPoint(reader, c);
  if (slow) PlanQuasiStatic(reader, end_time, c);
  c->hierarchy.tip_level = reader.Help() ? 0 : c->LevelAtTip();
  if (reader.Help()) return;
  CheckIndenterInput(reader, *c, kind);
}

} // namespace mlgimp
