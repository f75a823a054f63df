// The coupled step of two levels, and what it leaves to the next.
#include "hierarchy/coupling/level_interface.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <tuple>

namespace mlgimp
{

PetscErrorCode LevelInterface::Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, double blend_width)
{
  PetscFunctionBeginUser;
  world_ = world;
  coarse_ = &coarse;
  fine_ = &fine;
  ratio_ = ratio;
  blend_width_ = blend_width;
  dim_ = fine.Geometry().grid.dim;
  velocity_size_ = NodeLayout::Velocity(dim_);
  ListOwned();
  ListBand();
  ListDonors();
  ListHeldAxes();
  PetscCall(FindReaders());
  if (fine.Mesh().Participates()) PetscCall(CreateExchange());
  PetscCall(CreateTransfer(owned_, &down_));
  PetscCall(CreateTransfer(owned_, &up_));
  coarse_sums_.assign(owned_, {});
  previous_force_.assign(owned_, {});
  contact_.assign(owned_, {});
  impulse_carried_over_ = contact_;
  outgoing_.assign(owned_, {});
  shared_.assign(coarse.Mesh().Participates() ? coarse.Mesh().GhostedNodes() : 0, {});
  by_hats_.assign(owned_, 0.0);
  finer_masses_.assign(shared_.size(), 0.0);
  for (const std::ptrdiff_t place : held_coarse_) finer_masses_[place] = HUGE_VAL;
  PetscCall(shared_unit_.Create(sizeof(SharedNode) / sizeof(double)));
  PetscCall(up_unit_.Create(sizeof(UpRecord) / sizeof(double)));
  PetscCall(state_unit_.Create(kState));
  mean_.assign(static_cast<std::size_t>(velocity_size_) * owned_, 0.0);
  sums_.assign(known_.size(), {});
  velocity_.assign(velocity_size_ * known_.size(), 0.0);
  contact_change_ = velocity_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::CoarseToFine()
{
  const LogScope log(fine_->Events().coupling);
  const Grid &coarse = coarse_->Mesh();
  PetscFunctionBeginUser;
  const auto keep_forces = [&] {
    for (int k = 0; k < owned_; ++k) std::copy_n(coarse_sums_[k].force, 3, previous_force_[k].begin());
  };
  keep_forces();
  PetscCall(PetscSFBcastBegin(down_, coarse.SumsUnit(), coarse.Sums(), coarse_sums_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(down_, coarse.SumsUnit(), coarse.Sums(), coarse_sums_.data(), MPI_REPLACE));
  if (!has_previous_) keep_forces();
  has_previous_ = true;
  PetscCall(ShareDonors());
  std::fill(mean_.begin(), mean_.end(), 0.0);
  for (SharedNode &node : outgoing_) node = {};
  if (!coarse_->Contact().IsActive()) std::fill(contact_.begin(), contact_.end(), Vec3{});
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::Advance(int substep, double dt)
{
  const LogScope log(fine_->Events().coupling);
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  if (!mesh.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Restrict());
  AdvanceInterface(substep, dt);
  PetscCall(BroadcastVelocity(&velocity_));
  Prolong();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// From the owners of interface nodes to their copies.
PetscErrorCode LevelInterface::BroadcastVelocity(std::vector<double> *array)
{
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  if (!mesh.HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(exchange_, mesh.VelocityUnit(), array->data(), array->data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(exchange_, mesh.VelocityUnit(), array->data(), array->data(), MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void AddSums(double part, const NodeSums &from, NodeSums *to)
{
  to->mass += part * from.mass;
  for (int axis = 0; axis < 3; ++axis)
    to->momentum[axis] += part * from.momentum[axis], to->force[axis] += part * from.force[axis];
}

/// (m, p, f)_I = sum_i (1 - beta_i) N_I(x_i) (m, p, f)_i, of which light nodes give what hangs on others to these.
PetscErrorCode LevelInterface::Restrict()
{
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  std::fill(sums_.begin(), sums_.end(), NodeSums{});
  for (const BlendNode &node : band_) {
    const NodeSums &from = mesh.Sums()[node.node];
    if (from.mass == 0) continue;
    for (int a = 0; a < node.count; ++a) {
      const double part = (1 - node.beta) * node.weight[a];
      AddSums(part, from, &sums_[node.interface[a]]);
    }
  }
  for (NodeSums &sums : sums_) sums.owned_mass = sums.mass;
  ForEachLight([&](int k) {
    const NodeSums from = sums_[k];
    sums_[k] = {0, from.owned_mass, {}, {}};
    ForEachDonorOf(k, [&](int on, double weight) { AddSums(weight, from, &sums_[on]); });
  });
  if (!mesh.HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(exchange_, mesh.SumsUnit(), sums_.data(), sums_.data(), MPI_SUM));
  PetscCall(PetscSFReduceEnd(exchange_, mesh.SumsUnit(), sums_.data(), sums_.data(), MPI_SUM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// old = (p^c + p^f)/m, dv = (dt (F_k + f^f) + J/r)/m with m = m^c + m^f, F_k = f^c + (k/r)(f^c - f^c of the step before) and J
/// the impulse that contact on the coarse level had in the last step, and what fine points have not received of it; then p^c +=
/// m^c dv, as the coarse points will get dv.
void LevelInterface::AdvanceInterface(int substep, double dt)
{
  const double extrapolation = static_cast<double>(substep) / ratio_, cutoff = coarse_->Nodal().mass_cutoff;
  for (int k = 0; k < owned_; ++k) {
    NodeSums &coarse = coarse_sums_[k];
    const NodeSums &fine = sums_[k];
    const NodeVelocity now = VelocityIn(velocity_, k), mean = VelocityIn(mean_, k);
    const double mass = coarse.mass + fine.mass;
    std::fill_n(now.velocity, velocity_size_, 0.0);
    if (mass <= cutoff) continue;
    for (int axis = 0; axis < dim_; ++axis) {
      const double ahead = extrapolation * (coarse.force[axis] - previous_force_[k][axis]);
      const double old = (coarse.momentum[axis] + fine.momentum[axis]) / mass;
      const double contact = (contact_[k][axis] + impulse_carried_over_[k][axis]) / ratio_;
      double dv = (dt * (coarse.force[axis] + ahead + fine.force[axis]) + contact) / mass;
      budgets_.stagger_impulse[axis] += dt * ahead + contact;
      const bool held = held_axes_[k] >> axis & 1;
      if (held) {
        const double at = coarse_->Geometry().sides.HeldVelocity(known_[k].at, axis), by = at - (old + dv);
        budgets_.support_impulse[axis] += mass * by;
        budgets_.external_work += at * by * mass;
        dv = at - old;
      } else {
        outgoing_[k].finer_contact_change[axis] += contact / mass;
        outgoing_[k].impulse[axis] += contact_[k][axis] / ratio_;
      }
      coarse.momentum[axis] += coarse.mass * dv;
      now.velocity[axis] = old + dv;
      now.change[axis] = dv;
      mean.velocity[axis] += now.velocity[axis] / ratio_;
      mean.change[axis] += dv;
    }
  }
}

/// (v, dv)_i = (1 - beta_i) sum_I N_I(x_i) (v, dv)_I + beta_i (v, dv)_i, where v is that of the motion.
void LevelInterface::Prolong()
{
  ProlongLight(&velocity_);
  for (const BlendNode &node : band_) {
    double *const to = fine_->Mesh().Velocity(node.node).velocity;
    for (int c = 0; c < velocity_size_; ++c) to[c] *= node.beta;
    for (int a = 0; a < node.count; ++a) {
      const double part = (1 - node.beta) * node.weight[a], *const from = VelocityIn(velocity_, node.interface[a]).velocity;
      for (int c = 0; c < velocity_size_; ++c) to[c] += part * from[c];
    }
  }
}

/// Gives light interface nodes the motion of those that they hang on.
void LevelInterface::ProlongLight(std::vector<double> *motion) const
{
  ForEachLight([&](int k) {
    double *const to = motion->data() + static_cast<std::ptrdiff_t>(velocity_size_) * k;
    for (int c = 0; c < velocity_size_; ++c) to[c] *= own_[k];
    for (int d = first_donor_[k]; d < first_donor_[k + 1]; ++d) {
      const double *const from = motion->data() + static_cast<std::ptrdiff_t>(velocity_size_) * donors_[d].on;
      for (int c = 0; c < velocity_size_; ++c) to[c] += donors_[d].weight * from[c];
    }
  });
}

PetscErrorCode LevelInterface::ShiftForces(bool from_fine)
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<NodeSums> shift(owned_, NodeSums{});
  PetscFunctionBeginUser;
  if (!from_fine) {
    PetscCall(PetscSFBcastBegin(down_, coarse.SumsUnit(), coarse.Sums(), shift.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(down_, coarse.SumsUnit(), coarse.Sums(), shift.data(), MPI_REPLACE));
  } else if (fine_->Mesh().Participates()) {
    PetscCall(Restrict());
    std::copy_n(sums_.begin(), shift.size(), shift.begin());
  }
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < dim_; ++axis) coarse_sums_[k].force[axis] += shift[k].force[axis];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// To the coarse level, with its ghosts.
PetscErrorCode LevelInterface::SendFinerMasses()
{
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(up_, MPIU_REAL, by_hats_.data(), finer_masses_.data(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(up_, MPIU_REAL, by_hats_.data(), finer_masses_.data(), MPI_REPLACE));
  if (coarse_->Mesh().Participates()) PetscCall(coarse_->Mesh().BroadcastNumbers(finer_masses_.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::FineToCoarse()
{
  const LogScope log(fine_->Events().coupling);
  const Grid &coarse = coarse_->Mesh();
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) by_hats_[k] = sums_[k].owned_mass;
  PetscCall(SendFinerMasses());
  steps_far_from_contact_ = MayMeetContact() ? 0 : steps_far_from_contact_ + 1;
  if (!IsFarFromContact()) {
    PetscCall(ShareContact());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  std::fill(shared_.begin(), shared_.end(), SharedNode());
  PetscCall(PetscSFReduceBegin(up_, coarse.VelocityUnit(), mean_.data(), coarse.VelocityArray(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(up_, coarse.VelocityUnit(), mean_.data(), coarse.VelocityArray(), MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// FineToCoarse with what contact on both levels must know, in one message.
PetscErrorCode LevelInterface::ShareContact()
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<UpRecord> outgoing(owned_), incoming(shared_.size());
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) outgoing_[k].finer_mass = sums_[k].mass;
  for (int k = 0; k < owned_; ++k) {
    std::copy_n(VelocityIn(mean_, k).velocity, velocity_size_, outgoing[k].velocity);
    outgoing[k].shared = outgoing_[k];
  }
  PetscCall(PetscSFReduceBegin(up_, up_unit_, outgoing.data(), incoming.data(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(up_, up_unit_, outgoing.data(), incoming.data(), MPI_REPLACE));
  for (const CoupledNode &node : coarse_nodes_) {
    std::copy_n(incoming[node.node].velocity, velocity_size_, coarse.Velocity(node.node).velocity);
    shared_[node.node] = incoming[node.node].shared;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<LevelInterface::NodeState> LevelInterface::States() const
{
  std::vector<NodeState> states;
  for (int k = 0; has_previous_ && k < owned_; ++k) {
    NodeState &state = states.emplace_back();
    state.at = known_[k].at;
    std::copy_n(coarse_sums_[k].force, 3, state.values);
    std::copy_n(contact_[k].begin(), 3, state.values + 3);
    std::copy_n(impulse_carried_over_[k].begin(), 3, state.values + 6);
    state.values[9] = by_hats_[k];
  }
  return states;
}

/// Of a node that this rank works out.
void LevelInterface::SetState(const NodeState &state)
{
  const int k = place_.at(state.at);
  std::copy_n(state.values, 3, coarse_sums_[k].force);
  std::copy_n(state.values + 3, 3, contact_[k].begin());
  std::copy_n(state.values + 6, 3, impulse_carried_over_[k].begin());
  by_hats_[k] = state.values[9];
}

PetscErrorCode LevelInterface::TakeState(const LevelInterface &before)
{
  std::vector<NodeState> states = before.States();
  PetscFunctionBeginUser;
  has_previous_ = before.has_previous_;
  PetscCall(ExchangeRecords(world_, &states, [&](const NodeState &s) { return fine_->Mesh().Layout().ranks[BlockOf(s.at)]; }));
  for (const NodeState &state : states) SetState(state);
  if (has_previous_) PetscCall(SendFinerMasses());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::GatherState(std::vector<double> *state) const
{
  std::vector<NodeState> states = States();
  PetscFunctionBeginUser;
  PetscCall(ExchangeRecords(world_, &states, [](const NodeState &) { return 0; }));
  std::sort(states.begin(), states.end(), [](const NodeState &s, const NodeState &t) {
    return std::tie(s.at[2], s.at[1], s.at[0]) < std::tie(t.at[2], t.at[1], t.at[0]);
  });
  state->clear();
  for (const NodeState &one : states) state->insert(state->end(), one.values, one.values + kState);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::RestoreState(const std::vector<double> &state)
{
  auto next = state.begin();
  PetscFunctionBeginUser;
  has_previous_ = !state.empty();
  if (!has_previous_) PetscFunctionReturn(PETSC_SUCCESS);
  ForEachInterface(Around(), [&](Index node) {
    NodeState one{node, {}};
    std::copy_n(next, kState, one.values);
    next += kState;
    if (const auto found = place_.find(node); found != place_.end() && found->second < owned_) SetState(one);
  });
  PetscCall(SendFinerMasses());
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::size_t LevelInterface::InterfaceNodes() const
{
  std::size_t count = 0;
  ForEachInterface(Around(), [&](Index) { ++count; });
  return count;
}

} // namespace mlgimp
