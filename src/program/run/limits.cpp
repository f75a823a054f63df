// Lengths of steps, and the ends of runs that have failed.
#include "program/run/limits.hpp"

#include "program/checkpoint/checks.hpp"
#include "program/system/agree.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// What a step must be a fraction of: the time that the fastest signal takes through a cell, or that of the damping, which
/// the nodal update takes explicitly.
static double TimeScale(const Case &c, double speed)
{
  const double damping = c.model.nodal.damping, crossing = c.cell_size / speed;
  return damping > 0 ? std::min(crossing, 1 / damping) : crossing;
}

double StepLength(const Case &c, double time, double speed)
{
  const double longest = c.time.time_step > 0 ? c.time.time_step : c.time.cfl * TimeScale(c, speed);
  const double left = c.time.end_time - time;
  return std::isfinite(left) ? left / std::max(1.0, std::ceil(left / longest - 1e-6)) : longest;
}

double FastestSignal(const Case &c, double time, const SpeedCheck &speeds)
{
  if (!c.model.indenter) return speeds.wave_speed;
  const double soon = time + 2 * kControlInterval * StepLength(c, time, speeds.wave_speed);
  return std::max(speeds.wave_speed, speeds.point_speed + c.model.indenter->Fastest(time, soon));
}

std::string WrongStep(const Case &c, double now, double speed, bool begun)
{
  constexpr double kMaxSteps = 1e15; // size: far fewer than a double counts, far more than a machine makes
  const TimeSettings &time = c.time;
  const double scale = TimeScale(c, speed), limit = kLargestCfl * scale, step = StepLength(c, now, speed),
               left = time.end_time - now;
  const bool by_damping = scale < c.cell_size / speed;
  if (time.time_step > limit)
    return Format("-time_step {}: must be <= {}{}{}", FormatNumber(time.time_step), limit,
                  by_damping ? ", the inverse of -damping" : ", the cell size over the wave speed or the indenter's",
                  begun ? " by now" : "");
  if (now + step > now && (!std::isfinite(left) || left < kMaxSteps * step)) return "";
  const std::string end = Format("-end_time {}", FormatNumber(time.end_time));
  return Format("{}; a step is {} s at time {} s, with a speed of {} m/s",
                time.time_step > 0 ? Format("-time_step {}: must bring {} in reach", FormatNumber(time.time_step), end)
                                   : Format("{}: must be in reach", end),
                step, now, speed);
}

std::string WrongPace(const Case &c, Hierarchy &hierarchy, double time, double next_check)
{
  if (c.hierarchy.follow.kind != FollowKind::kContact) return "";
  const int finest = hierarchy.Boxes().State().plan.active - 1;
  const double room = c.hierarchy.rules.Border(finest);
  const double distance = Norm(hierarchy.Tip().At(next_check) - hierarchy.Tip().At(time));
  if (finest == 0 || distance <= room) return "";
  return Format("-level_follow contact: the tip goes {} m until boxes are checked again, by time {} s, more than the {} m that "
                "level {} keeps free around the contact; try a slower indenter, fewer -levels or a smaller -regrid_interval",
                distance, next_check, room, finest);
}

/// A tip that cannot go on: deeper than its surface is known, or under load control.
static std::string DescribeTip(const Case &c, const TipTrack &tip, double time)
{
  constexpr double kMaxOverrun = 0.1; // of the body's height, for which waves take as long as the tip at its largest speed
  if (!c.model.indenter) return "";
  const Indenter &indenter = *c.model.indenter;
  const double height = tip.At(time)[indenter.up], lowest = c.LowestTip(c.hierarchy.tip_level);
  if (const double known = indenter.surface->KnownHeights().largest; indenter.Depth(tip.At(time)) > known)
    return Format("time {}: the tip is {} m deep, and its surface is known up to {} m above its end; try a smaller depth or load",
                  time, indenter.Depth(tip.At(time)), known);
  if (!indenter.by_load) return "";
  const std::string load = Format("time {}: -indenter_loads, {} N by now, ", time, tip.LoadAt(time));
  if (tip.Overrun() > kMaxOverrun * (indenter.initial_surface - c.domain.lower[indenter.up]))
    return Format(
        "{}are not met although the tip comes down at {} m/s, a tenth of the speed of waves; try smaller or slower ones", load,
        indenter.largest_speed);
  if (height < lowest)
    return Format("{}press the tip {} m below {}, to which level {} can hold it; try smaller ones, a larger box, or smaller "
                  "cells, of which the box's border takes some",
                  load, lowest - height, lowest, c.hierarchy.tip_level);
  return "";
}

std::string FindFailure(const Case &c, Hierarchy &hierarchy, double time)
{
  std::string problem = hierarchy.DescribeFailure();
  if (problem.empty()) problem = DescribeTip(c, hierarchy.Tip(), time);
  return Agree(hierarchy.Comm(), "failure", problem);
}

std::string FindBadPoints(const Case &c, Hierarchy &hierarchy, double time)
{
  std::string problem;
  for (int l = 0; l < hierarchy.Levels() && problem.empty(); ++l) {
    const PointArrays points = hierarchy.At(l).PointStore().Arrays();
    const std::string wrong = WrongValues(points, static_cast<int>(c.model.bodies.size()));
    if (!wrong.empty()) problem = Format("time {}, level {}: {}; try a smaller -cfl or -time_step", time, l, wrong);
  }
  return Agree(hierarchy.Comm(), "state", problem);
}

} // namespace mlgimp
