// The complementarity problem of contact pressures: a primal-dual active set around a KSP.
#pragma once

#include "base/handle.hpp"

#include <vector>

namespace mlgimp
{

/// A square matrix that is zero beyond `reach` places from the diagonal.
struct BandMatrix {
  int size = 0, reach = 0;
  std::vector<double> values;
  void Reset(int new_size, int new_reach)
  {
    size = new_size;
    reach = new_reach;
    values.assign(static_cast<std::size_t>(size) * (2 * reach + 1), 0.0);
  }
  double &At(int row, int column) { return values[static_cast<std::size_t>(row) * (2 * reach + 1) + column - row + reach]; }
  double At(int row, int column) const { return const_cast<BandMatrix *>(this)->At(row, column); }
  int First(int row) const { return row > reach ? row - reach : 0; }
  int Last(int row) const { return row + reach < size ? row + reach : size - 1; }
};

struct ActiveSetReport {
  int set_updates = 0, linear_iterations = 0, active = 0;
  bool fallback = false, solved = true;
};

/// Finds lambda >= 0 with A lambda - r >= 0 and lambda (A lambda - r) = 0. Serial.
class ActiveSetSolver
{
public:
  /// Creates the KSP with the prefix -contact_ and reads its options. `symmetric` chooses the default method.
  PetscErrorCode Create(bool symmetric);
  /// lambda: the previous pressures on entry (the set starts from them), the solution on return.
  PetscErrorCode Solve(const BandMatrix &A, const std::vector<double> &r, std::vector<double> &lambda, ActiveSetReport *report);

private:
  PetscErrorCode Resize(int size, int reach);
  PetscErrorCode SolveActive(const BandMatrix &A, const std::vector<double> &r, const std::vector<char> &active,
                             std::vector<double> &lambda, ActiveSetReport *report);

  KSPHandle ksp_;
  MatHandle matrix_;
  VecHandle right_side_, solution_;
  int size_ = -1, reach_ = -1;
};

} // namespace mlgimp
