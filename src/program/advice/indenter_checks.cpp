// Checks of the indenter, its path and what holds the bodies against it, once its options are read.
#include "program/advice/case_checks.hpp"

#include "base/index.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// Lowest place of the tip during the run; -infinity where the end of the run is not known.
double LowestTip(const Indenter &indenter, double end_time)
{
  constexpr int kSamples = 1000; // size
  if (!std::isfinite(end_time) || indenter.by_load) return -HUGE_VAL;
  double lowest = indenter.Tip(std::min(end_time, indenter.motion.turning_time))[indenter.up];
  for (int k = 0; k <= kSamples; ++k) lowest = std::min(lowest, indenter.Tip(end_time * k / kSamples)[indenter.up]);
  return lowest;
}

/// How deep the indenter is inside any body with its tip there, by points of their surfaces, m; below zero where it is in none.
double DeepestInside(const Case &c, Vec3 tip)
{
  const Indenter &indenter = *c.model.indenter;
  const int up = indenter.up, places = up == 2 ? 31 : 101;
  double deepest = -HUGE_VAL;
  for (const Body &body : c.model.bodies) {
    const Box bounds = body.region->Bounds();
    ForEach({{0, 0, 0}, {places, up == 2 ? places : 1, 1}}, [&](Index place) {
      Vec3 x{};
      for (int axis = 0; axis < up; ++axis)
        x[axis] = bounds.lower[axis] + (place[axis] + 0.5) / places * (bounds.upper[axis] - bounds.lower[axis]);
      if (SurfaceAbove(*body.region, x, up, &x[up])) deepest = std::max(deepest, -indenter.Gap(x, tip).distance);
    });
  }
  return deepest;
}

/// Refuses the option that leads the tip to a depth at which the domain has ended before, both in m.
[[noreturn]] void RefuseTooDeep(OptionReader &reader, double depth, double floor)
{
  std::string name = "-indenter_velocities", value;
  for (const char *other : {"-indenter_max_depth", "-indenter_depths"})
    if (FindValue(other, &value)) name = other;
  FindValue(name, &value);
  reader.Refuse(name, value, "such that the tip stays in the domain; it leads to a depth of {} m, where the domain ends at {} m",
                depth, floor);
}

/// Refuses a tip that starts far above the body, usually by a wrong unit, and warns of one that does not reach it.
void CheckReach(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  const double above = indenter.tip[indenter.up] - indenter.initial_surface;
  const double height = c.domain.upper[indenter.up] - c.domain.lower[indenter.up];
  const double nearest = LowestTip(indenter, c.time.end_time) - indenter.initial_surface;
  if (!std::isfinite(above)) return; // there is no body
  if (above > height)
    reader.Refuse("-indenter_tip", indenter.tip, "at most the height of the domain, {}, above the body; it is {}", height, above);
  const double deepest = -nearest;
  const double floor = indenter.initial_surface - c.domain.lower[indenter.up];
  if (c.model.contact.method != "none" && std::isfinite(deepest) && deepest > floor) RefuseTooDeep(reader, deepest, floor);
  bool moves = !c.model.loads.empty() || c.model.nodal.gravity != Vec3{}; // a body to the tip, or the tip sideways
  for (int axis = 0; axis < indenter.up; ++axis) moves = moves || !indenter.sideways[axis].Times().empty();
  for (const Body &body : c.model.bodies) moves = moves || body.velocity != Vec3{};
  Vec3 lowest = indenter.tip;
  lowest[indenter.up] = indenter.initial_surface + nearest;
  if (c.model.contact.method != "none" && nearest > 0 && !moves && DeepestInside(c, lowest) < 0) // also none beside the tip
    reader.WarnLater(
        "-indenter_tip {}: the indenter comes no nearer than {} m to the body until the end: there will be no contact",
        reader.Text(indenter.tip), nearest);
}

/// Depths count from the body below the tip. An indenter that is deep inside another part by then, as a punch over a gap between
/// pillars, goes far beyond the depth that was meant.
void CheckOtherParts(OptionReader &reader, const Case &c)
{
  constexpr double kMaxDepth = 0.5; // cells
  const Indenter &indenter = *c.model.indenter;
  Vec3 tip = indenter.tip;
  tip[indenter.up] = indenter.initial_surface;
  if (c.model.contact.method == "none" || indenter.by_load || !std::isfinite(tip[indenter.up])) return;
  const double deepest = DeepestInside(c, tip);
  if (deepest > kMaxDepth * c.CellSize(c.LevelAtTip()))
    reader.WarnLater("-indenter_tip {}: depths count from the body below the tip; when the tip gets there, the indenter is "
                     "already {} m inside another part; put the tip above the part that it touches first",
                     reader.Text(indenter.tip), deepest);
}

