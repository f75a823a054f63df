// Writing of history.csv.
#include "program/history.hpp"

#include "program/agree.hpp"

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>

namespace mlgimp
{

namespace
{

struct Column {
  const char *name;
  double (*value)(const HistoryRow &row);
};

const Column kColumns[] = {
    {"time", [](const HistoryRow &r) { return r.time; }},
    {"depth", [](const HistoryRow &r) { return r.depth; }},
    {"load", [](const HistoryRow &r) { return r.load; }},
    {"contact_points", [](const HistoryRow &r) { return r.budgets.contact_points; }},
    {"contact_half_width", [](const HistoryRow &r) { return r.half_width; }},
    {"kinetic_energy", [](const HistoryRow &r) { return r.budgets.kinetic_energy; }},
    {"strain_energy", [](const HistoryRow &r) { return r.budgets.strain_energy; }},
    {"dissipated_energy", [](const HistoryRow &r) { return r.budgets.Dissipated(); }},
    {"external_work", [](const HistoryRow &r) { return r.budgets.external_work; }},
    {"indenter_work", [](const HistoryRow &r) { return r.budgets.indenter_work; }},
    {"momentum_x", [](const HistoryRow &r) { return r.budgets.momentum[0]; }},
    {"momentum_y", [](const HistoryRow &r) { return r.budgets.momentum[1]; }},
    {"support_impulse_x", [](const HistoryRow &r) { return r.budgets.support_impulse[0]; }},
    {"support_impulse_y", [](const HistoryRow &r) { return r.budgets.support_impulse[1]; }},
    {"mass", [](const HistoryRow &r) { return r.budgets.mass; }},
    {"points", [](const HistoryRow &r) { return r.budgets.points; }},
    {"contact_impulse_x", [](const HistoryRow &r) { return r.budgets.contact_impulse[0]; }},
    {"contact_impulse_y", [](const HistoryRow &r) { return r.budgets.contact_impulse[1]; }},
    {"load_impulse_x", [](const HistoryRow &r) { return r.budgets.load_impulse[0]; }},
    {"load_impulse_y", [](const HistoryRow &r) { return r.budgets.load_impulse[1]; }},
    {"gravity_impulse_x", [](const HistoryRow &r) { return r.budgets.gravity_impulse[0]; }},
    {"gravity_impulse_y", [](const HistoryRow &r) { return r.budgets.gravity_impulse[1]; }},
    {"damping_impulse_x", [](const HistoryRow &r) { return r.budgets.damping_impulse[0]; }},
    {"damping_impulse_y", [](const HistoryRow &r) { return r.budgets.damping_impulse[1]; }},
    {"penetration", [](const HistoryRow &r) { return r.penetration; }},
    {"peak_pressure", [](const HistoryRow &r) { return r.peak_pressure; }},
    {"stagger_impulse_x", [](const HistoryRow &r) { return r.budgets.stagger_impulse[0]; }},
    {"stagger_impulse_y", [](const HistoryRow &r) { return r.budgets.stagger_impulse[1]; }},
    {"contact_work", [](const HistoryRow &r) { return r.budgets.contact_work; }},
    {"exchange_energy", [](const HistoryRow &r) { return r.budgets.exchange_energy; }},
    {"transfer_energy", [](const HistoryRow &r) { return r.budgets.transfer_energy; }},
    {"contact_area", [](const HistoryRow &r) { return r.area; }},
};

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

std::string Header()
{
  std::string text = "step";
  for (const Column &column : kColumns) text += std::string(",") + column.name;
  return text + "\n";
}

} // namespace

PetscErrorCode History::Open(MPI_Comm comm, const std::string &directory, long resume_step, std::string *problem)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  comm_ = comm;
  path_ = directory + "/history.csv";
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    *problem = ReplaceFile(path_, Header() + (resume_step >= 0 ? RowsUpTo(path_, resume_step, &last_) : ""));
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

PetscErrorCode History::Write(const HistoryRow &row, std::string *problem)
{
  PetscFunctionBeginUser;
  if (file_.Valid()) {
    std::string text = std::to_string(row.step);
    for (const Column &column : kColumns) {
      char number[32];
      const auto end = std::to_chars(number, number + sizeof number, column.value(row)).ptr;
      text.append(1, ',').append(number, end);
    }
    *problem = Append(text + "\n");
  }
  PetscCall(Agree(comm_, "history_row", problem));
  if (problem->empty()) last_ = row.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
