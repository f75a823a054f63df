// Writing of history.csv.
#include "program/output/history.hpp"

#include "base/text.hpp"
#include "program/system/agree.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <utility>

namespace mlgimp
{

namespace
{

/// In the order of the file: that of the table, but new columns go to the end.
std::vector<HistoryColumn> Columns(const Case &c)
{
  const Geometry &geometry = c.model.geometry;
  const Budgets table;
  std::vector<HistoryColumn> columns;
  const auto add = [&](Shown shown, int from, int to) {
    for (const Budget &row : table)
      for (int axis = from; row.shown == shown && axis < std::min(to, row.components); ++axis)
        columns.push_back({row.components > 1 ? Format("{}_{}", row.name, "xyz"[axis]) : row.name,
                           static_cast<int>(&row - table.begin()), axis});
  };
  add(Shown::kColumn, 0, 2);
  if (geometry.HasHoop()) add(Shown::kHoopColumn, 0, 1);
  add(Shown::kColumn, 2, geometry.Dim());
  add(Shown::kLaterColumn, 0, geometry.Dim());
  if (c.quasi_static.on) add(Shown::kSlowColumn, 0, 1);
  if (c.quasi_static.test.On()) add(Shown::kTestColumn, 0, 1);
  if (c.model.indenter && c.model.indenter->compliance.Any()) add(Shown::kSpringColumn, 0, 1);
  return columns;
}

/// The rows of an earlier part of the run up to a step, without one that a kill left incomplete.
std::string RowsUpTo(const std::string &path, long step, long *last)
{
  std::ifstream file(path);
  std::string text, line;
  std::getline(file, line);
  while (std::getline(file, line) && !file.eof()) { // the last line ends like the others, or not at all
    const long row = std::strtol(line.c_str(), nullptr, 10);
    if (row > step) continue;
    text += line + "\n";
    *last = row;
  }
  return text;
}

std::string Header(const std::vector<HistoryColumn> &columns)
{
  std::string text = "step";
  for (const HistoryColumn &column : columns) text += "," + column.name;
  return text + "\n";
}

} // namespace

std::string History::Open(MPI_Comm comm, const Case &c, long resume_step)
{
  comm_ = comm;
  path_ = c.output.directory + "/history.csv";
  columns_ = Columns(c);
  std::string problem = OnFirstRank(comm, "history_open", [&] {
    const std::string kept = resume_step >= 0 ? RowsUpTo(path_, resume_step, &last_) : "";
    const std::string wrong = ReplaceFile(path_, Header(columns_) + kept);
    if (wrong.empty()) file_ = Descriptor(open(path_.c_str(), O_WRONLY | O_APPEND), close);
    return wrong.empty() && !file_.Valid() ? CannotWrite(path_, errno) : wrong;
  });
  MPI_Bcast(&last_, 1, MPI_LONG, 0, comm);
  return problem;
}

/// Adds the whole text or nothing; empty, or what CannotWrite says.
std::string History::Append(const std::string &text) const
{
  const off_t end = lseek(file_, 0, SEEK_END);
  if (!IsThere()) return Format("cannot write {}: the file was removed or replaced during the run", path_);
  if (WriteAll(file_, text)) return "";
  const int error = errno;
  (void)!ftruncate(file_, end);
  return CannotWrite(path_, error);
}

void History::Add(long step, const Budgets &budgets)
{
  text_ += std::to_string(step);
  for (const HistoryColumn &column : columns_) {
    char number[32];
    const auto end = std::to_chars(number, number + sizeof number, budgets.begin()[column.row].value[column.component]).ptr;
    text_.append(1, ',').append(number, end);
  }
  text_ += '\n';
  added_ = step;
}

std::string History::Write()
{
  const std::string text = std::exchange(text_, "");
  if (text.empty()) return "";
  std::string problem = OnFirstRank(comm_, "history_row", [&] { return Append(text); });
  if (problem.empty()) last_ = added_;
  return problem;
}

} // namespace mlgimp
