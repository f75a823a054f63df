// Contact at the border of two levels: impulses on interface nodes, and what moves with these.
#pragma once

#include "contact/border_nodes.hpp"
#include "hierarchy/coupling/light_interface.hpp"
#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// What interface nodes hold in a step of the coarse level. Velocities: (v, dv), see NodeLayout::Velocity.
struct InterfaceFields {
  int components = 4;           ///< of a velocity
  std::vector<NodeSums> coarse; ///< [owned]: of the coarse points
  std::vector<NodeSums> fine;   ///< [known]: of the fine points, restricted; owned_mass: the same by hats alone
  std::vector<double> velocity; ///< [known][components]: of the substep
  std::vector<double> mean;     ///< [owned][components]: mean v and sum of dv over substeps

  /// (v, dv) of node k in one of the arrays.
  NodeVelocity In(std::vector<double> &array, int k) const
  {
    double *const first = &array[static_cast<std::size_t>(components) * k];
    return {first, first + components / 2};
  }
  /// Of the points of both levels on an owned node, kg.
  double Mass(int k) const { return coarse[k].mass + fine[k].mass; }
};

/// Both levels' contact may push interface nodes. That of the finer one acts in its substep, by Push and Spread. That of the
/// coarser one acts after all substeps, so fine points get its impulse in the next coarse step: in each substep an r-th of it.
class BorderContact : public BorderNodes
{
public:
  /// All are kept by reference.
  BorderContact(Level &coarse, Level &fine, const BorderGeometry &border, const InterfaceNodes &nodes,
                const LightInterface &light, InterfaceFields &fields)
      : coarse_(coarse), fine_(fine), border_(border), nodes_(nodes), light_(light), fields_(fields)
  {
  }
  PetscErrorCode Create();

  // What contact on the finer level asks.
  NodeBlend BlendOf(Index node) const override { return border_.BlendOf(node); }
  int BlockOf(Index coarse) const override { return nodes_.BlockOf(coarse); }
  double MassOf(Index coarse) const override;
  void ForEachDonor(Index coarse, const DonorWork &work) const override;
  Vec3 FreePart(Index coarse, Vec3 change) const override;
  void Push(Index coarse, Vec3 change_of_velocity) override;
  PetscErrorCode Spread(std::vector<NodeChange> *pushed) override;

  /// The coarser level's nodes by place, for its contact in a step that has come to ToCoarse.
  SharedNode *Shared() { return shared_.data(); }

  // A coarse step.

  void Begin();
  /// The impulse of coarse contact that an owned node gets in each substep, N s.
  Vec3 ImpulseInSubstep(int k) const;
  /// It has changed the velocity of an owned node by that along an axis, m/s.
  void Record(int k, int axis, double change);
  /// Brings mean velocities to the coarse level, with what contact on both levels must know where either may push interface
  /// nodes. Collective on all.
  PetscErrorCode ToCoarse();
  /// Takes what contact on the coarser level leaves to the finer level's points; they get it in the next step. Collective on all.
  PetscErrorCode Take(Budgets &budgets);

  /// What an owned node keeps from step to step: impulse of contact, and what fine points have not got of it, N s.
  static constexpr int kState = 6; ///< size
  void GetState(int k, double *state) const;
  void SetState(int k, const double *state);

private:
  /// What an interface node brings to the coarse level where contact may push it.
  struct UpRecord {
    double velocity[8]; ///< [components]
    SharedNode shared;
  };
  bool FineContactMeets() const;
  bool MayMeetContact() const;
  PetscErrorCode ShareContact();
  /// True where all that contact has done to interface nodes is over: it lasts for two coarse steps more.
  bool IsFar() const { return steps_far_ > 2; }

  Level &coarse_, &fine_;
  const BorderGeometry &border_;
  const InterfaceNodes &nodes_;
  const LightInterface &light_;
  InterfaceFields &fields_;
  std::vector<Vec3> impulse_;        ///< [owned]: of contact on the coarse level
  std::vector<Vec3> carried_over_;   ///< [owned]: what fine points have not got of it yet
  std::vector<double> change_;       ///< [known][components]: what contact on the finer level adds to velocities
  std::vector<SharedNode> shared_;   ///< by place on the coarse level
  std::vector<UpRecord> incoming_;   ///< by place on the coarse level, where contact may push
  std::vector<SharedNode> outgoing_; ///< [owned]
  int steps_far_ = 0;                ///< coarse steps in a row in which contact could push no interface node
  UnitHandle shared_unit_, up_unit_;
};

} // namespace mlgimp