/// Whether gravity or a load presses bodies against the indenter, which then holds them.
bool ArePressedUp(const Case &c)
{
  const int up = c.model.indenter->up;
  const auto presses = [&](const Load &load) {
    return load.side == static_cast<Side>(2 * up) && load.pressure.LargestMagnitude(0, c.time.end_time) > 0;
  };
  return c.model.nodal.gravity[up] > 0 || std::any_of(c.model.loads.begin(), c.model.loads.end(), presses);
}

/// Warns of bodies that no side holds: the indenter pushes them away and the load is that of inertia. Usually a side was
/// forgotten, or a gap was left to it.
void CheckSupport(OptionReader &reader, const Case &c)
{
  constexpr double kGap = 1e-3; // cells
  const int up = c.model.indenter->up;
  const bool rests = !c.model.indenter->by_load && c.model.indenter->Fastest(0, c.time.end_time) == 0;
  if (c.model.contact.method == "none" || ArePressedUp(c)) return;
  for (const Side side : SidesOf{c.Dim()}) {
    const BoundaryKind kind = c.model.sides[side];
    if (kind == BoundaryKind::kFree || (kind == BoundaryKind::kSymmetry && AxisOf(side) != up)) continue;
    for (const Body &body : c.model.bodies)
      if (std::abs(body.region->Bounds().At(side) - c.domain.At(side)) < kGap * c.cell_size) return;
  }
  if (rests && c.model.nodal.gravity[up] < 0)
    reader.WarnLater("-gravity {}: no body lies at a side of the domain that holds it: they fall",
                     reader.Text(c.model.nodal.gravity));
  else
    reader.WarnLater(
        "-boundary_{}: no body lies at a side of the domain that holds it against the indenter: the load is that of inertia",
        kSideNames[2 * up]);
}

/// What the tip's path fills; sideways up to the last of its times where the end of the run is not known, and down without end
/// where the lowest place is not.
Box TipPath(const Indenter &indenter, double end_time)
{
  constexpr int kSamples = 1000; // size
  Box path{indenter.tip, indenter.tip};
  for (int axis = 0; axis < indenter.up; ++axis) {
    const double end = std::isfinite(end_time) ? end_time : indenter.sideways[axis].EndTime();
    for (int k = 1; k <= kSamples; ++k) {
      const double x = indenter.tip[axis] + indenter.Sideways(end * k / kSamples)[axis];
      path.lower[axis] = std::min(path.lower[axis], x), path.upper[axis] = std::max(path.upper[axis], x);
    }
  }
  path.lower[indenter.up] = LowestTip(indenter, end_time);
  return path;
}

/// Refuses a tip just beside a side of symmetry, which was meant to be on the side and would count as a whole indenter, and a tip
/// beyond the side, whose remainder and mirror image are no indenter.
void CheckBesideSide(OptionReader &reader, const Case &c, int axis)
{
  constexpr double kMinDistance = 0.1; // cells
  const Vec3 tip = c.model.indenter->tip;
  const Box path = TipPath(*c.model.indenter, c.time.end_time);
  for (const Side side : SidesAcross(axis)) {
    if (c.model.sides[side] != BoundaryKind::kSymmetry) continue;
    const double off = std::abs(tip[axis] - c.domain.At(side)), beyond = SignOf(side) * (path.At(side) - c.domain.At(side));
    if (off < kMinDistance * c.CellSize(c.LevelAtTip()))
      reader.Refuse("-indenter_tip", tip, "on the side of symmetry {}, or away from it; it is {} m off", kSideNames[side], off);
    if (beyond > 0 && std::isfinite(c.model.indenter->surface->Width(0)))
      reader.Refuse("-indenter_tip", tip, "inside {}, a side of symmetry, at all times; the tip gets {} m beyond it",
                    kSideNames[side], beyond);
  }
}

