// How corners of the surface move in a step: with the nodes where contact presses, as the points around them go elsewhere.
#pragma once

#include "physics/body_table.hpp"
#include "surface/near_points.hpp"
#include "surface/surface.hpp"

#include <unordered_map>
#include <vector>

namespace mlgimp
{

/// A column of the grid and the share of its surface that presses.
struct PressedColumn {
  std::int64_t key;
  double share;
};

class SurfaceMotion
{
public:
  /// Before contact: nothing presses yet in the step.
  void Begin() { pressed_.clear(); }
  /// The columns in which contact presses in the step.
  void SetPressed(const std::vector<PressedColumn> &columns)
  {
    for (const PressedColumn &one : columns) pressed_[one.key] = one.share;
  }
  /// Before points move: finds the part of each corner that goes with the nodes, and keeps the points around the others. path: a
  /// bound of how far points have moved since any time, m. Collective on the grid's ranks.
  PetscErrorCode Prepare(Grid &grid, const Surface &surface, const BodyTable &bodies, Points &points, double path);
  /// The same where the indenter is out of reach: all go with the nodes.
  void PrepareFar(const Surface &surface);
  /// After points have moved: moves the corners. by_rates: of bodies, see Surface::Move. Collective on the grid's ranks.
  PetscErrorCode Finish(Grid &grid, const BoundaryConditions &sides, const PointArrays &points, const std::vector<char> &by_rates,
                        double mass_cutoff, double dt, Surface *surface);

private:
  double PartOfNodes(const GridGeometry &grid, const SurfaceCorner &corner, bool flows) const;

  NearPoints near_;
  bool near_indenter_ = false;
  std::vector<Surface::CornerMotion> corners_;
  std::unordered_map<std::int64_t, double> pressed_; ///< shares of PressedColumn by key
};

} // namespace mlgimp
