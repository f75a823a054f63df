// Lists of the nodes that couple two levels: each rank lists those near its own.
#include "hierarchy/coupling/interface_nodes.hpp"

#include "base/exchange.hpp"
#include "grid/light_nodes.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace mlgimp
{

PetscErrorCode InterfaceNodes::Create(MPI_Comm world, const BorderGeometry &border, const NodePartition &coarse,
                                      const BoundaryConditions &coarse_sides, const NodePartition &fine)
{
  PetscFunctionBeginUser;
  world_ = world;
  border_ = &border;
  coarse_ = &coarse;
  fine_ = &fine;
  ListOwned();
  ListBand();
  ListBesideLight();
  ListHeldAxes(coarse_sides);
  if (fine.Participates()) PetscCall(CreateCopies());
  PetscCall(CreateTransfer());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The interface nodes that this rank owns on the coarse level, and those that it advances.
void InterfaceNodes::ListOwned()
{
  if (coarse_->Participates())
    border_->ForEachInterface(coarse_->Ghosted(), [&](Index node) {
      coupled_.held_coarse.push_back(coarse_->Place(node));
      if (coarse_->Owned().Contains(node)) coupled_.coarse.push_back(coupled_.held_coarse.back());
    });
  if (fine_->Participates()) {
    const PetscMPIInt block = RankIn(fine_->Comm());
    const Index offset = border_->Offset();
    const int ratio = border_->Ratio(), padding = fine_->Geometry().padding;
    IndexBox near = fine_->Owned(); // with those beyond the fine grid, to whose edge they belong
    for (int axis = 0; axis < border_->Dim(); ++axis) {
      near.lower[axis] = offset[axis] + (fine_->Owned().lower[axis] - padding) / ratio - 1;
      near.upper[axis] = offset[axis] + (fine_->Owned().upper[axis] + padding) / ratio + 2;
    }
    border_->ForEachInterface(near, [&](Index node) {
      if (BlockOf(node) != block) return;
      const int k = Know(node);
      known_[k].place = k;
    });
  }
  owned_ = Known();
}

/// The number of an interface node, which becomes known.
int InterfaceNodes::Know(Index at)
{
  const auto [found, is_new] = place_.insert({at, Known()});
  if (is_new) known_.push_back({at, BlockOf(at), -1});
  return found->second;
}

void InterfaceNodes::ListBand()
{
  CoupledPlaces &places = coupled_.fine_places;
  places.reach = (2 + border_->Ratio()) * fine_->Geometry().spacing; // the nodes of both levels that a segment pushes
  if (!fine_->Participates()) return;
  ForEach(Intersection(fine_->Owned(), border_->MassNodes()), [&](Index node) {
    if (border_->Beta(node) >= 1) return;
    band_.push_back(Blend(node));
    coupled_.fine.push_back(band_.back().node);
  });
  ForEach(Intersection(fine_->Ghosted(), border_->MassNodes()), [&](Index node) {
    const double beta = border_->Beta(node);
    if (beta == 0) places.held.push_back(fine_->Place(node));
    if (beta > 0 && beta < 1) places.blended.push_back(node);
  });
}

/// Those that light ones among the known may hang on become known too.
void InterfaceNodes::ListBesideLight()
{
  for (int k = 0, count = Known(); k < count; ++k) {
    IndexBox near{known_[k].at, known_[k].at + Index{1, 1, 1}};
    for (int axis = 0; axis < border_->Dim(); ++axis)
      near.lower[axis] -= LightNodes::kReach, near.upper[axis] += LightNodes::kReach;
    border_->ForEachInterface(near, [&](Index node) { Know(node); });
  }
}

void InterfaceNodes::ListHeldAxes(const BoundaryConditions &coarse_sides)
{
  held_axes_.assign(owned_, 0);
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < border_->Dim(); ++axis)
      if (coarse_sides.Constrains(known_[k].at, axis)) held_axes_[k] |= 1 << axis;
}

/// The weights of a fine node on interface nodes, which become known.
BlendNode InterfaceNodes::Blend(Index node)
{
  const NodeBlend all = border_->BlendOf(node);
  const IndexBox around = border_->Around();
  BlendNode blend{fine_->Place(node), all.beta, 0, {}, {}};
  for (int a = 0; a < all.count; ++a) {
    if (!around.Contains(all.node[a]) || !border_->IsInterface(all.node[a])) continue;
    blend.interface[blend.count] = Know(all.node[a]);
    blend.weight[blend.count++] = all.weight[a];
  }
  return blend;
}

/// Asks the owners of the other nodes known here for their numbers there. Collective on the finer level's ranks.
PetscErrorCode InterfaceNodes::FindPlaces()
{
  struct Question {
    Index at;
    int block, from, known, place;
  };
  const MPI_Comm comm = fine_->Comm();
  std::vector<Question> list;
  PetscFunctionBeginUser;
  for (int k = owned_; k < Known(); ++k) list.push_back({known_[k].at, known_[k].block, RankIn(comm), k, 0});
  PetscCall(ExchangeRecords(comm, &list, [](const Question &one) { return one.block; }));
  for (Question &one : list) one.place = place_.at(one.at);
  PetscCall(ExchangeRecords(comm, &list, [](const Question &one) { return one.from; }));
  for (const Question &one : list) known_[one.known].place = one.place;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Owned interface nodes to their copies on other ranks of the fine level.
PetscErrorCode InterfaceNodes::CreateCopies()
{
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  PetscCall(FindPlaces());
  for (int k = owned_; k < Known(); ++k) {
    leaves.push_back(k);
    roots.push_back({known_[k].block, known_[k].place});
  }
  PetscCall(PetscSFCreate(fine_->Comm(), copies_.Out()));
  PetscCall(PetscSFSetGraph(copies_, owned_, static_cast<PetscInt>(leaves.size()), leaves.data(), PETSC_COPY_VALUES, roots.data(),
                            PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(copies_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::CreateTransfer()
{
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) {
    const int block = coarse_->BlockOf(known_[k].at);
    roots.push_back({coarse_->Layout().ranks[block], static_cast<PetscInt>(coarse_->GhostedOf(block).Place(known_[k].at))});
  }
  const PetscInt places = coarse_->Participates() ? static_cast<PetscInt>(coarse_->Ghosted().Count()) : 0;
  PetscCall(PetscSFCreate(world_, transfer_.Out()));
  PetscCall(PetscSFSetGraph(transfer_, places, owned_, nullptr, PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(transfer_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::ToInterface(MPI_Datatype unit, const void *coarse, void *interface) const
{
  PetscFunctionBeginUser;
  PetscCall(PetscSFBcastBegin(transfer_, unit, coarse, interface, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(transfer_, unit, coarse, interface, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::ToCoarse(MPI_Datatype unit, const void *interface, void *coarse) const
{
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(transfer_, unit, interface, coarse, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(transfer_, unit, interface, coarse, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::Broadcast(MPI_Datatype unit, void *values) const
{
  PetscFunctionBeginUser;
  if (!fine_->HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(copies_, unit, values, values, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(copies_, unit, values, values, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::AddUp(MPI_Datatype unit, void *values) const
{
  PetscFunctionBeginUser;
  if (!fine_->HasGhosts()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(copies_, unit, values, values, MPI_SUM));
  PetscCall(PetscSFReduceEnd(copies_, unit, values, values, MPI_SUM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InterfaceNodes::AddTraffic(int level, double factor, std::vector<BlockTraffic> *traffic) const
{
  const double node_bytes = sizeof(NodeSums) + sizeof(double) * NodeLayout::Velocity(border_->Dim());
  std::map<int, double> bytes; // by the coarse block; the fine one is this rank's
  std::vector<BlockTraffic> own, all;
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) bytes[coarse_->BlockOf(known_[k].at)] += factor * node_bytes;
  for (const auto &[coarse, sum] : bytes) own.push_back({level, coarse, RankIn(fine_->Comm()), sum});
  PetscCall(GatherRecords(world_, own, &all));
  std::sort(all.begin(), all.end(),
            [](const BlockTraffic &s, const BlockTraffic &t) { return std::tie(s.coarse, s.fine) < std::tie(t.coarse, t.fine); });
  traffic->insert(traffic->end(), all.begin(), all.end());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
