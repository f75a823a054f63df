// The clock on the wall, by which -max_wall_time ends a run in time to write a checkpoint.
#pragma once

namespace mlgimp
{

class WallTime
{
public:
  /// limit: seconds from now, by the clock.
  explicit WallTime(double limit);
  /// Call before the first step.
  void StartLooking();
  /// Takes what writing a checkpoint takes or may take, s; the longest counts.
  void RecordWriting(double seconds);
  /// Must be called at every check of a run: whether less time is left than to the next check, and for a checkpoint and the end.
  bool IsShort();

private:
  double limit_, start_, last_check_, longest_ = 0, writing_ = 0; ///< s; longest time between two checks
};

} // namespace mlgimp
