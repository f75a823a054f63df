// The border between a level and the next finer one: one composite grid, without copies of points.
//
// Nested grids give N_I = sum_i N_I(x_i) N_i for a coarse hat N_I and the fine hats N_i. With beta_i in [0, 1], which grows
// from zero outside the fine level's box to one at depth W h inside, the functions beta_i N_i and
// sum_i (1 - beta_i) N_I(x_i) N_i add up to one, and each nodal force acts on one momentum. The coarse nodes of the second
// kind are the interface nodes. They advance with the fine step; fine nodes with beta = 0 are constrained. See docs/levels.md.
#pragma once

#include "contact/border_nodes.hpp"
#include "hierarchy/partition/mapping.hpp"
#include "level/level.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// A fine node with beta < 1 and the interface nodes it hangs on.
struct BlendNode {
  std::ptrdiff_t node; ///< place in the fine level's ghosted arrays
  double beta;
  int count;        ///< of interface nodes with a weight
  int interface[8]; ///< places in the arrays of interface nodes
  double weight[8]; ///< N_I(x_i)
};

/// Width of the band inside a border, cells of the coarser level: where boxes leave room, and at the least.
inline constexpr double kBlendWidth = 4, kMinBlendWidth = 2;
/// Cells beside the band that a border needs free of other borders and of contact.
inline constexpr double kBorderCells = 3;

class LevelInterface : public BorderNodes
{
public:
  /// The levels are kept by reference. Collective on `world`.
  PetscErrorCode Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, double blend_width);

  /// Brings mass, momentum and force of the coarse points to the interface nodes. Starts a coarse step. Collective on all.
  PetscErrorCode CoarseToFine();
  /// Advances the interface nodes by the fine step number `substep`, and sets the velocities (v, dv) of the band from
  /// theirs; the free part of the velocities must be there. On the fine level's ranks.
  PetscErrorCode Advance(int substep, double dt);
  /// Brings the mean velocity and the whole change of the interface nodes to the coarse level. Collective on all.
  PetscErrorCode FineToCoarse();

  /// The coarser level's nodes by place, for its contact in a step that has come to FineToCoarse.
  SharedNode *Shared() { return shared_.data(); }
  /// Mass that the finer level's points give its interface nodes by their hats, by place, as of the last step: such nodes are
  /// light where both levels' points give them little. Infinite where it is not known yet, 0 elsewhere.
  const double *FinerMasses() const { return finer_masses_.data(); }
  /// Takes what contact on the coarser level leaves to the finer level's points; they get it in the next step. Collective on all.
  PetscErrorCode TakeContact();

  // What contact on the finer level asks.
  NodeBlend BlendOf(Index node) const override;
  int BlockOf(Index coarse) const override;
  double MassOf(Index coarse) const override;
  void ForEachDonor(Index coarse, const DonorWork &work) const override;
  Vec3 FreePart(Index coarse, Vec3 change) const override;
  void Push(Index coarse, Vec3 change_of_velocity) override;
  PetscErrorCode Spread(std::vector<NodeChange> *pushed) override;

  /// Adds to the coarse forces of the step before those of points that have changed levels, which are no change to
  /// extrapolate: what is in `sums` of the coarse level, or of the fine level's constrained nodes. Collective on all.
  PetscErrorCode ShiftForces(bool from_fine);

  /// Owned nodes of this rank that the border acts on: interface nodes on the coarse level, and those of the band on the fine.
  const std::vector<CoupledNode> &CoarseNodes() const { return coarse_nodes_; }
  const std::vector<CoupledNode> &FineNodes() const { return fine_nodes_; }
  /// Nodes, with ghosts, whose velocity the border makes, alone or in part: interface nodes are of the first kind.
  const std::vector<std::ptrdiff_t> &HeldCoarseNodes() const { return held_coarse_; }
  const CoupledPlaces &FinePlaces() const { return fine_places_; }

  /// Takes what the last step left to the next from the border before a change of layout, with the same nodes. Collective on all.
  PetscErrorCode TakeState(const LevelInterface &before);
  /// The same as numbers for a restart, [interface nodes][kState], on the first rank; empty where there has been no step.
  /// Collective on all.
  PetscErrorCode GatherState(std::vector<double> *state) const;
  /// Collective on all.
  PetscErrorCode RestoreState(const std::vector<double> &state);
  static constexpr int kState =
      10; ///< size; of an interface node: the coarse force, the impulse of coarse contact, what is left of it, and its finer mass
  std::size_t InterfaceNodes() const;

  /// What the border adds up on this rank.
  Budgets &Totals() { return budgets_; }
  /// Adds what the blocks of the two levels exchange in a coarse step, times a factor; `level` is that of the coarser one. The
  /// same on all ranks. Collective on all.
  PetscErrorCode AddTraffic(int level, double factor, std::vector<BlockTraffic> *traffic) const;

