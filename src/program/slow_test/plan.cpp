// The plan of a slow test: speeds, ramps, holds and damping from the size of the body and its materials.
#include "program/slow_test/plan.hpp"

#include "base/index.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

// By measurement (docs/indentation.md): inertia and damping of the ratio kDampingRatio add about kLoadPerTransit/N to the load.
constexpr double kLoadPerTransit = 0.4, kMinTransits = 8, kDampingRatio = 0.1, kMetalDampingRatio = 0.05;
constexpr double kFarField = 2;        ///< (pace where a contact alone moves / where the whole body does)^2 over a/R
constexpr double kCfl = 0.6;           ///< of a slow test, whose waves are smooth
constexpr double kXpicFraction = 0.02; ///< in holds and slow motion the noise of velocities does not go by itself
constexpr double kPlaneStrain = 2;     ///< more transits where the load grows like the depth, and its beginning counts
constexpr double kLoadControl = 2;     ///< more transits for metals, whose depth lags behind their load
constexpr double kMaxStress = 15;      ///< of rho c V over the shear yield stress, times the tolerance

/// The material that holds a place; null where no body is.
const Material *MaterialAt(const Model &model, Vec3 x)
{
  for (const Body &body : model.bodies)
    if (body.region->Contains(x)) return model.materials[body.material].get();
  return nullptr;
}

/// Time that waves take for a length, s/m: of pressure, or, where they are much faster than those of shear, as in nearly
/// incompressible bodies, so much of the latter's as at a Poisson's ratio of 0.4; what is slow to come to rest is shear.
double Slowness(const Material &material)
{
  const double kRatio = std::sqrt(6); // of the two speeds at 0.4
  return std::max(1 / material.SpeedOfSound(), std::sqrt(material.Density() / material.Elastic().mu) / kRatio);
}

constexpr int kSamples = 40; // size: of the domain along each axis

/// Calls work(material, layer) for places spread over the domain that lie in a body; layers are counted along the last axis.
template <class Work> void ForEachSample(const Case &c, Work work)
{
  const Vec3 step = (1.0 / kSamples) * (c.domain.upper - c.domain.lower);
  ForEach({{0, 0, 0}, {kSamples, kSamples, c.Dim() == 3 ? kSamples : 1}}, [&](Index k) {
    Vec3 x = c.domain.lower;
    for (int axis = 0; axis < c.Dim(); ++axis) x[axis] += (k[axis] + 0.5) * step[axis];
    if (const Material *material = MaterialAt(c.model, x)) work(*material, k[c.Dim() - 1]);
  });
}

/// Mean of the time that waves take for a length over all bodies, s/m.
double MeanSlowness(const Case &c)
{
  double sum = 0;
  int count = 0;
  ForEachSample(c, [&](const Material &material, int) { sum += Slowness(material), ++count; });
  return count > 0 ? sum / count : Slowness(*c.model.materials[c.model.bodies[0].material]);
}

/// Where the tip meets the body, just inside it.
Vec3 ContactPlace(const Case &c)
{
  constexpr double kInside = 1e-6; // rounding: of the domain
  const Indenter &indenter = *c.model.indenter;
  Vec3 x = indenter.tip;
  x[indenter.up] = indenter.initial_surface;
  for (int axis = 0; axis < c.Dim(); ++axis) {
    const double margin = kInside * (c.domain.upper[axis] - c.domain.lower[axis]);
    const double lower = c.domain.lower[axis] + margin, upper = c.domain.upper[axis] - margin;
    x[axis] = std::clamp(axis == indenter.up ? x[axis] - margin : x[axis], lower, upper);
  }
  return x;
}

/// The longest path within the bodies from the contact along an axis towards a side of the domain.
double PathTowards(const Case &c, Side side)
{
  const Indenter &indenter = *c.model.indenter;
  const int axis = AxisOf(side);
  const double from = axis == indenter.up ? indenter.initial_surface : indenter.tip[axis];
  double longest = 0;
  for (const Body &body : c.model.bodies) longest = std::max(longest, std::abs(body.region->Bounds().At(side) - from));
  return longest;
}

