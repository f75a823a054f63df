// Creation of a level's grid and the exchange of its ghost nodes.
#include "grid/grid.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode Grid::Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout, int volume_averages)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  geometry_ = geometry;
  layout_ = layout;
  velocity_size_ = NodeLayout::Velocity(geometry.dim);
  rates_size_ = NodeLayout::Rates(geometry.dim);
  cell_size_ = volume_averages;
  for (int axis = 0; axis < 3; ++axis) {
    starts_[axis] = {-geometry.Padding(axis)};
    for (PetscInt width : layout.widths[axis]) starts_[axis].push_back(starts_[axis].back() + width);
  }
  PetscCallMPI(MPI_Comm_rank(world, &rank));
  const auto place = std::find(layout.ranks.begin(), layout.ranks.end(), rank);
  const bool participates = place != layout.ranks.end();
  PetscCallMPI(MPI_Comm_split(world, participates ? 0 : MPI_UNDEFINED, static_cast<int>(place - layout.ranks.begin()), &comm_));
  PetscCall(sums_unit_.Create(NodeLayout::kSums));
  PetscCall(velocity_unit_.Create(static_cast<int>(velocity_size_)));
  if (!participates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateNodes());
  PetscCall(CreateHalo());
  PetscCall(CreateSharedNodes());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::CreateNodes()
{
  const auto &widths = layout_.widths;
  PetscInt start[3], size[3];
  PetscFunctionBeginUser;
  PetscCall(DMDACreate(comm_, nodes_.Out()));
  PetscCall(DMSetDimension(nodes_, geometry_.dim));
  PetscCall(DMDASetSizes(nodes_, geometry_.Nodes(0), geometry_.Nodes(1), geometry_.Nodes(2)));
  PetscCall(DMDASetNumProcs(nodes_, static_cast<PetscInt>(widths[0].size()), static_cast<PetscInt>(widths[1].size()),
                            static_cast<PetscInt>(widths[2].size())));
  PetscCall(DMDASetOwnershipRanges(nodes_, widths[0].data(), widths[1].data(), widths[2].data()));
  PetscCall(DMDASetDof(nodes_, NodeLayout::Viewed(geometry_.dim)));
  PetscCall(DMDASetStencilType(nodes_, DMDA_STENCIL_BOX));
  PetscCall(DMDASetStencilWidth(nodes_, kHaloWidth));
  PetscCall(DMSetUp(nodes_));
  const auto to_box = [&](const PetscInt *first, const PetscInt *count) {
    IndexBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = axis < geometry_.dim ? first[axis] - geometry_.padding : 0;
      box.upper[axis] = axis < geometry_.dim ? box.lower[axis] + count[axis] : 1;
    }
    return box;
  };
  PetscCall(DMDAGetCorners(nodes_, &start[0], &start[1], &start[2], &size[0], &size[1], &size[2]));
  owned_ = to_box(start, size);
  PetscCall(DMDAGetGhostCorners(nodes_, &start[0], &start[1], &start[2], &size[0], &size[1], &size[2]));
  ghosted_ = to_box(start, size);
  lattice_.inverse_spacing = 1 / geometry_.spacing;
  for (int axis = 0, stride = 1; axis < 3; stride *= ghosted_.Size(axis++)) {
    lattice_.origin[axis] = geometry_.lower[axis];
    lattice_.first[axis] = ghosted_.lower[axis];
    lattice_.stride[axis] = stride;
  }
  const std::ptrdiff_t components[3] = {NodeLayout::kSums, velocity_size_, rates_size_};
  for (int k = 0; k < 3; ++k) memory_[k].assign((GhostedNodes() * components[k] + 7) / 8, {});
  sums_ = reinterpret_cast<NodeSums *>(memory_[0].data());
  velocity_ = memory_[1].data()->values;
  rates_ = memory_[2].data()->values;
  cell_memory_.resize(cell_size_ * GhostedNodes());
  cells_ = cell_memory_.data();
  PetscFunctionReturn(PETSC_SUCCESS);
}

Grid::~Grid()
{
  PetscFunctionBegin;
  halo_.Reset(), nodes_.Reset();
  if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
  PetscFunctionReturnVoid();
}

