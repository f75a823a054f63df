// Interface nodes with little mass, which hang on fuller ones as the coarse level's light nodes do; see light_nodes.hpp.
#pragma once

#include "grid/light_nodes.hpp"
#include "hierarchy/coupling/interface_nodes.hpp"

#include <vector>

namespace mlgimp
{

class LightInterface
{
public:
  /// Both are kept by reference. Collective on `world`.
  PetscErrorCode Create(MPI_Comm world, const InterfaceNodes &nodes, const NodePartition &coarse);
  /// Takes over what the coarse level's nodes hang on in its step. Collective on `world`.
  PetscErrorCode Update(const LightNodes &light);

  /// Calls work(k, weight) for the known nodes that the motion of one of them hangs on, itself among them.
  template <class Work> void ForEachDonor(int k, Work work) const
  {
    if (own_[k] != 0) work(k, own_[k]);
    for (int d = first_[k]; d < first_[k + 1]; ++d) work(donors_[d].on, donors_[d].weight);
  }
  /// From the sums of known nodes to those of their motion: light ones give what hangs on others to these; owned_mass is left.
  void Restrict(std::vector<NodeSums> *sums) const;
  /// Gives light nodes the motion of those that they hang on, [known][components].
  void Prolong(int components, std::vector<double> *motion) const;

private:
  /// A node that a light one hangs on.
  struct Donor {
    int on; ///< among the known
    double weight;
  };

  /// Calls work(k) for the known nodes whose motion is not all their own.
  template <class Work> void ForEachLight(Work work) const
  {
    for (std::size_t k = 0; k < own_.size(); ++k)
      if (own_[k] != 1) work(static_cast<int>(k));
  }

  MPI_Comm world_ = MPI_COMM_NULL;
  const InterfaceNodes *nodes_ = nullptr;
  const NodePartition *coarse_ = nullptr;
  std::vector<std::vector<PetscMPIInt>> readers_; ///< of the coarse level's owned interface nodes: the ranks that know them
  std::vector<double> own_;                       ///< [known]: the part of a node's motion that does not hang on others
  std::vector<int> first_;                        ///< [known + 1] of its donors
  std::vector<Donor> donors_;
};

} // namespace mlgimp
