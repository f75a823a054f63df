// The half width of a contact in the plane, from its pressures.
#pragma once

#include <vector>

namespace mlgimp
{

/// What an unknown pressure covers of the surface.
struct SurfaceRange {
  double x, left, right; ///< its place and its ends, m
};

/// Half the width of the part under pressure; where it lies on one side of the tip, all of its width. What lies within `rounding`
/// of the tip counts on both sides. smooth: ranges are evenly spaced and pressures a function of x, so that the edge is found
/// between them. ranges: by rising x, with the pressure of each.
double HalfWidth(const std::vector<SurfaceRange> &ranges, const std::vector<double> &pressures, bool smooth, double tip,
                 double rounding);

} // namespace mlgimp