private:
  /// An interface node by its index on the coarse grid, the fine block that advances it and its place there.
  struct InterfaceNode {
    Index at;
    int block, place;
  };
  /// What an interface node keeps from step to step.
  struct NodeState {
    Index at;
    double values[kState];
  };

  /// What an interface node brings to the coarse level where contact may push it.
  struct UpRecord {
    double velocity[8]; ///< [velocity_size_]
    SharedNode shared;
  };

  Index Offset() const;
  int Depth(Index node) const;
  double Beta(Index node) const;
  IndexBox MassNodes() const;
  bool IsInterface(Index node) const;
  IndexBox Around() const;
  /// Calls work(index) for the interface nodes in a box, the first axis fastest.
  template <class Work> void ForEachInterface(const IndexBox &box, Work work) const
  {
    ForEach(Intersection(box, Around()), [&](Index node) {
      if (IsInterface(node)) work(node);
    });
  }
  void ListOwned();
  void ListBand();
  void ListDonors();
  void ListHeldAxes();
  BlendNode Blend(Index node);
  int Know(Index at);
  PetscErrorCode FindReaders();
  PetscErrorCode ShareDonors();
  PetscErrorCode SendFinerMasses();
  /// Calls work(k, weight) for the known nodes that the motion of one of them hangs on, itself among them.
  template <class Work> void ForEachDonorOf(int k, Work work) const
  {
    if (own_[k] != 0) work(k, own_[k]);
    for (int d = first_donor_[k]; d < first_donor_[k + 1]; ++d) work(donors_[d].on, donors_[d].weight);
  }
  /// Calls work(k) for the known nodes whose motion is not all their own.
  template <class Work> void ForEachLight(Work work) const
  {
    for (std::size_t k = 0; k < own_.size(); ++k)
      if (own_[k] != 1) work(static_cast<int>(k));
  }
  bool FineContactMeets() const;
  bool MayMeetContact() const;
  PetscErrorCode ShareContact();
  /// True where all that contact has done to interface nodes is over: it lasts for two coarse steps more.
  bool IsFarFromContact() const { return steps_far_from_contact_ > 2; }
  PetscErrorCode FindPlaces();
  std::vector<NodeState> States() const;
  void SetState(const NodeState &state);
  PetscErrorCode BroadcastVelocity(std::vector<double> *array);
  PetscErrorCode CreateExchange();
  PetscErrorCode CreateTransfer(int count, SFHandle *transfer);
  /// `sums_` of the interface nodes that this rank works out. Collective on the finer level's ranks.
  PetscErrorCode Restrict();
  void AdvanceInterface(int substep, double dt);
  /// (v, dv) of an interface node in one of the arrays below.
  NodeVelocity VelocityIn(std::vector<double> &array, int k) const
  {
    double *const first = &array[static_cast<std::size_t>(velocity_size_) * k];
    return {first, first + velocity_size_ / 2};
  }
  void Prolong();
  void ProlongLight(std::vector<double> *motion) const;

  MPI_Comm world_ = MPI_COMM_NULL;
  Level *coarse_ = nullptr, *fine_ = nullptr;
  int ratio_ = 2, dim_ = 2, velocity_size_ = 4;
  double blend_width_ = kBlendWidth;
  std::vector<InterfaceNode> known_; ///< interface nodes that this rank advances, and then others that its band hangs on
  int owned_ = 0;                    ///< those that it advances
  std::unordered_map<Index, int, IndexHash> place_; ///< in known_
  std::vector<BlendNode> band_;                     ///< of owned fine nodes
  /// A node that a light one hangs on, see light_nodes.hpp.
  struct Donor {
    int on; ///< among the known
    double weight;
  };
  std::vector<double> own_;      ///< [known_]: the part of a node's motion that does not hang on others
  std::vector<int> first_donor_; ///< [known_ + 1]
  std::vector<Donor> donors_;
  std::vector<std::vector<PetscMPIInt>> readers_;      ///< of coarse_nodes_: the ranks that know them
  std::vector<unsigned char> held_axes_;               ///< [owned_] bit per axis held by a side
  std::vector<CoupledNode> coarse_nodes_, fine_nodes_; ///< the latter in the order of band_
  std::vector<std::ptrdiff_t> held_coarse_;
  CoupledPlaces fine_places_;
  SFHandle exchange_;                 ///< interface nodes to other ranks that know them
  SFHandle down_, up_;                ///< coarse nodes to interface nodes, and those of their owners to coarse nodes
  std::vector<NodeSums> coarse_sums_; ///< [owned_]: of the coarse points
  std::vector<Vec3> previous_force_;  ///< [owned_]
  std::vector<Vec3> contact_,
      impulse_carried_over_;       ///< [owned_]: impulse of contact on the coarse level; what fine points have not got of it yet
  std::vector<SharedNode> shared_; ///< by place on the coarse level
  std::vector<double> finer_masses_; ///< likewise, see FinerMasses
  std::vector<double> by_hats_;      ///< [owned_]: the same
  std::vector<SharedNode> outgoing_; ///< [owned_]
  int steps_far_from_contact_ = 0;   ///< coarse steps in a row in which contact could push no interface node
  UnitHandle shared_unit_, up_unit_, state_unit_;
  std::vector<NodeSums> sums_;         ///< [known_]: of the fine points, restricted; owned_mass: the same by hats alone
  std::vector<double> velocity_;       ///< [known_][velocity_size_]: (v, dv) of the substep
  std::vector<double> contact_change_; ///< [known_][velocity_size_]: what contact on the finer level adds to it
  std::vector<double> mean_;           ///< [owned_][velocity_size_]: mean v and sum of dv over substeps
  bool has_previous_ = false;
  Budgets budgets_;
};

} // namespace mlgimp
