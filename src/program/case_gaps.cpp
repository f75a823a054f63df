// Gaps below a cell, between bodies or to a side that holds them, which the grid closes; bodies that touch and part.
#include "program/case_groups.hpp"

#include "base/index.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// What may be near a body: another one, or all that lies beyond a side, without a region.
struct Neighbour {
  Box bounds;
  const Region *region;
  bool Contains(Vec3 x) const { return !region || region->Contains(x); }
};

/// Size of the cells that a box lies in.
double CellAround(const Case &c, const Box &box)
{
  for (int k = c.levels - 1; k > 0; --k) {
    bool inside = true;
    for (int d = 0; d < c.Dim(); ++d)
      inside = inside && box.lower[d] >= c.boxes[k].lower[d] && box.upper[d] <= c.boxes[k].upper[d];
    if (inside) return c.CellSize(k);
  }
  return c.cell_size;
}

/// The space between two bounds, and the axis across it, along which they may touch; -1 where that is no axis, or more than one.
int FindGap(const Box &a, const Box &b, int dim, double tolerance, Box *gap)
{
  int across = -1;
  for (int d = 0; d < dim; ++d) {
    gap->lower[d] = std::max(a.lower[d], b.lower[d]), gap->upper[d] = std::min(a.upper[d], b.upper[d]);
    if (gap->upper[d] - gap->lower[d] > tolerance) continue;
    if (across >= 0) return -1; // they meet along an edge only, or are farther
    across = d;
    if (gap->upper[d] < gap->lower[d]) std::swap(gap->lower[d], gap->upper[d]);
  }
  return across;
}

/// Whether both reach from the gap so far that less than a cell lies between them at some place, as boxes do, and disks where
/// they are nearest.
bool AreNear(const Neighbour &a, const Neighbour &b, const Box &gap, int across, int dim, double cell)
{
  constexpr int kPlaces = 33; // along an axis
  const double depth = 0.25 * (cell - (gap.upper[across] - gap.lower[across]));
  const bool a_below = a.bounds.upper[across] <= b.bounds.lower[across];
  IndexBox places{{0, 0, 0}, {1, 1, 1}};
  bool near = false;
  for (int d = 0; d < dim; ++d)
    if (d != across) places.upper[d] = kPlaces;
  ForEach(places, [&](Index place) {
    Vec3 below{};
    for (int d = 0; d < dim; ++d) below[d] = gap.lower[d] + (place[d] + 0.5) / places.upper[d] * (gap.upper[d] - gap.lower[d]);
    Vec3 above = below;
    below[across] = gap.lower[across] - depth, above[across] = gap.upper[across] + depth;
    near = near || (a.Contains(a_below ? below : above) && b.Contains(a_below ? above : below));
  });
  return near;
}

/// A gap of which nodes see nothing; returns the axis across it where the two touch, else -1.
int WarnOfGap(OptionReader &reader, const Case &c, const Neighbour &a, const Neighbour &b, const std::string &option,
              const std::string &between)
{
  constexpr double kTouching = 1e-3; // cells
  const double tolerance = kTouching * c.CellSize(c.levels - 1);
  Box gap;
  const int across = FindGap(a.bounds, b.bounds, c.Dim(), tolerance, &gap);
  if (across < 0) return -1;
  const double width = gap.upper[across] - gap.lower[across], cell = CellAround(c, gap);
  if (width >= (1 - kTouching) * cell || !AreNear(a, b, gap, across, c.Dim(), cell)) return -1;
  if (width <= tolerance) return across;
  reader.WarnLater(option + ": " + FormatRounded(width) + " m are left between " + between + ", less than a cell of " +
                   FormatRounded(cell) + " m: they move as if they touched; take smaller cells, or close the gap");
  return -1;
}

/// Two bodies that touch at the start share nodes there and stay together, however fast they move on each other or apart.
void WarnOfBond(OptionReader &reader, const Body &a, const Body &b, int across)
{
  if (across < 0 || a.velocity[across] == b.velocity[across]) return;
  reader.WarnLater(
      "-bodies: " + a.name + " and " + b.name +
      " touch at the start and do not move alike: they stay together; leave more than a cell between bodies that are "
      "to collide, or to part");
}

} // namespace

void WarnOfGaps(OptionReader &reader, const Case &c, const Body &body)
{
  const Neighbour own = {body.region->Bounds(), body.region.get()};
  for (const Body &other : c.model.bodies)
    WarnOfBond(
        reader, other, body,
        WarnOfGap(reader, c, own, {other.region->Bounds(), other.region.get()}, "-bodies", other.name + " and " + body.name));
  for (int s = 0; s < 2 * c.Dim(); ++s) {
    const Side side = static_cast<Side>(s);
    if (c.model.sides[side] == BoundaryKind::kFree || (s == 0 && c.model.geometry.HasHoop())) continue;
    Box beyond = own.bounds;
    (SignOf(side) < 0 ? beyond.upper : beyond.lower)[AxisOf(side)] = c.domain.At(side);
    (SignOf(side) < 0 ? beyond.lower : beyond.upper)[AxisOf(side)] = SignOf(side) * HUGE_VAL;
    const std::string option = std::string("-boundary_") + kSideNames[s];
    WarnOfGap(reader, c, own, {beyond, nullptr}, option, "this side and body " + body.name);
  }
}

} // namespace mlgimp
