// Creation of a level's grid and the exchange of its ghost nodes.
#include "level/grid.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode Grid::Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  geometry_ = geometry;
  layout_ = layout;
  for (int d = 0; d < 2; ++d) {
    starts_[d] = {-geometry.padding};
    for (PetscInt width : layout.widths[d]) starts_[d].push_back(starts_[d].back() + width);
  }
  PetscCallMPI(MPI_Comm_rank(world, &rank));
  const auto place = std::find(layout.ranks.begin(), layout.ranks.end(), rank);
  const bool participates = place != layout.ranks.end();
  PetscCallMPI(MPI_Comm_split(world, participates ? 0 : MPI_UNDEFINED, static_cast<int>(place - layout.ranks.begin()), &comm_));
  if (participates) {
    PetscCall(CreateArrays());
    PetscCall(CreateHalo());
  }
  PetscCallMPI(MPI_Type_contiguous(8, MPIU_SCALAR, &unit8_));
  PetscCallMPI(MPI_Type_contiguous(4, MPIU_SCALAR, &unit4_));
  PetscCallMPI(MPI_Type_commit(&unit8_));
  PetscCallMPI(MPI_Type_commit(&unit4_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::CreateArrays()
{
  const PetscInt m = static_cast<PetscInt>(layout_.widths[0].size()), n = static_cast<PetscInt>(layout_.widths[1].size());
  PetscInt xs, ys, xm, ym;
  PetscFunctionBeginUser;
  PetscCall(DMDACreate2d(comm_, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX, geometry_.Nodes(0), geometry_.Nodes(1), m,
                         n, NodeArrays::kSums, kHaloWidth, layout_.widths[0].data(), layout_.widths[1].data(), nodes8_.Out()));
  PetscCall(DMSetUp(nodes8_));
  PetscCall(DMDACreateCompatibleDMDA(nodes8_, NodeArrays::kVelocity, nodes4_.Out()));

  PetscCall(DMDAGetCorners(nodes8_, &xs, &ys, nullptr, &xm, &ym, nullptr));
  const PetscInt owned_start[2] = {xs, ys}, owned_size[2] = {xm, ym};
  PetscCall(DMDAGetGhostCorners(nodes8_, &xs, &ys, nullptr, &xm, &ym, nullptr));
  const PetscInt ghost_start[2] = {xs, ys}, ghost_size[2] = {xm, ym};
  for (int d = 0; d < 2; ++d) {
    owned_lower_[d] = owned_start[d] - geometry_.padding;
    owned_upper_[d] = owned_lower_[d] + owned_size[d];
    ghost_lower_[d] = ghost_start[d] - geometry_.padding;
    ghost_size_[d] = ghost_size[d];
    lattice_.origin[d] = geometry_.lower[d];
    lattice_.first[d] = ghost_lower_[d];
  }
  lattice_.inverse_spacing = 1 / geometry_.spacing;
  lattice_.stride[0] = 1;
  lattice_.stride[1] = ghost_size_[0];
  PetscCall(CreateField(nodes8_, NodeArrays::kSums, &sums_, &arrays_.sums));
  PetscCall(CreateField(nodes8_, NodeArrays::kRates, &rates_, &arrays_.rates));
  PetscCall(CreateField(nodes4_, NodeArrays::kVelocity, &velocity_, &arrays_.velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A local vector of a DMDA as DMCreateLocalVector makes it, but on whole cache lines.
PetscErrorCode Grid::CreateField(DM nodes, int components, NodalField *field, double **array)
{
  const std::size_t size = static_cast<std::size_t>(GhostedNodes()) * components;
  PetscFunctionBeginUser;
  field->memory.assign((size + 7) / 8, {});
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, components, static_cast<PetscInt>(size), field->memory.data()->values,
                                  field->vector.Out()));
  PetscCall(VecSetDM(field->vector, nodes));
  PetscCall(VecGetArray(field->vector, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

Grid::~Grid()
{
  PetscFunctionBegin;
  if (sums_.vector) PetscCallVoid(VecRestoreArray(sums_.vector, &arrays_.sums));
  if (rates_.vector) PetscCallVoid(VecRestoreArray(rates_.vector, &arrays_.rates));
  if (velocity_.vector) PetscCallVoid(VecRestoreArray(velocity_.vector, &arrays_.velocity));
  for (MPI_Datatype *unit : {&unit4_, &unit8_})
    if (*unit != MPI_DATATYPE_NULL) MPI_Type_free(unit);
  halo_.Reset(), sums_.vector.Reset(), rates_.vector.Reset(), velocity_.vector.Reset(), nodes4_.Reset(), nodes8_.Reset();
  if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
  PetscFunctionReturnVoid();
}

/// Roots are owned nodes and leaves ghost nodes, both as places in the ghosted arrays, so that the exchange is in place.
PetscErrorCode Grid::CreateHalo()
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  for (int j = ghost_lower_[1]; j < ghost_lower_[1] + ghost_size_[1]; ++j)
    for (int i = ghost_lower_[0]; i < ghost_lower_[0] + ghost_size_[0]; ++i) {
      const int block = BlockOfNode(i, j);
      if (block == rank) continue;
      leaves.push_back(Index(i, j));
      roots.push_back({block, IndexInBlock(block, i, j)});
    }
  PetscCall(PetscSFCreate(comm_, halo_.Out()));
  PetscCall(PetscSFSetGraph(halo_, GhostedNodes(), static_cast<PetscInt>(leaves.size()), leaves.data(), PETSC_COPY_VALUES,
                            roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(halo_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int Grid::BlockOfNode(int i, int j) const
{
  const int node[2] = {i, j};
  int block[2];
  for (int d = 0; d < 2; ++d) {
    if (node[d] < starts_[d].front() || node[d] >= starts_[d].back()) return -1;
    block[d] = static_cast<int>(std::upper_bound(starts_[d].begin(), starts_[d].end(), node[d]) - starts_[d].begin()) - 1;
  }
  return block[1] * static_cast<int>(starts_[0].size() - 1) + block[0];
}

PetscMPIInt Grid::OwnerOfNode(int i, int j) const
{
  const int block = BlockOfNode(i, j);
  return block < 0 ? -1 : layout_.ranks[block];
}

int Grid::IndexInBlock(int block, int i, int j) const
{
  const int columns = static_cast<int>(starts_[0].size() - 1), place[2] = {block % columns, block / columns};
  int lower[2], width = 0;
  for (int d = 0; d < 2; ++d) {
    lower[d] = std::max(starts_[d][place[d]] - kHaloWidth, starts_[d].front());
    if (d == 0) width = std::min(starts_[d][place[d] + 1] + kHaloWidth, starts_[d].back()) - lower[d];
  }
  return (j - lower[1]) * width + i - lower[0];
}

PetscErrorCode Grid::ReduceToOwners(double *array)
{
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(halo_, unit8_, array, array, MPI_SUM));
  PetscCall(PetscSFReduceEnd(halo_, unit8_, array, array, MPI_SUM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::Broadcast(double *array, int components)
{
  PetscFunctionBeginUser;
  if (!HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(halo_, Unit(components), array, array, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(halo_, Unit(components), array, array, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<PetscInt> DivideByWeight(const std::vector<double> &weights, int parts, int minimum)
{
  const int count = static_cast<int>(weights.size());
  double total = 0, sum = 0;
  for (double w : weights) total += w;
  std::vector<PetscInt> widths;
  int start = 0, end = 0;
  for (int part = 1; part <= parts; ++part) {
    const int last = count - (parts - part) * minimum; // leaves room for the parts to come
    while (end < last && (end < start + minimum || sum + 0.5 * weights[end] < total * part / parts)) sum += weights[end++];
    if (part == parts) end = count;
    widths.push_back(end - start);
    start = end;
  }
  return widths;
}

} // namespace mlgimp
