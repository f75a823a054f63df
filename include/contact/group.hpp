// The ranks of a level that contact concerns, which alone meet in its collective calls.
#pragma once

#include "grid/node_partition.hpp"

#include <climits>
#include <vector>

namespace mlgimp
{

/// A zone of which nothing is known.
inline constexpr IndexBox kAllNodes = {{INT_MIN, INT_MIN, INT_MIN}, {INT_MAX, INT_MAX, INT_MAX}};

/// The owners of the nodes that the surface near the indenter touches, ordered by their blocks.
class ContactGroup
{
public:
  ContactGroup() = default;
  ContactGroup(const ContactGroup &) = delete;
  ContactGroup &operator=(const ContactGroup &) = delete;
  ~ContactGroup();

  /// Those of a zone of nodes, which is the same on all ranks. To be called by all that know the grid; collective on the ranks
  /// of the new group.
  PetscErrorCode Create(const NodePartition &nodes, const IndexBox &zone);

  MPI_Comm Comm() const { return comm_; } ///< null on ranks that are not in the group
  bool Participates() const { return comm_ != MPI_COMM_NULL; }
  const IndexBox &Zone() const { return zone_; }
  /// The blocks of the grid that they hold, on all ranks.
  const std::vector<int> &Blocks() const { return blocks_; }
  /// The number of these ranks, and the first of them, among all.
  int Size() const { return static_cast<int>(blocks_.size()); }
  PetscMPIInt Root() const { return root_; }
  /// Another zone, in the same blocks as long as there is no new group.
  void SetZone(const IndexBox &zone) { zone_ = zone; }
  /// The rank in Comm() that holds a block; -1 for none.
  PetscMPIInt RankOf(int block) const;

private:
  PetscErrorCode Free();

  MPI_Comm comm_ = MPI_COMM_NULL, inner_ = MPI_COMM_NULL; ///< inner: PETSc's own beside it, which it would make anew in each use
  IndexBox zone_ = kAllNodes;
  std::vector<int> blocks_;
  PetscMPIInt root_ = 0;
};

} // namespace mlgimp