/// The longest of these paths, or of those to a side that is held.
double LongestPath(const Case &c, bool held)
{
  double longest = 0;
  for (const Side side : SidesOf{c.Dim()})
    if (!held || c.model.sides[side] != BoundaryKind::kFree) longest = std::max(longest, PathTowards(c, side));
  return longest;
}

/// Whether bodies stand on a side of the domain that holds them, with half of their widest section at least: others bend or rock.
bool StandsOnSupport(const Case &c)
{
  const int up = c.model.indenter->up;
  int sections[kSamples] = {};
  ForEachSample(c, [&](const Material &, int layer) { ++sections[layer]; });
  if (2 * sections[0] < *std::max_element(std::begin(sections), std::end(sections))) return false;
  for (const Side side : SidesAcross(up))
    for (const Body &body : c.model.bodies)
      if (c.domain.At(side) < c.model.indenter->initial_surface && c.model.sides[side] != BoundaryKind::kFree &&
          std::abs(body.region->Bounds().At(side) - c.domain.At(side)) < kRounding * c.cell_size)
        return true;
  return false;
}

/// The path of a wave to the support; where nothing lies between the tip and the sides that are held, to any end of the bodies.
double WavePath(const Case &c)
{
  const double held = LongestPath(c, true);
  return held < kRounding * c.cell_size ? LongestPath(c, false) : held;
}

/// Exponent m of an elastic load over depth, P ~ h^m, from the width of the indenter; in plane strain there is only a logarithm.
double LoadExponent(const Case &c, double depth)
{
  const IndenterSurface &surface = *c.model.indenter->surface;
  if (c.model.geometry.kind == GeometryKind::kPlaneStrain) return 1;
  const double wider = surface.Width(2 * depth) / surface.Width(depth);
  return std::isfinite(wider) ? 1 + std::log2(wider) : 1;
}

/// Share of a depth that comes back until half of the load is gone: 1 - 2^(-1/m) of what is elastic. In a metal that is
/// m P/S = m pi H a/(2 E*), with a hardness H.
double SpringBack(const Case &c, double exponent, double depth)
{
  const double half = 1 - std::pow(0.5, 1 / exponent);
  const Material *material = MaterialAt(c.model, ContactPlace(c));
  if (!material || !(depth > 0)) return half;
  const double slope = 0.5 * c.model.indenter->surface->Width(depth) / depth; // a/h
  return half *
         std::min(1.0, exponent * M_PI / 2 * ContactPressureOfFlow(*material) / material->Elastic().PlaneModulus() * slope);
}

/// The speed from which on inertia presses a metal noticeably: rho c V against the shear yield stress sy/sqrt 3.
double MaxSpeed(const Case &c)
{
  double fastest = HUGE_VAL;
  for (const auto &material : c.model.materials)
    fastest = std::min(fastest, kMaxStress * c.quasi_static.tolerance * material->FlowStress(0) / std::sqrt(3) /
                                    (material->Density() * material->SpeedOfSound()));
  return fastest;
}

/// Whether all bodies are boxes whose sides lie on lines of cells of level 0. Others may have thin points, which bear shorter
/// steps alone (CheckThinPoints in src/program/advice/start_checks.cpp).
bool LiesOnCellLines(const Case &c)
{
  for (const Body &body : c.model.bodies)
    for (const Side side : SidesOf{c.Dim()}) {
      const int axis = AxisOf(side);
      const double cells = (body.region->Bounds().At(side) - c.domain.lower[axis]) / c.cell_size;
      if (!body.region->IsBox() || std::abs(cells - std::round(cells)) > kRounding * std::max(1.0, std::abs(cells))) return false;
    }
  return true;
}

