// The methods of contact that CreateContact chooses from.
#pragma once

#include "level/contact/contact.hpp"

namespace mlgimp
{

/// One pressure per grid column (docs/method.md): the default.
PetscErrorCode CreatePressureContact(const ContactSettings &settings, std::unique_ptr<Contact> *contact);
/// One pressure per material point, gap at its centre: the paper's Eq. 11 as printed, for comparison.
PetscErrorCode CreatePointPressureContact(const ContactSettings &settings, std::unique_ptr<Contact> *contact);
/// Hu & Chen's (2003) multi-mesh contact at nodes that body and indenter share, for comparison.
PetscErrorCode CreateMultimeshContact(std::unique_ptr<Contact> *contact);

} // namespace mlgimp
