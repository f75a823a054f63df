// Building the operator over segments, and what its solutions do.
#include "contact/segment_problem.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace mlgimp
{

namespace
{

/// Compliance between the nodes, of h/E*: what an elastic half space yields to waves of pressure more than the grid's nodes do,
/// where it is even, shorter than two and a half cells. Where waves run in all directions, as in space and under an axis, that is
/// less.
constexpr double kInPlane = 0.45, kInSpace = 0.36;
/// Flow between the nodes, for a pressure as large as the mean one at which the metal flows under a contact: the offset that a
/// strain of 1 makes, three times 2.8, and the largest one that it holds, cells.
constexpr double kRate = 8.4, kBack = 0.5;

} // namespace

/// Whether a column presses nodes that have no motion of their own, at the border to the coarser level or beyond.
bool SegmentProblem::CrossesBorderAt(const BorderNodes *border, Vec3 tip, Index column) const
{
  column[Dim() - 1] = Locate(grid_, tip).cell[Dim() - 1];
  return border && border->BlendOf(column).beta == 0;
}

void SegmentProblem::SumColumns()
{
  columns_.clear(), column_number_.clear();
  for (const Segment &segment : segments_) {
    ForEachColumn(grid_, segment.place, [&](std::int64_t key, Index at, double hat) {
      const auto [found, is_new] = column_number_.try_emplace(key, static_cast<int>(columns_.size()));
      if (is_new) columns_.push_back({key, at});
      SurfaceColumn &column = columns_[found->second];
      column.surface += hat * segment.area;
      column.pressable += hat * segment.pressed;
      column.projected -= hat * segment.pressed * segment.normal[Dim() - 1];
    });
  }
}

/// The nodes of a cell, -1 for those that do not move.
const std::array<int, 8> &SegmentProblem::NodesOfCell(Index cell)
{
  const auto [found, is_new] = cell_nodes_.try_emplace(cell);
  for (int c = 0; is_new && c < 1 << Dim(); ++c) {
    const int number = nodes_->NumberOf(Corner(cell, c));
    found->second[c] = number >= 0 && nodes_->At(number).moves ? number : -1;
  }
  return found->second;
}

/// The nodes that move the corners of its patch, with their weights in it; false where none does.
bool SegmentProblem::FindWeights(const Segment &segment, Candidate *one)
{
  constexpr double kNothing = 1e-9; // rounding: of a hat: a corner on a line of nodes but for rounding pushes none beyond
  std::array<NodeWeight, 32> found; // in the order of nodes
  int count = 0;
  for (int c = 0; c < OnColumns(); ++c) {
    const CellPlace place = Locate(grid_, segment.corner[c]);
    const std::array<int, 8> &numbers = NodesOfCell(place.cell);
    const std::array<double, 8> hats = Hats(place.part, Dim());
    const auto counts = [&](int n) { return numbers[n] >= 0 && hats[n] > kNothing; };
    double sum = 0;
    for (int n = 0; n < 1 << Dim(); ++n) sum += counts(n) ? hats[n] : 0;
    for (int n = 0; n < 1 << Dim(); ++n) {
      if (!counts(n)) continue;
      int at = count;
      while (at > 0 && found[at - 1].node >= numbers[n]) --at;
      if (at == count || found[at].node != numbers[n]) {
        std::copy_backward(found.begin() + at, found.begin() + count, found.begin() + count + 1);
        found[at] = {numbers[n], 0}, ++count;
      }
      found[at].weight += hats[n] * segment.corner_part[c] / sum;
    }
  }
  one->first = static_cast<int>(weights_.size());
  weights_.insert(weights_.end(), found.begin(), found.begin() + count);
  one->end = static_cast<int>(weights_.size());
  return count > 0;
}

/// What creeps flows at any pressure: in the mean at that which the contact had in the last step.
void SegmentProblem::FindCreepPressure(const ColumnNumbers &before)
{
  double load = 0, area = 0;
  for (const SurfaceColumn &column : columns_)
    if (const auto found = before.find(column.key); found != before.end())
      load += column.surface * found->second, area += column.surface;
  for (Segment &segment : segments_)
    if (segment.flow == 0) segment.flow = load > 0 ? load / area : HUGE_VAL;
}

void SegmentProblem::AddCandidates(const ColumnNumbers &before)
{
  candidates_.clear(), weights_.clear();
  gaps_.clear(), closing_.clear(), start_.clear();
  for (std::size_t k = 0; k < segments_.size(); ++k) {
    const Segment &segment = segments_[k];
    if (segment.pressed == 0 || segment.gap > kCandidateGap * grid_.spacing) continue;
    Candidate one{};
    one.segment = static_cast<int>(k);
    one.root_area = std::sqrt(segment.pressed);
    one.normal = segment.normal;
    double mean = 0;
    if (!FindWeights(segment, &one)) continue;
    Vec3 velocity{};
    for (int n = one.first; n < one.end; ++n) velocity = velocity + weights_[n].weight * nodes_->At(weights_[n].node).velocity;
    int c = 0;
    ForEachColumn(grid_, segment.place, [&](std::int64_t key, Index, double hat) {
      one.column[c] = column_number_.at(key);
      one.hat[c++] = hat;
      if (const auto found = before.find(key); found != before.end()) mean += hat * found->second;
    });
    gaps_.push_back(one.root_area * (segment.gap + segment.offset + dt_ * Dot(segment.normal, velocity)));
    closing_.push_back(-one.root_area * segment.normal[Dim() - 1]);
    start_.push_back(one.root_area * mean);
    candidates_.push_back(one);
  }
}

/// c = kInPlane or kInSpace h/E*, c_p = kBack h/flow.
void SegmentProblem::SetCompliance(GeometryKind geometry)
{
  const double elastic = geometry == GeometryKind::kPlaneStrain ? kInPlane : kInSpace;
  for (Candidate &one : candidates_) {
    const Segment &segment = segments_[one.segment];
    one.beside = 1;
    for (int n = 0; n < OnColumns(); ++n) {
      const SurfaceColumn &column = columns_[one.column[n]];
      one.beside -= one.hat[n] * column.pressable / column.surface;
    }
    one.root_c = std::sqrt(grid_.spacing * elastic / segment.modulus);
    one.back = std::isfinite(segment.flow) ? kBack * grid_.spacing / segment.flow : 0;
  }
}

void SegmentProblem::Build(const GridGeometry &grid, GeometryKind geometry, double dt, const ContactNodes &nodes,
                           std::vector<Segment> segments, const ColumnNumbers &before, const ColumnNumbers &strains,
                           const std::vector<PatchState> &last)
{
  grid_ = grid;
  dt_ = dt;
  nodes_ = &nodes;
  cell_nodes_.clear();
  segments_ = std::move(segments);
  SumColumns();
  FindCreepPressure(before);
  AddCandidates(before);
  SetCompliance(geometry);
  SetFlow(strains);
  StartFrom(last);
  gaps_without_friction_ = gaps_;
  scratch_.moved.resize(nodes_->Size());
}

void SegmentProblem::StartFrom(const std::vector<PatchState> &last)
{
  auto next = last.begin();
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Segment &segment = segments_[candidates_[k].segment];
    const auto key = std::tie(segment.patch, segment.path);
    while (next != last.end() && std::tie(next->patch, next->path) < key) ++next;
    const bool known = next != last.end() && std::tie(next->patch, next->path) == key;
    if (!known || !std::isfinite(next->pressure)) continue;
    start_[k] = candidates_[k].root_area * next->pressure;
    candidates_[k].traction_before = next->traction;
  }
}

