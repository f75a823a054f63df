// Writing of history.csv.
#include "program/history.hpp"

#include "program/agree.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>

namespace mlgimp
{

namespace
{

/// In the order of the file: that of the table, but new columns go to the end.
std::vector<HistoryColumn> Columns(const Geometry &geometry)
{
  const Budgets table;
  std::vector<HistoryColumn> columns;
  const auto add = [&](Shown shown, int from, int to) {
    for (const Budget &row : table)
      for (int c = from; row.shown == shown && c < std::min(to, row.components); ++c)
        columns.push_back(
            {row.components > 1 ? std::string(row.name) + "_" + "xyz"[c] : row.name, static_cast<int>(&row - table.begin()), c});
  };
  add(Shown::kColumn, 0, 2);
  if (geometry.HasHoop()) add(Shown::kHoopColumn, 0, 1);
  add(Shown::kColumn, 2, geometry.Dim());
  add(Shown::kLaterColumn, 0, geometry.Dim());
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

PetscErrorCode History::Open(MPI_Comm comm, const std::string &directory, const Geometry &geometry, long resume_step,
                             std::string *problem)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  comm_ = comm;
  path_ = directory + "/history.csv";
  columns_ = Columns(geometry);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    *problem = ReplaceFile(path_, Header(columns_) + (resume_step >= 0 ? RowsUpTo(path_, resume_step, &last_) : ""));
    if (problem->empty()) {
      file_.Reset(open(path_.c_str(), O_WRONLY | O_APPEND));
      if (!file_.Valid()) *problem = CannotWrite(path_, errno);
    }
  }
  PetscCall(Agree(comm, "history_open", problem));
  PetscCallMPI(MPI_Bcast(&last_, 1, MPI_LONG, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds the whole text or nothing; empty, or what CannotWrite says.
std::string History::Append(const std::string &text) const
{
  const off_t end = lseek(file_, 0, SEEK_END);
  if (!IsThere()) return "cannot write " + path_ + ": somebody has removed or replaced it during the run";
  if (WriteAll(file_, text)) return "";
  const int error = errno;
  (void)!ftruncate(file_, end);
  return CannotWrite(path_, error);
}

PetscErrorCode History::Write(long step, const Budgets &budgets, std::string *problem)
{
  PetscFunctionBeginUser;
  if (file_.Valid()) {
    std::string text = std::to_string(step);
    for (const HistoryColumn &column : columns_) {
      char number[32];
      const auto end = std::to_chars(number, number + sizeof number, budgets.begin()[column.row].value[column.component]).ptr;
      text.append(1, ',').append(number, end);
    }
    *problem = Append(text + "\n");
  }
  PetscCall(Agree(comm_, "history_row", problem));
  if (problem->empty()) last_ = step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