/// Warns where a body goes on beyond a side of symmetry as another crystal.
void CheckCrystals(OptionReader &reader, const Case &c, Side side)
{
  for (const Body &body : c.model.bodies)
    if (c.model.materials[body.material]->Traits().skew_axes >> AxisOf(side) & 1)
      reader.WarnLater(
          "-boundary_{}: a side of symmetry under the tip, which is no mirror of the crystal of body {}: what is beyond "
          "would be another crystal; turn it, or take the whole of the body",
          kSideNames[side], body.name);
}

/// On a side of symmetry the tip is one half of an indenter, so the indenter must be symmetric about the side; on another side
/// the body ends at the tip, which is rarely meant.
void CheckMirror(OptionReader &reader, const Case &c, const std::string &kind)
{
  for (int axis = 0; axis < c.model.indenter->up; ++axis) {
    const std::optional<Side> side = c.SideAtTip(axis);
    if (axis == 0 && c.model.geometry.HasHoop()) continue;
    if (!side) CheckBesideSide(reader, c, axis);
    if (!side) continue;
    if (!c.MirrorsTip(axis))
      reader.WarnLater("-boundary_{}: the indenter's tip is on this side, where the body ends; with symmetry it would be half of "
                       "a body that goes on",
                       kSideNames[*side]);
    else if (!c.model.indenter->surface->MayBeMirrored(axis))
      reader.Refuse("-indenter", kind,
                    "its own mirror image about {}, the side of symmetry that its tip is on; move the tip off that side, or turn "
                    "the indenter until it is symmetric",
                    kSideNames[*side]);
    else
      CheckCrystals(reader, c, *side);
  }
}

/// Under an indenter of which less than a cell ever meets the surface the load is dominated by discretisation error; one that is
/// curved and yet flat over the whole domain has a size in another unit.
void CheckIndenterSize(OptionReader &reader, const Case &c, const std::string &kind)
{
  const Indenter &indenter = *c.model.indenter;
  const int level = c.LevelAtTip();
  const double h = c.CellSize(level), depth = indenter.initial_surface - LowestTip(indenter, c.time.end_time);
  constexpr double kFlat = 0.1; // cells
  const std::string cell = Format("{} m, a cell of level {}, which it meets", h, level);
  if (indenter.surface->Width(HUGE_VAL) < h * (1 - kRounding))
    reader.Refuse("-indenter", kind, "at least as wide as {}; it is {} m wide", cell, indenter.surface->Width(HUGE_VAL));
  if (c.model.contact.method != "none" && depth > 0 && indenter.surface->Width(depth) < h)
    reader.WarnLater(
        "-indenter {}: at its largest depth of {} m it is {} m wide, less than {}: the load is dominated by discretisation error",
        kind, depth, indenter.surface->Width(depth), cell);
  double extent = 0;
  for (int axis = 0; axis < indenter.up; ++axis) extent = std::max(extent, c.domain.upper[axis] - c.domain.lower[axis]);
  if (indenter.surface->Width(0) < h && indenter.surface->Width(kFlat * h) > 2 * extent)
    reader.WarnLater(
        "-indenter {}: rises by less than {} cells of level {} within the domain, as if it were flat; are its sizes in m?", kind,
        FormatNumber(kFlat), level);
}

