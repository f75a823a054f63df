// Lists of interface and band nodes, and the coupled step.
#include "hierarchy/level_interface.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <map>

namespace mlgimp
{

static constexpr double kOuterBeta = 0.3; ///< beta just inside the box

static int FloorDivide(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

PetscErrorCode LevelInterface::Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, double blend_width)
{
  PetscFunctionBeginUser;
  world_ = world;
  coarse_ = &coarse;
  fine_ = &fine;
  ratio_ = ratio;
  blend_width_ = blend_width;
  ListInterface();
  PetscCall(ListBand());
  if (fine.Mesh().Participates()) PetscCall(CreateExchange());
  PetscCall(CreateTransfer());
  const int known = static_cast<int>(local_.size());
  coarse_sums_.assign(NodeArrays::kSums * static_cast<std::size_t>(owned_), 0.0);
  previous_force_.assign(2 * static_cast<std::size_t>(owned_), 0.0);
  mean_.assign(NodeArrays::kVelocity * static_cast<std::size_t>(owned_), 0.0);
  sums_.assign(NodeArrays::kSums * static_cast<std::size_t>(known), 0.0);
  velocity_.assign(NodeArrays::kVelocity * static_cast<std::size_t>(known), 0.0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Depth of a fine node inside the box, in fine cells; sides of the domain do not count.
double LevelInterface::Depth(int i, int j) const
{
  const LevelGeometry &geometry = fine_->Geometry();
  const int node[2] = {i, j};
  int depth = INT_MAX;
  for (int s = 0; s < kSides; ++s) {
    const int axis = s / 2;
    if (geometry.border[s]) depth = std::min(depth, s % 2 ? geometry.grid.cells[axis] - node[axis] : node[axis]);
  }
  return depth;
}

double LevelInterface::Beta(int i, int j) const
{
  const double depth = Depth(i, j), width = blend_width_ * ratio_;
  return depth <= 0 ? 0 : depth >= width ? 1 : kOuterBeta + (1 - kOuterBeta) * depth / width;
}

/// True for nodes that can bear mass: beyond a side of the domain that is the first layer only.
bool LevelInterface::InFineGrid(int i, int j) const
{
  const LevelGeometry &geometry = fine_->Geometry();
  const int node[2] = {i, j};
  for (int axis = 0; axis < 2; ++axis) {
    const int below = geometry.border[2 * axis] ? geometry.grid.padding : 1;
    const int above = geometry.border[2 * axis + 1] ? geometry.grid.padding : 1;
    if (node[axis] < -below || node[axis] > geometry.grid.cells[axis] + above) return false;
  }
  return true;
}

/// Indices of the fine box's lower corner on the coarse grid.
static std::array<int, 2> Offset(const Level &coarse, const Level &fine)
{
  const GridGeometry &c = coarse.Geometry().grid, &f = fine.Geometry().grid;
  return {static_cast<int>(std::lround((f.lower[0] - c.lower[0]) / c.spacing)),
          static_cast<int>(std::lround((f.lower[1] - c.lower[1]) / c.spacing))};
}

/// True where some fine node with beta < 1 lies within the hat of the coarse node (i, j).
bool LevelInterface::IsInterface(int i, int j) const
{
  const auto [oi, oj] = Offset(*coarse_, *fine_);
  const int centre[2] = {(i - oi) * ratio_, (j - oj) * ratio_};
  for (int b = 1 - ratio_; b < ratio_; ++b)
    for (int a = 1 - ratio_; a < ratio_; ++a)
      if (InFineGrid(centre[0] + a, centre[1] + b) && Beta(centre[0] + a, centre[1] + b) < 1) return true;
  return false;
}

void LevelInterface::ListInterface()
{
  const GridGeometry &f = fine_->Geometry().grid, &c = coarse_->Geometry().grid;
  const Grid &mesh = fine_->Mesh();
  const auto [oi, oj] = Offset(*coarse_, *fine_);
  std::vector<int> places(mesh.Layout().Blocks(), 0);
  interface_.clear();
  const int reach = (f.padding + ratio_ - 1) / ratio_;
  for (int j = oj - reach; j <= oj + f.cells[1] / ratio_ + reach; ++j)
    for (int i = oi - reach; i <= oi + f.cells[0] / ratio_ + reach; ++i) {
      const bool on_grid = i >= -c.padding && i <= c.cells[0] + c.padding && j >= -c.padding && j <= c.cells[1] + c.padding;
      if (!on_grid || !IsInterface(i, j)) continue;
      const int at[2] = {std::clamp((i - oi) * ratio_, -f.padding, f.cells[0] + f.padding),
                         std::clamp((j - oj) * ratio_, -f.padding, f.cells[1] + f.padding)};
      const int block = mesh.BlockOfNode(at[0], at[1]);
      interface_.push_back({i, j, block, places[block]++});
    }
}

PetscErrorCode LevelInterface::ListBand()
{
  const Grid &mesh = fine_->Mesh(), &coarse = coarse_->Mesh();
  const auto [oi, oj] = Offset(*coarse_, *fine_);
  std::map<std::pair<int, int>, int> number, place; // of interface nodes: among all, among those known here
  PetscMPIInt block = -1;
  PetscFunctionBeginUser;
  local_.clear(), band_.clear(), held_axes_.clear(), fine_nodes_.clear(), coarse_nodes_.clear();
  if (mesh.Participates()) PetscCallMPI(MPI_Comm_rank(mesh.Comm(), &block));
  for (int k = 0; k < static_cast<int>(interface_.size()); ++k) {
    const InterfaceNode &node = interface_[k];
    number[{node.i, node.j}] = k;
    if (coarse.Participates() && node.i >= coarse.OwnedLower(0) && node.i < coarse.OwnedUpper(0) &&
        node.j >= coarse.OwnedLower(1) && node.j < coarse.OwnedUpper(1))
      coarse_nodes_.push_back({coarse.Index(node.i, node.j), true});
    if (node.block != block) continue;
    place[{node.i, node.j}] = static_cast<int>(local_.size());
    local_.push_back(k);
    held_axes_.push_back(0);
    for (int axis = 0; axis < 2; ++axis)
      if (coarse_->Geometry().sides.Constrains(node.i, node.j, axis)) held_axes_.back() |= 1 << axis;
  }
  owned_ = static_cast<int>(local_.size());
  if (!mesh.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  for (int j = mesh.OwnedLower(1); j < mesh.OwnedUpper(1); ++j)
    for (int i = mesh.OwnedLower(0); i < mesh.OwnedUpper(0); ++i) {
      if (!InFineGrid(i, j) || Beta(i, j) >= 1) continue;
      BlendNode node{mesh.Index(i, j), Beta(i, j), 0, {}, {}};
      const int I = FloorDivide(i, ratio_), J = FloorDivide(j, ratio_);
      for (int b = 0; b < 2; ++b)
        for (int a = 0; a < 2; ++a) {
          const double x = static_cast<double>(i - I * ratio_) / ratio_, y = static_cast<double>(j - J * ratio_) / ratio_;
          const double weight = (a ? x : 1 - x) * (b ? y : 1 - y);
          const auto found = number.find({I + a + oi, J + b + oj});
          if (weight == 0 || found == number.end()) continue;
          const auto [at, is_new] = place.insert({found->first, static_cast<int>(local_.size())});
          if (is_new) local_.push_back(found->second);
          node.interface[node.count] = at->second;
          node.weight[node.count++] = weight;
        }
      fine_nodes_.push_back({node.node, node.beta == 0});
      band_.push_back(node);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
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
    const int block = coarse.BlockOfNode(node.i, node.j);
    roots.push_back({coarse.Layout().ranks[block], coarse.IndexInBlock(block, node.i, node.j)});
  }
  const PetscInt places = coarse.Participates() ? coarse.GhostedNodes() : 0;
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
    bytes[{coarse_->Mesh().BlockOfNode(node.i, node.j), node.block}] +=
        sizeof(double) * (NodeArrays::kSums + NodeArrays::kVelocity);
  for (const auto &[blocks, sum] : bytes) traffic.push_back({level, blocks.first, blocks.second, sum});
  return traffic;
}

PetscErrorCode LevelInterface::CoarseToFine()
{
  const Grid &coarse = coarse_->Mesh();
  const MPI_Datatype unit = coarse.Unit(NodeArrays::kSums);
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < 2; ++axis) previous_force_[2 * k + axis] = coarse_sums_[NodeArrays::kSums * k + 4 + axis];
  PetscCall(PetscSFBcastBegin(transfer_, unit, coarse.Arrays().sums, coarse_sums_.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(transfer_, unit, coarse.Arrays().sums, coarse_sums_.data(), MPI_REPLACE));
  if (!has_previous_)
    for (int k = 0; k < owned_; ++k)
      for (int axis = 0; axis < 2; ++axis) previous_force_[2 * k + axis] = coarse_sums_[NodeArrays::kSums * k + 4 + axis];
  has_previous_ = true;
  std::fill(mean_.begin(), mean_.end(), 0.0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::Advance(int substep, double dt)
{
  const Grid &mesh = fine_->Mesh();
  PetscFunctionBeginUser;
  if (!mesh.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  const MPI_Datatype unit = mesh.Unit(NodeArrays::kVelocity);
  PetscCall(Restrict());
  AdvanceInterface(substep, dt);
  if (mesh.HasGhosts()) {
    PetscCall(PetscSFBcastBegin(exchange_, unit, velocity_.data(), velocity_.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(exchange_, unit, velocity_.data(), velocity_.data(), MPI_REPLACE));
  }
  Prolong();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// (m, p, f)_I = sum_i (1 - beta_i) N_I(x_i) (m, p, f)_i, and the other nodal sums in the same way.
PetscErrorCode LevelInterface::Restrict()
{
  const Grid &mesh = fine_->Mesh();
  const MPI_Datatype unit = mesh.Unit(NodeArrays::kSums);
  const double *fine = mesh.Arrays().sums;
  PetscFunctionBeginUser;
  std::fill(sums_.begin(), sums_.end(), 0.0);
  for (const BlendNode &band : band_) {
    const double *from = fine + NodeArrays::kSums * static_cast<std::ptrdiff_t>(band.node);
    if (from[0] == 0) continue;
    for (int a = 0; a < band.count; ++a) {
      double *to = &sums_[NodeArrays::kSums * static_cast<std::size_t>(band.interface[a])];
      const double weight = (1 - band.beta) * band.weight[a];
      for (int c = 0; c < NodeArrays::kSums; ++c) to[c] += weight * from[c];
    }
  }
  if (!mesh.HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(exchange_, unit, sums_.data(), sums_.data(), MPI_SUM));
  PetscCall(PetscSFReduceEnd(exchange_, unit, sums_.data(), sums_.data(), MPI_SUM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// old = (p^c + p^f)/m, dv = dt (F_k + f^f)/m with m = m^c + m^f and F_k = f^c + (k/r)(f^c - f^c of the step before);
/// then p^c += m^c dv, as the coarse points will get dv.
void LevelInterface::AdvanceInterface(int substep, double dt)
{
  const double extrapolation = static_cast<double>(substep) / ratio_, cutoff = coarse_->MassCutoff();
  for (int k = 0; k < owned_; ++k) {
    double *coarse = &coarse_sums_[NodeArrays::kSums * static_cast<std::size_t>(k)];
    double *velocity = &velocity_[NodeArrays::kVelocity * static_cast<std::size_t>(k)];
    double *mean = &mean_[NodeArrays::kVelocity * static_cast<std::size_t>(k)];
    const double *fine = &sums_[NodeArrays::kSums * static_cast<std::size_t>(k)];
    const double mass = coarse[0] + fine[0];
    std::fill_n(velocity, NodeArrays::kVelocity, 0.0);
    if (mass <= cutoff) continue;
    for (int axis = 0; axis < 2; ++axis) {
      const double change = extrapolation * (coarse[4 + axis] - previous_force_[2 * k + axis]);
      const double old = (coarse[1 + axis] + fine[1 + axis]) / mass;
      double dv = dt * (coarse[4 + axis] + change + fine[4 + axis]) / mass;
      totals_.stagger_impulse[axis] += dt * change;
      if (held_axes_[k] >> axis & 1) {
        totals_.support_impulse[axis] -= mass * (old + dv);
        dv = -old;
      }
      coarse[1 + axis] += coarse[0] * dv;
      velocity[axis] = old + dv;
      velocity[2 + axis] = dv;
      mean[axis] += velocity[axis] / ratio_;
      mean[2 + axis] += dv;
    }
  }
}

/// sum_I N_I(x_i) (v, dv)_I
std::array<double, NodeArrays::kVelocity> LevelInterface::Interpolate(const BlendNode &band) const
{
  std::array<double, NodeArrays::kVelocity> sum{};
  for (int a = 0; a < band.count; ++a) {
    const double *from = &velocity_[NodeArrays::kVelocity * static_cast<std::size_t>(band.interface[a])];
    for (int c = 0; c < NodeArrays::kVelocity; ++c) sum[c] += band.weight[a] * from[c];
  }
  return sum;
}

/// (v, dv)_i = (1 - beta_i) sum_I N_I(x_i) (v, dv)_I + beta_i (v, dv)_i
void LevelInterface::Prolong()
{
  double *fine = fine_->Mesh().Arrays().velocity;
  for (const BlendNode &band : band_) {
    double *to = fine + NodeArrays::kVelocity * static_cast<std::ptrdiff_t>(band.node);
    const std::array<double, NodeArrays::kVelocity> sum = Interpolate(band);
    for (int c = 0; c < NodeArrays::kVelocity; ++c) to[c] = (1 - band.beta) * sum[c] + band.beta * to[c];
  }
}

PetscErrorCode LevelInterface::ShiftForces(bool from_fine)
{
  const Grid &coarse = coarse_->Mesh();
  const MPI_Datatype unit = coarse.Unit(NodeArrays::kSums);
  std::vector<double> shift(coarse_sums_.size(), 0.0);
  PetscFunctionBeginUser;
  if (!from_fine) {
    PetscCall(PetscSFBcastBegin(transfer_, unit, coarse.Arrays().sums, shift.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(transfer_, unit, coarse.Arrays().sums, shift.data(), MPI_REPLACE));
  } else if (fine_->Mesh().Participates()) {
    PetscCall(Restrict());
    std::copy_n(sums_.begin(), shift.size(), shift.begin());
  }
  for (std::size_t k = 0; k < shift.size(); k += NodeArrays::kSums)
    for (int axis = 0; axis < 2; ++axis) coarse_sums_[k + 4 + axis] += shift[k + 4 + axis];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::FineToCoarse()
{
  const Grid &coarse = coarse_->Mesh();
  const MPI_Datatype unit = coarse.Unit(NodeArrays::kVelocity);
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(transfer_, unit, mean_.data(), coarse.Arrays().velocity, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(transfer_, unit, mean_.data(), coarse.Arrays().velocity, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::GatherState(std::vector<double> *state) const
{
  PetscFunctionBeginUser;
  state->clear();
  if (!has_previous_) PetscFunctionReturn(PETSC_SUCCESS);
  state->assign(kState * interface_.size(), 0.0);
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < 2; ++axis) {
      double *node = &(*state)[kState * static_cast<std::size_t>(local_[k])];
      node[axis] = coarse_sums_[NodeArrays::kSums * static_cast<std::size_t>(k) + 4 + axis];
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, state->data(), static_cast<int>(state->size()), MPI_DOUBLE, MPI_SUM, world_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LevelInterface::RestoreState(const std::vector<double> &state)
{
  has_previous_ = !state.empty();
  if (!has_previous_) return;
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < 2; ++axis)
      coarse_sums_[NodeArrays::kSums * static_cast<std::size_t>(k) + 4 + axis] =
          state[kState * static_cast<std::size_t>(local_[k]) + axis];
}

} // namespace mlgimp
