// Options of the indenter and its motion.
#include "program/input/read_case.hpp"

#include "program/options/presets.hpp"

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

/// What a free tip asks of the rest of the case. why: the option that makes it free.
void CheckFreeTip(OptionReader &reader, const char *why, const Case &c)
{
  if (c.model.contact.method != "pressure") reader.Refuse("-contact", c.model.contact.method, "pressure with {}", why);
  if (c.levels > 1 && c.hierarchy.coupling == LevelCoupling::kPoints)
    reader.Refuse("-level_coupling", "points", "nodes with {}", why);
}

/// What load control asks of the rest of the case, and what follows from it.
void FinishLoadControl(OptionReader &reader, const PiecewiseLinear &force, Case *c)
{
  for (const char *option : {"-indenter_velocities", "-indenter_max_depth", "-indenter_unload_velocity"})
    RefuseGiven(reader, option, "load");
  CheckFreeTip(reader, "-indenter_control load", *c);
  c->model.indenter->by_load = force;
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

/// What gives way between the tip and what moves it. Sides of symmetry through the tip leave a part of the indenter its part of
/// the force.
void ReadCompliance(OptionReader &reader, Case *c)
{
  Indenter &indenter = *c->model.indenter;
  const bool plane = c->model.geometry.kind == GeometryKind::kPlaneStrain;
  double stiffness = HUGE_VAL, modulus = HUGE_VAL, ratio = 0;
  const bool sprung =
      reader.Read({"-indenter_stiffness", "of frame or cantilever, in series with the whole indenter; inf is rigid", "N/m",
                   OrInfinity(kPositive)},
                  &stiffness);
  const bool elastic =
      reader.Read({"-indenter_youngs_modulus", "of the tip, which gives way by (1 - nu^2)/(2 a E) of the load; inf is rigid",
                   "Pa", OrInfinity(kPositive)},
                  &modulus);
  const bool has_ratio = reader.Read({"-indenter_poissons_ratio", "of the tip", "", {-1, 0.5, true, false}}, &ratio);
  if (reader.Help()) return;
  if (elastic && plane)
    reader.Refuse("-indenter_youngs_modulus", modulus,
                  "left out in -geometry plane_strain, where depths grow with the body's size");
  if (has_ratio && !elastic) reader.Refuse("-indenter_poissons_ratio", ratio, "left out without -indenter_youngs_modulus");
  const double parts = c->PartsOfTip();
  indenter.compliance = {parts / stiffness, parts * (1 - ratio * ratio) / (2 * modulus), !c->model.Flows(),
                         0.5 * c->CellSize(c->LevelAtTip())};
  for (const auto &material : c->model.materials)
    indenter.compliance.wave_speed = std::max(indenter.compliance.wave_speed, material->SpeedOfSound());
  indenter.largest_speed = kLargestSpeed * indenter.compliance.wave_speed;
  if (indenter.compliance.Any())
    CheckFreeTip(reader, sprung && std::isfinite(stiffness) ? "-indenter_stiffness" : "-indenter_youngs_modulus", *c);
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
  std::vector<std::string> kinds;
  for (const NamedInGeometry &one : IndenterKinds()) kinds.emplace_back(one.name);
  if (!reader.Help())
    ReadTipPreset(reader, geometry == GeometryKind::kAxisymmetric ? EquivalentHalfAngle : nullptr, kinds, &c->notes);
  ChooseInGeometry(reader, {"-indenter", "indenter, or one of the tips that -presets lists"}, geometry, IndenterKinds(), &kind);
  reader.Choice({"-contact", "contact method"}, methods, &c->model.contact.method);
  ReadQuasiStatic(reader, kind != "none", &c->quasi_static);
  if (kind == "none" && !reader.Help()) return;
  ReadContact(reader, &c->model.contact);
  Indenter &indenter = c->model.indenter.emplace();
  indenter.up = UpAxis(geometry);
  ReadTip(reader, kind, c);
  reader.Read({"-indenter_tip", "lowest point of the indenter at t = 0", "m"}, &indenter.tip, kRequired);
  const bool slow = c->quasi_static.on && !reader.Help();
  const double end_time = c->time.end_time;
  if (slow) c->time.end_time = HUGE_VAL; // it is of another clock than the schedule
  const bool by_depths = !c->quasi_static.turns.empty();
  if (!by_depths) ReadControl(reader, c);
  if (geometry == GeometryKind::kAxisymmetric && indenter.tip[0] != 0)
    reader.Refuse("-indenter_tip", indenter.tip, "on the axis, at x = 0, in -geometry axisymmetric");
  if (!reader.Help()) indenter.initial_surface = InitialSurface(*c, indenter);
  ReadCompliance(reader, c);
  if (!indenter.by_load && !by_depths) ReadTurningPoint(reader, c);
  if (slow) PlanQuasiStatic(reader, end_time, c);
  c->hierarchy.tip_level = reader.Help() ? 0 : c->LevelAtTip();
  if (reader.Help()) return;
  CheckIndenterInput(reader, *c, kind);
}

} // namespace mlgimp
