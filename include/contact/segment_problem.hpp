// The pressures of segments as a problem with bounds, on one rank.
//
//   g_s + dt n_s . v(x_s) + c (p - Pi p)_s >= 0,  p_s >= 0,  one of them zero for each segment s
//   v_i = v_i^0 + (dt/m_i) sum_s w_s p_s N_i(x_s) n_s,      v(x_s) = sum_i N_i(x_s) v_i
//   (Pi p)(x) = sum_j H_j(x) L_j,  L_j = sum_s H_j w_s p_s/sum_s H_j w_s     over the columns j of the grid, hats H_j
//
// c is the compliance of what lies between the nodes. With q = sqrt(w) p the problem has the symmetric, positive operator
//   A = sqrt(c) (1 - sqrt(w) Pi 1/sqrt(w)) sqrt(c) + dt^2 B M^-1 B^T,  B_si = sqrt(w_s) N_i(x_s) n_s.
#pragma once

#include "contact/contact_nodes.hpp"
#include "contact/pressure_problem.hpp"
#include "contact/segments.hpp"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// What a column of the grid has of the surface.
struct SurfaceColumn {
  std::int64_t key;
  Index at;
  double surface = 0;   ///< sum_s H_j w_s over all surface, also what is not pressed, m2
  double projected = 0; ///< the same of the projection of what may be pressed on the plane normal to the axis, m2
  double pressable = 0; ///< the same over what may be pressed, m2
};

/// A number of columns, by their keys.
using ColumnNumbers = std::unordered_map<std::int64_t, double>;

/// What a patch leaves to the next step.
struct PatchState {
  std::int64_t patch;
  std::int64_t path;
  double pressure;                ///< Pa
  std::array<double, 2> traction; ///< along the indenter's tangents, Pa
};

/// What pressures on segments do in a step.
struct SegmentSolution {
  /// What presses a segment along the axis, N.
  struct Load {
    int segment;
    double force;
  };
  /// What the surface of a segment flows by in the step, m.
  struct Flow {
    int segment;
    double by;
  };
  struct Column {
    double touching = 0; ///< sum_s H_j w_s over what has a pressure, m2
    double load = 0;     ///< along the axis, N
    double mean = 0;     ///< L_j, Pa
  };
  struct Footprint {
    double area = 0;             ///< projected, m2
    double stored = 0;           ///< energy of the compliance, J
    double flow_work = 0;        ///< of pressures on what flows, J
    double peak = 0;             ///< largest mean pressure of a column, Pa
    double reach = 0;            ///< from the tip to the farthest loaded column along a horizontal axis, m
    bool crosses_border = false; ///< a loaded column is at the border to the coarser level, or beyond
    int points = 0;              ///< patches with a segment under pressure
  };
  std::vector<Load> loads;
  std::vector<Flow> flows;
  std::vector<Vec3> impulses;  ///< [nodes], N s
  std::vector<Column> columns; ///< in the order of the problem's
  Footprint shape;
};

/// The problem of the pressures on segments.
class SegmentProblem : public PressureProblem
{
public:
  /// A segment that may touch.
  struct Candidate {
    int segment;
    double root_area, root_c, root_flow; ///< roots of w_s, of the compliance c and of what flow adds to it in the step
    double beside;                       ///< share of its columns' surface that an edge of the indenter leaves free
    double back;                         ///< c_p: offset over the pressure that holds it, m/Pa; 0 of what does not flow
    double relaxes;                      ///< the part of the way to what the pressure holds that it flows in the step
    Vec3 normal;
    int first, end; ///< of the nodes that move it
    int column[4];
    double hat[4];
    std::array<double, 2> traction_before; ///< along the indenter's tangents, in the last step, Pa
    /// w_s p_s, N.
    double Force(double q) const { return root_area * q; }
    double Area() const { return root_area * root_area; }
    double Compliance() const { return root_c * root_c; }
  };

  /// From segments in their order and the nodes that they push, which must stay. before: L_j of the last step; strains: that
  /// points under columns have flowed in it; last: what patches had in it, in the order of segments.
  void Build(const GridGeometry &grid, GeometryKind geometry, double dt, const ContactNodes &nodes, std::vector<Segment> segments,
             const ColumnNumbers &before, const ColumnNumbers &strains, const std::vector<PatchState> &last);

  int Size() const override { return static_cast<int>(candidates_.size()); }
  void Multiply(const double *q, double *y) const override;
  void Diagonal(double *diagonal) const override;
  /// q of the last step's pressures, those of columns on patches that had none.
  const std::vector<double> &Start() const { return start_; }
  /// What a solution leaves to the next step, without tractions.
  std::vector<PatchState> StatesOf(const std::vector<double> &q) const;

