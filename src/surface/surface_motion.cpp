// The law by which corners of the surface move.
#include "surface/surface_motion.hpp"

#include "base/tensor.hpp"
#include "grid/cell_place.hpp"
#include "surface/pieces.hpp"

namespace mlgimp
{

/// The part of the motion of a corner that goes with the nodes: where contact presses they are in balance with the forces in the
/// body on any line of nodes, and points are not; in bodies that flow where most of the surface presses, as the crest beside a
/// steep tip, where few points are, runs away with them.
double SurfaceMotion::PartOfNodes(const GridGeometry &grid, const SurfaceCorner &corner, bool flows) const
{
  constexpr double kMinShare = 0.25, kFadeRange = 0.25; // share of the surface; cells off the indenter
  if (pressed_.empty()) return 0;
  const double off = corner.gap.distance / (kFadeRange * grid.spacing);
  if (off >= 1 || !flows) return 1 - SmoothStep(off);
  double share = 0;
  ForEachColumn(grid, Locate(grid, corner.x), [&](std::int64_t key, Index, double hat) {
    if (const auto found = pressed_.find(key); found != pressed_.end()) share += hat * found->second;
  });
  return SmoothStep((share - kMinShare) / (1 - kMinShare)) * (1 - SmoothStep(off));
}

PetscErrorCode SurfaceMotion::Prepare(Grid &grid, const Surface &surface, const BodyTable &bodies, Points &points, double path)
{
  const double range = kContactRange * grid.Geometry().spacing; // no segment is beyond it, and nodes and points move alike
  std::vector<NearPoints::Place> places;
  PetscFunctionBeginUser;
  PrepareFar(surface);
  near_indenter_ = true;
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const SurfaceCorner &corner = surface.Corners()[k];
    if (corner.gap.distance > range) continue;
    corners_[k].by_nodes = PartOfNodes(grid.Geometry(), corner, bodies.material[corner.body]->Traits().flows);
    if (corners_[k].by_nodes < 1) places.push_back({corner.x, corner.body});
  }
  PetscCall(near_.Begin(grid, places, points, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SurfaceMotion::PrepareFar(const Surface &surface)
{
  near_indenter_ = false;
  corners_.assign(surface.Corners().size(), {1, {}});
}

PetscErrorCode SurfaceMotion::Finish(Grid &grid, const BoundaryConditions &sides, const PointArrays &points,
                                     const std::vector<char> &by_rates, double mass_cutoff, double dt, Surface *surface)
{
  std::vector<NearPoints::Sum> sums;
  PetscFunctionBeginUser;
  if (near_indenter_) PetscCall(near_.Finish(grid, points, &sums));
  auto next = sums.begin();
  for (Surface::CornerMotion &corner : corners_)
    if (corner.by_nodes < 1) corner.sums = *next++;
  surface->Move(grid, sides, by_rates, corners_, mass_cutoff, dt);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