/// Half the width of the contact at the largest load, m, or more: as in an elastic half space, P = 0.6 E* a h, or as where all
/// of it flows, P = H pi a^2, whichever is wider.
double HalfWidthOfLoad(const Case &c, double load)
{
  constexpr double kElastic = 0.6; // exact: a bound below 2/pi, that of a cone with the tip's own width; of a ball it is 0.94
  const Indenter &indenter = *c.model.indenter;
  const Material *material = MaterialAt(c.model, ContactPlace(c));
  if (!material) return HUGE_VAL;
  const auto carries = [&](double depth) {
    const double a = indenter.HalfWidth(depth);
    const double whole =
        std::min(kElastic * material->Elastic().PlaneModulus() * a * depth, ContactPressureOfFlow(*material) * M_PI * a * a);
    return whole / c.PartsOfTip();
  };
  double depth = kRounding * c.cell_size;
  for (; carries(depth) < load; depth *= 2)
    if (depth > c.domain.upper[indenter.up] - c.domain.lower[indenter.up]) return HUGE_VAL;
  return indenter.HalfWidth(depth);
}

/// Pace over that where the whole body moves with the tip. Around a contact of half width a a body that stands on a support moves
/// as a/r, so that its kinetic energy over the strain energy is as (a/R)/N^2, R the distance of its sides and N the transits: the
/// same with N as (a/R)^(1/2) (docs/indentation.md). In plane strain the motion reaches all ends.
double PaceOfContact(const Case &c, double half_width)
{
  if (c.model.geometry.kind == GeometryKind::kPlaneStrain || !StandsOnSupport(c)) return 1;
  double nearest = HUGE_VAL;
  for (const Side side : SidesOf{c.Dim()}) {
    const double path = PathTowards(c, side);
    if (path > kRounding * c.cell_size) nearest = std::min(nearest, path);
  }
  return std::sqrt(std::min(1.0, kFarField * half_width / nearest));
}

/// Transits of a loading in which inertia and damping add no more than the tolerance to the load.
double Transits(const Case &c, double pace)
{
  const double transits = std::max(kMinTransits, std::ceil(kLoadPerTransit * pace / c.quasi_static.tolerance - 1e-9));
  return c.model.geometry.kind == GeometryKind::kPlaneStrain ? kPlaneStrain * transits : transits;
}

/// Loads and gravity rise from nothing, and the bodies come to rest, before the tip starts: what begins at once is a blow.
void PlanRise(Case *c)
{
  QuasiStaticPlan &plan = c->quasi_static;
  if (c->model.loads.empty() && c->model.nodal.gravity == Vec3{}) return;
  plan.rise = Transits(*c, 1) * plan.pace.transit;
  plan.pace.start = plan.rise + SlowPace::kHold * plan.pace.transit;
  for (Load &load : c->model.loads) load.pressure = SmoothRise(load.pressure.EndValue(), plan.rise);
  c->model.gravity_share = SmoothRise(1, plan.rise);
}

/// Turns with small unloadings at even parts of the first loading, from a place on; a loading that ends there is unloaded as
/// well. half(x): where half of the load at x is left.
template <class Half> std::vector<double> WithUnloadings(const std::vector<double> &turns, int count, double from, Half half)
{
  if (count == 0) return turns;
  std::vector<double> all = {turns[0]};
  for (int k = 1; k <= count; ++k) {
    const double x = from + (turns[1] - from) * k / count;
    all.push_back(x);
    if (k < count || turns.size() == 2) all.push_back(half(x));
  }
  all.insert(all.end(), turns.begin() + 2, turns.end());
  return all;
}

