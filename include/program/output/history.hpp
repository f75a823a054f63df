// history.csv: one row of totals per interval, flushed as written, some rows at a time.
#pragma once

#include "program/case/case.hpp"
#include "program/system/files.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// A column of the file: a number of a row in the table of budgets.
struct HistoryColumn {
  std::string name;
  int row, component;
};

class History
{
public:
  /// With the columns that the case has. Starts the file, or, after a restart at `resume_step` >= 0, keeps the rows up to it.
  /// Returns nothing, or why the file cannot be written, the same on every rank. Collective.
  std::string Open(MPI_Comm comm, const Case &c, long resume_step);
  /// Adds a row to those that Write will write.
  void Add(long step, const Budgets &budgets);
  /// Writes the rows that were added, or none of them. Returns as Open. Collective.
  std::string Write();
  /// Step of the last row that was written; -1 for none.
  long Last() const { return last_; }
  /// False when the file was removed. First rank.
  bool IsThere() const { return SameFile(file_, path_); }

private:
  std::string Append(const std::string &text) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::string path_;
  std::vector<HistoryColumn> columns_;
  Descriptor file_;  ///< on the first rank
  std::string text_; ///< of the rows that were added
  long added_ = -1;  ///< step of the last of them
  long last_ = -1;
};

} // namespace mlgimp
