// The clock on the wall.
#include "program/system/wall_time.hpp"

#include "base/petsc.hpp"

#include <algorithm>

namespace mlgimp
{

WallTime::WallTime(double limit) : limit_(limit), start_(MPI_Wtime()), last_check_(start_) {}

void WallTime::StartLooking() { last_check_ = MPI_Wtime(); }

void WallTime::RecordWriting(double seconds) { writing_ = std::max(writing_, seconds); }

bool WallTime::IsShort()
{
  constexpr double kEnding = 0.5, kMargin = 1.5; // size; s, to close what is open; steps and disks may be slower the next time
  const double now = MPI_Wtime();
  longest_ = std::max(longest_, now - last_check_);
  last_check_ = now;
  return now - start_ + kMargin * (longest_ + writing_) + kEnding > limit_;
}

} // namespace mlgimp
