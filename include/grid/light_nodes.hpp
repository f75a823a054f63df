// Nodes with little mass, at the surface of bodies, hang on fuller ones: an extended basis (Hoellig, Reif and Wipper 2001).
//
// The motion of a light node i is v_i = s_i u_i + (1 - s_i) sum_k e_ik v_k, with s_i = smoothstep(m_i/(theta m_full)) and e_ik
// the linear least squares fit at i over fuller nodes k around it. What points give to nodes goes to these by the transpose, x_k
// + sum_i (1 - s_i) e_ik x_i and s_i x_i for x = m, p, f. As sum_k e_ik = 1, momentum and mass are kept, and linear motions are
// as they were. Without it the velocity f/m of a node that few points have reached has no bound.
#pragma once

#include "grid/grid.hpp"
#include "grid/node_bodies.hpp"
#include "grid/nodes.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace mlgimp
{

class LightNodes
{
public:
  /// Of nodes with less than this part of a full node's mass the motion is not their own alone.
  static constexpr double kLight = 0.05;

  static constexpr int kReach = 2;         ///< cells to what they hang on
  static constexpr double kWithFiner = -1; ///< size; in place of a share: of nodes that move with the next finer level's
  /// For a grid. shares: by place, of the nodes' motion that is their own level's. Where that is nothing, they are never light;
  /// where it is a part, they hang on nodes with the same part, so that the level's sums and the part's go together.
  void Create(const Grid &grid, const BoundaryConditions &sides, const NodalSettings &settings, bool hoop,
              std::vector<double> shares);

  /// Finds the light ones among the nodes that this rank owns from their sums, of which all ghosts must be known.
  /// more: by place, mass that nodes have beside, kg, infinite of those of which it is not known: they are not light, and nothing
  /// hangs on them. None where it is null. bodies: nodes of different ones do not hang on each other.
  void Find(const Grid &grid, const NodeBodies &bodies, const double *more = nullptr);
  bool IsLight(std::ptrdiff_t place) const { return tables_.light[place] >= 0; }

  /// From points' sums to those of the motion: in place on nodes [ghosted nodes][size], also on ghosts. Collective on the grid's
  /// ranks.
  PetscErrorCode Restrict(HaloExchange &halo, double *values, std::ptrdiff_t size) const;
  /// From the motion of fuller nodes to that of light ones, likewise.
  PetscErrorCode Prolong(HaloExchange &halo, double *values, std::ptrdiff_t size) const;

  /// Calls work(place, weight) for the nodes that an owned node's motion hangs on, itself among them.
  template <class Work> void ForEachDonor(std::ptrdiff_t place, Work work) const
  {
    if (!IsLight(place)) return work(place, 1.0);
    const Light &light = lights_[tables_.light[place]];
    work(place, light.own);
    for (int d = light.first; d < light.end; ++d) work(donors_[d].place, donors_[d].weight);
  }

private:
  /// A node around a light one.
  struct Around {
    Index offset;
    std::ptrdiff_t step; ///< to its place
    double nearness;
  };
  /// One of them that is fuller: its number, its weight in a mean of them, and what a linear fit adds to that.
  struct Near {
    int number;
    double even, slope;
  };
  using FullPattern = std::array<std::uint64_t, 2>; ///< a bit for each node around that is full
  struct PatternHash {
    std::size_t operator()(const FullPattern &full) const
    {
      return full[0] * 0x9e3779b97f4a7c15ULL ^ full[1] * 0xc2b2ae3d27d4eb4fULL;
    }
  };
  struct Light {
    std::ptrdiff_t place;
    double own; ///< s_j
    int first, end;
  };
  struct Donor {
    double weight;     ///< (1 - s_j) e_ij
    int place, target; ///< of the node, and its number among targets_
  };
  /// A node of which another rank has a copy.
  struct Copy {
    int number;           ///< of a target or of a light node
    std::size_t rank;     ///< of the grid's neighbours
    std::ptrdiff_t place; ///< there
  };
  double FullMass(const Grid &grid, Index node) const;
  double MassAt(const Grid &grid, std::ptrdiff_t place) const { return grid.Sums()[place].mass + (more_ ? more_[place] : 0); }
  void AddLight(const Grid &grid, const NodeBodies &bodies, Index node, double mass);
  void FindDonors(const Grid &grid, const NodeBodies &bodies, Index node, Light *light);
  void KeepJoined(std::vector<Near> *nodes) const;
  void FitLinear(std::vector<Near> *nodes, int dim) const;
  int Target(const Grid &grid, std::ptrdiff_t place, Index node);

  /// What makes a node light.
  struct Rule {
    double full_mass = 0, cutoff = 0; ///< of a full node; what is less is empty, kg
    bool hoop = false;                ///< nodes near an axis have less
    BoundaryConditions sides;
  } rule_;
  /// By place in the ghosted arrays.
  struct Tables {
    std::vector<double> limit, shares;   ///< mass below which nodes are light, kg; see Create
    std::vector<unsigned char> at_sides; ///< a bit for each side that the node is at or beyond
    std::vector<int> light, target;      ///< its number among lights_ and among targets_, or -1
  } tables_;
  /// The linear fits so far, which many nodes have in common.
  struct Fits {
    std::vector<Around> around;
    std::vector<Near> near;
    std::unordered_map<FullPattern, std::vector<Near>, PatternHash> known;
  } fits_;
  const double *more_ = nullptr; ///< see Find
  std::vector<Light> lights_;
  std::vector<Donor> donors_;
  std::vector<std::ptrdiff_t> targets_; ///< nodes that get something in Restrict
  std::vector<Copy> target_copies_, light_copies_;
  mutable std::vector<double> given_; ///< [targets][size]
};

} // namespace mlgimp
