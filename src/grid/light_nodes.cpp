// Finding what light nodes hang on, and sums and motions to and fro.
#include "grid/light_nodes.hpp"

#include "base/pack.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace mlgimp
{

namespace
{

int Distance(Index a, Index b)
{
  int most = 0;
  for (int axis = 0; axis < 3; ++axis) most = std::max(most, std::abs(a[axis] - b[axis]));
  return most;
}

/// (C + part) y = r by Cholesky's factors, in place of r.
struct SpreadFactors {
  int dim;
  double L[3][3];

  SpreadFactors(const double C[3][3], double part, int dim_of) : dim(dim_of)
  {
    for (int a = 0; a < dim; ++a)
      for (int b = 0; b <= a; ++b) {
        L[a][b] = C[a][b] + (a == b ? part : 0);
        for (int k = 0; k < b; ++k) L[a][b] -= L[a][k] * L[b][k];
        L[a][b] = a == b ? std::sqrt(L[a][a]) : L[a][b] / L[b][b];
      }
  }
  void Solve(double r[3]) const
  {
    for (int a = 0; a < dim; ++a) {
      for (int k = 0; k < a; ++k) r[a] -= L[a][k] * r[k];
      r[a] /= L[a][a];
    }
    for (int a = dim - 1; a >= 0; --a) {
      for (int k = a + 1; k < dim; ++k) r[a] -= L[k][a] * r[k];
      r[a] /= L[a][a];
    }
  }
};

} // namespace

/// Leaves those that are joined to the light node through nodes beside it, where there are such: a linear fit must not reach over
/// a gap to another body.
void LightNodes::KeepJoined(std::vector<Near> *nodes) const
{
  std::vector<Index> beside;
  for (const Near &one : *nodes)
    if (Distance(fits_.around[one.number].offset, {}) == 1) beside.push_back(fits_.around[one.number].offset);
  if (beside.empty()) return;
  const auto apart = [&](const Near &one) {
    return std::none_of(beside.begin(), beside.end(),
                        [&](Index other) { return Distance(fits_.around[one.number].offset, other) <= 1; });
  };
  nodes->erase(std::remove_if(nodes->begin(), nodes->end(), apart), nodes->end());
}

/// Makes of the weights those of a linear fit at the light node, which add up to one: w_i (1 - y . (x_i - m))/sum w with C y = m,
/// of the mean m and the covariance C of the places x_i. Where they lie on a line or a plane, C y = m has no solution, and the
/// fit is to have no slope across: a part of a cell's square is added to C, and taken off again in some turns where C has more.
void LightNodes::FitLinear(std::vector<Near> *nodes, int dim) const
{
  constexpr double kNoSlope = 1e-5; // cells2; two layers of nodes have 0.01
  constexpr int kTurns = 6;         // each leaves kNoSlope over the spread of what it missed
  double sum = 0, mean[3] = {}, C[3][3] = {}, y[3] = {};
  for (const Near &one : *nodes) {
    sum += one.even;
    for (int a = 0; a < dim; ++a) mean[a] += one.even * fits_.around[one.number].offset[a];
  }
  for (int a = 0; a < dim; ++a) mean[a] /= sum;
  for (const Near &one : *nodes) {
    const Index x = fits_.around[one.number].offset;
    for (int a = 0; a < dim; ++a)
      for (int b = 0; b < dim; ++b) C[a][b] += one.even / sum * (x[a] - mean[a]) * (x[b] - mean[b]);
  }
  const SpreadFactors factors(C, kNoSlope, dim);
  for (int turn = 0; turn < kTurns; ++turn) {
    double r[3];
    for (int a = 0; a < dim; ++a) {
      r[a] = mean[a];
      for (int b = 0; b < dim; ++b) r[a] -= C[a][b] * y[b];
    }
    factors.Solve(r);
    for (int a = 0; a < dim; ++a) y[a] += r[a];
  }
  for (Near &one : *nodes) {
    one.even /= sum;
    one.slope = 0;
    for (int a = 0; a < dim; ++a) one.slope -= one.even * y[a] * (fits_.around[one.number].offset[a] - mean[a]);
  }
}

/// Mass of the node amid material, halved at sides, where the grid's half beyond is empty.
double LightNodes::FullMass(const Grid &grid, Index node) const
{
  constexpr double kAtAxis = 1.0 / 6; // exact: mass of a node at the axis, of that one cell from it
  const double radius = grid.Geometry().Coordinate(0, node[0]) / grid.Geometry().spacing;
  const bool at_axis = rule_.hoop && radius < 0.5;
  double share = rule_.hoop ? std::max(radius, kAtAxis) : 1;
  for (const Side side : SidesOf{grid.Geometry().dim})
    if (rule_.sides.kind[side] != BoundaryKind::kFree && rule_.sides.Reaches(side, node) && !(at_axis && AxisOf(side) == 0))
      share *= 0.5;
  return share * rule_.full_mass;
}

void LightNodes::Create(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, bool hoop,
                        std::vector<double> shares)
{
  tables_.shares = std::move(shares);
  rule_.full_mass = settings.full_mass, rule_.cutoff = settings.mass_cutoff, rule_.hoop = hoop, rule_.sides = sides;
  tables_.limit.resize(grid.Ghosted().Count()), tables_.at_sides.assign(grid.Ghosted().Count(), 0);
  tables_.light.assign(grid.Ghosted().Count(), -1), tables_.target = tables_.light;
  lights_.clear(), donors_.clear(), targets_.clear(), target_copies_.clear(), light_copies_.clear();
  fits_.around.clear(), fits_.known.clear();
  IndexBox box = {{}, {1, 1, 1}};
  for (int axis = 0; axis < grid.Geometry().dim; ++axis) box.lower[axis] = -kReach, box.upper[axis] = kReach + 1;
  const Index first = grid.Ghosted().lower;
  ForEach(box, [&](Index d) {
    constexpr double kWidth = 0.8; // cells, of a Gaussian
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (square > 0) fits_.around.push_back({d, grid.Place(first + d) - grid.Place(first), std::exp(-square / (kWidth * kWidth))});
  });
  ForEach(grid.Ghosted(), [&](Index node) {
    const std::ptrdiff_t place = grid.Place(node);
    tables_.limit[place] = kLight * FullMass(grid, node);
    for (const Side side : SidesOf{grid.Geometry().dim})
      if (sides.kind[side] != BoundaryKind::kFree && sides.Reaches(side, node)) tables_.at_sides[place] |= 1U << side;
  });
}

int LightNodes::Target(const Grid &grid, std::ptrdiff_t place, Index node)
{
  int &number = tables_.target[place];
  if (number >= 0) return number;
  number = static_cast<int>(targets_.size());
  targets_.push_back(place);
  grid.Nodes().ForEachCopy(node, [&](std::size_t rank, std::ptrdiff_t there) {
    target_copies_.push_back({number, rank, there});
  });
  return number;
}

/// Nodes within two cells at the same sides, so that what these hold stays held; the nearer and the fuller they are, the more
/// they count. The fit is that of a pattern of full nodes, which is kept, but where some are between light and full.
void LightNodes::FindDonors(const Grid &grid, const NodeBodies &bodies, Index node, Light *light)
{
  constexpr double kSame = 1e-9;          // rounding: of shares
  constexpr double kMayTake = 1.0 / 32;   // of a node's mass, see below
  constexpr std::size_t kMaxFits = 10000; // size
  const int dim = grid.Geometry().dim;
  const double share = tables_.shares[light->place];
  FullPattern full{};
  bool all_full = true, inner = true;
  fits_.near.clear();
  for (int axis = 0; axis < dim; ++axis)
    inner = inner && node[axis] - kReach >= grid.Ghosted().lower[axis] && node[axis] + kReach < grid.Ghosted().upper[axis];
  for (int k = 0; k < static_cast<int>(fits_.around.size()); ++k) {
    const Around &at = fits_.around[k];
    if (!inner && !grid.Ghosted().Contains(node + at.offset)) continue;
    const std::ptrdiff_t place = light->place + at.step;
    const double mass = MassAt(grid, place);
    if (mass <= tables_.limit[place] || std::isinf(mass) || tables_.at_sides[place] != tables_.at_sides[light->place]) continue;
    if (share < 1 && std::abs(tables_.shares[place] - share) > kSame) continue;
    if (!bodies.MayShare(place, light->place)) continue;
    const double fuller = SmoothStep(mass / tables_.limit[place] - 1);
    all_full = all_full && fuller == 1;
    full[k / 64] |= std::uint64_t(1) << k % 64;
    fits_.near.push_back({k, fuller * at.nearness, 0});
  }
  light->first = light->end = static_cast<int>(donors_.size());
  if (fits_.near.empty()) { // of points that have left their body
    light->own = 1;
    return;
  }
  const auto fit = [&] { KeepJoined(&fits_.near), FitLinear(&fits_.near, dim); };
  if (all_full) {
    if (fits_.known.size() > kMaxFits) fits_.known.clear();
    std::vector<Near> &kept = fits_.known[full];
    if (kept.empty()) fit(), kept = fits_.near;
    fits_.near = kept;
  } else {
    fit();
  }
  // A negative weight takes mass: as much of the slope as leaves nodes theirs, though many light ones hang on them.
  const double given = (1 - light->own) * MassAt(grid, light->place);
  double part = 1;
  for (const Near &one : fits_.near) {
    const double may = kMayTake * MassAt(grid, light->place + fits_.around[one.number].step);
    if (given * -(one.even + one.slope) > may) part = std::min(part, (may / given + one.even) / -one.slope);
  }
  for (const Near &one : fits_.near) {
    const Around &at = fits_.around[one.number];
    const std::ptrdiff_t place = light->place + at.step;
    donors_.push_back(
        {(1 - light->own) * (one.even + part * one.slope), static_cast<int>(place), Target(grid, place, node + at.offset)});
  }
  light->end = static_cast<int>(donors_.size());
}

/// Where points may be gone within a step of the coarser level, nothing of a node's motion is its own.
static constexpr double kMinOwnShare = 1e-12; // rounding

void LightNodes::Find(const Grid &grid, const NodeBodies &bodies, const double *more)
{
  more_ = more;
  for (const Light &light : lights_) tables_.light[light.place] = -1;
  for (const std::ptrdiff_t place : targets_) tables_.target[place] = -1;
  lights_.clear(), donors_.clear(), targets_.clear(), target_copies_.clear(), light_copies_.clear();
  IndexBox rows = grid.Owned();
  const int width = rows.Size(0);
  rows.upper[0] = rows.lower[0] + 1;
  ForEach(rows, [&](Index first) {
    const std::ptrdiff_t start = grid.Place(first);
    for (int k = 0; k < width; ++k) {
      const double mass = MassAt(grid, start + k);
      if (mass > rule_.cutoff && mass < tables_.limit[start + k]) AddLight(grid, bodies, first + Index{k, 0, 0}, mass);
    }
  });
}

void LightNodes::AddLight(const Grid &grid, const NodeBodies &bodies, Index node, double mass)
{
  const std::ptrdiff_t place = grid.Place(node);
  if (tables_.shares[place] == 0) return;
  const int number = tables_.light[place] = static_cast<int>(lights_.size());
  const double own = SmoothStep(mass / tables_.limit[place]);
  lights_.push_back({place, own * mass > kMinOwnShare * tables_.limit[place] ? own : 0, 0, 0});
  FindDonors(grid, bodies, node, &lights_.back());
  Target(grid, place, node);
  grid.Nodes().ForEachCopy(node, [&](std::size_t rank, std::ptrdiff_t there) { light_copies_.push_back({number, rank, there}); });
}

/// All ranks add the shares in the order of the ranks that they come from, so that copies of a node stay the same.
PetscErrorCode LightNodes::Restrict(HaloExchange &halo, double *values, std::ptrdiff_t size) const
{
  std::vector<std::vector<double>> outgoing(halo.Neighbours()), incoming;
  PetscFunctionBeginUser;
  given_.assign(targets_.size() * size, 0.0);
  for (const Light &light : lights_) {
    const double *const from = values + size * light.place;
    AddTimes(light.own - 1, from, &given_[size * tables_.target[light.place]], size);
    for (int d = light.first; d < light.end; ++d) AddTimes(donors_[d].weight, from, &given_[size * donors_[d].target], size);
  }
  const auto add = [&](std::ptrdiff_t place, const double *shares) { AddTimes(1, shares, values + size * place, size); };
  const auto add_from = [&](std::size_t first, std::size_t end) {
    for (std::size_t rank = first; rank < end; ++rank)
      for (std::size_t k = 0; k < incoming[rank].size(); k += 1 + size)
        add(static_cast<std::ptrdiff_t>(incoming[rank][k]), &incoming[rank][k + 1]);
  };
  for (const Copy &copy : target_copies_) {
    std::vector<double> &message = outgoing[copy.rank];
    message.push_back(copy.place);
    message.insert(message.end(), &given_[size * copy.number], &given_[size * copy.number] + size);
  }
  PetscCall(halo.Send(outgoing, &incoming));
  add_from(0, halo.LowerNeighbours());
  for (std::size_t k = 0; k < targets_.size(); ++k) add(targets_[k], &given_[size * k]);
  add_from(halo.LowerNeighbours(), halo.Neighbours());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LightNodes::Prolong(HaloExchange &halo, double *values, std::ptrdiff_t size) const
{
  std::vector<std::vector<double>> outgoing(halo.Neighbours()), incoming;
  PetscFunctionBeginUser;
  for (const Light &light : lights_) {
    double *const to = values + size * light.place;
    for (int c = 0; c < size; ++c) to[c] *= light.own;
    for (int d = light.first; d < light.end; ++d) AddTimes(donors_[d].weight, values + size * donors_[d].place, to, size);
  }
  for (const Copy &copy : light_copies_) {
    const double *const from = values + size * lights_[copy.number].place;
    std::vector<double> &message = outgoing[copy.rank];
    message.push_back(copy.place);
    message.insert(message.end(), from, from + size);
  }
  PetscCall(halo.Send(outgoing, &incoming));
  for (const std::vector<double> &message : incoming)
    for (std::size_t k = 0; k < message.size(); k += 1 + size)
      std::copy_n(&message[k + 1], size, values + size * static_cast<std::ptrdiff_t>(message[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
