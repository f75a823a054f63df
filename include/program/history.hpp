// history.csv: one row of totals per interval, flushed as written.
#pragma once

#include "levels/hierarchy.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// A row; the columns are named in history.cpp.
struct HistoryRow {
  long step;
  double time, depth, load, half_width, penetration, peak_pressure;
  Books books;
};

class History
{
public:
  /// Starts the file, or, after a restart at `resume_step` >= 0, keeps the rows up to it. Collective.
  PetscErrorCode Open(MPI_Comm comm, const std::string &directory, long resume_step);
  PetscErrorCode Write(const HistoryRow &row);
  ~History();

private:
  bool Append(const std::string &text) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::string path_;
  int file_ = -1; ///< on the first rank
};

} // namespace mlgimp