/// Turns of the travel that was read, m, from 0 on; gap: what is left of it before the surface.
std::vector<double> TravelTurns(OptionReader &reader, const Case &c, double gap)
{
  std::vector<double> turns = {0};
  const TestPlan &test = c.quasi_static.test;
  const std::vector<double> ends = test.On() ? EndsOf(test.legs) : std::vector<double>();
  for (std::size_t k = 1; k < ends.size(); ++k) turns.push_back(gap + ends[k]);
  for (std::size_t k = 0; k < c.quasi_static.turns.size() && !test.On(); ++k) turns.push_back(gap + c.quasi_static.turns[k]);
  if (turns.size() > 1) return turns;
  const IndenterMotion &motion = c.model.indenter->motion;
  const bool comes_back = std::isfinite(motion.turning_time);
  const double end = comes_back ? motion.turning_time : std::isfinite(c.time.end_time) ? c.time.end_time : motion.speed.EndTime();
  if (end == 0) reader.Refuse("-indenter_max_depth", "", "given with -quasi_static, or more than one of -indenter_times");
  turns = motion.speed.TurnsOfIntegral(end);
  if (comes_back) turns.push_back(0);
  return turns;
}

/// The legs of a test through values at its times, and what its clock has to know of the body.
void PlanTest(OptionReader &reader, const std::vector<double> &values, const char *option, Case *c)
{
  TestPlan &test = c->quasi_static.test;
  if (test.times.empty()) return;
  if (values.size() != test.times.size())
    reader.Refuse("-test_times", Format("{} values", test.times.size()), "as many as {} has: {}", option, values.size());
  if (values.size() < 2 && values.front() == 0) reader.Refuse(option, 0.0, "more than nothing at some time");
  test.legs = LegsOf(values, test.times);
  if (test.legs.front().Holds()) reader.Refuse(option, 0.0, "above 0 at the second of -test_times: nothing happens before");
}

void PlanDepths(OptionReader &reader, Case *c)
{
  QuasiStaticPlan &plan = c->quasi_static;
  Indenter &indenter = *c->model.indenter;
  const double gap = indenter.tip[indenter.up] - indenter.initial_surface;
  PlanTest(reader, plan.turns, "-indenter_depths", c);
  std::vector<double> turns = TravelTurns(reader, *c, gap);
  plan.depth = *std::max_element(turns.begin(), turns.end()) - gap;
  if (!(plan.depth > 0)) reader.Refuse("-quasi_static", "true", "with an indenter that comes below the body's surface");
  plan.exponent = LoadExponent(*c, plan.depth);
  plan.pace.transits = Transits(*c, PaceOfContact(*c, indenter.HalfWidth(plan.depth)));
  plan.pace.max_speed = MaxSpeed(*c);
  plan.pace.spring_back = SpringBack(*c, plan.exponent, plan.depth);
  turns = WithUnloadings(turns, plan.unloadings, gap,
                         [&](double x) { return x - SpringBack(*c, plan.exponent, x - gap) * (x - gap); });
  const SlowSchedule schedule(plan.pace, turns, gap);
  indenter.motion = {schedule.Speed()};
  plan.test.Place(schedule.Legs());
  plan.largest_speed = schedule.LargestSpeed();
  plan.end_time = schedule.EndTime();
  plan.holds = schedule.Holds();
}

/// Under load control the m-th root of the load takes the place of the depth.
void PlanLoads(OptionReader &reader, Case *c)
{
  QuasiStaticPlan &plan = c->quasi_static;
  PiecewiseLinear &force = *c->model.indenter->by_load;
  PlanTest(reader, plan.test.loads, "-indenter_loads", c);
  std::vector<double> turns = plan.test.On() ? EndsOf(plan.test.legs) : force.Turns();
  plan.load = *std::max_element(turns.begin(), turns.end());
  if (!(plan.load > 0)) reader.Refuse("-quasi_static", "true", "with a load above 0");
  plan.exponent = LoadExponent(*c, c->CellSize(c->LevelAtTip()));
  plan.pace.transits = Transits(*c, PaceOfContact(*c, HalfWidthOfLoad(*c, plan.load)));
  if (c->model.Flows()) plan.pace.transits *= kLoadControl;
  plan.pace.spring_back = 1 - std::pow(0.5, 1 / plan.exponent);
  for (double &load : turns) load = std::pow(load, 1 / plan.exponent);
  if (turns.front() > 0) turns.insert(turns.begin(), 0.0);
  turns = WithUnloadings(turns, plan.unloadings, 0, [&](double x) { return (1 - plan.pace.spring_back) * x; });
  const SlowSchedule schedule(plan.pace, turns);
  force = schedule.Power(plan.exponent);
  plan.test.Place(schedule.Legs());
  plan.end_time = schedule.EndTime();
  plan.holds = schedule.Holds();
}

