// Multi-mesh contact after Hu & Chen (2003): where a node has mass of the body and weight of the indenter, the normal
// component of the approach is removed. The indenter, filled with points up to its surface, gives weight to the nodes
// within one cell of it, so contact comes up to a cell too early (the paper's Fig. 1). For comparison only.
#include "contact/methods.hpp"

#include "contact/body.hpp"

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
    double bounds[3] = {-HUGE_VAL, -HUGE_VAL, 0}; // minus the first and the last place of contact; largest impulse
    PetscFunctionBeginUser;
    *report = {};
    ForEach(grid.Owned(), [&](Index node) { ApplyAtNode(view, node, bounds, report); });
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 3, MPI_DOUBLE, MPI_MAX, view.group.Comm()));
    const double tip = view.tip.start[0];
    if (bounds[0] > -HUGE_VAL) report->half_width = std::max(bounds[1] - tip, tip + bounds[0]);
    CountPoints(view, bounds[2] > 0, report);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// Removes the approach at a node.
  static void ApplyAtNode(const ContactView &view, Index node, double bounds[3], ContactReport *report)
  {
    const Grid &grid = view.grid;
    const double mass = MassOf(view, node), x = grid.Coordinate(0, node[0]);
    if (MassOf(view, node) <= view.mass_cutoff) return;
    const SurfaceGap gap = view.indenter.Gap({x, grid.Coordinate(1, node[1])}, view.tip.end);
    const double approach = Dot(gap.normal, view.indenter.Velocity(view.time + view.dt) - VelocityOf(view, node));
    if (gap.distance >= grid.Geometry().spacing || approach <= 0) return;
    PushNode(view, node, mass * approach * gap.normal, report);
    bounds[0] = std::max(bounds[0], -x);
    bounds[1] = std::max(bounds[1], x);
    bounds[2] = std::max(bounds[2], std::abs(mass * approach * gap.normal[1]));
  }

  static void CountPoints(const ContactView &view, bool touching, ContactReport *report)
  {
    const PointArrays points = view.points.Arrays();
    const std::vector<int> &surface = view.points.SurfacePoints();
    for (int p : surface) {
      const double distance = view.indenter.Gap(points.Position(p), view.tip.start).distance;
      report->local_points += touching && distance < view.grid.Geometry().spacing;
      report->penetration = std::max(report->penetration, -distance);
    }
  }
};

} // namespace

std::unique_ptr<Contact> MakeMultimeshContact() { return std::make_unique<MultimeshContact>(); }

} // namespace mlgimp