std::vector<PatchState> SegmentProblem::StatesOf(const std::vector<double> &q) const
{
  std::vector<PatchState> states;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Segment &segment = segments_[candidates_[k].segment];
    states.push_back({segment.patch, segment.path, q[k] / candidates_[k].root_area, {}});
  }
  return states;
}

/// dw = kappa h ((p - Pi p) - w/c_p)/flow deps, with the mean of w over the step's end: beta (c_p (p - Pi p) - w) with
/// beta = 1 - exp(-kappa h deps/(flow c_p)), a compliance in the step beside the elastic one. Strain is greater within a cell of
/// an indenter's edge, about as one over the distance from it, than the points under a column have it.
void SegmentProblem::SetFlow(const ColumnNumbers &strains)
{
  constexpr double kMoreAtEdge = 16;
  flows_step_ = false;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    Candidate &one = candidates_[k];
    const Segment &segment = segments_[one.segment];
    double strain = 0;
    for (int n = 0; n < OnColumns(); ++n)
      if (const auto found = strains.find(columns_[one.column[n]].key); found != strains.end())
        strain += one.hat[n] * found->second;
    if (one.back == 0 || strain == 0) continue;
    one.relaxes = -std::expm1(-kRate * grid_.spacing / segment.flow * strain * (1 + kMoreAtEdge * one.beside) / one.back);
    one.root_flow = std::sqrt(one.relaxes * one.back);
    gaps_[k] -= one.root_area * one.relaxes * segment.offset;
    flows_step_ = true;
  }
}

