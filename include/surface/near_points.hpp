// Points beside the surface, and how they move in a step: where contact does not press all around, the surface goes with them.
#pragma once

#include "grid/grid.hpp"
#include "physics/region.hpp"
#include "points/points.hpp"

#include <vector>

namespace mlgimp
{

/// The place x of a body's surface goes to sum_p W_p (x_p' + F_p' F_p^-1 (x - x_p))/sum_p W_p, from x_p and F_p to x_p' and F_p',
/// with the weights W_p = m_p (1 - |x - x_p|^2/h^2)^3 of the body's points within a cell.
class NearPoints
{
public:
  struct Place {
    Vec3 x; ///< m
    int body;
  };
  /// Where a place goes: the sums above.
  struct Sum {
    Vec3 weighted{};
    double weight = 0; ///< 0 where no point is near
  };

  /// Before points move: keeps those near some places of this rank or of its neighbours. path: a
  /// bound of how far points have moved since any time, m. Collective on the grid's ranks.
  PetscErrorCode Begin(Grid &grid, const std::vector<Place> &places, Points &points, double path);
  /// After it: where they go, in their order. The points must be stored as they were. Collective on the grid's ranks.
  PetscErrorCode Finish(Grid &grid, const PointArrays &points, std::vector<Sum> *sums);

private:
  struct Moved {
    int point, next; ///< of its cell, or -1
    int body;
    double mass;
    Vec3 from, to;
    std::array<double, 9> F; ///< first before the step, then what turns and stretches its surroundings in it
  };
  void Mark(const NodePartition &nodes, Vec3 x);
  void FindAround(const GridGeometry &grid, Points &points, double path);
  Sum SumAt(const NodePartition &nodes, const Place &place) const;

  std::vector<Place> places_; ///< of this rank, then of its neighbours in their order
  std::size_t own_ = 0;
  std::vector<std::vector<std::size_t>> asked_; ///< own places that each neighbour was sent
  std::vector<std::size_t> of_neighbour_;       ///< number of places that each has sent
  std::vector<int> first_; ///< of each cell by the place of its lowest node: in moved_, or -1; -2 of no interest
  std::vector<std::ptrdiff_t> marked_;
  std::vector<Moved> moved_;
  std::vector<int> around_; ///< points that may be in a box, in their order
  Box box_{};
  double path_ = 0;  ///< up to which they are known, m
  long version_ = 0; ///< of the points
};

} // namespace mlgimp
