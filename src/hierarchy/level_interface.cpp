// Lists of interface and band nodes, and the coupled step.
#include "hierarchy/level_interface.hpp"

#include <algorithm>
#include <climits>
#include <cmath>

namespace mlgimp
{

static constexpr double kOuterBeta = 0.3; ///< beta just inside the box
/// Of a full cell: nodes with less mass may lose it within a step, and get nothing of what acted on them in the step before.
static constexpr double kLeastExpecting = 1e-3;

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
  ListInterface();
  ListBand();
  if (fine.Mesh().Participates()) PetscCall(CreateExchange());
  PetscCall(CreateTransfer());
  coarse_sums_.assign(owned_, {});
  previous_force_.assign(owned_, {});
  contact_.assign(owned_, {});
  left_ = contact_;
  to_share_.assign(owned_, {});
  shared_.assign(coarse.Mesh().Participates() ? coarse.Mesh().GhostedNodes() : 0, {});
  PetscCall(shared_unit_.Create(sizeof(SharedNode) / sizeof(double)));
  mean_.assign(static_cast<std::size_t>(velocity_size_) * owned_, 0.0);
  sums_.assign(local_.size(), {});
  velocity_.assign(velocity_size_ * local_.size(), 0.0);
  pushed_ = velocity_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Depth of a fine node inside the box, in fine cells; sides of the domain do not count.
int LevelInterface::Depth(Index node) const
{
  const LevelGeometry &geometry = fine_->Geometry();
  int depth = INT_MAX;
  for (int s = 0; s < 2 * dim_; ++s) {
    const int axis = s / 2;
    if (geometry.border[s]) depth = std::min(depth, s % 2 ? geometry.grid.cells[axis] - node[axis] : node[axis]);
  }
  return depth;
}

double LevelInterface::Beta(Index node) const
{
  const double depth = Depth(node), width = blend_width_ * ratio_;
  return depth <= 0 ? 0 : depth >= width ? 1 : kOuterBeta + (1 - kOuterBeta) * depth / width;
}

/// The fine nodes that can bear mass: beyond a side of the domain that is the first layer only.
IndexBox LevelInterface::MassNodes() const
{
  const LevelGeometry &geometry = fine_->Geometry();
  IndexBox nodes = geometry.grid.NodeBox();
  for (int axis = 0; axis < dim_; ++axis) {
    if (!geometry.border[2 * axis]) nodes.lower[axis] = -1;
    if (!geometry.border[2 * axis + 1]) nodes.upper[axis] = geometry.grid.cells[axis] + 2;
  }
  return nodes;
}

/// Indices of the fine box's lower corner on the coarse grid.
Index LevelInterface::Offset() const
{
  const GridGeometry &c = coarse_->Geometry().grid, &f = fine_->Geometry().grid;
  Index offset{};
  for (int axis = 0; axis < f.dim; ++axis)
    offset[axis] = static_cast<int>(std::lround((f.lower[axis] - c.lower[axis]) / c.spacing));
  return offset;
}

/// True where some fine node with beta < 1 lies within the hat of a coarse node.
bool LevelInterface::IsInterface(Index node) const
{
  const Index from = node - Offset();
  IndexBox hat{{}, {1, 1, 1}};
  for (int axis = 0; axis < dim_; ++axis)
    hat.lower[axis] = (from[axis] - 1) * ratio_ + 1, hat.upper[axis] = (from[axis] + 1) * ratio_;
  hat = Intersection(hat, MassNodes());
  if (hat.Empty()) return false;
  const int depth = std::min(Depth(hat.lower), Depth(hat.upper - Index{1, 1, 1})); // of a box, at its corners
  return depth < blend_width_ * ratio_;
}

void LevelInterface::ListInterface()
{
  const GridGeometry &f = fine_->Geometry().grid;
  const Grid &mesh = fine_->Mesh();
  const Index offset = Offset();
  const int reach = (f.padding + ratio_ - 1) / ratio_;
  std::vector<int> places(mesh.Layout().Blocks(), 0);
  IndexBox around{{}, {1, 1, 1}};
  for (int axis = 0; axis < dim_; ++axis) {
    around.lower[axis] = offset[axis] - reach;
    around.upper[axis] = offset[axis] + f.cells[axis] / ratio_ + reach + 1;
  }
  interface_.clear();
  ForEach(Intersection(around, coarse_->Geometry().grid.NodeBox()), [&](Index node) {
    if (!IsInterface(node)) return;
    const int block = BlockOf(node);
    interface_.push_back({node, block, places[block]++});
  });
}

/// The interface nodes that this rank owns on the coarse level, and those that it advances.
void LevelInterface::ListKnown(std::map<Index, int> *place)
{
  const Grid &mesh = fine_->Mesh(), &coarse = coarse_->Mesh();
  const PetscMPIInt block = mesh.Participates() ? RankIn(mesh.Comm()) : -1;
  local_.clear(), held_axes_.clear(), coarse_nodes_.clear();
  for (int k = 0; k < static_cast<int>(interface_.size()); ++k) {
    const InterfaceNode &node = interface_[k];
    if (coarse.Participates() && coarse.Owns(node.at)) coarse_nodes_.push_back({coarse.Place(node.at), true});
    if (node.block != block) continue;
    (*place)[node.at] = static_cast<int>(local_.size());
    local_.push_back(k);
    held_axes_.push_back(0);
    for (int axis = 0; axis < dim_; ++axis)
      if (coarse_->Geometry().sides.Constrains(node.at, axis)) held_axes_.back() |= 1 << axis;
  }
  owned_ = static_cast<int>(local_.size());
  owned_place_ = *place;
}

void LevelInterface::ListBand()
{
  const Grid &mesh = fine_->Mesh();
  std::map<Index, int> number, place; // of interface nodes: among all, among those known here
  band_.clear(), fine_nodes_.clear();
  ListKnown(&place);
  for (std::size_t k = 0; k < interface_.size(); ++k) number[interface_[k].at] = static_cast<int>(k);
  if (!mesh.Participates()) return;
  ForEach(Intersection(mesh.Owned(), MassNodes()), [&](Index node) {
    if (Beta(node) >= 1) return;
    band_.push_back(Blend(node, number, place));
    fine_nodes_.push_back({band_.back().node, band_.back().beta == 0});
  });
}

/// The weights of a fine node; interface nodes that other ranks advance become known here.
BlendNode LevelInterface::Blend(Index node, const std::map<Index, int> &number, std::map<Index, int> &place)
{
  const NodeBlend all = BlendOf(node);
  BlendNode blend{fine_->Mesh().Place(node), all.beta, 0, {}, {}};
  for (int a = 0; a < all.count; ++a) {
    const auto found = number.find(all.node[a]);
    if (found == number.end()) continue;
    const auto [at, is_new] = place.insert({all.node[a], static_cast<int>(local_.size())});
    if (is_new) local_.push_back(found->second);
    blend.interface[blend.count] = at->second;
    blend.weight[blend.count++] = all.weight[a];
  }
  return blend;
}

/// Owned interface nodes to their copies on other ranks of the fine level.
PetscErrorCode LevelInterface::CreateExchange()
{
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  for (int k = owned_; k < static_cast<int>(local_.size()); ++k) {
    leaves.push_back(k);
    roots.push_back({interface_[local_[k]].block, interface_[local_[k]].place});
  }
  PetscCall(PetscSFCreate(fine_->Mesh().Comm(), exchange_.Out()));
  PetscCall(PetscSFSetGraph(exchange_, owned_, static_cast<PetscInt>(leaves.size()), leaves.data(), PETSC_COPY_VALUES,
                            roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(exchange_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Owned coarse nodes to the interface nodes that the fine level's ranks advance.
PetscErrorCode LevelInterface::CreateTransfer()
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) {
    const InterfaceNode &node = interface_[local_[k]];
    const int block = coarse.BlockOfNode(node.at);
    roots.push_back({coarse.Layout().ranks[block], coarse.PlaceInBlock(block, node.at)});
  }
  const PetscInt places = coarse.Participates() ? static_cast<PetscInt>(coarse.GhostedNodes()) : 0;
  PetscCall(PetscSFCreate(world_, transfer_.Out()));
  PetscCall(PetscSFSetGraph(transfer_, places, owned_, nullptr, PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(transfer_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<BlockTraffic> LevelInterface::Traffic(int level) const
{
  std::map<std::pair<int, int>, double> bytes;
  std::vector<BlockTraffic> traffic;
  for (const InterfaceNode &node : interface_)
    bytes[{coarse_->Mesh().BlockOfNode(node.at), node.block}] += sizeof(NodeSums) + sizeof(double) * velocity_size_;
  for (const auto &[blocks, sum] : bytes) traffic.push_back({level, blocks.first, blocks.second, sum});
  return traffic;
}

PetscErrorCode LevelInterface::CoarseToFine()
{
  const Grid &coarse = coarse_->Mesh();
  PetscFunctionBeginUser;
  const auto keep_forces = [&] {
    for (int k = 0; k < owned_; ++k) std::copy_n(coarse_sums_[k].force, 3, previous_force_[k].begin());
  };
  keep_forces();
  PetscCall(PetscSFBcastBegin(transfer_, coarse.SumsUnit(), coarse.Sums(), coarse_sums_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(transfer_, coarse.SumsUnit(), coarse.Sums(), coarse_sums_.data(), MPI_REPLACE));
  if (!has_previous_) keep_forces();
  has_previous_ = true;
  std::fill(mean_.begin(), mean_.end(), 0.0);
  for (SharedNode &node : to_share_) node = {};
  if (!coarse_->ContactAwake()) std::fill(contact_.begin(), contact_.end(), Vec3{});
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::Advance(int substep, double dt)
{
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

/// (m, p, f)_I = sum_i (1 - beta_i) N_I(x_i) (m, p, f)_i, and the other nodal sums in the same way.
PetscErrorCode LevelInterface::Restrict()
{
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  std::fill(sums_.begin(), sums_.end(), NodeSums{});
  for (const BlendNode &node : band_) {
    const NodeSums &from = mesh.Sums()[node.node];
    if (from.mass == 0) continue;
    for (int a = 0; a < node.count; ++a) {
      NodeSums &to = sums_[node.interface[a]];
      const double weight = (1 - node.beta) * node.weight[a];
      to.mass += weight * from.mass;
      to.owned_mass += weight * from.owned_mass;
      for (int axis = 0; axis < 3; ++axis) {
        to.momentum[axis] += weight * from.momentum[axis];
        to.force[axis] += weight * from.force[axis];
      }
    }
  }
  if (!mesh.HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(exchange_, mesh.SumsUnit(), sums_.data(), sums_.data(), MPI_SUM));
  PetscCall(PetscSFReduceEnd(exchange_, mesh.SumsUnit(), sums_.data(), sums_.data(), MPI_SUM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// old = (p^c + p^f)/m, dv = (dt (F_k + f^f) + J/r)/m with m = m^c + m^f, F_k = f^c + (k/r)(f^c - f^c of the step before) and J
/// the impulse that contact on the coarse level had in the last step, and what fine points lack of it; then p^c += m^c dv, as the
/// coarse points will get dv.
void LevelInterface::AdvanceInterface(int substep, double dt)
{
  const double extrapolation = static_cast<double>(substep) / ratio_, cutoff = coarse_->MassCutoff();
  for (int k = 0; k < owned_; ++k) {
    NodeSums &coarse = coarse_sums_[k];
    const NodeSums &fine = sums_[k];
    const NodeVelocity now = VelocityIn(velocity_, k), mean = VelocityIn(mean_, k);
    const double mass = coarse.mass + fine.mass;
    std::fill_n(now.velocity, velocity_size_, 0.0);
    if (mass <= cutoff) continue;
    const bool expects = mass > kLeastExpecting / kEmptyNode * cutoff;
    for (int axis = 0; axis < dim_; ++axis) {
      const double ahead = expects * extrapolation * (coarse.force[axis] - previous_force_[k][axis]);
      const double old = (coarse.momentum[axis] + fine.momentum[axis]) / mass;
      const double contact = expects * (contact_[k][axis] + left_[k][axis]) / ratio_;
      double dv = (dt * (coarse.force[axis] + ahead + fine.force[axis]) + contact) / mass;
      budgets_.stagger_impulse[axis] += dt * ahead + contact;
      if (held_axes_[k] >> axis & 1) {
        budgets_.support_impulse[axis] -= mass * (old + dv);
        dv = -old;
      } else {
        to_share_[k].finer_push[axis] += contact / mass;
        to_share_[k].impulse[axis] += expects * contact_[k][axis] / ratio_;
      }
      coarse.momentum[axis] += coarse.mass * dv;
      now.velocity[axis] = old + dv;
      now.change[axis] = dv;
      mean.velocity[axis] += now.velocity[axis] / ratio_;
      mean.change[axis] += dv;
    }
  }
}

/// (v, dv)_i = (1 - beta_i) sum_I N_I(x_i) (v, dv)_I + beta_i (v, dv)_i
void LevelInterface::Prolong()
{
  for (const BlendNode &node : band_) {
    double *const to = fine_->Mesh().Velocity(node.node).velocity;
    for (int c = 0; c < velocity_size_; ++c) {
      double sum = 0;
      for (int a = 0; a < node.count; ++a)
        sum += node.weight[a] * velocity_[static_cast<std::size_t>(velocity_size_) * node.interface[a] + c];
      to[c] = (1 - node.beta) * sum + node.beta * to[c];
    }
  }
}

PetscErrorCode LevelInterface::ShiftForces(bool from_fine)
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<NodeSums> shift(owned_, NodeSums{});
  PetscFunctionBeginUser;
  if (!from_fine) {
    PetscCall(PetscSFBcastBegin(transfer_, coarse.SumsUnit(), coarse.Sums(), shift.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(transfer_, coarse.SumsUnit(), coarse.Sums(), shift.data(), MPI_REPLACE));
  } else if (fine_->Mesh().Participates()) {
    PetscCall(Restrict());
    std::copy_n(sums_.begin(), shift.size(), shift.begin());
  }
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < dim_; ++axis) coarse_sums_[k].force[axis] += shift[k].force[axis];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::FineToCoarse()
{
  const Grid &coarse = coarse_->Mesh();
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(transfer_, coarse.VelocityUnit(), mean_.data(), coarse.VelocityArray(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(transfer_, coarse.VelocityUnit(), mean_.data(), coarse.VelocityArray(), MPI_REPLACE));
  if (!coarse_->ContactAwake()) PetscFunctionReturn(PETSC_SUCCESS);
  for (int k = 0; k < owned_; ++k) to_share_[k].finer_mass = sums_[k].mass;
  PetscCall(PetscSFReduceBegin(transfer_, shared_unit_, to_share_.data(), shared_.data(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(transfer_, shared_unit_, to_share_.data(), shared_.data(), MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::GatherState(std::vector<double> *state) const
{
  PetscFunctionBeginUser;
  state->clear();
  if (!has_previous_) PetscFunctionReturn(PETSC_SUCCESS);
  state->assign(kState * interface_.size(), 0.0);
  for (int k = 0; k < owned_; ++k) {
    double *const to = &(*state)[kState * static_cast<std::size_t>(local_[k])];
    std::copy_n(coarse_sums_[k].force, 3, to);
    std::copy_n(contact_[k].begin(), 3, to + 3);
    std::copy_n(left_[k].begin(), 3, to + 6);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, state->data(), static_cast<int>(state->size()), MPI_DOUBLE, MPI_SUM, world_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LevelInterface::RestoreState(const std::vector<double> &state)
{
  has_previous_ = !state.empty();
  for (int k = 0; has_previous_ && k < owned_; ++k) {
    const double *const from = &state[kState * static_cast<std::size_t>(local_[k])];
    std::copy_n(from, 3, coarse_sums_[k].force);
    std::copy_n(from + 3, 3, contact_[k].begin());
    std::copy_n(from + 6, 3, left_[k].begin());
  }
}

} // namespace mlgimp
