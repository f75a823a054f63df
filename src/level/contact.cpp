// The surface of the body as contact sees it, and the choice of a method.
#include "level/contact.hpp"

#include "level/contact_methods.hpp"
#include "level/loads.hpp"

namespace mlgimp
{

int PointSegments(const PointArrays &points, int p, SurfaceSegment segments[kSides * kSegmentsPerFace])
{
  int count = 0;
  for (int s = 0; s < kSides; ++s) {
    const Side side = static_cast<Side>(s);
    if (!(points.faces[p] & OuterFaceBit(side))) continue;
    const Face face = PointFace(points, p, side);
    const double area = Norm(face.area_normal);
    for (int k = 0; k < kSegmentsPerFace; ++k) {
      const double xi = (2 * k + 1.0) / kSegmentsPerFace - 1;
      segments[count++] = {face.center + xi * face.half_edge, (1 / area) * face.area_normal,
                           2 * Norm(face.half_edge) / kSegmentsPerFace};
    }
  }
  return count;
}

bool FarFromIndenter(const ContactView &view, const PointArrays &points, int p)
{
  const double h = view.grid.Geometry().spacing;
  return view.indenter.Gap(points.Position(p), view.time + view.dt).distance > kPointRange * h;
}

void ChangeVelocity(const ContactView &view, Index node, Vec3 by, ContactReport *report)
{
  const std::ptrdiff_t place = view.grid.Place(node);
  const double mass = view.grid.Owns(node) ? view.grid.Sums()[place].mass : 0;
  const auto [velocity, change] = view.grid.Velocity(place);
  for (int d = 0; d < view.grid.Geometry().dim; ++d) {
    velocity[d] += by[d];
    change[d] += by[d];
    report->work += mass * by[d] * (velocity[d] - 0.5 * change[d]);
  }
}

std::vector<std::string> ContactMethods() { return {"pressure", "point_pressure", "multimesh"}; }

PetscErrorCode CreateContact(const std::string &method, bool monitor, std::unique_ptr<Contact> *contact)
{
  PetscFunctionBeginUser;
  if (method == "pressure")
    PetscCall(CreatePressureContact(monitor, contact));
  else if (method == "point_pressure")
    PetscCall(CreatePointPressureContact(monitor, contact));
  else
    PetscCall(CreateMultimeshContact(contact));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
