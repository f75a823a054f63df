// Which nodes couple two levels, which rank advances them, and how their values travel: each rank lists those near its own.
#include "hierarchy/coupling/level_interface.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <numeric>
#include <tuple>

namespace mlgimp
{

static constexpr double kOuterBeta = 0.3; ///< beta just inside the box

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

/// The coarse nodes among which interface nodes are.
IndexBox LevelInterface::Around() const
{
  const GridGeometry &f = fine_->Geometry().grid;
  const Index offset = Offset();
  const int reach = (f.padding + ratio_ - 1) / ratio_;
  IndexBox around{{}, {1, 1, 1}};
  for (int axis = 0; axis < dim_; ++axis) {
    around.lower[axis] = offset[axis] - reach;
    around.upper[axis] = offset[axis] + f.cells[axis] / ratio_ + reach + 1;
  }
  return Intersection(around, coarse_->Geometry().grid.NodeBox());
}

/// The interface nodes that this rank owns on the coarse level, and those that it advances.
void LevelInterface::ListOwned()
{
  const Grid &mesh = fine_->Mesh(), &coarse = coarse_->Mesh();
  known_.clear(), coarse_nodes_.clear(), held_coarse_.clear(), place_.clear();
  if (coarse.Participates())
    ForEachInterface(coarse.Ghosted(), [&](Index node) {
      held_coarse_.push_back(coarse.Place(node));
      if (coarse.Owns(node)) coarse_nodes_.push_back({held_coarse_.back()});
    });
  if (mesh.Participates()) {
    const PetscMPIInt block = RankIn(mesh.Comm());
    const Index offset = Offset();
    IndexBox near = mesh.Owned(); // with those beyond the fine grid, to whose edge they belong
    for (int axis = 0; axis < dim_; ++axis) {
      near.lower[axis] = offset[axis] + (mesh.Owned().lower[axis] - mesh.Geometry().padding) / ratio_ - 1;
      near.upper[axis] = offset[axis] + (mesh.Owned().upper[axis] + mesh.Geometry().padding) / ratio_ + 2;
    }
    ForEachInterface(near, [&](Index node) {
      if (BlockOf(node) != block) return;
      const int k = Know(node);
      known_[k].place = k;
    });
  }
  owned_ = static_cast<int>(known_.size());
}

/// The number of an interface node, which becomes known.
int LevelInterface::Know(Index at)
{
  const auto [found, is_new] = place_.insert({at, static_cast<int>(known_.size())});
  if (is_new) known_.push_back({at, BlockOf(at), -1});
  return found->second;
}

void LevelInterface::ListBand()
{
  const Grid &mesh = fine_->Mesh();
  band_.clear(), fine_nodes_.clear(), fine_places_ = {};
  fine_places_.reach = (2 + ratio_) * mesh.Geometry().spacing; // the nodes of both levels that a segment pushes
  if (!mesh.Participates()) return;
  ForEach(Intersection(mesh.Owned(), MassNodes()), [&](Index node) {
    if (Beta(node) >= 1) return;
    band_.push_back(Blend(node));
    fine_nodes_.push_back({band_.back().node});
  });
  ForEach(Intersection(mesh.Ghosted(), MassNodes()), [&](Index node) {
    const double beta = Beta(node);
    if (beta == 0) fine_places_.held.push_back(mesh.Place(node));
    if (beta > 0 && beta < 1) fine_places_.blended.push_back(node);
  });
}

/// Those that light ones among the known may hang on become known too.
void LevelInterface::ListDonors()
{
  for (std::size_t k = 0, count = known_.size(); k < count; ++k) {
    IndexBox near{known_[k].at, known_[k].at + Index{1, 1, 1}};
    for (int axis = 0; axis < dim_; ++axis) near.lower[axis] -= LightNodes::kReach, near.upper[axis] += LightNodes::kReach;
    ForEachInterface(near, [&](Index node) { Know(node); });
  }
  own_.assign(known_.size(), 1.0);
  first_donor_.assign(known_.size() + 1, 0);
  donors_.clear();
}

/// The axes that sides hold of the interface nodes that this rank works out.
void LevelInterface::ListHeldAxes()
{
  held_axes_.assign(owned_, 0);
  for (int k = 0; k < owned_; ++k)
    for (int axis = 0; axis < dim_; ++axis)
      if (coarse_->Geometry().sides.Constrains(known_[k].at, axis)) held_axes_[k] |= 1 << axis;
}

/// The weights of a fine node on interface nodes, which become known.
BlendNode LevelInterface::Blend(Index node)
{
  const NodeBlend all = BlendOf(node);
  const IndexBox around = Around();
  BlendNode blend{fine_->Mesh().Place(node), all.beta, 0, {}, {}};
  for (int a = 0; a < all.count; ++a) {
    if (!around.Contains(all.node[a]) || !IsInterface(all.node[a])) continue;
    blend.interface[blend.count] = Know(all.node[a]);
    blend.weight[blend.count++] = all.weight[a];
  }
  return blend;
}

/// Asks the owners of the other nodes known here for their places there. Collective on the finer level's ranks.
PetscErrorCode LevelInterface::FindPlaces()
{
  struct Question {
    Index at;
    int block, from, known, place;
  };
  const MPI_Comm comm = fine_->Mesh().Comm();
  std::vector<Question> list;
  PetscFunctionBeginUser;
  for (int k = owned_; k < static_cast<int>(known_.size()); ++k)
    list.push_back({known_[k].at, known_[k].block, RankIn(comm), k, 0});
  PetscCall(ExchangeRecords(comm, &list, [](const Question &one) { return one.block; }));
  for (Question &one : list) one.place = place_.at(one.at);
  PetscCall(ExchangeRecords(comm, &list, [](const Question &one) { return one.from; }));
  for (const Question &one : list) known_[one.known].place = one.place;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Owned interface nodes to their copies on other ranks of the fine level.
PetscErrorCode LevelInterface::CreateExchange()
{
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  PetscCall(FindPlaces());
  for (int k = owned_; k < static_cast<int>(known_.size()); ++k) {
    leaves.push_back(k);
    roots.push_back({known_[k].block, known_[k].place});
  }
  PetscCall(PetscSFCreate(fine_->Mesh().Comm(), exchange_.Out()));
  PetscCall(PetscSFSetGraph(exchange_, owned_, static_cast<PetscInt>(leaves.size()), leaves.data(), PETSC_COPY_VALUES,
                            roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(exchange_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Owned coarse nodes to the first `count` interface nodes that are known here.
PetscErrorCode LevelInterface::CreateTransfer(int count, SFHandle *transfer)
{
  const Grid &coarse = coarse_->Mesh();
  std::vector<PetscSFNode> roots;
  PetscFunctionBeginUser;
  for (int k = 0; k < count; ++k) {
    const int block = coarse.BlockOfNode(known_[k].at);
    roots.push_back({coarse.Layout().ranks[block], coarse.PlaceInBlock(block, known_[k].at)});
  }
  const PetscInt places = coarse.Participates() ? static_cast<PetscInt>(coarse.GhostedNodes()) : 0;
  PetscCall(PetscSFCreate(world_, transfer->Out()));
  PetscCall(PetscSFSetGraph(*transfer, places, count, nullptr, PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(*transfer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Gives the owners of coarse nodes the ranks that hold a copy of them. Collective on all.
PetscErrorCode LevelInterface::FindReaders()
{
  struct Reader {
    Index at;
    PetscMPIInt to, from;
  };
  const Grid &coarse = coarse_->Mesh();
  std::vector<Reader> list;
  PetscFunctionBeginUser;
  for (const InterfaceNode &node : known_) list.push_back({node.at, coarse.OwnerOfNode(node.at), RankIn(world_)});
  PetscCall(ExchangeRecords(world_, &list, [](const Reader &one) { return one.to; }));
  readers_.assign(coarse_nodes_.size(), {});
  std::map<std::ptrdiff_t, std::size_t> number;
  for (std::size_t k = 0; k < coarse_nodes_.size(); ++k) number[coarse_nodes_[k].node] = k;
  for (const Reader &one : list) readers_[number.at(coarse.Place(one.at))].push_back(one.from);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends the donors of light interface nodes in this step to the ranks that hold a copy of these nodes. Collective on all.
PetscErrorCode LevelInterface::ShareDonors()
{
  struct Link {
    Index node, on;
    double weight;
    PetscMPIInt to;
  };
  const Grid &coarse = coarse_->Mesh();
  std::vector<Link> list;
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < coarse_nodes_.size(); ++k) {
    const std::ptrdiff_t place = coarse_nodes_[k].node;
    if (!coarse_->Light().IsLight(place)) continue;
    coarse_->Light().ForEachDonor(place, [&](std::ptrdiff_t on, double weight) {
      for (const PetscMPIInt reader : readers_[k]) list.push_back({coarse.NodeAt(place), coarse.NodeAt(on), weight, reader});
    });
  }
  PetscCall(ExchangeRecords(world_, &list, [](const Link &one) { return one.to; }));
  std::fill(own_.begin(), own_.end(), 1.0);
  if (list.empty() && donors_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<std::pair<int, Donor>> found;
  for (const Link &one : list) {
    const int k = place_.at(one.node);
    if (one.node == one.on)
      own_[k] = one.weight;
    else if (const auto on = place_.find(one.on); on != place_.end()) // what only copies in the ring hang on is of no interest
      found.push_back({k, {on->second, one.weight}});
  }
  std::fill(first_donor_.begin(), first_donor_.end(), 0);
  for (const auto &[k, donor] : found) ++first_donor_[k + 1];
  std::partial_sum(first_donor_.begin(), first_donor_.end(), first_donor_.begin());
  donors_.resize(found.size());
  std::vector<int> next = first_donor_;
  for (const auto &[k, donor] : found) donors_[next[k]++] = donor;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LevelInterface::AddTraffic(int level, double factor, std::vector<BlockTraffic> *traffic) const
{
  const double node_bytes = sizeof(NodeSums) + sizeof(double) * velocity_size_;
  std::map<int, double> bytes; // by the coarse block; the fine one is this rank's
  std::vector<BlockTraffic> own, all;
  PetscFunctionBeginUser;
  for (int k = 0; k < owned_; ++k) bytes[coarse_->Mesh().BlockOfNode(known_[k].at)] += factor * node_bytes;
  for (const auto &[coarse, sum] : bytes) own.push_back({level, coarse, RankIn(fine_->Mesh().Comm()), sum});
  PetscCall(GatherRecords(world_, own, &all));
  std::sort(all.begin(), all.end(),
            [](const BlockTraffic &s, const BlockTraffic &t) { return std::tie(s.coarse, s.fine) < std::tie(t.coarse, t.fine); });
  traffic->insert(traffic->end(), all.begin(), all.end());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
