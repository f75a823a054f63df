// Whether vertices make a polygon with an inside.
#pragma once

#include "base/tensor.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// An empty string for a simple polygon; else what is wrong with its vertices, which the text numbers from 1.
std::string WrongPolygon(const std::vector<Vec3> &vertices);

} // namespace mlgimp
