// What goes by the table of budgets: sums over parts and ranks, and what checkpoints keep.
#include "grid/budgets.hpp"

#include "base/index.hpp"

#include <cmath>

namespace mlgimp
{

void Budgets::Add(const Budgets &part)
{
  const Budget *from = part.begin();
  for (Budget &row : *this) {
    for (int c = 0; c < row.components; ++c) row.Add(c, from->value[c]);
    ++from;
  }
}

PetscErrorCode AddRanks(MPI_Comm comm, std::vector<Budgets> *rows)
{
  PetscFunctionBeginUser;
  for (const bool largest : {false, true}) {
    std::vector<double> values;
    for (const Budgets &budgets : *rows)
      for (const Budget &row : budgets)
        if (row.IsLargest() == largest) values.insert(values.end(), row.value.begin(), row.value.begin() + row.components);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE,
                               largest ? MPI_MAX : MPI_SUM, comm));
    const double *next = values.data();
    for (Budgets &budgets : *rows)
      for (Budget &row : budgets)
        for (int c = 0; row.IsLargest() == largest && c < row.components; ++c) row.value[c] = *next++;
  }
  for (Budgets &budgets : *rows)
    if (budgets.contact_width_power > 0)
      budgets.contact_half_width = std::pow(budgets.contact_width_power, 1 / budgets.contact_axes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Budgets::AppendKept(std::vector<double> *numbers) const
{
  for (const Budget &row : *this)
    if (row.IsKept()) numbers->insert(numbers->end(), row.value.begin(), row.value.begin() + row.components);
}

const double *Budgets::AddKept(const double *numbers)
{
  for (Budget &row : *this)
    for (int c = 0; row.IsKept() && c < row.components; ++c) {
      const double x = *numbers++;
      if (row.adds == Adds::kCount && !(x >= 0 && x <= kLargestWhole && x == std::floor(x))) return nullptr;
      row.Add(c, x);
    }
  return numbers;
}

} // namespace mlgimp
