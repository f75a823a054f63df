// Boxes around the contact, and along paths.
#include "hierarchy/following.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kHalfWidths = 1.6;          ///< of the contact, from the tip to the sides of a box and from the surface down
constexpr double kFromSide = 4;              ///< coarser cells: borders nearer to the domain's side lie on it
constexpr double kGrowth = 1.25, kAhead = 4; ///< of the contact, that new boxes have room for; cells of the finest level
constexpr double kTooLarge = 2;              ///< times the area or volume that new boxes would have

/// Widens a box to the next cell lines of a level, and to the domain's side where it comes near.
Box OutToLines(const LevelRules &rules, Box box, double cell)
{
  for (int axis = 0; axis < rules.dim; ++axis) {
    const double first = rules.domain.lower[axis], last = rules.domain.upper[axis];
    const double cells = std::round((last - first) / cell);
    const double from = std::floor((box.lower[axis] - first) / cell + kRounding);
    const double to = std::ceil((box.upper[axis] - first) / cell - kRounding);
    box.lower[axis] = from < kFromSide ? first : first + from * cell;
    box.upper[axis] = to > cells - kFromSide ? last : first + to * cell;
  }
  return box;
}

bool LiesIn(const Box &inner, const Box &outer, int dim, double tolerance)
{
  for (int axis = 0; axis < dim; ++axis)
    if (inner.lower[axis] < outer.lower[axis] - tolerance || inner.upper[axis] > outer.upper[axis] + tolerance) return false;
  return true;
}

double Content(const Box &box, int dim)
{
  double content = 1;
  for (int axis = 0; axis < dim; ++axis) content *= box.upper[axis] - box.lower[axis];
  return content;
}

/// What level k must hold of a contact, with its margins.
Box AroundContact(const LevelRules &rules, const BoxMargin &margin, const ContactPlace &place, int k)
{
  const int up = rules.dim - 1;
  const double h = rules.CellSize(k), border = rules.Border(k), lowest = std::min(place.surface, place.tip[up]);
  const double widest = std::max(place.half_width, place.reach);
  const double side = std::max(border, margin.sideways < 0 ? (kHalfWidths - 1) * widest : margin.sideways * h);
  const double depth = margin.down < 0 ? place.surface - kHalfWidths * widest : lowest - margin.down * h;
  Box box;
  for (int axis = 0; axis < up; ++axis) {
    box.lower[axis] = place.tip[axis] - place.reach - side;
    box.upper[axis] = place.tip[axis] + place.reach + side;
  }
  box.lower[up] = std::min(depth, lowest - border);
  box.upper[up] = std::max(place.surface, place.top) + border;
  return box;
}

/// Whether some box of the active levels is far larger than it would be now.
bool IsTooLarge(const LevelRules &rules, const BoxPlan &now, const std::vector<Box> &fresh)
{
  for (int k = 1; k < now.active; ++k)
    if (Content(now.boxes[k], rules.dim) > kTooLarge * Content(fresh[k], rules.dim)) return true;
  return false;
}

} // namespace

double LevelRules::CellSize(int k) const { return cell_size / std::pow(ratio, k); }

double LevelRules::Border(int k) const { return k == 0 ? 0 : blend_widths[k - 1] * CellSize(k - 1) + border_cells * CellSize(k); }

Box OnNearestLines(const LevelRules &rules, Box box, double cell)
{
  for (int axis = 0; axis < rules.dim; ++axis) {
    const double first = rules.domain.lower[axis], last = rules.domain.upper[axis], cells = std::round((last - first) / cell);
    const double from = std::round((box.lower[axis] - first) / cell), to = std::round((box.upper[axis] - first) / cell);
    box.lower[axis] = first + from * cell;
    box.upper[axis] = to == cells ? last : first + to * cell;
  }
  return box;
}

std::vector<Box> BoxesAround(const LevelRules &rules, const FollowSettings &settings, const ContactPlace &place, int active)
{
  std::vector<Box> boxes(rules.levels, rules.domain);
  ContactPlace resting = place;
  resting.half_width = resting.reach = 0;
  for (int k = rules.levels - 1; k > 0; --k) {
    Box box = AroundContact(rules, settings.margins[k], k < active ? place : resting, k);
    for (int axis = 0; axis < rules.dim && k + 1 < rules.levels; ++axis) {
      const double needed = rules.Border(k);
      box.lower[axis] = std::min(box.lower[axis], boxes[k + 1].lower[axis] - needed);
      box.upper[axis] = std::max(box.upper[axis], boxes[k + 1].upper[axis] + needed);
    }
    boxes[k] = OutToLines(rules, box, rules.CellSize(k - 1));
  }
  return boxes;
}

bool FollowContact(const LevelRules &rules, const FollowSettings &settings, const ContactPlace &place, const BoxPlan &now,
                   BoxPlan *next)
{
  const double cells = place.half_width / rules.CellSize(now.active - 1);
  ContactPlace ahead = place;
  next->active = now.active;
  if (cells > settings.cells_max && now.active > 1) --next->active;
  if (cells < settings.cells_min && now.active < rules.levels) ++next->active;
  ahead.half_width *= kGrowth;
  ahead.reach = kGrowth * place.reach + kAhead * rules.CellSize(next->active - 1);
  ahead.top += kAhead * rules.CellSize(next->active - 1);
  next->boxes = BoxesAround(rules, settings, ahead, next->active);
  if (next->active != now.active) return true;
  const std::vector<Box> needed = BoxesAround(rules, settings, place, now.active);
  for (int k = 1; k < now.active; ++k)
    if (!LiesIn(needed[k], now.boxes[k], rules.dim, kRounding * rules.CellSize(k))) return true;
  return IsTooLarge(rules, now, next->boxes);
}

bool FollowPath(const LevelRules &rules, const FollowSettings &settings, double time, const BoxPlan &now, BoxPlan *next)
{
  bool moved = false;
  *next = now;
  for (int k = 1; k < rules.levels; ++k) {
    Vec3 way{};
    for (int axis = 0; axis < rules.dim; ++axis) way[axis] = settings.paths[k][axis].Value(time);
    const Box box = OnNearestLines(rules, {settings.start[k].lower + way, settings.start[k].upper + way}, rules.CellSize(k - 1));
    next->boxes[k] = box;
    moved = moved || box.lower != now.boxes[k].lower || box.upper != now.boxes[k].upper;
  }
  return moved;
}

int FindMisplaced(const LevelRules &rules, const std::vector<Box> &boxes)
{
  for (int k = 1; k < rules.levels; ++k) {
    Box room = boxes[k - 1];
    for (int axis = 0; axis < rules.dim; ++axis) {
      if (room.lower[axis] > rules.domain.lower[axis]) room.lower[axis] += rules.Border(k - 1);
      if (room.upper[axis] < rules.domain.upper[axis]) room.upper[axis] -= rules.Border(k - 1);
    }
    if (!LiesIn(boxes[k], room, rules.dim, kRounding * rules.CellSize(k))) return k;
  }
  return 0;
}

} // namespace mlgimp