  /// What pressures do in the step. border: to the next coarser level, or null; tip: at the start of the step, m; travel: of a
  /// free tip, m.
  SegmentSolution SolutionOf(const std::vector<double> &q, const BorderNodes *border, Vec3 tip, double travel) const;
  const std::vector<Segment> &Segments() const { return segments_; }
  const std::vector<SurfaceColumn> &Columns() const { return columns_; }
  const ContactNodes &Nodes() const { return *nodes_; }
  /// A segment that may touch.
  const Candidate &CandidateAt(int k) const { return candidates_[k]; }

  // For friction.
  /// Forces on candidates as forces on nodes; what they move in the step, dt^2 M^-1; and how candidates move with nodes, m.
  void Spread(const std::vector<Vec3> &forces, std::vector<Vec3> *on_nodes) const;
  void Move(std::vector<Vec3> *nodes) const { nodes_->Move(dt_, nodes); }
  std::vector<Vec3> MotionOf(const std::vector<Vec3> &nodes) const;
  /// How they move in the step before contact, m.
  std::vector<Vec3> MotionBefore() const;
  /// How they yield between the nodes to tractions t along a tangent, c (t - Pi t), both times the roots of areas. odd: the
  /// columns in which the tractions of both halves at a side take each other off.
  std::vector<double> YieldTo(const std::vector<double> &tractions, const std::vector<char> &odd) const;
  /// Replaces what friction moves nodes by, of which the gaps have a part, m.
  void SetFriction(const std::vector<Vec3> &nodes);

private:
  int Dim() const { return grid_.dim; }
  /// Columns around a segment.
  int OnColumns() const { return 1 << (grid_.dim - 1); }
  struct NodeWeight {
    int node;
    double weight;
  };
  /// Of what a candidate's nodes have, by their weights.
  Vec3 SumOver(const Candidate &one, const std::vector<Vec3> &nodes) const
  {
    Vec3 sum{};
    for (int n = one.first; n < one.end; ++n) sum = sum + weights_[n].weight * nodes[weights_[n].node];
    return sum;
  }
  void AddTo(const Candidate &one, Vec3 value, std::vector<Vec3> *nodes) const
  {
    for (int n = one.first; n < one.end; ++n)
      (*nodes)[weights_[n].node] = (*nodes)[weights_[n].node] + weights_[n].weight * value;
  }
  const std::array<int, 8> &NodesOfCell(Index cell);
  bool FindWeights(const Segment &segment, Candidate *one);
  void SumColumns();
  void FindCreepPressure(const ColumnNumbers &before);
  void AddCandidates(const ColumnNumbers &before);
  void SetCompliance(GeometryKind geometry);
  void AddLoads(const std::vector<double> &q, SegmentSolution *solution) const;
  void MeasureColumns(const BorderNodes *border, Vec3 tip, SegmentSolution *solution) const;
  void MeasureSegments(const std::vector<double> &q, double travel, SegmentSolution *solution) const;
  bool CrossesBorderAt(const BorderNodes *border, Vec3 tip, Index column) const;
  void SetFlow(const ColumnNumbers &strains);
  void StartFrom(const std::vector<PatchState> &last);
  void SumMeans(const double *q, double Candidate::*root, std::vector<double> *means) const;
  /// root (root q - Pi root q) of a candidate, with the means that SumMeans has found.
  double BeyondColumns(const Candidate &one, double q, double root, const std::vector<double> &means) const
  {
    double mean = 0;
    for (int c = 0; c < OnColumns(); ++c) mean += one.hat[c] * means[one.column[c]];
    return root * (root * q - one.root_area * mean);
  }

  bool flows_step_ = false; ///< some surface flows in the step
  double dt_ = 0;           ///< of the step, s
  GridGeometry grid_{};
  const ContactNodes *nodes_ = nullptr;
  std::vector<SurfaceColumn> columns_;
  std::unordered_map<std::int64_t, int> column_number_;
  std::vector<Segment> segments_;
  std::vector<Candidate> candidates_;
  std::vector<NodeWeight> weights_;
  std::unordered_map<Index, std::array<int, 8>, IndexHash> cell_nodes_;
  std::vector<double> gaps_without_friction_, start_;
  struct Scratch {
    std::vector<Vec3> moved;               ///< [nodes]
    std::vector<double> means, flow_means; ///< [columns]
  };
  mutable Scratch scratch_; ///< of Multiply
};

} // namespace mlgimp
