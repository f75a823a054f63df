// Assembling, solving and applying the contact equations.
#include "level/contact/system.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <numeric>

namespace mlgimp
{

namespace
{

/// kg
double MassOf(const ContactView &view, const ContactCoupling &at)
{
  return at.coarser ? view.border->MassOf(at.node) : MassOf(view, at.node);
}
double MovedMassOf(const ContactView &view, const ContactCoupling &at)
{
  return at.coarser ? view.border->MovedMassOf(at.node) : MovedMassOf(view, at.node);
}

bool AreAtOneNode(const ContactCoupling &a, const ContactCoupling &b) { return a.node == b.node && a.coarser == b.coarser; }

/// Calls work(first, end) for the couplings of each node, which stand together.
template <class Work> void ForEachNode(const std::vector<ContactCoupling> &couplings, Work work)
{
  for (auto first = couplings.begin(), end = first; first != couplings.end(); first = end) {
    while (end != couplings.end() && AreAtOneNode(*end, *first)) ++end;
    work(first, end);
  }
}

/// Orders numbers by a key from 0 to `count`; those of equal keys stay as they stand.
template <class Key> void OrderBy(std::int64_t count, Key key, std::vector<int> *numbers)
{
  std::vector<int> starts(count + 1), ordered(numbers->size());
  for (const int n : *numbers) ++starts[key(n) + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for (const int n : *numbers) ordered[starts[key(n)]++] = n;
  numbers->swap(ordered);
}

/// Brings all couplings to the owners of their nodes and adds up those of the same unknown; nodes without mass are left out.
/// at_nodes: those of this rank, ordered by nodes, the last axis slowest, and unknowns.
PetscErrorCode GatherAtNodes(const ContactView &view, int unknowns, std::vector<ContactCoupling> *couplings, SendPattern pattern,
                             std::vector<ContactCoupling> *at_nodes)
{
  const auto owner = [&](const ContactCoupling &c) { return ContactSystem::OwnerOf(view, c); };
  PetscFunctionBeginUser;
  if (view.border) ContactSystem::AddBeyondBorder(*view.border, couplings);
  PetscCall(ExchangeRecords(view.group.Comm(), couplings, owner, pattern));
  const std::vector<ContactCoupling> &all = *couplings;
  IndexBox boxes[2] = {kNowhere, kNowhere}; // of this level's nodes and of the coarser one's
  for (const ContactCoupling &c : all) boxes[c.coarser].Include(c.node);
  std::vector<int> order(all.size()); // of the couplings, which are large
  std::iota(order.begin(), order.end(), 0);
  const auto unknown = [&](int k) { return all[k].unknown; };
  const auto node = [&](int k) { return (all[k].coarser ? boxes[0].Count() : 0) + boxes[all[k].coarser].Place(all[k].node); };
  OrderBy(unknowns, unknown, &order);
  OrderBy(boxes[0].Count() + boxes[1].Count(), node, &order);
  at_nodes->clear();
  for (const int k : order) {
    const ContactCoupling &next = all[k];
    if (!at_nodes->empty() && at_nodes->back().unknown == next.unknown && AreAtOneNode(at_nodes->back(), next)) {
      at_nodes->back().constraint = at_nodes->back().constraint + next.constraint;
      at_nodes->back().traction = at_nodes->back().traction + next.traction;
    } else if (MassOf(view, next) > view.mass_cutoff) {
      at_nodes->push_back(next);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds an impulse on a node of the coarser level.
void PushBeyondBorder(const ContactView &view, const ContactCoupling &at, Vec3 impulse, ContactReport *report)
{
  const Vec3 taken = view.border->FreePart(at.node, impulse);
  view.border->Push(at.node, (1 / MassOf(view, at)) * taken);
  report->impulse = report->impulse + impulse;
  report->side_impulse = report->side_impulse + taken - impulse;
}

/// Adds what pressures and tractions do to the velocities of nodes.
void Push(const ContactView &view, const std::vector<ContactCoupling> &couplings, const std::vector<double> &lambda,
          int per_column, ContactReport *report)
{
  constexpr double kRounding = 1e-9; // of the impulse
  ForEachNode(couplings, [&](auto first, auto end) {
    Vec3 impulse{}, of_tractions{};
    for (auto c = first; c != end; ++c) {
      const Vec3 part = view.dt * lambda[c->unknown] * c->traction;
      impulse = impulse + part;
      if (c->unknown % per_column) of_tractions = of_tractions + part;
    }
    if (impulse == Vec3{}) return;
    if (first->coarser) {
      PushBeyondBorder(view, *first, impulse, report);
    } else {
      PushNode(view, first->node, first->share * impulse, report);
      report->pushed.back().rubbed = Norm(of_tractions) > kRounding * Norm(impulse);
    }
  });
}

/// The part of that impulse that tractions give.
Vec3 FrictionImpulse(const ContactView &view, const std::vector<ContactCoupling> &couplings, const std::vector<double> &lambda,
                     int per_column)
{
  Vec3 impulse{};
  for (const ContactCoupling &c : couplings)
    if (c.unknown % per_column && !c.coarser) impulse = impulse + view.dt * lambda[c.unknown] * c.traction;
  return impulse;
}

/// Who sends products to the ranks that solve: the owners of nodes that couplings may be with.
SendPattern PatternOfTerms(SendPattern couplings, PetscMPIInt solvers)
{
  SendPattern pattern = 0;
  for (PetscMPIInt from = 0; from < kFewRanks; ++from)
    for (PetscMPIInt owner = 0; owner < kFewRanks; ++owner)
      for (PetscMPIInt to = 0; to < std::min(solvers, kFewRanks); ++to)
        if (couplings & Sends(from, owner)) pattern |= Sends(owner, to);
  return pattern;
}

/// Who hears of the pressures from the first rank: who has couplings or owns nodes of theirs, and all of a tip that travels.
SendPattern PatternOfPressures(SendPattern couplings, bool is_free)
{
  SendPattern pattern = is_free ? kAnyToAny : 0;
  for (PetscMPIInt from = 0; from < kFewRanks; ++from)
    for (PetscMPIInt owner = 0; owner < kFewRanks; ++owner)
      if (couplings & Sends(from, owner)) pattern |= Sends(0, from) | Sends(0, owner);
  return pattern;
}

} // namespace

PetscMPIInt ContactSystem::OwnerOf(const ContactView &view, const ContactCoupling &coupling)
{
  if (coupling.coarser) return view.group.RankOf(view.border->BlockOf(coupling.node));
  return mlgimp::OwnerOf(view, coupling.node);
}

void ContactSystem::AddBeyondBorder(const BorderNodes &border, std::vector<ContactCoupling> *couplings)
{
  const std::size_t count = couplings->size();
  for (std::size_t k = 0; k < count; ++k) {
    const NodeBlend blend = border.BlendOf((*couplings)[k].node);
    (*couplings)[k].share = blend.beta;
    for (int a = 0; a < blend.count; ++a) {
      const ContactCoupling &own = (*couplings)[k];
      const double weight = (1 - blend.beta) * blend.weight[a];
      couplings->push_back({blend.node[a], own.unknown, weight * own.constraint, weight * own.traction, true});
    }
  }
}

PetscErrorCode ContactSystem::Create(bool symmetric, double diagonal_shift, const ContactSettings &settings)
{
  PetscFunctionBeginUser;
  symmetric_ = symmetric && settings.friction == 0;
  diagonal_shift_ = diagonal_shift;
  settings_ = settings;
  PetscCall(serial_.Create(PETSC_COMM_SELF, symmetric_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The part of A, r and c that comes from the nodes of this rank, [unknowns][terms] in `rows_`.
void ContactSystem::AddProducts(const ContactView &view, int per_column)
{
  const Vec3 way = view.tip.end - view.tip.start;
  const auto add = [&](int row, int column, double value) {
    std::vector<Term> &terms = rows_[row];
    const auto same = std::find_if(terms.begin(), terms.end(), [&](const Term &term) { return term.column == column; });
    if (same != terms.end())
      same->value += value;
    else
      terms.push_back({row, column, value});
  };
  ForEachNode(at_nodes_, [&](auto first, auto end) {
    const double mobility = view.dt * view.dt * first->share / MovedMassOf(view, *first);
    for (auto a = first; a != end; ++a) {
      const Vec3 mobile =
          mobility * (a->coarser ? view.border->FreePart(a->node, a->constraint) : FreePart(view, a->node, a->constraint));
      if (!a->coarser) { // whose velocity has the coarser nodes' part
        add(a->unknown, kRightSide, -view.dt * Dot(a->constraint, VelocityOf(view, a->node)));
        if (a->unknown % per_column) add(a->unknown, kRightSide, Dot(a->constraint, way)); // of pressures the gap has it
        if (view.tip.IsFree()) add(a->unknown, kLoad, -a->traction[view.indenter.up]);
      }
      for (auto b = symmetric_ ? a : first; b != end; ++b) add(a->unknown, b->unknown, Dot(mobile, b->traction));
    }
  });
  for (std::size_t row = 0; row < rows_.size() && symmetric_; ++row)
    for (const Term &term : rows_[row])
      if (term.column > term.row) rows_[term.column].push_back({term.column, term.row, term.value});
}

/// This rank's equations from the products at the nodes of all ranks. An unknown that moves no mass stays without pressure.
PetscErrorCode ContactSystem::MakeEquations(const ContactView &view, const std::vector<ContactUnknown> &unknowns,
                                            const Layout &layout, SendPattern pattern)
{
  const PetscMPIInt rank = RankIn(view.group.Comm());
  std::vector<Term> terms;
  PetscFunctionBeginUser;
  rows_.resize(unknowns.size());
  for (std::vector<Term> &row : rows_) row.clear();
  AddProducts(view, layout.per_column);
  for (const std::vector<Term> &row : rows_) terms.insert(terms.end(), row.begin(), row.end());
  PetscCall(ExchangeRecords(
      view.group.Comm(), &terms, [&](const Term &term) { return layout.Owner(term.row); }, pattern));

  const int first = layout.First(rank), count = layout.First(rank + 1) - first;
  std::vector<double> diagonal(count);
  for (std::vector<PetscInt> *places : {&problem_.rows, &problem_.columns}) places->clear();
  for (std::vector<double> *values : {&problem_.values, &problem_.r, &problem_.c}) values->clear();
  problem_.by_load = view.tip.IsFree();
  problem_.load = view.tip.load;
  problem_.most_travel = view.tip.most_travel;
  problem_.tractions = layout.per_column - 1;
  problem_.friction = settings_.friction;
  problem_.c.resize(problem_.by_load ? count : 0);
  for (int row = 0; row < count; ++row) problem_.r.push_back(-unknowns[first + row].gap);
  for (const Term &term : terms) {
    const double value = term.row == term.column ? (1 + diagonal_shift_) * term.value : term.value;
    if (term.row == term.column) diagonal[term.row - first] += value;
    if (term.column == kRightSide) {
      problem_.r[term.row - first] += value;
    } else if (term.column == kLoad) {
      problem_.c[term.row - first] += value;
    } else {
      problem_.rows.push_back(term.row);
      problem_.columns.push_back(term.column);
      problem_.values.push_back(value);
    }
  }
  const double largest = count ? *std::max_element(diagonal.begin(), diagonal.end()) : 0;
  for (int row = 0; row < count; ++row) {
    if (diagonal[row] > 0) continue;
    problem_.rows.push_back(first + row);
    problem_.columns.push_back(first + row);
    problem_.values.push_back(largest > 0 ? largest : 1);
    problem_.r[row] = row % layout.per_column ? 0 : -1;
    if (problem_.by_load) problem_.c[row] = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves on the ranks that hold equations and tells those of the pattern the pressures, and how far a free tip travels; to
/// others they are zero.
PetscErrorCode ContactSystem::FindPressures(const ContactView &view, const Layout &layout, SendPattern pattern,
                                            ContactReport *report)
{
  const MPI_Comm comm = view.group.Comm();
  const PetscMPIInt rank = RankIn(comm), size = RanksOf(comm);
  ActiveSetReport solved;
  PetscFunctionBeginUser;
  if (layout.ranks > 1 && !parallel_) {
    parallel_ = std::make_unique<ActiveSetSolver>();
    PetscCall(parallel_->Create(comm, symmetric_));
  }
  ActiveSetSolver *const solver = layout.ranks > 1 ? parallel_.get() : &serial_;
  std::vector<double> own(lambda_.begin() + layout.First(rank), lambda_.begin() + layout.First(rank + 1));
  if (rank < layout.ranks) PetscCall(solver->Solve(problem_, &own, &solved));
  double found[2] = {solved.travel, double(solved.limited && solved.active > 0)};
  if (layout.ranks > 1) {
    std::vector<int> counts, starts;
    for (int k = 0; k < size; ++k) starts.push_back(layout.First(k)), counts.push_back(layout.First(k + 1) - starts.back());
    PetscCallMPI(
        MPI_Allgatherv(own.data(), counts[rank], MPI_DOUBLE, lambda_.data(), counts.data(), starts.data(), MPI_DOUBLE, comm));
  } else {
    own.resize(lambda_.size());
    own.insert(own.end(), found, found + 2);
    PetscCall(ShareFromFirst(comm, &own, pattern));
    std::copy(own.end() - 2, own.end(), found);
    own.resize(lambda_.size());
    lambda_ = own;
  }
  if (problem_.by_load) report->travel = found[0], report->limited = found[1] != 0;
  report->solved = solved.solved;
  report->friction_work = solved.heat;
  if (rank > 0) PetscFunctionReturn(PETSC_SUCCESS);
  report->set_updates = solved.set_updates;
  report->fallback = solved.fallback;
  if (settings_.monitor && solved.active)
    PetscCall(PetscPrintf(
        PETSC_COMM_SELF, "contact: time %.6e unknowns %d, at most %d on a rank, active %d set updates %d iterations %d\n",
        view.time, layout.First(size), layout.Most(), solved.active, solved.set_updates, solved.linear_iterations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactSystem::Solve(const ContactView &view, const std::vector<ContactUnknown> &unknowns,
                                    const std::vector<ContactCoupling> &couplings, SendPattern pattern, ContactReport *report)
{
  const int count = static_cast<int>(unknowns.size()), per_column = UnknownsPerColumn(settings_, view.geometry);
  PetscFunctionBeginUser;
  lambda_.clear();
  for (const ContactUnknown &unknown : unknowns) {
    const auto previous = pressures_.find(unknown.key);
    lambda_.push_back(previous == pressures_.end() ? 0 : previous->second);
  }
  pressures_.clear();
  if (view.tip.IsFree() && count == 0) report->travel = view.tip.FreeTravel();
  if (count == 0) PetscFunctionReturn(PETSC_SUCCESS);
  const Layout layout = {count / per_column, per_column, count < settings_.serial_unknowns ? 1 : RanksOf(view.group.Comm())};
  couplings_ = couplings;
  PetscCall(GatherAtNodes(view, count, &couplings_, pattern, &at_nodes_));
  PetscCall(MakeEquations(view, unknowns, layout, PatternOfTerms(pattern, layout.ranks)));
  PetscCall(FindPressures(view, layout, PatternOfPressures(pattern, view.tip.IsFree()), report));
  for (int j = 0; j < count; ++j)
    if (lambda_[j] != 0) pressures_.emplace_hint(pressures_.end(), unknowns[j].key, lambda_[j]);
  Push(view, at_nodes_, lambda_, per_column, report);
  report->friction_impulse = FrictionImpulse(view, at_nodes_, lambda_, per_column);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
