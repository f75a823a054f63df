// An indenter whose axis is not upright.
#pragma once

#include "physics/indenter.hpp"

namespace mlgimp
{

/// A surface of space whose axis leans by an angle from z toward a direction, that at the angle `toward` from x, degrees. Its
/// tip is what is its lowest point then. Null where the surface has none.
std::unique_ptr<IndenterSurface> CreateTilted(std::unique_ptr<IndenterSurface> upright, double angle, double toward);

} // namespace mlgimp
