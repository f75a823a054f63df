// Warnings of contact: its cells, its levels, and whether it was met.
#include "program/advice/warning_lines.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

/// The surface lies deeper inside the indenter than a sharp tip between two columns explains.
std::string PenetrationWarning(const Case &c, const Budgets &budgets, const Watched &)
{
  if (!c.model.indenter || c.model.contact.method == "none") return "";
  const int level = c.LevelAtTip();
  const bool follows = c.hierarchy.follow.kind == FollowKind::kContact;
  if (budgets.penetration_cells <= 1) return "";
  return Format("-cell_size {}: the surface lies {} m inside the indenter{}, more than a cell{}: the indenter is too slender or "
                "too fast for the cells, and the load too small",
                FormatNumber(c.cell_size), budgets.penetration, When(budgets), follows ? "" : Format(" of level {}", level));
}

/// Where contact crosses a border of levels, columns of both press the same nodes, and share the load as they happen to. Where
/// the surface there comes to a line of nodes, points may still split, and make energy.
std::string BorderWarning(const Case &c, const Budgets &budgets, const Watched &)
{
  const int coarsest = c.levels - static_cast<int>(budgets.contact_coarseness), finest = static_cast<int>(budgets.contact_level);
  if (c.hierarchy.follow.kind != FollowKind::kNone || budgets.contact_level == 0 || coarsest == finest) return "";
  const std::string level = Format("-level_{}", finest);
  const double half = budgets.contact_half_width;
  return Format(
      "{}_lower, {}_upper: contact crosses a border of levels{}, half its width being {} cells of level {} and {} of level {}: "
      "contact_area, contact_half_width, peak_pressure and pressures on points are uneven there, and so may stress and load be "
      "where the surface comes to a line of cells; try a box that reaches more than {} m to each side of the tip",
      level, level, When(budgets), half / c.CellSize(finest), finest, half / c.CellSize(coarsest), coarsest,
      half + c.BorderMargin(finest));
}

/// The contact is wider than the coarsest of the levels that follow it allows.
std::string WidestContactWarning(const Case &c, const Budgets &budgets, const Watched &)
{
  const FollowSettings &follow = c.hierarchy.follow;
  const double cells = budgets.contact_half_width / c.CellSize(0);
  if (follow.kind != FollowKind::kContact || cells <= follow.cells_max) return "";
  return Format("-levels {}: half the contact's width is {} cells of level 0{}, more than -level_cells_max, and no level is "
                "coarser: try more levels and a larger -cell_size",
                c.levels, cells, When(budgets));
}

/// Cells in half the contact's width from which the load is no more that of the cells. With fewer than two it is some 10 %
/// off, and a third before, as the tip stands between columns; metal rises beside a steep tip column by column for longer.
static double EnoughCells(const Case &c)
{
  constexpr double kHeight = 4, kSteepRatio = 4; // a half angle of 63 degrees
  const double height = kHeight * c.CellSize(c.LevelAtTip());
  return c.model.Flows() && c.model.indenter->surface->Width(height) < kSteepRatio * height ? 6 : 2;
}

/// The contact never gets wide. No warning for a flat indenter over the whole end of a body.
std::string NarrowestContactWarning(const Case &c, const Budgets &budgets, const Watched &)
{
  if (budgets.contact_cells == 0) return "";
  const FollowSettings &follow = c.hierarchy.follow;
  const bool follows = follow.kind == FollowKind::kContact;
  const int level = follows ? c.levels - 1 : c.LevelAtTip();
  const double cells = budgets.contact_cells, cell = c.CellSize(level);
  const double min_cells = follows ? follow.cells_min : EnoughCells(c);
  if (cells >= min_cells || c.model.indenter->surface->Width(0) > 2 * (cells + 1) * cell) return "";
  return Format("{}: half the contact's width is at most {} cells of level {}, fewer than {}: the load is dominated by "
                "discretisation error; try {}",
                follows ? Format("-levels {}", c.levels) : Format("-cell_size {}", FormatNumber(c.cell_size)), cells, level,
                follows ? "-level_cells_min" : FormatNumber(min_cells),
                follows                ? "more levels"
                : level < c.levels - 1 ? "a finer level there"
                                       : "smaller cells, or more -levels");
}