/// Of each column sum_s H_j sqrt(w_s) root_s q_s over its surface.
void SegmentProblem::SumMeans(const double *q, double Candidate::*root, std::vector<double> *means) const
{
  means->assign(columns_.size(), 0.0);
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate &one = candidates_[k];
    const double weighted = one.*root * one.root_area * q[k];
    for (int c = 0; c < OnColumns(); ++c) (*means)[one.column[c]] += one.hat[c] * weighted;
  }
  for (std::size_t j = 0; j < columns_.size(); ++j) (*means)[j] /= columns_[j].surface;
}

void SegmentProblem::Spread(const std::vector<Vec3> &forces, std::vector<Vec3> *on_nodes) const
{
  on_nodes->assign(nodes_->Size(), {});
  for (std::size_t k = 0; k < candidates_.size(); ++k) AddTo(candidates_[k], forces[k], on_nodes);
}

std::vector<Vec3> SegmentProblem::MotionOf(const std::vector<Vec3> &nodes) const
{
  std::vector<Vec3> motion(candidates_.size());
  for (std::size_t k = 0; k < candidates_.size(); ++k) motion[k] = SumOver(candidates_[k], nodes);
  return motion;
}

std::vector<Vec3> SegmentProblem::MotionBefore() const
{
  std::vector<Vec3> nodes(nodes_->Size());
  for (int k = 0; k < nodes_->Size(); ++k) nodes[k] = dt_ * nodes_->At(k).velocity;
  return MotionOf(nodes);
}

std::vector<double> SegmentProblem::YieldTo(const std::vector<double> &tractions, const std::vector<char> &odd) const
{
  std::vector<double> means, yields(candidates_.size());
  SumMeans(tractions.data(), &Candidate::root_c, &means);
  for (std::size_t j = 0; j < means.size(); ++j)
    if (odd[j]) means[j] = 0;
  for (std::size_t k = 0; k < candidates_.size(); ++k)
    yields[k] = BeyondColumns(candidates_[k], tractions[k], candidates_[k].root_c, means);
  return yields;
}

void SegmentProblem::SetFriction(const std::vector<Vec3> &nodes)
{
  const std::vector<Vec3> motion = MotionOf(nodes);
  for (std::size_t k = 0; k < candidates_.size(); ++k)
    gaps_[k] = gaps_without_friction_[k] + candidates_[k].root_area * Dot(candidates_[k].normal, motion[k]);
}

void SegmentProblem::Multiply(const double *q, double *y) const
{
  std::fill(scratch_.moved.begin(), scratch_.moved.end(), Vec3{});
  for (std::size_t k = 0; k < candidates_.size(); ++k)
    if (q[k] != 0) AddTo(candidates_[k], candidates_[k].root_area * q[k] * candidates_[k].normal, &scratch_.moved);
  nodes_->Move(dt_, &scratch_.moved);
  SumMeans(q, &Candidate::root_c, &scratch_.means);
  if (flows_step_) SumMeans(q, &Candidate::root_flow, &scratch_.flow_means);
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate &one = candidates_[k];
    y[k] = one.root_area * Dot(one.normal, SumOver(one, scratch_.moved)) + BeyondColumns(one, q[k], one.root_c, scratch_.means);
    if (flows_step_) y[k] += BeyondColumns(one, q[k], one.root_flow, scratch_.flow_means);
  }
}

void SegmentProblem::Diagonal(double *diagonal) const
{
  const std::vector<Vec3> mobility = nodes_->Mobility(dt_);
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate &one = candidates_[k];
    const double area = one.Area(), c = one.Compliance() + one.root_flow * one.root_flow;
    double moves = 0, shown = 0;
    for (int n = one.first; n < one.end; ++n)
      for (int a = 0; a < Dim(); ++a)
        moves += weights_[n].weight * weights_[n].weight * one.normal[a] * one.normal[a] * mobility[weights_[n].node][a];
    for (int n = 0; n < OnColumns(); ++n) shown += one.hat[n] * one.hat[n] / columns_[one.column[n]].surface;
    diagonal[k] = area * moves + c * (1 - area * shown);
  }
}

