// Which interface nodes are light, and what they hang on, on every rank that knows them.
#include "hierarchy/coupling/light_interface.hpp"

#include "base/exchange.hpp"
#include "base/pack.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace mlgimp
{

/// to += part times mass, momentum and force of `from`.
static void AddSums(double part, const NodeSums &from, NodeSums *to)
{
  to->mass += part * from.mass;
  for (int axis = 0; axis < 3; ++axis)
    to->momentum[axis] += part * from.momentum[axis], to->force[axis] += part * from.force[axis];
}

PetscErrorCode LightInterface::Create(MPI_Comm world, const InterfaceNodes &nodes, const NodePartition &coarse)
{
  struct Reader {
    Index at;
    PetscMPIInt to, from;
  };
  const std::vector<std::ptrdiff_t> &owned = nodes.Coupled().coarse;
  std::vector<Reader> list;
  std::map<std::ptrdiff_t, std::size_t> number;
  PetscFunctionBeginUser;
  world_ = world;
  nodes_ = &nodes;
  coarse_ = &coarse;
  own_.assign(nodes.Known(), 1.0);
  first_.assign(nodes.Known() + 1, 0);
  for (int k = 0; k < nodes.Known(); ++k) list.push_back({nodes.At(k), coarse.OwnerOf(nodes.At(k)), RankIn(world)});
  PetscCall(ExchangeRecords(world, &list, [](const Reader &one) { return one.to; }));
  readers_.assign(owned.size(), {});
  for (std::size_t k = 0; k < owned.size(); ++k) number[owned[k]] = k;
  for (const Reader &one : list) readers_[number.at(coarse.Place(one.at))].push_back(one.from);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LightInterface::Update(const LightNodes &light)
{
  struct Link {
    Index node, on;
    double weight;
    PetscMPIInt to;
  };
  std::vector<Link> list;
  std::vector<std::pair<int, Donor>> found;
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < readers_.size(); ++k) {
    const std::ptrdiff_t place = nodes_->Coupled().coarse[k];
    if (!light.IsLight(place)) continue;
    light.ForEachDonor(place, [&](std::ptrdiff_t on, double weight) {
      for (const PetscMPIInt reader : readers_[k])
        list.push_back({coarse_->Ghosted().At(place), coarse_->Ghosted().At(on), weight, reader});
    });
  }
  PetscCall(ExchangeRecords(world_, &list, [](const Link &one) { return one.to; }));
  std::fill(own_.begin(), own_.end(), 1.0);
  if (list.empty() && donors_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Link &one : list) {
    const int k = nodes_->Find(one.node), on = nodes_->Find(one.on);
    if (one.node == one.on)
      own_[k] = one.weight;
    else if (on >= 0) // what only copies in the ring hang on is of no interest
      found.push_back({k, {on, one.weight}});
  }
  std::fill(first_.begin(), first_.end(), 0);
  for (const auto &[k, donor] : found) ++first_[k + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  donors_.resize(found.size());
  std::vector<int> next = first_;
  for (const auto &[k, donor] : found) donors_[next[k]++] = donor;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LightInterface::Restrict(std::vector<NodeSums> *sums) const
{
  ForEachLight([&](int k) {
    const NodeSums from = (*sums)[k];
    (*sums)[k] = {0, from.owned_mass, {}, {}};
    ForEachDonor(k, [&](int on, double weight) { AddSums(weight, from, &(*sums)[on]); });
  });
}

void LightInterface::Prolong(int components, std::vector<double> *motion) const
{
  const auto motion_of = [&](int k) { return motion->data() + static_cast<std::ptrdiff_t>(components) * k; };
  ForEachLight([&](int k) {
    double *const to = motion_of(k);
    for (int c = 0; c < components; ++c) to[c] *= own_[k];
    for (int d = first_[k]; d < first_[k + 1]; ++d) AddTimes(donors_[d].weight, motion_of(donors_[d].on), to, components);
  });
}

} // namespace mlgimp
