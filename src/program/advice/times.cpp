// Checks of times and loads: how long a run is, how fast its indenter and its loads are beside waves, and whether a load is one.
#include "program/advice/case_checks.hpp"

#include "program/slow_test/plan.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// Warns of a tip that is fast beside waves, usually by a wrong unit of Young's modulus: the load is that of inertia.
void CheckSpeed(OptionReader &reader, const Case &c)
{
  if (c.model.indenter->by_load) return;
  const double speed = c.model.indenter->Fastest(0, c.time.end_time);
  double slowest = HUGE_VAL;
  for (const auto &material : c.model.materials) slowest = std::min(slowest, material->SpeedOfSound());
  if (speed > kLargestSpeed * slowest)
    reader.WarnLater("-indenter: moves at up to {} m/s, and waves at {} m/s: that is an impact; is Young's modulus in Pa?", speed,
                     slowest);
}

/// When the tip first comes down to the body, s; infinity where it does not.
double FirstTouch(const Indenter &indenter, double end_time)
{
  const double above = indenter.tip[indenter.up] - indenter.initial_surface;
  return above > 0 ? indenter.motion.speed.TimeOfIntegral(above, end_time) : 0;
}

/// A loading within so few transits of a wave through the bodies is carried by their inertia, though the tip is slow.
void CheckLoading(OptionReader &reader, const Case &c)
{
  constexpr double kMinTransits = 2; // transits; at 0.6 the load of an elastic block is 1.3 times that of a slow test
  const Indenter &indenter = *c.model.indenter;
  const double end = std::min(c.time.end_time, indenter.motion.turning_time), transit = TransitOf(c);
  if (!std::isfinite(end) || indenter.motion.speed.EndValue() < 0) return;
  const double loading = end - FirstTouch(indenter, end);
  if (loading > 0 && loading < kMinTransits * transit)
    reader.WarnLater("-indenter: presses for {} s, where a wave takes {} s through the bodies: the load is that of their "
                     "inertia; a slow test takes ten such times or more (-quasi_static)",
                     loading, transit);
}

/// Warns of a load that rises so fast that the tip overshoots; in a metal the excess depth is permanent.
void CheckLoadRise(OptionReader &reader, const Case &c)
{
  constexpr double kMinTransits = 5,
                   kJump = 0.1; // transits, at 4 the depth of an elastic block is 10 % too large; of the largest load
  const PiecewiseLinear &force = *c.model.indenter->by_load;
  const double largest = force.LargestMagnitude(0, force.EndTime()), transit = TransitOf(c);
  double rise = force.Value(0) > kJump * largest ? 0 : HUGE_VAL;
  for (std::size_t k = 1; k < force.Times().size(); ++k) {
    const double from = force.Times()[k - 1], to = force.Times()[k], more = force.Value(to) - force.Value(from);
    if (more > kJump * largest) rise = std::min(rise, (to - from) * largest / more);
  }
  if (rise < kMinTransits * transit)
    reader.WarnLater("-indenter_loads: {}, where a wave takes {} s through the bodies: the tip overshoots, in metals for good; "
                     "let them rise from 0 within ten such times or more (-quasi_static)",
                     rise > 0 ? Format("rise within {} s", rise) : "begin at once", transit);
}

/// Warns of loads after the end of the run, and of loads too small to strain the body, usually by a wrong unit.
void CheckLoadUnits(OptionReader &reader, const Case &c)
{
  constexpr double kMinShare = 0.1, kMinStrain = 1e-7; // of the largest pressure; of the shear modulus
  for (std::size_t k = 0; k < c.model.loads.size(); ++k) {
    const PiecewiseLinear &pressure = c.model.loads[k].pressure;
    const double met = pressure.LargestMagnitude(0, std::min(c.time.end_time, pressure.EndTime()));
    const double largest = pressure.LargestMagnitude(0, pressure.EndTime());
    if (met < kMinShare * largest)
      reader.WarnLater("-{}_times: the largest pressure of {} Pa comes after the end of the run at {} s, by when it is at most "
                       "{} Pa; are the times in s?",
                       c.load_names[k], largest, c.time.end_time, met);
    const double mu = c.model.MaterialOf(c.model.loads[k].body).Elastic().mu;
    if (largest > 0 && largest < kMinStrain * mu)
      reader.WarnLater("-{}_pressures: a pressure of at most {} Pa is below 1e-7 of the shear modulus of {} Pa; are they in Pa?",
                       c.load_names[k], largest, mu);
  }
}

