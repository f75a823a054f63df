// The edges of a contact, found between the places of its pressures.
#include "level/contact/width.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mlgimp
{

/// Where a contact ends, from the pressures p of the five outermost unknowns, `spacing` apart, the second at distance d.
/// At a smooth edge p^2 = B t (1 + g t), t = a - x (g = -1/2a under a cylinder, positive under a wedge). As single
/// pressures scatter at the edge, the last four enter by their integral only; the first two fix g. Where p does not
/// fall, or this leads beyond `limit`, an edge of the indenter ends the contact.
static double ContactEdge(double d, double spacing, const double p[5], double limit)
{
  if (p[1] >= p[0]) return limit;
  const double tail = spacing * (0.5 * p[1] + p[2] + p[3] + p[4]) / p[1], fall = (p[0] / p[1]) * (p[0] / p[1]);
  double e = 1.5 * tail; // a - d
  for (int iteration = 0; iteration < 20; ++iteration) {
    const double s = fall * e / (e + spacing);
    const double ge = std::clamp((1 - s) * e / (s * e - (e + spacing)), -0.4, 1.0);
    e = tail * std::sqrt(1 + ge) / (2.0 / 3 + ge / 5);
  }
  return std::min(limit, d + e);
}

double HalfWidth(const std::vector<SurfaceRange> &ranges, const std::vector<double> &pressures, bool smooth, double tip,
                 double rounding)
{
  double reach[2] = {0, 0}; // to the left and to the right of the tip
  for (int side = 0; side < 2; ++side) {
    const double sign = side ? 1 : -1;
    std::vector<std::pair<double, int>> loaded; // by distance from the tip
    for (int k = 0; k < static_cast<int>(ranges.size()); ++k)
      if (pressures[k] > 0 && sign * (ranges[k].x - tip) >= -rounding) loaded.push_back({sign * (ranges[k].x - tip), k});
    if (loaded.empty()) continue;
    std::sort(loaded.begin(), loaded.end());
    const std::size_t n = loaded.size();
    const SurfaceRange &last = ranges[loaded.back().second];
    reach[side] = std::max(0.0, sign * ((side ? last.right : last.left) - tip));
    if (smooth && n >= 5) {
      double p[5];
      for (std::size_t k = 0; k < 5; ++k) p[k] = pressures[loaded[n - 5 + k].second];
      reach[side] = ContactEdge(loaded[n - 4].first, loaded[n - 4].first - loaded[n - 5].first, p, reach[side]);
    }
  }
  const bool both_sides = std::min(reach[0], reach[1]) > 0.05 * std::max(reach[0], reach[1]);
  return both_sides ? 0.5 * (reach[0] + reach[1]) : std::max(reach[0], reach[1]);
}

} // namespace mlgimp
