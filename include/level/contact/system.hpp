// The contact equations of a step: assembled where the nodes are, solved on one rank or on all, and applied at the nodes.
//
// Unknown j is a pressure; it pushes node i by t_ij lambda_j (traction), and its condition reads, with c_ij (constraint),
//   gap_j + dt sum_i c_ij . v_i >= 0,  v_i = v_i^0 + (dt/m_i) sum_k t_ik lambda_k,  lambda_j >= 0, complementary, or
//   A lambda - r >= 0,  A_jk = dt^2 sum_i c_ij . t_ik/m_i,  r_j = -gap_j - dt sum_i c_ij . v_i^0.
// Under load control gap_j is that with the indenter at rest, which travels by u: A lambda - r - u c >= 0, c . lambda = P, with
// c_j = -sum_i (t_ij along the indenter's axis), the load that a pressure carries.
//
// With friction each pressure is followed by its tractions, whose t_ij lie along the surface and whose rows give the slip,
//   s_j = dt sum_i c_ij . (v_i - V) = (A x - r)_j,  r_j = dt sum_i c_ij . (V - v_i^0),  V the velocity of the indenter.
#pragma once

#include "base/exchange.hpp"
#include "level/contact/active_set.hpp"
#include "level/contact/body.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace mlgimp
{

/// One unknown; all ranks know all of them.
struct ContactUnknown {
  std::int64_t key; ///< its name from step to step
  double gap;       ///< weighted gap
};

/// Coupling of an unknown and a node; the parts of all ranks add up.
struct ContactCoupling {
  Index node;
  int unknown; ///< its place among the unknowns
  Vec3 constraint, traction;
  bool coarser = false; ///< the node is one of the next coarser level, beyond the border
  double share = 1;     ///< of the node's velocity that is its own: beta, see border_nodes.hpp
};

class ContactSystem
{
public:
  /// `symmetric`: t is c; `diagonal_shift`: added to the diagonal, as a part of it.
  PetscErrorCode Create(bool symmetric, double diagonal_shift, const ContactSettings &settings);

  /// Solves and applies. unknowns: the same on all ranks, by rising keys, columns of UnknownsPerColumn; couplings: this rank's
  /// part, to any nodes; pattern: whose couplings may be with whose nodes. Adds to the report what it did. Collective on the
  /// group.
  PetscErrorCode Solve(const ContactView &view, const std::vector<ContactUnknown> &unknowns,
                       const std::vector<ContactCoupling> &couplings, SendPattern pattern, ContactReport *report);
  /// The rank of the group that owns the node of a coupling; negative for none.
  static PetscMPIInt OwnerOf(const ContactView &view, const ContactCoupling &coupling);
  /// Adds the couplings with the coarser nodes that nodes near a border hang on.
  static void AddBeyondBorder(const BorderNodes &border, std::vector<ContactCoupling> *couplings);

  /// The pressures and tractions of the last solve, on the first rank of the group and those with a part in it: in the order of
  /// its unknowns, and those that are not zero by their keys. The next solve starts from them.
  const std::vector<double> &Lambda() const { return lambda_; }
  const ContactPressures &Pressures() const { return pressures_; }
  /// To be called by all ranks before their group changes. Collective on the group.
  void SetPressures(const ContactPressures &pressures) { pressures_ = pressures, parallel_.reset(); }

private:
  /// A number of the system at (row, column), or of r or c where column is kRightSide or kLoad.
  struct Term {
    int row, column;
    double value;
  };
  static constexpr int kRightSide = -1, kLoad = -2;
  /// Which rank holds the equations of which columns: ranges of equal size, which may be empty, on the first or on all
  /// ranks.
  struct Layout {
    int columns, per_column, ranks;
    int First(int rank) const
    {
      return per_column * static_cast<int>(static_cast<std::int64_t>(columns) * std::min(rank, ranks) / ranks);
    }
    int Most() const { return per_column * ((columns + ranks - 1) / ranks); }
    int Owner(int row) const { return static_cast<int>(((row / per_column + std::int64_t(1)) * ranks - 1) / columns); }
  };

  void AddProducts(const ContactView &view, int per_column);
  PetscErrorCode MakeEquations(const ContactView &view, const std::vector<ContactUnknown> &unknowns, const Layout &layout,
                               SendPattern pattern);
  PetscErrorCode FindPressures(const ContactView &view, const Layout &layout, SendPattern pattern, ContactReport *report);

  bool symmetric_ = true;
  double diagonal_shift_ = 0;
  ContactSettings settings_;
  ActiveSetSolver serial_;                    ///< on this rank alone
  std::unique_ptr<ActiveSetSolver> parallel_; ///< on all ranks of the group, until it changes
  std::vector<ContactCoupling> couplings_;    ///< as they come from all ranks
  std::vector<ContactCoupling> at_nodes_;     ///< their sums, see GatherAtNodes
  std::vector<std::vector<Term>> rows_;
  ComplementarityProblem problem_;
  std::vector<double> lambda_;
  ContactPressures pressures_;
};

} // namespace mlgimp