/// Warns of a pressure that changes within few transits of a wave: the wave doubles the stress of the change, and a metal that
/// would bear the pressure yields.
void CheckPressureRates(OptionReader &reader, const Case &c)
{
  constexpr double kMinTransits = 2; // transits
  for (std::size_t k = 0; k < c.model.loads.size(); ++k) {
    const PiecewiseLinear &pressure = c.model.loads[k].pressure;
    const Material &material = c.model.MaterialOf(c.model.loads[k].body);
    const Box bounds = c.model.bodies[c.model.loads[k].body].region->Bounds();
    double extent = 0, largest_sum = 0, largest = 0; // of pressure and change, of the pressure, Pa
    for (int axis = 0; axis < c.Dim(); ++axis) extent = std::max(extent, bounds.upper[axis] - bounds.lower[axis]);
    const double transit = extent / material.SpeedOfSound();
    const auto sample = [&](double time) {
      const double now = pressure.Value(time),
                   then = time > kMinTransits * transit ? pressure.Value(time - kMinTransits * transit) : 0;
      largest_sum = std::max(largest_sum, std::abs(now) + std::abs(now - then)), largest = std::max(largest, std::abs(now));
    };
    sample(0);
    for (const double time : pressure.Times()) sample(time), sample(time + kMinTransits * transit);
    const double yield = material.FlowStress(0);
    if (!material.Traits().flows || largest >= yield || largest_sum <= yield) continue;
    reader.WarnLater("-{}_pressures: change by so much within {} s, in which a wave crosses the body twice, that the stress of "
                     "the wave makes a metal with a yield stress of {} Pa flow, which would bear {} Pa at rest; let them rise "
                     "from 0 within five such times or more{}",
                     c.load_names[k], kMinTransits * transit, yield, largest, c.model.indenter ? " (-quasi_static)" : "");
  }
}

/// Warns when a run needs more than 1e8 steps: usually a time has the wrong unit, or is that of a test in the laboratory.
void CheckSteps(OptionReader &reader, const Case &c)
{
  constexpr double kMaxSteps = 1e8;
  double fastest = 0;
  for (const auto &material : c.model.materials) fastest = std::max(fastest, material->SpeedOfSound());
  const double step = c.time.time_step > 0 ? c.time.time_step : c.time.cfl * c.cell_size / fastest;
  const double steps = c.time.max_steps > 0 ? c.time.max_steps : c.time.end_time / step;
  if (steps > kMaxSteps)
    reader.WarnLater("{}: the end of the run at {} s is some {} steps of {} s away; {}",
                     c.quasi_static.on ? "-quasi_static" : "-end_time", c.time.end_time, steps, step,
                     c.quasi_static.on ? "is all in SI units?"
                                       : "are times in s? With -quasi_static the program chooses those of a slow test");
}

/// Warns of a body that creeps or relaxes within the nanoseconds of a simulation.
void CheckClock(OptionReader &reader, const Case &c)
{
  if (c.model.Creeps() && c.time.rate_scale == 1)
    reader.WarnLater(
        "-rate_scale 1: a material creeps or relaxes, and the time of the test is that of the simulation (theta = t); "
        "-test_times give that of a slow test (-quasi_static), or the scale is the simulation's time over it");
}

} // namespace

void CheckTimes(OptionReader &reader, const Case &c)
{
  CheckLoadUnits(reader, c);     // -LOAD_times, _pressures: after the end of the run, or too small to strain anything
  CheckPressureRates(reader, c); // -LOAD_pressures: change so fast that a metal yields by the wave
  if (!c.quasi_static.on) CheckClock(reader, c); // a law in time without a time of the test
  CheckSteps(reader, c);                         // -end_time: too many steps away
  if (!c.model.indenter || c.model.contact.method == "none") return;
  CheckSpeed(reader, c); // -indenter: fast beside waves
  if (c.quasi_static.on) return;
  if (c.model.indenter->by_load)
    CheckLoadRise(reader, c); // -indenter_loads: rise within a few transits of a wave
  else
    CheckLoading(reader, c); // -indenter: a loading within a few transits of a wave
}

} // namespace mlgimp
