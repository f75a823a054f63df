// Impulses of contact on interface nodes, in the step of either level.
#include "hierarchy/coupling/border_contact.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode BorderContact::Create()
{
  PetscFunctionBeginUser;
  impulse_.assign(nodes_.Owned(), {});
  carried_over_ = impulse_;
  change_.assign(static_cast<std::size_t>(fields_.components) * nodes_.Known(), 0.0);
  outgoing_.assign(nodes_.Owned(), {});
  shared_.assign(coarse_.Mesh().Participates() ? coarse_.Mesh().Ghosted().Count() : 0, {});
  PetscCall(shared_unit_.Create(sizeof(SharedNode) / sizeof(double)));
  PetscCall(up_unit_.Create(sizeof(UpRecord) / sizeof(double)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double BorderContact::MassOf(Index coarse) const
{
  const int k = nodes_.Find(coarse);
  return k < 0 || k >= nodes_.Owned() ? 0 : fields_.Mass(k);
}

Vec3 BorderContact::FreePart(Index coarse, Vec3 change) const
{
  const int k = nodes_.Find(coarse);
  for (int axis = 0; axis < border_.Dim(); ++axis)
    if (nodes_.IsHeld(k, axis)) change[axis] = 0;
  return change;
}

void BorderContact::Push(Index coarse, Vec3 change_of_velocity)
{
  const NodeVelocity to = fields_.In(change_, nodes_.Find(coarse));
  for (int axis = 0; axis < border_.Dim(); ++axis) to.velocity[axis] = to.change[axis] = change_of_velocity[axis];
}

void BorderContact::ForEachDonor(Index coarse, const DonorWork &work) const
{
  const int node = nodes_.Find(coarse);
  if (node < 0) return work(coarse, 1);
  light_.ForEachDonor(node, [&](int k, double weight) { work(nodes_.At(k), weight); });
}

/// Whether contact on the finer level may push nodes that move with interface nodes; the same on all ranks.
bool BorderContact::FineContactMeets() const
{
  bool meets = false;
  IndexBox pushed = fine_.Contact().Group().Zone(); // which holds also the coarser nodes that these move with
  for (int axis = 0; axis < border_.Dim(); ++axis) pushed.lower[axis] += border_.Ratio(), pushed.upper[axis] -= border_.Ratio();
  if (fine_.Contact().IsActive())
    ForEach(Intersection(pushed, border_.MassNodes()), [&](Index node) { meets = meets || border_.Beta(node) < 1; });
  return meets;
}

/// Whether contact on one of the two levels may push interface nodes; the same on all ranks.
bool BorderContact::MayMeetContact() const
{
  bool meets = FineContactMeets();
  if (!meets && coarse_.Contact().IsActive())
    border_.ForEachInterface(coarse_.Contact().Group().Zone(), [&](Index) { meets = true; });
  return meets;
}

/// v_I, dv_I, what they are summed up to and p^c as in a substep; then (v, dv)_i += (1 - beta_i) sum_I N_I(x_i) (v, dv)_I.
PetscErrorCode BorderContact::Spread(std::vector<NodeChange> *pushed)
{
  const int dim = border_.Dim();
  PetscFunctionBeginUser;
  if (!FineContactMeets()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(nodes_.Broadcast(fine_.Mesh().Arrays().VelocityUnit(), change_.data()));
  for (int k = 0; k < nodes_.Owned(); ++k) {
    const NodeVelocity by = fields_.In(change_, k), mean = fields_.In(fields_.mean, k);
    for (int axis = 0; axis < dim; ++axis) {
      fields_.coarse[k].momentum[axis] += fields_.coarse[k].mass * by.change[axis];
      mean.velocity[axis] += by.velocity[axis] / border_.Ratio();
      mean.change[axis] += by.change[axis];
      outgoing_[k].finer_contact_change[axis] += by.change[axis];
    }
  }
  light_.Prolong(fields_.components, &change_);
  for (const BlendNode &node : nodes_.Band()) {
    NodeChange one{node.node, {}};
    Vec3 motion{};
    for (int a = 0; a < node.count; ++a) {
      const double part = (1 - node.beta) * node.weight[a];
      const NodeVelocity by = fields_.In(change_, node.interface[a]);
      for (int axis = 0; axis < dim; ++axis) one.change[axis] += part * by.change[axis], motion[axis] += part * by.velocity[axis];
    }
    if (one.change == Vec3{}) continue;
    const NodeVelocity to = fine_.Mesh().Velocity(node.node);
    for (int axis = 0; axis < dim; ++axis) to.velocity[axis] += motion[axis], to.change[axis] += one.change[axis];
    pushed->push_back(one);
  }
  std::fill(change_.begin(), change_.end(), 0.0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void BorderContact::Begin()
{
  for (SharedNode &node : outgoing_) node = {};
  if (!coarse_.Contact().IsActive()) std::fill(impulse_.begin(), impulse_.end(), Vec3{});
}

Vec3 BorderContact::ImpulseInSubstep(int k) const
{
  Vec3 impulse;
  for (int axis = 0; axis < 3; ++axis) impulse[axis] = (impulse_[k][axis] + carried_over_[k][axis]) / border_.Ratio();
  return impulse;
}

void BorderContact::Record(int k, int axis, double change)
{
  outgoing_[k].finer_contact_change[axis] += change;
  outgoing_[k].impulse[axis] += impulse_[k][axis] / border_.Ratio();
}

PetscErrorCode BorderContact::ToCoarse()
{
  const NodalArrays &coarse = coarse_.Mesh().Arrays();
  PetscFunctionBeginUser;
  steps_far_ = MayMeetContact() ? 0 : steps_far_ + 1;
  if (!IsFar()) {
    PetscCall(ShareContact());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  std::fill(shared_.begin(), shared_.end(), SharedNode()); // contact has left impulses on other nodes too
  PetscCall(nodes_.ToCoarse(coarse.VelocityUnit(), fields_.mean.data(), coarse.VelocityArray()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// ToCoarse with what contact on both levels must know, in one message.
PetscErrorCode BorderContact::ShareContact()
{
  const NodalArrays &coarse = coarse_.Mesh().Arrays();
  std::vector<UpRecord> outgoing(nodes_.Owned());
  PetscFunctionBeginUser;
  for (int k = 0; k < nodes_.Owned(); ++k) {
    outgoing_[k].finer_mass = fields_.fine[k].mass;
    std::copy_n(fields_.In(fields_.mean, k).velocity, fields_.components, outgoing[k].velocity);
    outgoing[k].shared = outgoing_[k];
  }
  incoming_.resize(shared_.size());
  PetscCall(nodes_.ToCoarse(up_unit_, outgoing.data(), incoming_.data()));
  for (const std::ptrdiff_t place : nodes_.Coupled().coarse) {
    std::copy_n(incoming_[place].velocity, fields_.components, coarse.Velocity(place).velocity);
    shared_[place] = incoming_[place].shared;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BorderContact::Take(Budgets &budgets)
{
  std::vector<Vec3> before; // the impulses in whose place new ones have come
  PetscFunctionBeginUser;
  for (const SharedNode &node : outgoing_) before.push_back(node.impulse);
  for (int k = 0; k < nodes_.Owned(); ++k) impulse_[k] = carried_over_[k] = {};
  if (!coarse_.Contact().IsActive() || IsFar()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(nodes_.ToInterface(shared_unit_, shared_.data(), outgoing_.data()));
  for (int k = 0; k < nodes_.Owned(); ++k) {
    const double mass = fields_.Mass(k);
    impulse_[k] = outgoing_[k].impulse;
    if (mass > 0) carried_over_[k] = fields_.fine[k].mass / mass * (impulse_[k] - before[k]);
    budgets.stagger_impulse += -1 * (before[k] + carried_over_[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void BorderContact::GetState(int k, double *state) const
{
  std::copy_n(impulse_[k].begin(), 3, state);
  std::copy_n(carried_over_[k].begin(), 3, state + 3);
}

void BorderContact::SetState(int k, const double *state)
{
  std::copy_n(state, 3, impulse_[k].begin());
  std::copy_n(state + 3, 3, carried_over_[k].begin());
}

} // namespace mlgimp
