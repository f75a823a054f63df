// A communicator of the blocks near the indenter.
#include "contact/group.hpp"

#include <algorithm>

namespace mlgimp
{

ContactGroup::~ContactGroup()
{
  PetscFunctionBegin;
  PetscCallVoid(Free());
  PetscFunctionReturnVoid();
}

PetscErrorCode ContactGroup::Free()
{
  PetscFunctionBeginUser;
  if (comm_ == MPI_COMM_NULL) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCommDestroy(&inner_));
  PetscCallMPI(MPI_Comm_free(&comm_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactGroup::Create(const NodePartition &nodes, const IndexBox &zone)
{
  MPI_Group all, members;
  PetscFunctionBeginUser;
  PetscCall(Free());
  zone_ = zone;
  blocks_ = nodes.BlocksIn(zone);
  root_ = blocks_.empty() ? 0 : nodes.Layout().ranks[blocks_[0]];
  if (!nodes.Participates() || RankOf(RankIn(nodes.Comm())) < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_group(nodes.Comm(), &all));
  PetscCallMPI(MPI_Group_incl(all, static_cast<int>(blocks_.size()), blocks_.data(), &members));
  PetscCallMPI(MPI_Comm_create_group(nodes.Comm(), members, 0, &comm_));
  PetscCall(PetscCommDuplicate(comm_, &inner_, nullptr));
  PetscCallMPI(MPI_Group_free(&members));
  PetscCallMPI(MPI_Group_free(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscMPIInt ContactGroup::RankOf(int block) const
{
  const auto place = std::lower_bound(blocks_.begin(), blocks_.end(), block);
  return place != blocks_.end() && *place == block ? static_cast<PetscMPIInt>(place - blocks_.begin()) : -1;
}

} // namespace mlgimp
