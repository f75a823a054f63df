// Options of the indenter and its motion.
#include "program/case_groups.hpp"

#include "base/index.hpp"
#include "level/contact/contact.hpp"

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
  reader.Numbers({"-indenter_vertices", "x,y of a convex polygon; its lowest vertex is put at the tip", "m"}, kAnyNumber, 6, 0,
                 true, &numbers);
  for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices->push_back({numbers[k], numbers[k + 1]});
  if (!reader.Help() && (numbers.size() % 2 || !IsConvex(*vertices)))
    reader.Refuse("-indenter_vertices", std::to_string(numbers.size()) + " numbers", "x,y pairs of a convex polygon");
}

/// Sizes of a wedge, a cone or a pyramid, angles in degrees.
struct PointedShape {
  double half_angle = NAN, tip_radius = 0, turn = 0;
  int faces = 4;
};

void ReadPointedShape(OptionReader &reader, const std::string &kind, bool pyramid, PointedShape *shape)
{
  for (const NamedPyramid &known : kPyramids)
    if (kind == known.name) shape->half_angle = known.half_angle, shape->faces = known.faces;
  if (std::isnan(shape->half_angle)) {
    reader.Number({"-indenter_half_angle", "angle of a face of a wedge, a cone or a pyramid from the axis", "degrees"},
                  Open(0, 90), true, &shape->half_angle);
    if (!reader.Help() && std::sin(shape->half_angle * M_PI / 180) <= kLeastFacing)
      reader.Refuse("-indenter_half_angle", FormatNumber(shape->half_angle),
                    "above 5.74 degrees; contact acts on faces that lean toward the surface, and misses steeper ones");
  }
  reader.Number({"-indenter_tip_radius", "radius of the rounded tip of a wedge, a cone or a pyramid", "m"}, kNotNegative, false,
                &shape->tip_radius);
  if (kind == "pyramid" || reader.Help())
    reader.Integer({"-indenter_faces", "number of a pyramid's faces"}, Closed(3, 360), &shape->faces);
  if (pyramid || reader.Help())
    reader.Number({"-indenter_turn", "angle of the normal of a pyramid's first face about the axis, from x", "degrees"},
                  kAnyNumber, false, &shape->turn);
}

void ReadSurface(OptionReader &reader, GeometryKind geometry, const std::string &kind, std::unique_ptr<IndenterSurface> *surface)
{
  const bool plane = geometry == GeometryKind::kPlaneStrain, punch = kind == "flat_punch";
  const bool cone = kind == "wedge" || kind == "cone", sphere = kind == "cylinder" || kind == "sphere";
  const bool pyramid = !cone && !sphere && !punch && kind != "polygon";
  double radius = NAN, width = NAN;
  PointedShape shape;
  std::vector<Vec3> vertices;
  if (cone || pyramid || reader.Help()) ReadPointedShape(reader, kind, pyramid, &shape);
  if (sphere || (punch && !plane) || reader.Help())
    reader.Number({"-indenter_radius", "radius of a cylinder, a sphere or a round flat punch", "m"}, kPositive, true, &radius);
  if ((punch && plane) || reader.Help())
    reader.Number({"-indenter_width", "width of a flat punch in plane strain", "m"}, kPositive, true, &width);
  if (kind == "polygon" || reader.Help()) ReadPolygon(reader, &vertices);
  if (reader.Help()) return;
  if (cone) *surface = CreateCone(geometry, shape.half_angle, shape.tip_radius);
  if (sphere) *surface = CreateSphere(geometry, radius);
  if (punch) *surface = CreateFlatPunch(geometry, plane ? 0.5 * width : radius);
  if (pyramid) *surface = CreatePyramid(shape.half_angle, shape.faces, shape.turn, shape.tip_radius);
  if (kind == "polygon") *surface = CreatePolygonIndenter(vertices);
}

/// Height of a body under or above x along an axis; false where there is none.
bool SurfaceAbove(const Region &region, Vec3 x, int up, double *height)
{
  constexpr int kLattice = 4096;
  const double lower = region.Bounds().lower[up], upper = region.Bounds().upper[up], step = (upper - lower) / kLattice;
  for (int k = 0; k < kLattice; ++k) {
    double inside = upper - (k + 0.5) * step, outside = inside + step;
    x[up] = inside;
    if (!region.Contains(x)) continue;
    for (int halving = 0; halving < 40; ++halving) {
      x[up] = 0.5 * (inside + outside);
      (region.Contains(x) ? inside : outside) = x[up];
    }
    *height = std::abs(inside - upper) < 1e-9 * (upper - lower) ? upper : inside;
    return true;
  }
  return false;
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
  if (reader.Text({option, "of another -indenter_control"}, false, &text))
    reader.Refuse(option, text, "left out with -indenter_control " + control);
}