/// The time of the test that the schedule stands for, where a material knows its rates.
std::string RatesText(const Case &c, const QuasiStaticPlan &plan)
{
  if (plan.test.On())
    return Format(", and holds as long as what creeps in them needs, that of a test of {} s", plan.test.legs.back().times.back());
  return c.model.HasRate() ? Format(", by -rate_scale that of a test of {} s", plan.end_time / c.time.rate_scale) : "";
}

/// What was chosen, in one line, and what the user should know of it, each in one.
void Describe(double end_time, Case *c)
{
  const QuasiStaticPlan &plan = c->quasi_static;
  c->notes.push_back(Format(
      "quasi-static: {} transits of {} s ({} m at {} m/s) for a loading{}; damping {} 1/s{}, {} of critical; schedule of {} s{}",
      plan.pace.transits, plan.pace.transit, plan.distance, plan.wave_speed,
      plan.depth > 0
          ? Format(", at most {} m/s = {} of the speed of waves", plan.largest_speed, plan.largest_speed / plan.wave_speed)
          : "",
      c->model.nodal.damping, plan.own_damping ? "" : " as given", plan.damping_ratio, plan.end_time, RatesText(*c, plan)));
  if (plan.rise > 0)
    c->notes.push_back(Format("quasi-static: loads and gravity rise within {} s; the tip starts at {} s, and depths count "
                              "from the surface without them",
                              plan.rise, plan.pace.start));
  if (std::isfinite(end_time) && end_time < plan.end_time)
    c->notes.push_back(Format("quasi-static: -end_time {} ends the run before its schedule", FormatNumber(end_time)));
}

constexpr char kNotSideways[] = "left out with -quasi_static, which does not stretch its times";

/// With -indenter_depths a slow test ignores the history of the indenter: its options are read and not used.
void LeaveHistoryAside(OptionReader &reader)
{
  std::string text;
  for (const char *option : {"-indenter_times", "-indenter_velocities", "-indenter_max_depth", "-indenter_unload_velocity"})
    reader.Read({option, "not used with -indenter_depths"}, &text);
  for (const char *option : {"-indenter_velocities_x", "-indenter_velocities_y"})
    if (reader.Read({option, "sideways speed"}, &text)) reader.Refuse(option, text, kNotSideways);
  text = "displacement";
  reader.Read({"-indenter_control", "not used with -indenter_depths"}, &text);
  if (text != "displacement")
    reader.Refuse("-indenter_control", text, "displacement or left out where -indenter_depths are given");
}

/// The times of the test that a slow one stands for.
void ReadTest(OptionReader &reader, TestPlan *test)
{
  reader.Read({"-test_times",
               "times of the test at its turns, with -indenter_depths, or -indenter_loads; two equal ones of these are a hold",
               "s", kNotNegative},
              &test->times);
  for (std::size_t k = 1; k < test->times.size() && !reader.Help(); ++k)
    if (!(test->times[k] > test->times[k - 1])) reader.Refuse("-test_times", test->times[k], "above the time before it");
  reader.Read({"-test_creep",
               "way that a tip may creep in a transit of waves, of its depth, in a hold of the depth that of the load",
               "",
               {0, 0.5, true, false}},
              &test->creep);
  std::string scale;
  if (!test->times.empty() && !reader.Help() && FindValue("-rate_scale", &scale))
    reader.Refuse("-rate_scale", scale, "left out with -test_times, which give the scale of each part of the test");
}

} // namespace

