// The surface of bodies in patches that belong to no point: lines in the plane, quadrilaterals in space.
#pragma once

#include "base/tensor.hpp"
#include "grid/grid.hpp"
#include "grid/nodes.hpp"
#include "physics/indenter.hpp"
#include "points/points.hpp"
#include "surface/near_points.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mlgimp
{

/// A patch; its corners go round so that the outward normal is (e_y, -e_x) of the edge from the first to the second in the plane,
/// and that of a right-handed turn in space.
struct SurfacePatch {
  std::int64_t number; ///< of the patch at the start that it is part of
  std::int64_t path;   ///< which part: 1 is the whole, those of part k are 2 k and 2 k + 1
  int body;
  Vec3 corner[4]; ///< m; two in the plane
  double ring;    ///< radius of the face that it is part of over its own, which areas are taken at; 1 without an axis
  double flow;    ///< how far it has flowed out of the line of its corners along the indenter's normal, m

  bool operator<(const SurfacePatch &other) const { return number != other.number ? number < other.number : path < other.path; }
  Vec3 Center(int dim) const
  {
    return dim == 2 ? 0.5 * (corner[0] + corner[1]) : 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]);
  }
};

/// The weights of a patch's corners at a place in it, from 0 to 1 along its edges from the first corner.
inline std::array<double, 4> CornerWeights(double s, double t, int dim)
{
  if (dim == 2) return {1 - s, s};
  return {(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t};
}

/// A corner that patches of a body share.
struct SurfaceCorner {
  Vec3 x; ///< m
  int body;
  SurfaceGap gap; ///< to the indenter; see Surface::Approach
};

/// The patches that lie in a level's part of the domain, on the ranks that own the nodes nearest to their centres.
class Surface
{
public:
  void Add(const SurfacePatch &patch) { patches_.push_back(patch); }
  /// Finds which patches share corners. Call after patches have come, gone or been halved.
  void NumberCorners(int dim);
  const std::vector<SurfaceCorner> &Corners() const { return corners_; }
  const SurfaceCorner &CornerOf(std::size_t patch, std::size_t corner) const
  {
    return corners_[number_[per_patch_ * patch + corner]];
  }
  /// Finds the gaps of corners to the indenter with its tip at a place. Where they are more than a range, m, the distance may be
  /// less than the true one, though more than the range, and the normal any.
  void Approach(const Indenter &indenter, Vec3 tip, double range);
  /// Of corners in their order.
  struct CornerMotion {
    double by_nodes;      ///< the part of it that goes with the nodes
    NearPoints::Sum sums; ///< where the points take it
  };
  /// Moves corners by f u + (1 - f) (what points do): with the motion of the nodes, hats over those that have one,
  /// u = dt sum_i N_i v_i/sum_i N_i, with v the second velocity for bodies whose points are strained by it, by their number, else
  /// the new one. Where no point is near, f = 1. Corners at sides stay there.
  void Move(const Grid &grid, const BoundaryConditions &sides, const std::vector<char> &by_rates,
            const std::vector<CornerMotion> &motion, double mass_cutoff, double dt);
  /// Halves what is longer than it may be, the less the nearer it is to the indenter with its tip there. Halves of what touches
  /// touch as it does, by their flow: a tilted one would fall into the indenter, and make work. h: of the grid, m.
  void Split(const Geometry &geometry, const Indenter &indenter, Vec3 tip, double h);

  const std::vector<SurfacePatch> &Patches() const { return patches_; }
  std::vector<SurfacePatch> &Patches() { return patches_; }

private:
  std::vector<SurfacePatch> patches_;
  std::vector<SurfaceCorner> corners_;
  std::vector<int> number_; ///< of a corner, [patches][per_patch_]
  std::size_t per_patch_ = 2;
  Vec3 tip_{}; ///< to which the gaps are, m
};

} // namespace mlgimp