constexpr double kLargestSpeed = 0.1; ///< of the speed of waves; no indentation is as fast

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

/// The side of the domain across a horizontal axis that the tip is on.
std::optional<Side> SideAtTip(const Case &c, int axis)
{
  for (const bool upper : {false, true}) {
    const double side = upper ? c.domain.upper[axis] : c.domain.lower[axis];
    if (std::abs(c.model.indenter->tip[axis] - side) < kRounding * c.cell_size) return static_cast<Side>(2 * axis + upper);
  }
  return {};
}
bool IsSymmetry(const Case &c, std::optional<Side> side) { return side && c.model.sides[*side] == BoundaryKind::kSymmetry; }

/// Sideways speeds, at the same times; an axis cannot move.
void ReadSideways(OptionReader &reader, const std::vector<double> &times, Case *c)
{
  const GeometryKind geometry = c->model.geometry.kind;
  for (int axis = 0; axis < (reader.Help() ? 2 : UpAxis(geometry)); ++axis) {
    const std::string name = std::string("-indenter_velocities_") + "xy"[axis];
    std::vector<double> speeds;
    const bool given = reader.Numbers({name, "sideways speed at the times, with either -indenter_control", "m/s"}, kAnyNumber, 1,
                                      0, false, &speeds);
    if (!given) continue;
    if (geometry == GeometryKind::kAxisymmetric) reader.Refuse(name, "", "left out with -geometry axisymmetric");
    if (speeds.size() != times.size())
      reader.Refuse(name, std::to_string(speeds.size()) + " values",
                    "as many as -indenter_times has: " + std::to_string(times.size()));
    if (IsSymmetry(*c, SideAtTip(*c, axis)))
      reader.Refuse(name, "", "left out where the tip is on a side of symmetry: the indenter's other half would move against it");
    c->model.indenter->sideways[axis] = PiecewiseLinear(times, speeds);
  }
}

/// The history of the speed or of the load.
void ReadControl(OptionReader &reader, Case *c)
{
  const std::vector<std::string> controls = {"displacement", "load"};
  const OptionText loads = {"-indenter_loads", "load at the times, of the part that is simulated, with -indenter_control load",
                            "N"};
  std::string control = controls[0];
  PiecewiseLinear force;
  std::vector<double> none;
  reader.Choice({"-indenter_control", "what is given of the indenter, its speed or its load"}, controls, &control);
  if (control == "displacement") {
    if (!reader.Help()) RefuseGiven(reader, loads.name, control);
    ReadHistory(reader, "-indenter_times", {"-indenter_velocities", "downward speed at the times, negative retracts", "m/s"},
                kAnyNumber, &c->model.indenter->motion.speed);
    if (reader.Help()) reader.Numbers(loads, kNotNegative, 1, 0, true, &none);
  } else {
    ReadHistory(reader, "-indenter_times", loads, kNotNegative, &force);
    if (!reader.Help()) FinishLoadControl(reader, force, c);
  }
  ReadSideways(reader, control == "load" ? force.Times() : c->model.indenter->motion.speed.Times(), c);
}