SegmentSolution SegmentProblem::SolutionOf(const std::vector<double> &q, const BorderNodes *border, Vec3 tip, double travel) const
{
  SegmentSolution solution;
  AddLoads(q, &solution);
  MeasureColumns(border, tip, &solution);
  MeasureSegments(q, travel, &solution);
  return solution;
}

/// What pressures give nodes, segments and columns.
void SegmentProblem::AddLoads(const std::vector<double> &q, SegmentSolution *solution) const
{
  std::int64_t last = -1;
  solution->impulses.assign(nodes_->Size(), {}), solution->columns.resize(columns_.size());
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate &one = candidates_[k];
    const double force = one.Force(q[k]);
    if (force <= 0) continue;
    const Segment &segment = segments_[one.segment];
    AddTo(one, (force * dt_) * one.normal, &solution->impulses);
    solution->loads.push_back({one.segment, -force * segment.normal[Dim() - 1]});
    for (int c = 0; c < OnColumns(); ++c) {
      SegmentSolution::Column &column = solution->columns[one.column[c]];
      column.mean += one.hat[c] * force;
      column.touching += one.hat[c] * segment.pressed;
      column.load -= one.hat[c] * force * segment.normal[Dim() - 1];
    }
    if (segment.patch != last) ++solution->shape.points;
    last = segment.patch;
  }
  nodes_->Restrict(&solution->impulses);
  for (std::size_t j = 0; j < columns_.size(); ++j) solution->columns[j].mean /= columns_[j].surface;
}

/// The footprint as loaded columns show it.
void SegmentProblem::MeasureColumns(const BorderNodes *border, Vec3 tip, SegmentSolution *solution) const
{
  SegmentSolution::Footprint &shape = solution->shape;
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const SurfaceColumn &column = columns_[j];
    const double load = solution->columns[j].load;
    if (load <= 0) continue;
    shape.crosses_border = shape.crosses_border || CrossesBorderAt(border, tip, column.at);
    if (column.projected > 0) shape.peak = std::max(shape.peak, load / column.projected);
    for (int a = 0; a < Dim() - 1; ++a) shape.reach = std::max(shape.reach, std::abs(grid_.Coordinate(a, column.at[a]) - tip[a]));
  }
}

/// The area, energies and flow of segments.
void SegmentProblem::MeasureSegments(const std::vector<double> &q, double travel, SegmentSolution *solution) const
{
  // Share of a segment's own in its column's pressure where contact ends; with 0.5 half widths are 0.1 cells short.
  constexpr double kEdge = 0.1;
  SegmentSolution::Footprint &shape = solution->shape;
  std::vector<double> aq(q.size());
  Multiply(q.data(), aq.data());
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate &one = candidates_[k];
    const double area = one.Area(), c = one.Compliance(), p = q[k] / one.root_area, offset = segments_[one.segment].offset;
    if (one.relaxes > 0) {
      solution->flows.push_back(
          {one.segment, BeyondColumns(one, q[k], one.root_flow, scratch_.flow_means) / one.root_area - one.relaxes * offset});
      shape.flow_work += area * p * solution->flows.back().by;
    }
    if (one.back > 0) shape.stored += 0.5 * area * offset * offset / one.back;
    double mean = 0, touching = 0;
    for (int n = 0; n < OnColumns(); ++n) {
      const SegmentSolution::Column &column = solution->columns[one.column[n]];
      mean += one.hat[n] * column.mean, touching += one.hat[n] * column.touching / columns_[one.column[n]].pressable;
    }
    if (mean <= 0) continue;
    // g_end = (A q + gaps - u closing)/sqrt(w) - c (p - mean)
    const double slack = (aq[k] + gaps_[k] - travel * closing_[k]) / one.root_area, gap_end = slack - c * (p - mean);
    const double at_edge = std::clamp(2 * (1 - gap_end / (c * mean)) - 2 * kEdge + 0.5, 0.0, 1.0),
                 share = touching < 1 - 1e-6 ? at_edge : 1;
    shape.area -= share * area * segments_[one.segment].ring * one.normal[Dim() - 1];
    shape.stored += 0.5 * c * area * p * (p - mean);
  }
}

} // namespace mlgimp
