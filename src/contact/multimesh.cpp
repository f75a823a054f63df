// Multi-mesh contact after Hu & Chen (2003): where a node has mass of the body and weight of the indenter, the normal
// component of the approach is removed. The indenter, filled with points up to its surface, gives weight to the nodes
// within one cell of it, so contact comes up to a cell too early (the paper's Fig. 1). For comparison only.
#include "contact/contact.hpp"

#include "contact/node_motion.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

class MultimeshContact : public Contact
{
public:
  using Contact::Contact;

  PetscErrorCode Apply(const SurfaceInputs &surface, const NodeMotion &nodes, const ContactStep &step,
                       ContactReport *report) override
  {
    double bounds[3] = {-HUGE_VAL, -HUGE_VAL, 0}; // minus the first and the last place of contact; largest impulse
    PetscFunctionBeginUser;
    *report = {};
    ForEach(surface.grid.Owned(), [&](Index node) { ApplyAtNode(surface, nodes, step, node, bounds, report); });
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 3, MPI_DOUBLE, MPI_MAX, group_.Comm()));
    const double tip = step.tip.start[0];
    if (bounds[0] > -HUGE_VAL) report->half_width = std::max(bounds[1] - tip, tip + bounds[0]);
    CountPoints(surface, step.tip.start, bounds[2] > 0, report);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  /// Removes the approach at a node.
  static void ApplyAtNode(const SurfaceInputs &surface, const NodeMotion &nodes, const ContactStep &step, Index node,
                          double bounds[3], ContactReport *report)
  {
    const double mass = nodes.MassOf(node), x = surface.grid.Geometry().Coordinate(0, node[0]);
    if (nodes.IsEmpty(mass)) return;
    const SurfaceGap gap = surface.indenter.Gap({x, surface.grid.Geometry().Coordinate(1, node[1])}, step.tip.end);
    const double approach = Dot(gap.normal, surface.indenter.Velocity(step.time + step.dt) - nodes.VelocityOf(node));
    if (gap.distance >= surface.grid.Geometry().spacing || approach <= 0) return;
    nodes.Push(node, mass * approach * gap.normal, report);
    bounds[0] = std::max(bounds[0], -x);
    bounds[1] = std::max(bounds[1], x);
    bounds[2] = std::max(bounds[2], std::abs(mass * approach * gap.normal[1]));
  }

  static void CountPoints(const SurfaceInputs &surface, Vec3 tip, bool touching, ContactReport *report)
  {
    const PointArrays points = surface.points.Arrays();
    for (const int p : surface.points.SurfacePoints()) {
      const double distance = surface.indenter.Gap(points.Position(p), tip).distance;
      report->local_points += touching && distance < surface.grid.Geometry().spacing;
      report->penetration = std::max(report->penetration, -distance);
    }
  }
};

} // namespace

std::unique_ptr<Contact> MakeMultimeshContact(const ContactGroup &group) { return std::make_unique<MultimeshContact>(group); }

} // namespace mlgimp
