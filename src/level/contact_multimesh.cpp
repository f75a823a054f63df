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
    ForEach(grid.Ghosted(), [&](Index node) { ApplyAtNode(view, node, local, extent, report); });
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
  static void ApplyAtNode(const ContactView &view, Index node, Vec3 local[2], double extent[2], ContactReport *report)
  {
    const Grid &grid = view.grid;
    const std::ptrdiff_t place = grid.Place(node);
    const double mass = grid.Sums()[place].mass, *velocity = grid.Velocity(place).velocity;
    if (mass <= view.mass_cutoff) return;
    const SurfaceGap gap = view.indenter.Gap({grid.Coordinate(0, node[0]), grid.Coordinate(1, node[1])}, view.time + view.dt);
    const double approach = Dot(gap.normal, view.indenter.Velocity(view.time + view.dt) - Vec3{velocity[0], velocity[1]});
    if (gap.distance >= grid.Geometry().spacing || approach <= 0) return;
    const bool owned = grid.Owns(node);
    Vec3 free{};
    for (int d = 0; d < 2; ++d) {
      const double change = approach * gap.normal[d];
      if (owned) local[0][d] += mass * change;
      if (view.sides.Constrains(node, d)) {
        if (owned) local[1][d] -= mass * change;
      } else {
        free[d] = change;
      }
    }
    ChangeVelocity(view, node, free, report);
    extent[0] = std::min(extent[0], grid.Coordinate(0, node[0]));
    extent[1] = std::max(extent[1], grid.Coordinate(0, node[0]));
  }

  static PetscErrorCode CountPoints(const ContactView &view, ContactReport *report)
  {
    const std::vector<int> *surface = nullptr;
    PointArrays points;
    PetscFunctionBeginUser;
    PetscCall(view.points.Arrays(&points));
    PetscCall(view.points.SurfacePoints(&surface));
    for (int p : *surface) {
      const double distance = view.indenter.Gap(points.Position(p), view.time).distance;
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
