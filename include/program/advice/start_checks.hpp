// Checks of a case that need the points at the start: whether bodies, loads and the indenter are as the options say.
#pragma once

#include "program/case/case.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// Ends the run with one line where a body has no points, where its mass or its outer faces are not those of its shape, or
/// where a load acts on no face. Returns lines that warn where a load acts on a part of its side only, and of points too thin
/// for the steps. Collective.
std::vector<std::string> CheckBodies(Hierarchy &hierarchy, const Case &settings);

/// Ends the run with one line where the indenter starts inside a body. Collective.
void CheckIndenter(Hierarchy &hierarchy, const Case &settings);

} // namespace mlgimp