/// The turn at the largest depth, and the end of the run that follows from the motion.
void ReadTurningPoint(OptionReader &reader, Case *c)
{
  double depth = HUGE_VAL, unload = 0;
  Indenter &indenter = *c->model.indenter;
  const bool has_depth = reader.Number(
      {"-indenter_max_depth", "tip depth below the body's initial surface that ends the run or turns to unloading", "m"},
      kPositive, false, &depth);
  const bool has_unload =
      (has_depth || reader.Help()) &&
      reader.Number({"-indenter_unload_velocity", "speed of retraction from the largest depth on, until the tip is back", "m/s"},
                    kAnyNumber, false, &unload);
  if (has_unload && unload == 0) reader.Refuse("-indenter_unload_velocity", "0", "not zero");
  if (!has_depth || reader.Help()) return;
  const double travel = depth + indenter.tip[indenter.up] - indenter.initial_surface;
  if (travel <= 0) reader.Refuse("-indenter_tip", reader.Text(indenter.tip), "above the depth that -indenter_max_depth gives");
  const double limit = std::isfinite(c->time.end_time) ? c->time.end_time : HUGE_VAL;
  const double reached = indenter.motion.speed.TimeOfIntegral(travel, limit);
  if (!std::isfinite(reached)) {
    if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0)
      reader.Refuse("-indenter_max_depth", FormatNumber(depth), "reached by the indenter's motion, or -end_time given");
    if (std::isfinite(c->time.end_time))
      reader.WarnLater("-end_time " + FormatNumber(c->time.end_time) + ": comes before the tip reaches -indenter_max_depth " +
                       FormatNumber(depth) + (has_unload ? ", so that it is never unloaded" : ""));
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

/// Lowest place of the tip during the run; -infinity where the end of the run is not known.
double LowestTip(const Indenter &indenter, double end_time)
{
  constexpr int kSamples = 1000;
  if (!std::isfinite(end_time) || indenter.by_load) return -HUGE_VAL;
  double lowest = indenter.Tip(std::min(end_time, indenter.motion.turning_time))[indenter.up];
  for (int k = 0; k <= kSamples; ++k) lowest = std::min(lowest, indenter.Tip(end_time * k / kSamples)[indenter.up]);
  return lowest;
}

/// A tip that starts far above the body, as by a wrong unit, or that does not come down to it.
void CheckReach(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  const double above = indenter.tip[indenter.up] - indenter.initial_surface;
  const double height = c.domain.upper[indenter.up] - c.domain.lower[indenter.up];
  const double nearest = LowestTip(indenter, c.time.end_time) - indenter.initial_surface;
  if (!std::isfinite(above)) return; // there is no body
  if (above > height)
    reader.Refuse("-indenter_tip", reader.Text(indenter.tip),
                  "at most the height of the domain, " + FormatRounded(height) + ", above the body; it is " +
                      FormatRounded(above));
  if (c.model.contact.method != "none" && nearest > 0)
    reader.WarnLater("-indenter_tip " + reader.Text(indenter.tip) + ": the indenter comes no nearer than " +
                     FormatRounded(nearest) + " m to the body until the end: there will be no contact");
}

/// A tip that is not slow beside waves, as by a wrong unit of Young's modulus: the load is that of inertia.
void CheckSpeed(OptionReader &reader, const Case &c)
{
  if (c.model.indenter->by_load || c.model.contact.method == "none") return;
  const double speed = c.model.indenter->Fastest(0, c.time.end_time);
  double slowest = HUGE_VAL;
  for (const auto &material : c.model.materials) slowest = std::min(slowest, material->SpeedOfSound());
  if (speed > kLargestSpeed * slowest)
    reader.WarnLater("-indenter: moves with up to " + FormatRounded(speed) + " m/s, where waves have " + FormatRounded(slowest) +
                     " m/s: that is an impact; is Young's modulus in Pa?");
}

/// Ends of the tip's way along a horizontal axis; up to the last of its times where the end of the run is not known.
std::array<double, 2> SidewaysWay(const Indenter &indenter, int axis, double end_time)
{
  constexpr int kSamples = 1000;
  const double start = indenter.tip[axis], end = std::isfinite(end_time) ? end_time : indenter.sideways[axis].EndTime();
  std::array<double, 2> way = {start, start};
  for (int k = 1; k <= kSamples; ++k) {
    const double x = start + indenter.Sideways(end * k / kSamples)[axis];
    way = {std::min(way[0], x), std::max(way[1], x)};
  }
  return way;
}

/// A tip on a side of symmetry is half of one that is the same beyond it; on another side the body ends at the tip.
void CheckMirror(OptionReader &reader, const Case &c, const std::string &kind)
{
  for (int axis = 0; axis < c.model.indenter->up; ++axis) {
    const std::optional<Side> side = SideAtTip(c, axis);
    if (!side || (axis == 0 && c.model.geometry.HasHoop())) continue;
    if (!IsSymmetry(c, side))
      reader.WarnLater(std::string("-boundary_") + kSideNames[*side] + ": the indenter's tip is on this side, where the body " +
                       "ends; with symmetry it would be half of a body that goes on");
    else if (!c.model.indenter->surface->MayBeMirrored(axis))
      reader.Refuse("-indenter", kind,
                    std::string("its own mirror image across ") + kSideNames[*side] +
                        ", a side of symmetry that the tip is on: take the side away from the tip, or turn the indenter");
  }
}

/// An indenter of which less than a cell ever meets the surface does not act, as a pressure belongs to a column of cells; one
/// that is curved and yet flat over the whole domain has a size in another unit.
void CheckIndenterSize(OptionReader &reader, const Case &c, const std::string &kind)
{
  const Indenter &indenter = *c.model.indenter;
  const int level = c.LevelAtTip();
  const double h = c.CellSize(level), depth = indenter.initial_surface - LowestTip(indenter, c.time.end_time);
  constexpr double kFlat = 0.1; // cells
  const std::string cell = FormatRounded(h) + " m, a cell of level " + std::to_string(level) + ", which it meets";
  if (indenter.surface->Width(HUGE_VAL) < h * (1 - kRounding))
    reader.Refuse("-indenter", kind,
                  "at least as wide as " + cell + "; it is " + FormatRounded(indenter.surface->Width(HUGE_VAL)) + " m wide");
  if (c.model.contact.method != "none" && depth > 0 && indenter.surface->Width(depth) < h)
    reader.WarnLater("-indenter " + kind + ": at its largest depth of " + FormatRounded(depth) + " m it is " +
                     FormatRounded(indenter.surface->Width(depth)) + " m wide, less than " + cell +
                     ": the load is that of the cells");
  double extent = 0;
  for (int axis = 0; axis < indenter.up; ++axis) extent = std::max(extent, c.domain.upper[axis] - c.domain.lower[axis]);
  if (indenter.surface->Width(0) < h && indenter.surface->Width(kFlat * h) > 2 * extent)
    reader.WarnLater("-indenter " + kind + ": is flat as far as the domain goes, as it rises there by less than " +
                     FormatNumber(kFlat) + " cells of level " + std::to_string(level) + "; are its sizes in m?");
}

/// A level that the tip meets must hold it with the band of its border for the whole run.
void CheckIndenterPath(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  const int up = indenter.up;
  const double lowest = LowestTip(indenter, c.time.end_time);
  for (int k = 1; k < c.levels; ++k) {
    const Box &box = c.boxes[k];
    const double margin = c.BorderMargin(k);
    const double just_below = indenter.initial_surface - 1e-6 * c.CellSize(k);
    bool meets = just_below >= box.lower[up] && just_below < box.upper[up];
    for (int axis = 0; axis < up; ++axis) {
      const auto [least, most] = SidewaysWay(indenter, axis, c.time.end_time);
      meets = meets && most >= box.lower[axis] - margin && least <= box.upper[axis] + margin;
    }
    if (!meets) continue;
    const std::string option = "-level_" + std::to_string(k), needed = "at least " + FormatRounded(margin);
    for (int axis = 0; axis < up; ++axis) {
      const auto [least, most] = SidewaysWay(indenter, axis, c.time.end_time);
      const auto from = [&, axis = axis](double x) {
        return needed + " from the indenter's tip at " + "xyz"[axis] + " = " + FormatNumber(x) + ", or the level away from it";
      };
      if (c.IsBorder(k, static_cast<Side>(2 * axis)) && least < box.lower[axis] + margin)
        reader.Refuse(option + "_lower", reader.Text(box.lower), from(least));
      if (c.IsBorder(k, static_cast<Side>(2 * axis + 1)) && most > box.upper[axis] - margin)
        reader.Refuse(option + "_upper", reader.Text(box.upper), from(most));
    }
    if (c.IsBorder(k, static_cast<Side>(2 * up)) && std::isfinite(lowest) && lowest < box.lower[up] + margin)
      reader.Refuse(option + "_lower", reader.Text(box.lower),
                    needed + " below the indenter's lowest place, " + FormatRounded(lowest));
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
  reader.Vector({"-indenter_tip", "lowest point of the indenter at t = 0", "m"}, true, &indenter.tip);
  const bool slow = c->quasi_static.on && !reader.Help();
  const double end_time = c->time.end_time;
  if (slow) c->time.end_time = HUGE_VAL; // it is of another clock than the schedule
  const bool by_depths = !c->quasi_static.turns.empty();
  if (!by_depths) ReadControl(reader, c);
  if (geometry == GeometryKind::kAxisymmetric && indenter.tip[0] != 0)
    reader.Refuse("-indenter_tip", reader.Text(indenter.tip), "on the axis, at x = 0, in -geometry axisymmetric");
  if (!reader.Help()) indenter.initial_surface = InitialSurface(*c, indenter);
  if (!indenter.by_load && !by_depths) ReadTurningPoint(reader, c);
  if (slow) PlanQuasiStatic(reader, end_time, c);
  c->hierarchy.tip_level = reader.Help() ? 0 : c->LevelAtTip();
  if (reader.Help()) return;
  CheckReach(reader, *c);
  CheckSpeed(reader, *c);
  CheckMirror(reader, *c, kind);
  CheckIndenterPath(reader, *c);
  CheckIndenterSize(reader, *c, kind);
}

} // namespace mlgimp
