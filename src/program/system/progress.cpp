// The progress line.
#include "program/system/progress.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sys/ioctl.h>
#include <unistd.h>
#include <vector>

namespace mlgimp
{

namespace
{

/// A number in words that hold one %g or the like.
std::string Words(const char *format, double number)
{
  char text[64];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

/// A part of the line; the one with the largest rank is left out first.
struct Part {
  std::string text;
  int rank;
};

std::string Joined(const std::vector<Part> &parts)
{
  std::string line;
  for (const Part &part : parts) line += (line.empty() ? "" : "  ") + part.text;
  return line;
}

} // namespace

std::string ProgressLine(const Progress &now, std::size_t columns)
{
  std::vector<Part> parts = {{Format("step {}", now.step), 4}, {Words("time %.4e s", now.time), 5}};
  if (now.has_indenter) parts.insert(parts.end(), {{Words("depth %.4e m", now.depth), 3}, {Words("load %.4e N", now.load), 2}});
  parts.insert(parts.end(), {{Words("%.2e points/s", now.points), 6},
                             {Words("%3.0f %%", 100 * now.share), 0},
                             {Words("%.0f s left", now.seconds_left), 1}});
  const auto by_rank = [](const Part &a, const Part &b) { return a.rank < b.rank; };
  while (Joined(parts).size() >= columns && parts.size() > 1) parts.erase(std::max_element(parts.begin(), parts.end(), by_rank));
  return Joined(parts).substr(0, std::max<std::size_t>(columns, 1) - 1);
}

std::size_t TerminalColumns()
{
  constexpr std::size_t kUsual = 80; // size
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const char *const columns = std::getenv("COLUMNS");
  const long given = columns ? std::strtol(columns, nullptr, 10) : 0;
  return given > 0 ? static_cast<std::size_t>(given) : kUsual;
}

} // namespace mlgimp
