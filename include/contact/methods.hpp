// The methods of contact that CreateContact chooses from.
#pragma once

#include "contact/contact.hpp"

namespace mlgimp
{

/// A pressure on each segment of the surface (docs/method.md): the default.
std::unique_ptr<Contact> MakePressureContact(const ContactGroup &group);
/// One pressure per material point, gap at its centre: the paper's Eq. 11 as printed, for comparison.
std::unique_ptr<Contact> MakePointPressureContact(const ContactGroup &group);
/// Hu & Chen's (2003) multi-mesh contact at nodes that body and indenter share, for comparison.
std::unique_ptr<Contact> MakeMultimeshContact(const ContactGroup &group);

} // namespace mlgimp
