// A step in time.
#pragma once

namespace mlgimp
{

/// A step from `time` to `time + dt`, s.
struct TimeStep {
  double time, dt;
  double scale = 1; ///< simulated time over that of the test, for laws that know a rate or relax
  bool last = true; ///< of the steps that a level makes in one of level 0
  double End() const { return time + dt; }
  /// Step k of the equal steps that it consists of on a finer level.
  TimeStep Part(int k, int of) const { return {time + k * (dt / of), dt / of, scale, last && k + 1 == of}; }
};

} // namespace mlgimp
