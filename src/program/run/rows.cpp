// What the rows of the history say beside the sums of all ranks.
#include "program/run/rows.hpp"

#include <utility>

namespace mlgimp
{

std::string RowWriter::Open(bool goes_on) { return history_.Open(hierarchy_.Comm(), case_, goes_on ? state_.step : -1); }

bool RowWriter::IsDue(long step, double schedule) const
{
  return step % case_.output.history_interval == 0 || case_.time.IsEnd(step, schedule);
}

void RowWriter::Keep()
{
  sums_.push_back(hierarchy_.SumBudgets());
  const TipTrack &tip = hierarchy_.Tip();
  rows_.push_back({state_.step, state_.time, state_.Schedule(), state_.test.time, tip.At(state_.time),
                   tip.Deflection(state_.time), tip.SpringEnergy(state_.time)});
}

/// The mean force of tractions from the last row to one at a time: on the body along the indenter's sideways motion, along x
/// without one.
void RowWriter::SetFrictionForce(double time, Budgets &budgets)
{
  const auto &indenter = case_.model.indenter;
  const Vec3 impulse = budgets.friction_impulse, last = state_.friction_at_row;
  const double passed = time - state_.time_at_row;
  if (!indenter) return;
  const Vec3 moved = indenter->Sideways(time) - indenter->Sideways(state_.time_at_row);
  const Vec3 along = Norm(moved) > 0 ? (1 / Norm(moved)) * moved : Vec3{1, 0, 0};
  if (passed > 0) friction_force_ = Dot(impulse - last, along) / passed;
  state_.friction_at_row = impulse;
  budgets.friction_force = friction_force_;
}

/// Fills the columns that follow from the sums of all ranks and from the row before.
void RowWriter::Complete(const Row &row, Budgets &budgets)
{
  const double passed = row.time - state_.time_at_row, impulse = budgets.contact_impulse[case_.Dim() - 1];
  if (passed > 0) load_ = -(impulse - state_.impulse_at_row) / passed;
  SetFrictionForce(row.time, budgets);
  state_.impulse_at_row = impulse;
  state_.time_at_row = row.time;
  budgets.time = row.time;
  budgets.schedule = row.schedule;
  budgets.test_time = row.test_time;
  budgets.depth = case_.model.indenter ? case_.model.indenter->Depth(row.tip) : 0;
  budgets.load = load_;
  budgets.measured_depth = budgets.depth + row.deflection;
  budgets.spring_energy = row.spring_energy;
  for (int axis = 0; axis < case_.Dim(); ++axis) budgets.tip[axis] = row.tip[axis];
  watch_.Record(budgets);
  warnings_.Check(hierarchy_.Comm(), case_, budgets, watch_, case_.time.IsEnd(row.step, row.schedule));
}

std::string RowWriter::Write()
{
  const std::vector<Row> rows = std::exchange(rows_, {}); // where writing fails, the run's end comes here again
  std::vector<Budgets> sums = std::exchange(sums_, {});
  if (rows.empty()) return "";
  ExitOnError(AddRanks(hierarchy_.Comm(), &sums));
  for (std::size_t k = 0; k < rows.size() && sums[k].failed == 0; ++k) {
    Complete(rows[k], sums[k]);
    history_.Add(rows[k].step, sums[k]);
  }
  return history_.Write();
}

void RowWriter::TakeState()
{
  watch_.SetState(state_.quasi_static);
  warnings_.SetState(state_.watched, state_.warnings);
}

void RowWriter::KeepState()
{
  state_.quasi_static = watch_.State();
  state_.watched = warnings_.State();
  state_.warnings = warnings_.KeptLines();
}

} // namespace mlgimp