/// A box of level k that meets the tip on its path must hold it with the band of its border; when: added to what is refused.
/// Returns whether it meets the tip.
bool CheckHoldsTip(OptionReader &reader, const Case &c, int k, const Box &box, const Box &path, const std::string &when)
{
  const int up = c.model.indenter->up;
  const double margin = c.BorderMargin(k), just_below = c.model.indenter->initial_surface - 1e-6 * c.CellSize(k);
  const auto is_border = [&](Side side) { return c.IsBorder(box, k, side); };
  bool meets = just_below >= box.lower[up] && just_below < box.upper[up];
  for (int axis = 0; axis < up; ++axis)
    meets = meets && path.upper[axis] >= box.lower[axis] - margin && path.lower[axis] <= box.upper[axis] + margin;
  if (!meets) return false;
  const std::string option = Format("-level_{}", k), needed = Format("at least {}", margin);
  for (int axis = 0; axis < up; ++axis) {
    const auto from = [&, axis = axis](double x) {
      return Format("{} from the indenter's tip at {} = {}{}, or the level away from it", needed, "xyz"[axis], x, when);
    };
    if (is_border(static_cast<Side>(2 * axis)) && path.lower[axis] < box.lower[axis] + margin)
      reader.Refuse(option + "_lower", box.lower, "{}", from(path.lower[axis]));
    if (is_border(static_cast<Side>(2 * axis + 1)) && path.upper[axis] > box.upper[axis] - margin)
      reader.Refuse(option + "_upper", box.upper, "{}", from(path.upper[axis]));
  }
  if (!is_border(static_cast<Side>(2 * up))) return true;
  if (std::isfinite(path.lower[up]) && path.lower[up] < box.lower[up] + margin)
    reader.Refuse(option + "_lower", box.lower, "{} below the indenter's lowest place, {}{}", needed, path.lower[up], when);
  // A load moves the tip to a depth that is not known yet, but from where it meets the body.
  const double start = std::min(path.upper[up], c.model.indenter->initial_surface);
  if (!std::isfinite(path.lower[up]) && start < box.lower[up] + margin + kRounding * c.CellSize(k))
    reader.Refuse(option + "_lower", box.lower, "more than {} below where the indenter begins to press, {}{}", margin, start,
                  when);
  return true;
}

} // namespace

/// Refuses depths at which the indenter's surface is not known, and warns of those at which much of it is a guess.
static void CheckKnownSurface(OptionReader &reader, const Case &c, const std::string &kind)
{
  constexpr double kMinDepth = 3; // of the least known height: there at most a third of a paraboloid's area is a guess
  const Indenter &indenter = *c.model.indenter;
  const double deepest = indenter.initial_surface - LowestTip(indenter, c.time.end_time);
  const HeightRange known = indenter.surface->KnownHeights();
  if (!std::isfinite(deepest)) return;
  if (deepest > known.largest * (1 + kRounding))
    reader.Refuse("-indenter", kind, "known up to the depth of the test, {} m; its surface is known up to {} m above its end",
                  deepest, known.largest);
  if (deepest > 0 && deepest < kMinDepth * known.least)
    reader.WarnLater(
        "-indenter {}: its surface is a guess below {} m, from which on its function is that of a tip; the test goes "
        "to {} m",
        kind, known.least, deepest);
}

void CheckIndenterInput(OptionReader &reader, const Case &c, const std::string &kind)
{
  CheckKnownSurface(reader, c, kind); // -indenter: a tip of a file or a function that ends below the depth
  CheckReach(reader, c);              // -indenter_tip: too far above the body, below the domain, or without contact
  CheckOtherParts(reader, c);         // -indenter_tip: inside another part when depths begin to count
  CheckMirror(reader, c, kind);       // -indenter, -indenter_tip, -boundary_SIDE: a tip at or near a side of the domain
  CheckSupport(reader, c);            // -boundary_SIDE, -gravity: nothing holds the bodies
  CheckIndenterSize(reader, c, kind); // -indenter: narrower than a cell, or flat over the whole domain
}

/// The tip on the path of boxes along their paths.
static void CheckPathsHoldTip(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  std::vector<bool> met;
  for (const BoxesAtTime &at : BoxesAlongPaths(c)) {
    Box tip{indenter.Tip(at.time), indenter.Tip(at.time)};
    if (indenter.by_load) tip.lower[indenter.up] = -HUGE_VAL;
    for (int k = 1; k < c.levels; ++k) {
      const std::string when = Format(" at time {} s", at.time);
      const bool meets = CheckHoldsTip(reader, c, k, at.boxes[k], tip, when);
      if (static_cast<int>(met.size()) < k) met.push_back(meets);
      if (meets != met[k - 1])
        reader.Refuse(Format("-level_{}_path", k), "",
                      "such that the level's box contains the indenter's tip at all times or at none; the tip {} it{}",
                      meets ? "has entered" : "has left", when);
    }
  }
}

void CheckLevelsHoldTip(OptionReader &reader, const Case &c)
{
  if (c.hierarchy.follow.kind == FollowKind::kPath) CheckPathsHoldTip(reader, c);
  if (c.hierarchy.follow.kind != FollowKind::kNone) return; // those of contact are where the tip is
  for (int k = 1; k < c.levels; ++k) CheckHoldsTip(reader, c, k, c.boxes[k], TipPath(*c.model.indenter, c.time.end_time), "");
}

} // namespace mlgimp
