// The contact equations of a step: gathered from all ranks, solved on one, and applied at the nodes of all.
//
// Unknown j is a pressure; it pushes node i by force_ij lambda_j, and its condition reads
//   gap_j + dt sum_i test_ij . v_i >= 0,  v_i = v_i^0 + (dt/m_i) sum_k force_ik lambda_k,  lambda_j >= 0, complementary.
#pragma once

#include "level/active_set.hpp"
#include "level/contact.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// One unknown, as far as a rank knows it; the parts of all ranks add up.
struct ContactRow {
  std::int64_t key;   ///< global number
  double weight, gap; ///< weight of the condition and weighted gap
  double x;           ///< place along the surface, m
  double left, right; ///< what the unknown covers of the surface, m
};

/// Coupling of an unknown and a node.
struct ContactEntry {
  std::int64_t key;
  int i, j; ///< box indices of the node
  Vec3 test, force;
};

class ContactSystem
{
public:
  /// `diagonal_shift`: added to the diagonal, as a part of it; `monitor`: print a line per solve.
  PetscErrorCode Create(bool symmetric, double diagonal_shift, bool monitor);

  /// Solves and applies. rows and entries: this rank's part; unknowns of less weight than `drop_below` are left out.
  /// Collective on the grid's communicator.
  PetscErrorCode Solve(const ContactView &view, const std::vector<ContactRow> &rows, const std::vector<ContactEntry> &entries,
                       double drop_below, ContactReport *report);

  /// The pressures of the last solve, on every rank; the next one starts from them.
  const ContactPressures &Pressures() const { return pressures_; }
  void SetPressures(const ContactPressures &pressures) { pressures_ = pressures; }

private:
  struct Problem;
  PetscErrorCode SolveOnRoot(const ContactView &view, Problem &problem, double drop_below, std::vector<double> *answer);

  bool symmetric_ = true, monitor_ = false;
  double diagonal_shift_ = 0;
  ActiveSetSolver solver_;
  ContactPressures pressures_;
};

} // namespace mlgimp
