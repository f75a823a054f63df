// The choice of a contact method.
#include "contact/contact.hpp"

namespace mlgimp
{

std::vector<std::string> ContactMethods(GeometryKind geometry)
{
  if (geometry != GeometryKind::kPlaneStrain) return {"pressure"};
  return {"pressure", "point_pressure", "multimesh"};
}

PetscErrorCode CreateContact(const ContactSettings &settings, const ContactGroup &group, std::unique_ptr<Contact> *contact)
{
  PetscFunctionBeginUser;
  if (settings.method == "pressure") *contact = MakePressureContact(group);
  if (settings.method == "point_pressure") *contact = MakePointPressureContact(group);
  if (settings.method == "multimesh") *contact = MakeMultimeshContact(group);
  PetscCall((*contact)->Create(settings));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
