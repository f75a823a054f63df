// Gaps below a cell, between bodies or to a side that holds them, which the grid closes; bodies that touch and part.
#include "program/advice/case_checks.hpp"

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

/// Of the places along the gap, how many both hold at a depth from it.
int CountNear(const Neighbour &a, const Neighbour &b, const Box &gap, int across, IndexBox places, double depth)
{
  const bool a_below = a.bounds.upper[across] <= b.bounds.lower[across];
  int near = 0;
  ForEach(places, [&](Index place) {
    Vec3 below{};
    for (int d = 0; d < 3; ++d) below[d] = gap.lower[d] + (place[d] + 0.5) / places.upper[d] * (gap.upper[d] - gap.lower[d]);
    Vec3 above = below;
    below[across] = gap.lower[across] - depth, above[across] = gap.upper[across] + depth;
    near += a.Contains(a_below ? below : above) && b.Contains(a_below ? above : below);
  });
  return near;
}

/// Bodies that touch, and part slowly from there, as a ball does from what it lies on, act on each other as far as less than a
/// cell lies between them.
void WarnOfCurve(OptionReader &reader, const std::string &option, const std::string &between, double cells, double cell)
{
  constexpr double kMaxGap = 2; // cells; in space their faces
  if (cells <= kMaxGap) return;
  reader.WarnLater(
      "{}: less than half a cell of {} m lies between {} along some {} cells beside where they touch: they move as if they "
      "touched there too, which is too stiff; take smaller cells, a body that is cut flat, or an -indenter for one of the two",
      option, cell, between, cells);
}

/// Warns of a gap that is narrower than a cell, so that both sides share nodes; returns the axis across the gap where the two
/// touch, otherwise -1.
int WarnOfGap(OptionReader &reader, const Case &c, const Neighbour &a, const Neighbour &b, const std::string &option,
              const std::string &between)
{
  constexpr double kTouching = 1e-3; // cells
  constexpr int kPlaces = 33;        // size: along an axis
  const double tolerance = kTouching * c.CellSize(c.levels - 1);
  Box gap;
  const int across = FindGap(a.bounds, b.bounds, c.Dim(), tolerance, &gap);
  if (across < 0) return -1;
  const double width = gap.upper[across] - gap.lower[across], cell = c.CellSize(c.LevelAround(gap));
  IndexBox places{{0, 0, 0}, {1, 1, 1}};
  double cells_of_place = 1;
  for (int d = 0; d < c.Dim(); ++d)
    if (d != across) places.upper[d] = kPlaces, cells_of_place *= (gap.upper[d] - gap.lower[d]) / (kPlaces * cell);
  // As boxes do, and disks where they are nearest.
  const int near = width < (1 - kTouching) * cell ? CountNear(a, b, gap, across, places, 0.25 * (cell - width)) : 0;
  if (near == 0) return -1;
  if (width <= tolerance) {
    const double half = (b.region ? 0.25 : 0.5) * cell; // of both that move, together
    const int beside = CountNear(a, b, gap, across, places, half) - CountNear(a, b, gap, across, places, 0.02 * half);
    WarnOfCurve(reader, option, between, beside * cells_of_place, cell);
    return across;
  }
  reader.WarnLater("{}: {} m are left between {}, less than a cell of {} m: they move as if they touched; take smaller cells, or "
                   "close the gap",
                   option, width, between, cell);
  return -1;
}

/// Two bodies that touch at the start share nodes there and stay together, however fast they move on each other or apart.
void WarnOfBond(OptionReader &reader, const Body &a, const Body &b, int across)
{
  if (across < 0 || a.velocity[across] == b.velocity[across]) return;
  reader.WarnLater("-bodies: {} and {} touch at the start and move differently: they will stick, because they share nodes; leave "
                   "a gap of more than a cell between bodies that are to collide or to part",
                   a.name, b.name);
}

} // namespace

void WarnOfGaps(OptionReader &reader, const Case &c, const Body &body)
{
  const Neighbour own = {body.region->Bounds(), body.region.get()};
  for (const Body &other : c.model.bodies)
    WarnOfBond(reader, other, body,
               WarnOfGap(reader, c, own, {other.region->Bounds(), other.region.get()}, "-bodies",
                         Format("{} and {}", other.name, body.name)));
  for (const Side side : SidesOf{c.Dim()}) {
    if (c.model.sides[side] == BoundaryKind::kFree || (side == kXLower && c.model.geometry.HasHoop())) continue;
    Box beyond = own.bounds;
    (SignOf(side) < 0 ? beyond.upper : beyond.lower)[AxisOf(side)] = c.domain.At(side);
    (SignOf(side) < 0 ? beyond.lower : beyond.upper)[AxisOf(side)] = SignOf(side) * HUGE_VAL;
    const std::string option = Format("-boundary_{}", kSideNames[side]);
    WarnOfGap(reader, c, own, {beyond, nullptr}, option, Format("this side and body {}", body.name));
  }
}

} // namespace mlgimp