void Grid::ClearSums() const { std::fill_n(sums_, GhostedNodes(), NodeSums{}); }

void Grid::ClearRates() const
{
  std::fill_n(reinterpret_cast<CacheLine *>(rates_), memory_[2].size(), CacheLine{});
  std::fill_n(cells_, cell_memory_.size(), CellSums{});
}

/// Roots are owned nodes and leaves ghost nodes, both as places in the ghosted arrays, so that the exchange is in place.
PetscErrorCode Grid::CreateHalo()
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  ForEach(ghosted_, [&](Index node) {
    const int block = BlockOfNode(node);
    if (block == rank) return;
    leaves.push_back(static_cast<PetscInt>(Place(node)));
    roots.push_back({block, PlaceInBlock(block, node)});
  });
  PetscCall(PetscSFCreate(comm_, halo_.Out()));
  PetscCall(PetscSFSetGraph(halo_, static_cast<PetscInt>(GhostedNodes()), static_cast<PetscInt>(leaves.size()), leaves.data(),
                            PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(halo_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::CreateSharedNodes()
{
  std::vector<SharedNodes::Common> with;
  IndexBox near = ghosted_; // with what reaches into it
  PetscFunctionBeginUser;
  for (int axis = 0; axis < geometry_.dim; ++axis) near.lower[axis] -= kHaloWidth, near.upper[axis] += kHaloWidth;
  const PetscMPIInt own = RankIn(comm_);
  for (const int block : BlocksIn(near)) {
    const IndexBox common = Intersection(ghosted_, GhostedOf(block));
    if (block == own || common.Empty()) continue;
    with.push_back({block, {}});
    neighbours_.push_back({block, GhostedOf(block)});
    lower_neighbours_ += block < own;
    ForEach(common, [&](Index node) { with.back().second.push_back(Place(node)); });
  }
  PetscCall(shared_.Create(comm_, std::move(with)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The nodes that the owner of a block has, with its ghosts.
IndexBox Grid::GhostedOf(int block) const
{
  IndexBox nodes;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int> &starts = starts_[axis];
    const int layers = static_cast<int>(starts.size() - 1), layer = block % layers, halo = axis < geometry_.dim ? kHaloWidth : 0;
    block /= layers;
    nodes.lower[axis] = std::max(starts[layer] - halo, starts.front());
    nodes.upper[axis] = std::min(starts[layer + 1] + halo, starts.back());
  }
  return nodes;
}

/// The layer of blocks that a node lies in.
static int LayerOf(const std::vector<int> &starts, int node)
{
  return static_cast<int>(std::upper_bound(starts.begin(), starts.end(), node) - starts.begin()) - 1;
}

int Grid::BlockOfNode(Index node) const
{
  int block = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const std::vector<int> &starts = starts_[axis];
    if (node[axis] < starts.front() || node[axis] >= starts.back()) return -1;
    block = block * static_cast<int>(starts.size() - 1) + LayerOf(starts, node[axis]);
  }
  return block;
}

std::vector<int> Grid::BlocksIn(const IndexBox &box) const
{
  std::vector<int> blocks;
  IndexBox layers;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = starts_[axis].front(), last = starts_[axis].back() - 1;
    layers.lower[axis] = LayerOf(starts_[axis], std::clamp(box.lower[axis], first, last));
    layers.upper[axis] = LayerOf(starts_[axis], std::clamp(box.upper[axis] - 1, first, last)) + 1;
  }
  const int rows = static_cast<int>(starts_[1].size()) - 1, columns = static_cast<int>(starts_[0].size()) - 1;
  ForEach(layers, [&](Index at) { blocks.push_back(at[0] + columns * (at[1] + rows * at[2])); });
  return blocks;
}

PetscMPIInt Grid::OwnerOfNode(Index node) const
{
  const int block = BlockOfNode(node);
  return block < 0 ? -1 : layout_.ranks[block];
}

PetscInt Grid::PlaceInBlock(int block, Index node) const
{
  const IndexBox nodes = GhostedOf(block);
  PetscInt place = 0, stride = 1;
  for (int axis = 0; axis < 3; stride *= nodes.Size(axis++)) place += stride * (node[axis] - nodes.lower[axis]);
  return place;
}

/// So many numbers from `first` on.
static void Choose(int first, int count, std::vector<int> *chosen)
{
  for (int k = 0; k < count; ++k) chosen->push_back(first + k);
}

PetscErrorCode Grid::ShareSums()
{
  NodalField sums = {&sums_->mass, NodeLayout::kSums, {}};
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  Choose(offsetof(NodeSums, mass) / sizeof(double), 2 + geometry_.dim, &sums.chosen); // and owned mass, momentum
  Choose(offsetof(NodeSums, force) / sizeof(double), geometry_.dim, &sums.chosen);
  PetscCall(shared_.Sum({sums}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::ShareRates(bool projection, bool strain_rate)
{
  const int dim = geometry_.dim;
  NodalField rates = {rates_, rates_size_, {}}, cells = {reinterpret_cast<double *>(cells_), 0, {}};
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  Choose(0, dim, &rates.chosen);
  if (projection) Choose(NodeLayout::Projected(dim), dim, &rates.chosen);
  if (strain_rate) Choose(NodeLayout::StrainRate(dim), dim == 2 ? 4 : 6, &rates.chosen);
  cells.size = cell_size_ * static_cast<int>(sizeof(CellSums) / sizeof(double));
  Choose(0, cells.size, &cells.chosen);
  PetscCall(shared_.Sum({rates, cells}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::BroadcastVelocity()
{
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(halo_, velocity_unit_, velocity_, velocity_, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(halo_, velocity_unit_, velocity_, velocity_, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::BroadcastNumbers(double *numbers)
{
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(halo_, MPIU_REAL, numbers, numbers, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(halo_, MPIU_REAL, numbers, numbers, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Names of the components of a node and the place that each node has in space, for viewers that write them.
static PetscErrorCode Describe(DM nodes, const GridGeometry &geometry)
{
  const std::string vectors[] = {"momentum_", "velocity_", "force_"};
  Vec3 lower{}, upper{};
  PetscFunctionBeginUser;
  PetscCall(DMDASetFieldName(nodes, 0, "mass"));
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < geometry.dim; ++axis)
      PetscCall(DMDASetFieldName(nodes, 1 + k * geometry.dim + axis, (vectors[k] + static_cast<char>('x' + axis)).c_str()));
  const IndexBox box = geometry.NodeBox();
  for (int axis = 0; axis < 3; ++axis) {
    lower[axis] = geometry.lower[axis] + geometry.spacing * box.lower[axis];
    upper[axis] = geometry.lower[axis] + geometry.spacing * (box.upper[axis] - 1);
  }
  PetscCall(DMDASetUniformCoordinates(nodes, lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::View(const std::string &prefix, double mass_cutoff) const
{
  VecHandle values;
  PetscScalar *array = nullptr;
  PetscBool on = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectSetName(nodes_.Object(), (prefix + "grid").c_str()));
  PetscCall(DMSetOptionsPrefix(nodes_, prefix.c_str()));
  PetscCall(DMViewFromOptions(nodes_, nullptr, "-dm_view"));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &on));
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Describe(nodes_, geometry_));
  PetscCall(DMCreateGlobalVector(nodes_, values.Out()));
  PetscCall(VecGetArrayWrite(values, &array));
  PetscScalar *value = array;
  ForEach(owned_, [&](Index node) {
    const NodeSums &sums = sums_[Place(node)];
    const double per_mass = sums.mass > mass_cutoff ? 1 / sums.mass : 0;
    *value++ = sums.mass;
    for (int axis = 0; axis < geometry_.dim; ++axis) {
      value[axis] = sums.momentum[axis];
      value[geometry_.dim + axis] = sums.momentum[axis] * per_mass;
      value[2 * geometry_.dim + axis] = sums.force[axis];
    }
    value += 3 * geometry_.dim;
  });
  PetscCall(VecRestoreArrayWrite(values, &array));
  PetscCall(PetscObjectSetName(values.Object(), (prefix + "nodes").c_str()));
  PetscCall(VecSetOptionsPrefix(values, prefix.c_str()));
  PetscCall(VecViewFromOptions(values, nullptr, "-nodes_view"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