/// Contact that reaches a side of symmetry which the tip is beside meets its mirror image: it presses the nodes there from half a
/// cell away. A plate over all of the domain has none.
std::string MirrorWarning(const Case &c, const Budgets &budgets, const Watched &)
{
  if (!c.model.indenter || budgets.contact_half_width == 0) return "";
  const Indenter &indenter = *c.model.indenter;
  const Vec3 tip = indenter.Tip(budgets.schedule);
  const double reach = budgets.contact_half_width + 0.5 * c.CellSize(c.LevelAtTip()), flat = indenter.surface->Width(0);
  for (int s = c.model.geometry.HasHoop() ? 2 * indenter.up : 0; s < 2 * indenter.up; ++s) {
    const Side side = static_cast<Side>(s);
    const int axis = AxisOf(side);
    const double off = std::abs(tip[axis] - c.domain.At(side));
    const bool covers = flat > 2 * (c.domain.upper[axis] - c.domain.lower[axis]);
    if (c.model.sides[s] == BoundaryKind::kSymmetry && c.SideAtTip(axis) != side && off < reach && !covers)
      return Format("-indenter_tip {}: contact has reached {}{}, a side of symmetry {} m beside the tip: the load is that of two "
                    "indenters, one of them mirrored, that have met; put the tip on the side, or farther away",
                    FormatVector(indenter.tip, c.Dim()), kSideNames[s], When(budgets), off);
  }
  return "";
}

/// The indenter has touched no body although it is deep, is beside all bodies, or has gone up. LoadWarning is for indenters that
/// a load moves.
std::string TouchWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMaxDepth = 0.5; // cells; the tip of a wedge between two columns is a fifth of a cell deep before it touches
  if (!c.model.indenter || c.model.contact.method == "none" || c.model.indenter->by_load || watched.carried > 0) return "";
  const Indenter &indenter = *c.model.indenter;
  const auto is_below = [&](const Body &body) {
    const Box bounds = body.region->Bounds();
    bool below = true;
    for (int axis = 0; axis < indenter.up; ++axis)
      below = below && indenter.tip[axis] >= bounds.lower[axis] && indenter.tip[axis] <= bounds.upper[axis];
    return below;
  };
  const bool above_body = std::any_of(c.model.bodies.begin(), c.model.bodies.end(), is_below);
  const bool came_down = budgets.depth >= indenter.Depth(indenter.tip);
  if (above_body && came_down && budgets.depth <= kMaxDepth * c.CellSize(c.LevelAtTip())) return "";
  return Format("-indenter_tip {}: the indenter has touched nothing: is it above a body?", FormatVector(indenter.tip, c.Dim()));
}

/// The tip, at its largest speed, has not reached the load that it was to carry.
std::string LoadWarning(const Case &c, const Budgets &budgets, const Watched &watched)
{
  constexpr double kMet = 0.5; // the load of a row is the mean of its step
  if (!c.model.indenter || !c.model.indenter->by_load) return "";
  const double asked = c.model.indenter->by_load->Value(budgets.schedule);
  const bool missed = watched.carried < kMet * watched.asked;
  if (budgets.load >= kMet * asked && !missed) return "";
  return Format("-indenter_loads: {} N are asked for{}{} N, because its speed is limited to a tenth of that of waves; try longer "
                "-indenter_times",
                missed ? watched.asked : asked, missed ? ", and the tip carries at most " : " at the end, and the tip carries ",
                missed ? watched.carried : budgets.load);
}

/// The coarsest level on the surface at a distance from the tip, as far as bodies reach.
static int CoarsestLevelAround(const Case &c, double distance)
{
  int coarsest = c.LevelAtTip();
  const Indenter &indenter = *c.model.indenter;
  for (int axis = 0; axis < indenter.up; ++axis)
    for (const double away : {-distance, distance}) {
      Vec3 x = indenter.tip;
      x[indenter.up] = indenter.initial_surface - 1e-6 * c.CellSize(c.levels - 1);
      x[axis] += away;
      const auto holds = [&](const Body &body) { return body.region->Bounds().Contains(x); };
      if (std::any_of(c.model.bodies.begin(), c.model.bodies.end(), holds)) coarsest = std::min(coarsest, c.LevelAt(x));
    }
  return coarsest;
}

std::vector<std::string> ForeseenWarnings(const Case &c, double half_width, double time)
{
  if (c.model.contact.method == "none" || !std::isfinite(c.model.indenter->initial_surface)) return {};
  const int level = c.LevelAtTip();
  Budgets budgets{};
  budgets.time = time;
  budgets.schedule = time;
  budgets.contact_half_width = half_width;
  budgets.contact_cells = half_width / c.CellSize(level);
  budgets.contact_level = level;
  budgets.contact_coarseness = c.levels - CoarsestLevelAround(c, half_width);
  const QuasiStaticWatch slow(c.quasi_static);
  const MotionWatch motion;
  const Watched watched = {WarningState{}, slow, motion, 0, 0};
  std::vector<std::string> lines;
  for (const auto line_of : {NarrowestContactWarning, BorderWarning, MirrorWarning, WidestContactWarning})
    if (std::string line = line_of(c, budgets, watched); !line.empty()) lines.push_back(std::move(line));
  return lines;
}

} // namespace mlgimp
