// States of nodes to one rank, impulses back to their owners.
#include "contact/contact_nodes.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <tuple>

namespace mlgimp
{

namespace
{

/// What contact gives a node.
struct NodeImpulse {
  Index at;
  int coarser;
  PetscMPIInt rank;
  double share;
  Vec3 impulse, of_friction; ///< N s
};

PetscMPIInt OwnerOf(const NodeMotion &motion, const NodeState &node)
{
  return node.coarser ? motion.Group().RankOf(motion.Border()->BlockOf(node.at)) : motion.OwnerOf(node.at);
}

/// Orders nodes by place and leaves one of each.
void Unite(std::vector<NodeState> *nodes)
{
  const auto key = [](const NodeState &node) { return NodeKey(node.at, node.coarser); };
  std::sort(nodes->begin(), nodes->end(), [&](const NodeState &a, const NodeState &b) { return key(a) < key(b); });
  const auto same = [&](const NodeState &a, const NodeState &b) { return key(a) == key(b); };
  nodes->erase(std::unique(nodes->begin(), nodes->end(), same), nodes->end());
}

/// Without what only its owner knows.
NodeState Asked(Index node, int coarser) { return {node, coarser, -1, 0, 1, false, 1, {}, {}}; }

/// Adds those that nodes of this rank hang on, of its own level and of the coarser one.
void AddDonors(const NodeMotion &motion, std::vector<NodeState> *nodes, std::vector<NodeLink> *links)
{
  std::vector<NodeState> more;
  for (const NodeState &node : *nodes) {
    const std::ptrdiff_t self = motion.Mesh().Place(node.at);
    motion.Light().ForEachDonor(self, [&](std::ptrdiff_t place, double weight) {
      if (place == self) return;
      more.push_back(Asked(motion.Mesh().Ghosted().At(place), 0));
      links->push_back({node.at, more.back().at, 0, weight});
    });
  }
  nodes->insert(nodes->end(), more.begin(), more.end());
  Unite(nodes);
  if (!motion.Border()) return;
  more.clear();
  for (const NodeState &node : *nodes) {
    const NodeBlend blend = motion.Border()->BlendOf(node.at);
    for (int a = 0; a < blend.count; ++a) more.push_back(Asked(blend.node[a], 1));
  }
  Unite(&more);
  nodes->insert(nodes->end(), more.begin(), more.end());
  for (const NodeState &node : more)
    motion.Border()->ForEachDonor(node.at, [&](Index on, double weight) {
      if (on == node.at) return;
      nodes->push_back(Asked(on, 1));
      links->push_back({node.at, on, 1, weight});
    });
  Unite(nodes);
}

/// Fills in what the owner knows.
void FindState(const NodeMotion &motion, NodeState *node)
{
  constexpr Vec3 kAll = {1, 1, 1}; // size
  const double mass = node->coarser ? motion.Border()->MassOf(node->at) : motion.MassOf(node->at);
  node->rank = RankIn(motion.Group().Comm());
  if (node->coarser)
    motion.Border()->ForEachDonor(node->at, [&](Index on, double weight) {
      if (on == node->at) node->own = weight;
    });
  else
    motion.Light().ForEachDonor(motion.Mesh().Place(node->at), [&](std::ptrdiff_t place, double weight) {
      if (place == motion.Mesh().Place(node->at)) node->own = weight;
    });
  node->moves = node->own < 1 || !motion.IsEmpty(mass);
  if (motion.IsEmpty(mass)) return;
  node->mass = mass;
  if (node->coarser) {
    node->free = motion.Border()->FreePart(node->at, kAll);
  } else {
    node->free = motion.FreePart(node->at, kAll);
    node->velocity = motion.VelocityOf(node->at);
    if (motion.Border()) node->share = motion.Border()->BlendOf(node->at).beta;
  }
  for (int axis = motion.Mesh().Geometry().dim; axis < 3; ++axis) node->free[axis] = 0;
}

void PushOwned(const NodeMotion &motion, const NodeImpulse &one, ContactReport *report)
{
  constexpr double kRounding = 1e-9; // rounding: of the impulse
  if (one.coarser) {
    const Vec3 taken = motion.Border()->FreePart(one.at, one.impulse);
    motion.Border()->Push(one.at, (1 / motion.Border()->MassOf(one.at)) * taken);
    report->impulse = report->impulse + one.impulse;
    report->side_impulse = report->side_impulse + taken - one.impulse;
    return;
  }
  motion.Push(one.at, one.share * one.impulse, report);
  report->contact_nodes.back().has_traction = Norm(one.of_friction) > kRounding * Norm(one.impulse);
  report->friction_impulse = report->friction_impulse + one.of_friction;
}

} // namespace

/// On the first rank, in their order; `links` of the light ones among them.
PetscErrorCode ContactNodes::GatherStates(const NodeMotion &motion, const std::vector<Index> &nodes, std::vector<NodeLink> *links)
{
  const MPI_Comm comm = motion.Group().Comm();
  const auto owner_of = [&](const NodeState &node) { return OwnerOf(motion, node); };
  PetscFunctionBeginUser;
  states_.clear();
  for (const Index node : nodes) states_.push_back(Asked(node, 0));
  Unite(&states_);
  PetscCall(ExchangeRecords(comm, &states_, owner_of));
  Unite(&states_);
  AddDonors(motion, &states_, links);
  PetscCall(ExchangeRecords(comm, &states_, owner_of));
  Unite(&states_);
  for (NodeState &node : states_) FindState(motion, &node);
  PetscCall(ExchangeRecords(
      comm, &states_, [](const NodeState &) { return 0; }, kAllToFirst));
  PetscCall(ExchangeRecords(
      comm, links, [](const NodeLink &) { return 0; }, kAllToFirst));
  Unite(&states_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactNodes::Gather(const NodeMotion &motion, const std::vector<Index> &nodes)
{
  std::vector<NodeLink> links;
  const auto key = [](const NodeLink &link) {
    return std::tuple(NodeKey(link.node, link.coarser), NodeKey(link.on, link.coarser));
  };
  PetscFunctionBeginUser;
  PetscCall(GatherStates(motion, nodes, &links));
  number_.clear(), light_.clear(), light_coarser_.clear(), at_border_.clear();
  for (int k = 0; k < Size(); ++k) number_.emplace(NodeKey(states_[k].at, states_[k].coarser), k);
  std::sort(links.begin(), links.end(), [&](const NodeLink &a, const NodeLink &b) { return key(a) < key(b); });
  links.erase(std::unique(links.begin(), links.end(), [&](const NodeLink &a, const NodeLink &b) { return key(a) == key(b); }),
              links.end());
  for (const NodeLink &link : links)
    (link.coarser ? light_coarser_ : light_)
        .push_back({number_.at(NodeKey(link.node, link.coarser)), number_.at(NodeKey(link.on, link.coarser)), link.weight});
  for (NodeState &node : states_) node.velocity = node.own * node.velocity;
  for (const Hanging &one : light_)
    states_[one.node].velocity = states_[one.node].velocity + one.weight * states_[one.on].velocity;
  for (int k = 0; k < Size() && motion.Border(); ++k) {
    if (states_[k].coarser) continue;
    const NodeBlend blend = motion.Border()->BlendOf(states_[k].at);
    for (int a = 0; a < blend.count; ++a)
      at_border_.push_back({k, number_.at(NodeKey(blend.node[a], true)), (1 - blend.beta) * blend.weight[a]});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ContactNodes::RestrictLight(const std::vector<Hanging> &light, int coarser, std::vector<Vec3> *u) const
{
  for (const Hanging &one : light) (*u)[one.on] = (*u)[one.on] + one.weight * (*u)[one.node];
  for (int k = 0; k < Size(); ++k)
    if (states_[k].own != 1 && states_[k].coarser == coarser) (*u)[k] = states_[k].own * (*u)[k];
}

void ContactNodes::ProlongLight(const std::vector<Hanging> &light, int coarser, std::vector<Vec3> *u) const
{
  for (int k = 0; k < Size(); ++k)
    if (states_[k].own != 1 && states_[k].coarser == coarser) (*u)[k] = states_[k].own * (*u)[k];
  for (const Hanging &one : light) (*u)[one.node] = (*u)[one.node] + one.weight * (*u)[one.on];
}

void ContactNodes::Restrict(std::vector<Vec3> *u) const
{
  RestrictLight(light_, 0, u);
  for (const Hanging &one : at_border_) (*u)[one.on] = (*u)[one.on] + one.weight * (*u)[one.node];
  RestrictLight(light_coarser_, 1, u);
}

void ContactNodes::Move(double dt, std::vector<Vec3> *u) const
{
  Restrict(u);
  for (int k = 0; k < Size(); ++k) {
    const NodeState &node = states_[k];
    const double factor = node.mass > 0 ? dt * dt * node.share / node.mass : 0;
    for (int a = 0; a < 3; ++a) (*u)[k][a] *= factor * node.free[a];
  }
  ProlongLight(light_coarser_, 1, u);
  for (const Hanging &one : at_border_) (*u)[one.node] = (*u)[one.node] + one.weight * (*u)[one.on];
  ProlongLight(light_, 0, u);
}

std::vector<Vec3> ContactNodes::Mobility(double dt) const
{
  std::vector<Vec3> mobility(Size());
  for (int k = 0; k < Size(); ++k)
    if (states_[k].mass > 0) mobility[k] = (dt * dt * states_[k].own * states_[k].own / states_[k].mass) * states_[k].free;
  for (const Hanging &one : light_)
    if (const NodeState &on = states_[one.on]; on.mass > 0)
      mobility[one.node] = mobility[one.node] + (dt * dt * one.weight * one.weight / on.mass) * on.free;
  return mobility;
}

PetscErrorCode ContactNodes::Push(const NodeMotion &motion, const std::vector<Vec3> &impulses,
                                  const std::vector<Vec3> &of_friction, ContactReport *report) const
{
  std::vector<NodeImpulse> pushed;
  PetscFunctionBeginUser;
  for (int k = 0; k < static_cast<int>(impulses.size()); ++k)
    if (const NodeState &node = states_[k]; node.mass > 0 && impulses[k] != Vec3{})
      pushed.push_back(
          {node.at, node.coarser, node.rank, node.share, impulses[k], of_friction.empty() ? Vec3{} : of_friction[k]});
  PetscCall(ExchangeRecords(
      motion.Group().Comm(), &pushed, [](const NodeImpulse &one) { return one.rank; }, kFirstToAll));
  for (const NodeImpulse &one : pushed) PushOwned(motion, one, report);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
