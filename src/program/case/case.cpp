// What follows from the options of a case.
#include "program/case/case.hpp"

namespace mlgimp
{

std::vector<BoxesAtTime> BoxesAlongPaths(const Case &c)
{
  constexpr int kTimes = 1000; // size
  const FollowSettings &follow = c.hierarchy.follow;
  std::vector<BoxesAtTime> all;
  double end = 0;
  for (const auto &path : follow.paths) end = std::max(end, path[0].EndTime());
  if (std::isfinite(c.time.end_time)) end = c.time.end_time;
  for (int k = 0; k <= kTimes; ++k) {
    BoxPlan plan;
    all.push_back({end * k / kTimes, {}});
    FollowPath(c.hierarchy.rules, follow, all.back().time, {c.boxes, c.levels}, &plan);
    all.back().boxes = plan.boxes;
  }
  return all;
}

} // namespace mlgimp
