// The line that -monitor shows: as much of it as the terminal has room for.
#pragma once

#include <cstddef>
#include <string>

namespace mlgimp
{

/// What there is to show.
struct Progress {
  long step;
  double time;         ///< s
  bool has_indenter;   ///< without one there is no depth and no load
  double depth, load;  ///< m, N
  double points;       ///< moved in a second
  double share;        ///< of the run that is done
  double seconds_left; ///< by the clock
};

/// The line, shorter than so many columns: a terminal goes to its next line behind the last one. What matters least is left out
/// first.
std::string ProgressLine(const Progress &now, std::size_t columns);

/// Columns of the terminal that standard output goes to; else the environment's COLUMNS, or 80.
std::size_t TerminalColumns();

} // namespace mlgimp
