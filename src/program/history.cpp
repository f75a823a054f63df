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

/// Columns for the components from axis `from` to before `to` of a budget.
void AddVector(std::vector<HistoryColumn> &columns, const std::string &name, int from, int to, double (Budgets::*budget)[3])
{
  for (int axis = from; axis < to; ++axis)
    columns.push_back({name + "_" + "xyz"[axis], [=](const HistoryRow &r) { return (r.budgets.*budget)[axis]; }});
}

/// In the order of the file: new ones at the end, so those of the third axis and of the hoop stress are there too.
std::vector<HistoryColumn> Columns(const Geometry &geometry)
{
  const auto sum = [](double Budgets::*budget) { return [=](const HistoryRow &r) { return r.budgets.*budget; }; };
  std::vector<HistoryColumn> columns = {
      {"time", [](const HistoryRow &r) { return r.time; }},
      {"depth", [](const HistoryRow &r) { return r.depth; }},
      {"load", [](const HistoryRow &r) { return r.load; }},
      {"contact_points", sum(&Budgets::contact_points)},
      {"contact_half_width", [](const HistoryRow &r) { return r.half_width; }},
      {"kinetic_energy", sum(&Budgets::kinetic_energy)},
      {"strain_energy", sum(&Budgets::strain_energy)},
      {"dissipated_energy", [](const HistoryRow &r) { return r.budgets.Dissipated(); }},
      {"external_work", sum(&Budgets::external_work)},
      {"indenter_work", sum(&Budgets::indenter_work)},
  };
  AddVector(columns, "momentum", 0, 2, &Budgets::momentum);
  AddVector(columns, "support_impulse", 0, 2, &Budgets::support_impulse);
  columns.push_back({"mass", sum(&Budgets::mass)});
  columns.push_back({"points", sum(&Budgets::points)});
  AddVector(columns, "contact_impulse", 0, 2, &Budgets::contact_impulse);
  AddVector(columns, "load_impulse", 0, 2, &Budgets::load_impulse);
  AddVector(columns, "gravity_impulse", 0, 2, &Budgets::gravity_impulse);
  AddVector(columns, "damping_impulse", 0, 2, &Budgets::damping_impulse);
  columns.push_back({"penetration", [](const HistoryRow &r) { return r.penetration; }});
  columns.push_back({"peak_pressure", [](const HistoryRow &r) { return r.peak_pressure; }});
  AddVector(columns, "stagger_impulse", 0, 2, &Budgets::stagger_impulse);
  columns.push_back({"contact_work", sum(&Budgets::contact_work)});
  columns.push_back({"exchange_energy", sum(&Budgets::exchange_energy)});
  columns.push_back({"transfer_energy", sum(&Budgets::transfer_energy)});
  columns.push_back({"contact_area", [](const HistoryRow &r) { return r.area; }});
  if (geometry.HasHoop()) columns.push_back({"hoop_impulse_x", sum(&Budgets::hoop_impulse)});
  if (geometry.Dim() == 2) return columns;
  AddVector(columns, "momentum", 2, 3, &Budgets::momentum);
  AddVector(columns, "support_impulse", 2, 3, &Budgets::support_impulse);
  AddVector(columns, "contact_impulse", 2, 3, &Budgets::contact_impulse);
  AddVector(columns, "load_impulse", 2, 3, &Budgets::load_impulse);
  AddVector(columns, "gravity_impulse", 2, 3, &Budgets::gravity_impulse);
  AddVector(columns, "damping_impulse", 2, 3, &Budgets::damping_impulse);
  AddVector(columns, "stagger_impulse", 2, 3, &Budgets::stagger_impulse);
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

PetscErrorCode History::Write(const HistoryRow &row, std::string *problem)
{
  PetscFunctionBeginUser;
  if (file_.Valid()) {
    std::string text = std::to_string(row.step);
    for (const HistoryColumn &column : columns_) {
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
