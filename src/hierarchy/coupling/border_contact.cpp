// What fine nodes near a border hang on, and contact there: impulses on nodes of the coarser level and what hangs on them.
#include "hierarchy/coupling/level_interface.hpp"

#include <algorithm>

namespace mlgimp
{

static int FloorDivide(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

NodeBlend LevelInterface::BlendOf(Index node) const
{
  NodeBlend blend{Beta(node), 0, {}, {}};
  if (blend.beta == 1) return blend;
  const Index offset = Offset();
  ForEach({{}, {2, 2, dim_ == 3 ? 2 : 1}}, [&](Index corner) {
    Index coarse{};
    double weight = 1;
    for (int axis = 0; axis < dim_; ++axis) {
      const int below = FloorDivide(node[axis], ratio_);
      const double x = static_cast<double>(node[axis] - below * ratio_) / ratio_;
      coarse[axis] = below + corner[axis] + offset[axis];
      weight *= corner[axis] ? x : 1 - x;
    }
    if (weight == 0) return;
    blend.node[blend.count] = coarse;
    blend.weight[blend.count++] = weight;
  });
  return blend;
}

/// The block of the fine node at its place, or of the nearest one.
int LevelInterface::BlockOf(Index coarse) const
{
  const IndexBox all = fine_->Geometry().grid.NodeBox();
  const Index offset = Offset();
  Index at{};
  for (int axis = 0; axis < dim_; ++axis)
    at[axis] = std::clamp((coarse[axis] - offset[axis]) * ratio_, all.lower[axis], all.upper[axis] - 1);
  return fine_->Mesh().BlockOfNode(at);
}

double LevelInterface::MassOf(Index coarse) const
{
  const auto place = place_.find(coarse);
  return place == place_.end() || place->second >= owned_ ? 0 : coarse_sums_[place->second].mass + sums_[place->second].mass;
}

Vec3 LevelInterface::FreePart(Index coarse, Vec3 change) const
{
  const unsigned char held = held_axes_[place_.at(coarse)];
  for (int axis = 0; axis < dim_; ++axis)
    if (held >> axis & 1) change[axis] = 0;
  return change;
}

void LevelInterface::Push(Index coarse, Vec3 change_of_velocity)
{
  const NodeVelocity to = VelocityIn(contact_change_, place_.at(coarse));
  for (int axis = 0; axis < dim_; ++axis) to.velocity[axis] = to.change[axis] = change_of_velocity[axis];
}

void LevelInterface::ForEachDonor(Index coarse, const DonorWork &work) const
{
  const auto place = place_.find(coarse);
  if (place == place_.end()) return work(coarse, 1);
  ForEachDonorOf(place->second, [&](int k, double weight) { work(known_[k].at, weight); });
}

/// Whether contact on the finer level may push nodes that move with interface nodes; the same on all ranks.
bool LevelInterface::FineContactMeets() const
{
  bool meets = false;
  IndexBox pushed = fine_->Contact().Zone(); // which holds also the coarser nodes that these move with
  for (int axis = 0; axis < dim_; ++axis) pushed.lower[axis] += ratio_, pushed.upper[axis] -= ratio_;
  if (fine_->Contact().IsActive())
    ForEach(Intersection(pushed, MassNodes()), [&](Index node) { meets = meets || Beta(node) < 1; });
  return meets;
}

/// Whether contact on one of the two levels may push interface nodes; the same on all ranks.
bool LevelInterface::MayMeetContact() const
{
  bool meets = FineContactMeets();
  if (!meets && coarse_->Contact().IsActive()) ForEachInterface(coarse_->Contact().Zone(), [&](Index) { meets = true; });
  return meets;
}

/// v_I, dv_I, what they are summed up to and p^c as in a substep; then (v, dv)_i += (1 - beta_i) sum_I N_I(x_i) (v, dv)_I.
PetscErrorCode LevelInterface::Spread(std::vector<NodeChange> *pushed)
{
  PetscFunctionBeginUser;
  if (!FineContactMeets()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BroadcastVelocity(&contact_change_));
  for (int k = 0; k < owned_; ++k) {
    const NodeVelocity by = VelocityIn(contact_change_, k), mean = VelocityIn(mean_, k);
    for (int axis = 0; axis < dim_; ++axis) {
      coarse_sums_[k].momentum[axis] += coarse_sums_[k].mass * by.change[axis];
      mean.velocity[axis] += by.velocity[axis] / ratio_;
      mean.change[axis] += by.change[axis];
      outgoing_[k].finer_contact_change[axis] += by.change[axis];
    }
  }
  ProlongLight(&contact_change_);
  for (const BlendNode &node : band_) {
    NodeChange one{node.node, {}};
    Vec3 motion{};
    for (int a = 0; a < node.count; ++a) {
      const double part = (1 - node.beta) * node.weight[a];
      const NodeVelocity by = VelocityIn(contact_change_, node.interface[a]);
      for (int axis = 0; axis < dim_; ++axis)
        one.change[axis] += part * by.change[axis], motion[axis] += part * by.velocity[axis];
    }
    if (one.change == Vec3{}) continue;
    const NodeVelocity to = fine_->Mesh().Velocity(node.node);
    for (int axis = 0; axis < dim_; ++axis) to.velocity[axis] += motion[axis], to.change[axis] += one.change[axis];
    pushed->push_back(one);
  }
  std::fill(contact_change_.begin(), contact_change_.end(), 0.0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::TakeContact()
{
  const LogScope log(fine_->Events().coupling);
  std::vector<Vec3> before; // the impulses in whose place new ones have come
  PetscFunctionBeginUser;
  for (const SharedNode &node : outgoing_) before.push_back(node.impulse);
  for (int k = 0; k < owned_; ++k) contact_[k] = impulse_carried_over_[k] = {};
  if (!coarse_->Contact().IsActive() || IsFarFromContact()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(down_, shared_unit_, shared_.data(), outgoing_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(down_, shared_unit_, shared_.data(), outgoing_.data(), MPI_REPLACE));
  for (int k = 0; k < owned_; ++k) {
    const double mass = coarse_sums_[k].mass + sums_[k].mass;
    contact_[k] = outgoing_[k].impulse;
    if (mass > 0) impulse_carried_over_[k] = sums_[k].mass / mass * (contact_[k] - before[k]);
    budgets_.stagger_impulse += -1 * (before[k] + impulse_carried_over_[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
