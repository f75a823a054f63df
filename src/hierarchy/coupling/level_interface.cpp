// The coupled step of two levels, and what it leaves to the next.
#include "hierarchy/coupling/level_interface.hpp"

#include "base/exchange.hpp"
#include "base/pack.hpp"

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
  border_ = BorderGeometry(coarse.Geometry().grid, fine.Geometry(), ratio, blend_width);
  PetscCall(nodes_.Create(world, border_, coarse.Mesh().Nodes(), coarse.Geometry().sides, fine.Mesh().Nodes()));
  PetscCall(light_.Create(world, nodes_, coarse.Mesh().Nodes()));
  fields_.components = NodeLayout::Velocity(border_.Dim());
  fields_.coarse.assign(nodes_.Owned(), {});
  fields_.fine.assign(nodes_.Known(), {});
  fields_.velocity.assign(static_cast<std::size_t>(fields_.components) * nodes_.Known(), 0.0);
  fields_.mean.assign(static_cast<std::size_t>(fields_.components) * nodes_.Owned(), 0.0);
  contact_.emplace(coarse, fine, border_, nodes_, light_, fields_);
  PetscCall(contact_->Create());
  previous_force_.assign(nodes_.Owned(), {});
  by_hats_.assign(nodes_.Owned(), 0.0);
  finer_masses_.assign(coarse.Mesh().Participates() ? coarse.Mesh().Ghosted().Count() : 0, 0.0);
  for (const std::ptrdiff_t place : nodes_.Coupled().held_coarse) finer_masses_[place] = HUGE_VAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::CoarseToFine()
{
  const LogScope log(fine_->Parts().events.coupling);
  const Grid &coarse = coarse_->Mesh();
  PetscFunctionBeginUser;
  const auto keep_forces = [&] {
    for (int k = 0; k < nodes_.Owned(); ++k) std::copy_n(fields_.coarse[k].force, 3, previous_force_[k].begin());
  };
  keep_forces();
  PetscCall(nodes_.ToInterface(coarse.Arrays().SumsUnit(), coarse.Sums(), fields_.coarse.data()));
  if (!has_previous_) keep_forces();
  has_previous_ = true;
  PetscCall(light_.Update(coarse_->Parts().light));
  std::fill(fields_.mean.begin(), fields_.mean.end(), 0.0);
  contact_->Begin();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::Advance(int substep, double dt)
{
  const LogScope log(fine_->Parts().events.coupling);
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  if (!mesh.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Restrict());
  AdvanceInterface(substep, dt);
  PetscCall(nodes_.Broadcast(mesh.Arrays().VelocityUnit(), fields_.velocity.data()));
  Prolong();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// (m, p, f)_I = sum_i (1 - beta_i) N_I(x_i) (m, p, f)_i, of which light nodes give what hangs on others to these; on owned
/// interface nodes. Collective on the finer level's ranks.
PetscErrorCode LevelInterface::Restrict()
{
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  std::fill(fields_.fine.begin(), fields_.fine.end(), NodeSums{});
  for (const BlendNode &node : nodes_.Band()) {
    const NodeSums &from = mesh.Sums()[node.node];
    if (from.mass == 0) continue;
    for (int a = 0; a < node.count; ++a) {
      const double part = (1 - node.beta) * node.weight[a];
      AddTimes(part, &from.mass, &fields_.fine[node.interface[a]].mass, NodeLayout::kSums);
    }
  }
  for (NodeSums &sums : fields_.fine) sums.owned_mass = sums.mass;
  light_.Restrict(&fields_.fine);
  PetscCall(nodes_.AddUp(mesh.Arrays().SumsUnit(), fields_.fine.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// old = (p^c + p^f)/m, dv = (dt (F_k + f^f) + J/r)/m with m = m^c + m^f, F_k = f^c + (k/r)(f^c - f^c of the step before) and J
/// the impulse that contact on the coarse level had in the last step, and what fine points have not received of it; then p^c +=
/// m^c dv, as the coarse points will get dv.
void LevelInterface::AdvanceInterface(int substep, double dt)
{
  const double extrapolation = static_cast<double>(substep) / border_.Ratio(), cutoff = coarse_->Parts().nodal.mass_cutoff;
  for (int k = 0; k < nodes_.Owned(); ++k) {
    NodeSums &coarse = fields_.coarse[k];
    const NodeSums &fine = fields_.fine[k];
    const NodeVelocity now = fields_.In(fields_.velocity, k), mean = fields_.In(fields_.mean, k);
    const double mass = fields_.Mass(k);
    std::fill_n(now.velocity, fields_.components, 0.0);
    if (mass <= cutoff) continue;
    const Vec3 contact = contact_->ImpulseInSubstep(k);
    for (int axis = 0; axis < border_.Dim(); ++axis) {
      const double ahead = extrapolation * (coarse.force[axis] - previous_force_[k][axis]);
      const double old = (coarse.momentum[axis] + fine.momentum[axis]) / mass;
      double dv = (dt * (coarse.force[axis] + ahead + fine.force[axis]) + contact[axis]) / mass;
      budgets_.stagger_impulse[axis] += dt * ahead + contact[axis];
      if (nodes_.IsHeld(k, axis)) {
        const double at = coarse_->Geometry().sides.HeldVelocity(nodes_.At(k), axis), by = at - (old + dv);
        budgets_.support_impulse[axis] += mass * by;
        budgets_.external_work += at * by * mass;
        dv = at - old;
      } else {
        contact_->Record(k, axis, contact[axis] / mass);
      }
      coarse.momentum[axis] += coarse.mass * dv;
      now.velocity[axis] = old + dv;
      now.change[axis] = dv;
      mean.velocity[axis] += now.velocity[axis] / border_.Ratio();
      mean.change[axis] += dv;
    }
  }
}

/// (v, dv)_i = (1 - beta_i) sum_I N_I(x_i) (v, dv)_I + beta_i (v, dv)_i, where v is that of the motion.
void LevelInterface::Prolong()
{
  const double *const velocity = fields_.velocity.data();
  light_.Prolong(fields_.components, &fields_.velocity);
  for (const BlendNode &node : nodes_.Band()) {
    double *const to = fine_->Mesh().Velocity(node.node).velocity;
    for (int c = 0; c < fields_.components; c += kLanes) {
      Pack of_interface{};
      for (int a = 0; a < node.count; ++a)
        of_interface += node.weight[a] * LoadVector(velocity + fields_.components * node.interface[a] + c);
      StoreVector(to + c, node.beta * LoadVector(to + c) + (1 - node.beta) * of_interface);
    }
  }
}

PetscErrorCode LevelInterface::ShiftForces(bool from_fine)
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<NodeSums> shift(nodes_.Owned(), NodeSums{});
  PetscFunctionBeginUser;
  if (!from_fine) {
    PetscCall(nodes_.ToInterface(coarse.Arrays().SumsUnit(), coarse.Sums(), shift.data()));
  } else if (fine_->Mesh().Participates()) {
    PetscCall(Restrict());
    std::copy_n(fields_.fine.begin(), shift.size(), shift.begin());
  }
  for (int k = 0; k < nodes_.Owned(); ++k)
    for (int axis = 0; axis < border_.Dim(); ++axis) fields_.coarse[k].force[axis] += shift[k].force[axis];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// To the coarse level, with its ghosts.
PetscErrorCode LevelInterface::SendFinerMasses()
{
  PetscFunctionBeginUser;
  PetscCall(nodes_.ToCoarse(MPIU_REAL, by_hats_.data(), finer_masses_.data()));
  if (coarse_->Mesh().Participates()) PetscCall(coarse_->Mesh().Halo().Broadcast(MPIU_REAL, finer_masses_.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::FineToCoarse()
{
  const LogScope log(fine_->Parts().events.coupling);
  PetscFunctionBeginUser;
  for (int k = 0; k < nodes_.Owned(); ++k) by_hats_[k] = fields_.fine[k].owned_mass;
  PetscCall(SendFinerMasses());
  PetscCall(contact_->ToCoarse());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::TakeContact()
{
  const LogScope log(fine_->Parts().events.coupling);
  PetscFunctionBeginUser;
  PetscCall(contact_->Take(budgets_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<LevelInterface::NodeState> LevelInterface::States() const
{
  std::vector<NodeState> states;
  for (int k = 0; has_previous_ && k < nodes_.Owned(); ++k) {
    NodeState &state = states.emplace_back();
    state.at = nodes_.At(k);
    std::copy_n(fields_.coarse[k].force, 3, state.values);
    contact_->GetState(k, state.values + 3);
    state.values[kState - 1] = by_hats_[k];
  }
  return states;
}

/// Of a node that this rank works out.
void LevelInterface::SetState(const NodeState &state)
{
  const int k = nodes_.Find(state.at);
  std::copy_n(state.values, 3, fields_.coarse[k].force);
  contact_->SetState(k, state.values + 3);
  by_hats_[k] = state.values[kState - 1];
}

PetscErrorCode LevelInterface::TakeState(const LevelInterface &before)
{
  std::vector<NodeState> states = before.States();
  PetscFunctionBeginUser;
  has_previous_ = before.has_previous_;
  PetscCall(ExchangeRecords(world_, &states,
                            [&](const NodeState &s) { return fine_->Mesh().Nodes().Layout().ranks[nodes_.BlockOf(s.at)]; }));
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
  border_.ForEachInterface(border_.Around(), [&](Index node) {
    NodeState one{node, {}};
    std::copy_n(next, kState, one.values);
    next += kState;
    if (const int k = nodes_.Find(node); k >= 0 && k < nodes_.Owned()) SetState(one);
  });
  PetscCall(SendFinerMasses());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
