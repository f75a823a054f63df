// What cells cannot resolve of a case: thin bodies, contact outside of the finest boxes.
#include "program/advice/case_checks.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

std::string RoundedVector(Vec3 x, int dim)
{
  std::string text = FormatRounded(x[0]);
  for (int axis = 1; axis < dim; ++axis) text += Format(",{}", x[axis]);
  return text;
}

/// Where a body begins and ends along an axis through a place, and how much of that it fills, m.
struct Extent {
  double lower, upper, length;
};
Extent ExtentAlong(const Region &region, Vec3 x, int axis)
{
  constexpr int kPlaces = 4096; // size
  const Box bounds = region.Bounds();
  const double start = bounds.lower[axis], step = (bounds.upper[axis] - start) / kPlaces;
  Extent extent{HUGE_VAL, -HUGE_VAL, 0};
  for (int k = 0; k < kPlaces; ++k) {
    x[axis] = start + (k + 0.5) * step;
    if (!region.Contains(x)) continue;
    extent = {std::min(extent.lower, start + k * step), start + (k + 1) * step, extent.length + step};
  }
  return extent;
}

/// Warns of a body that is thinner along an axis than two cells at a place where it is pressed. Its image beyond a side of
/// symmetry counts.
void WarnOfThin(OptionReader &reader, const Case &c, const Body &body, Vec3 place, int axis, const std::string &presses)
{
  constexpr double kMinCells = 2, kTolerance = 1e-3; // cells: with fewer, strain is the same through all of it
  const Extent extent = ExtentAlong(*body.region, place, axis);
  if (extent.length == 0) return;
  place[axis] = 0.5 * (extent.lower + extent.upper);
  const double cell = c.CellSize(c.LevelAt(place));
  double length = extent.length;
  for (const Side side : SidesAcross(axis))
    if (c.model.sides[side] == BoundaryKind::kSymmetry &&
        std::abs((SignOf(side) < 0 ? extent.lower : extent.upper) - c.domain.At(side)) < kTolerance * cell)
      length = 2 * extent.length;
  if (length >= (kMinCells - kTolerance) * cell) return;
  reader.WarnLater("-bodies {}: is {} m thin where {}, from {} = {} to {}: {} cells of {} m, where its bending and flow need two "
                   "or more; take cells of at most {} m there (-cell_size, -levels)",
                   body.name, length, presses, "xyz"[axis], extent.lower, extent.upper, length / cell, cell, length / kMinCells);
}

/// Bodies under the tip, through their height and across.
void WarnOfThinUnderTip(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  if (c.model.contact.method == "none" || !std::isfinite(indenter.initial_surface)) return;
  Vec3 place = indenter.tip;
  for (int axis = 0; axis < indenter.up; ++axis) { // a tip on a side is beside the body but for rounding
    const double inward = 1e-6 * (c.domain.upper[axis] - c.domain.lower[axis]);
    place[axis] = std::clamp(place[axis], c.domain.lower[axis] + inward, c.domain.upper[axis] - inward);
  }
  for (const Body &body : c.model.bodies) {
    const Extent height = ExtentAlong(*body.region, place, indenter.up);
    if (height.length == 0) continue;
    WarnOfThin(reader, c, body, place, indenter.up, "the indenter presses it");
    place[indenter.up] = 0.5 * (height.lower + height.upper);
    for (int axis = 0; axis < indenter.up; ++axis) WarnOfThin(reader, c, body, place, axis, "the indenter presses it");
  }
}

/// Bodies under loads, across the side and at the middle of what is loaded.
void WarnOfThinUnderLoads(OptionReader &reader, const Case &c)
{
  for (std::size_t k = 0; k < c.model.loads.size(); ++k) {
    const Load &load = c.model.loads[k];
    const Body &body = c.model.bodies[load.body];
    const Box bounds = body.region->Bounds();
    Vec3 place = 0.5 * (bounds.lower + bounds.upper);
    for (int t = 0; t < c.Dim() - 1; ++t) {
      const int along = TangentAxis(load.side, t);
      place[along] = 0.5 * (std::max(bounds.lower[along], load.span[t][0]) + std::min(bounds.upper[along], load.span[t][1]));
    }
    WarnOfThin(reader, c, body, place, AxisOf(load.side), Format("load {} presses it", c.load_names[k]));
  }
}

/// Warns where the surface under the tip is not in the box of the finest level.
void WarnOfMissedBox(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  const int level = c.LevelAtTip(), finest = c.levels - 1;
  Vec3 place = indenter.tip;
  place[indenter.up] = indenter.initial_surface;
  if (c.model.contact.method == "none" || c.hierarchy.follow.kind == FollowKind::kContact || level == finest) return;
  if (!std::isfinite(indenter.initial_surface)) return;
  const bool moves = c.hierarchy.follow.kind == FollowKind::kPath;
  const std::string option = Format("-level_{}", finest);
  const double end = std::min(c.time.end_time, indenter.motion.turning_time);
  const double half = indenter.by_load || !std::isfinite(end) ? 0 : indenter.HalfWidth(indenter.Depth(indenter.Tip(end)));
  reader.WarnLater("{}{}: the box of level {} does not hold the surface under the tip, {}: contact has the cells of {} m of "
                   "level {}{}; let the box reach above {} m and {} m to each side of the tip",
                   option, moves ? "_path" : Format("_lower, {}_upper", option), finest, RoundedVector(place, c.Dim()),
                   c.CellSize(level), level,
                   half > 0 ? Format(", {} of them in half the width at the largest depth", half / c.CellSize(level)) : "",
                   place[indenter.up], half + c.BorderMargin(finest));
}

} // namespace

void WarnOfCells(OptionReader &reader, const Case &c)
{
  WarnOfThinUnderLoads(reader, c); // -bodies: thinner than two cells where a load presses
  if (!c.model.indenter) return;
  WarnOfThinUnderTip(reader, c); // -bodies: the same under the indenter
  WarnOfMissedBox(reader, c);    // -level_K_lower, _upper, _path: the finest box does not hold the contact
}

} // namespace mlgimp
