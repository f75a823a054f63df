// Multi-mesh contact after Hu & Chen (2003): where a node has mass of the body and weight of the indenter, the normal
// component of the approach is removed. The indenter, filled with points up to its surface, gives weight to the nodes
// within one cell of it, so contact comes up to a cell too early (the paper's Fig. 1). For comparison only.
#include "level/contact_methods.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

class MultimeshContact : public Contact
{
public:
  PetscErrorCode Apply(const ContactView &view, ContactReport *report) override
  {
    const Grid &grid = view.grid;
    Vec3 local[2] = {};
    double extent[2] = {HUGE_VAL, -HUGE_VAL};
    PetscFunctionBeginUser;
    *report = {};
    for (int j = grid.GhostLower(1); j < grid.GhostLower(1) + grid.GhostSize(1); ++j)
      for (int i = grid.GhostLower(0); i < grid.GhostLower(0) + grid.GhostSize(0); ++i)
        ApplyAtNode(view, i, j, local, extent, report);
    double sums[4] = {local[0][0], local[0][1], local[1][0], local[1][1]}, bounds[2] = {-extent[0], extent[1]};
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, grid.Comm()));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 2, MPI_DOUBLE, MPI_MAX, grid.Comm()));
    report->impulse = {sums[0], sums[1]};
    report->side_impulse = {sums[2], sums[3]};
    const double tip = view.indenter.Tip(view.time)[0];
    if (bounds[0] > -HUGE_VAL) report->half_width = std::max(bounds[1] - tip, tip + bounds[0]);
    PetscCall(CountPoints(view, report));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// Removes the approach at a node; adds the impulse of an owned node to local[0], and what sides take to local[1].
  static void ApplyAtNode(const ContactView &view, int i, int j, Vec3 local[2], double extent[2], ContactReport *report)
  {
    const Grid &grid = view.grid;
    const std::ptrdiff_t index = grid.Index(i, j);
    const double mass = grid.Arrays().sums[NodeArrays::kSums * index];
    const double *velocity = grid.Arrays().velocity + NodeArrays::kVelocity * index;
    if (mass <= view.mass_cutoff) return;
    const SurfaceGap gap = view.indenter.Gap({grid.Coordinate(0, i), grid.Coordinate(1, j)}, view.time + view.dt);
    const double approach = Dot(gap.normal, view.indenter.Velocity(view.time + view.dt) - Vec3{velocity[0], velocity[1]});
    if (gap.distance >= grid.Geometry().spacing || approach <= 0) return;
    const bool owned = grid.Owns(i, j);
    Vec3 free{};
    for (int d = 0; d < 2; ++d) {
      const double change = approach * gap.normal[d];
      if (owned) local[0][d] += mass * change;
      if (view.sides.Constrains(i, j, d)) {
        if (owned) local[1][d] -= mass * change;
      } else {
        free[d] = change;
      }
    }
    ChangeVelocity(view, i, j, free, report);
    extent[0] = std::min(extent[0], grid.Coordinate(0, i));
    extent[1] = std::max(extent[1], grid.Coordinate(0, i));
  }

  static PetscErrorCode CountPoints(const ContactView &view, ContactReport *report)
  {
    const std::vector<int> *surface = nullptr;
    PointArrays points;
    PetscFunctionBeginUser;
    PetscCall(view.points.Arrays(&points));
    PetscCall(view.points.SurfacePoints(&surface));
    for (int p : *surface) {
      const double distance = view.indenter.Gap({points.position[2 * p], points.position[2 * p + 1]}, view.time).distance;
      report->local_points += report->impulse[1] != 0 && distance < view.grid.Geometry().spacing;
      report->penetration = std::max(report->penetration, -distance);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

} // namespace

PetscErrorCode CreateMultimeshContact(std::unique_ptr<Contact> *contact)
{
  PetscFunctionBeginUser;
  *contact = std::make_unique<MultimeshContact>();
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