void ReadQuasiStatic(OptionReader &reader, bool has_indenter, QuasiStaticPlan *plan)
{
  reader.Read(
      {"-quasi_static", "slow test through the turns of the indenter's history: speeds, ramps, holds and damping are chosen"},
      &plan->on);
  if (plan->on && !has_indenter && !reader.Help()) reader.Refuse("-quasi_static", "true", "left out without -indenter");
  std::string times;
  if (!plan->on && !reader.Help() && FindValue("-test_times", &times))
    reader.Refuse("-test_times", times, "given with -quasi_static, whose schedule they stand for");
  if (!plan->on && !reader.Help()) return;
  reader.Read({"-indenter_depths", "depths at the turns of a slow test, in place of its history", "m", kNotNegative},
              &plan->turns);
  if (reader.Help()) plan->turns.clear();
  if (!plan->turns.empty()) LeaveHistoryAside(reader);
  ReadTest(reader, &plan->test);
  reader.Read(
      {"-indenter_unloadings",
       "small unloadings, to about half of the load, at even parts of the first loading: for the stiffness over the depth", "",
       Closed(0, 1000)},
      &plan->unloadings);
  if (plan->unloadings > 0 && !plan->test.times.empty() && !reader.Help())
    reader.Refuse("-indenter_unloadings", plan->unloadings, "left out with -test_times, which need a time for each turn");
  reader.Read({"-quasi_static_tolerance", "share of the load that inertia and damping may add", "", {0, 0.1, true, false}},
              &plan->tolerance);
}

double TransitOf(const Case &c) { return WavePath(c) * MeanSlowness(c); }

void PlanQuasiStatic(OptionReader &reader, double end_time, Case *c)
{
  QuasiStaticPlan &plan = c->quasi_static;
  for (int axis = 0; axis < 2; ++axis)
    if (!c->model.indenter->sideways[axis].Times().empty())
      reader.Refuse(Format("-indenter_velocities_{}", "xy"[axis]), "", kNotSideways);
  for (std::size_t k = 0; k < c->model.loads.size(); ++k)
    if (c->model.loads[k].pressure.EndTime() > 0)
      reader.Refuse("-quasi_static", "true", "left out where a load changes with time, as {}: its times are not stretched",
                    c->load_names[k]);
  plan.distance = LongestPath(*c, false); // free ends ring as well, and a thin layer is wider than it is high
  plan.pace.transit = plan.distance * MeanSlowness(*c);
  plan.wave_speed = plan.distance / plan.pace.transit;
  if (!plan.test.times.empty() && std::isfinite(end_time))
    reader.Refuse("-end_time", end_time, "left out with -test_times: the test ends at the last of them");
  PlanRise(c);
  c->model.indenter->by_load ? PlanLoads(reader, c) : PlanDepths(reader, c);
  double &damping = c->model.nodal.damping;
  const double critical = M_PI / plan.pace.transit; // 2 omega of the lowest mode, omega = pi/2 over the transit
  if (plan.own_damping) damping = (c->model.Flows() ? kMetalDampingRatio : kDampingRatio) * critical;
  plan.damping_ratio = damping / critical;
  double &xpic_fraction = c->model.nodal.xpic_fraction;
  if (plan.own_xpic) xpic_fraction = std::max(xpic_fraction, kXpicFraction);
  if (plan.own_step && LiesOnCellLines(*c)) c->time.cfl = kCfl;
  reader.Chosen("-damping", damping);
  reader.Chosen("-xpic_fraction", xpic_fraction);
  c->time.end_time = std::isfinite(end_time) ? end_time : plan.end_time;
  Describe(end_time, c);
  if (c->model.HasRate() && c->time.rate_scale == 1 && !plan.test.On())
    reader.WarnLater("-rate_scale 1: a material knows a rate, and flows as at the speed of the simulation; -test_times give the "
                     "times of the test, or the scale is the simulation's time over the test's");
}

} // namespace mlgimp
