// Options of the grid levels: boxes, ratio and coupling.
#include "program/input/read_case.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mlgimp
{

namespace
{

/// One corner of a level's box must lie on the cell lines of the next coarser level.
void CheckLines(OptionReader &reader, const Case &c, const std::string &option, Vec3 corner, double cell)
{
  for (int axis = 0; axis < c.Dim(); ++axis) {
    const double cells = (corner[axis] - c.domain.lower[axis]) / cell;
    const bool at_side = corner[axis] == c.domain.upper[axis]; // itself a whole number of cells but for rounding
    if (std::abs(cells - std::round(cells)) > kGivenOffLine && !at_side)
      reader.Refuse(option, corner, "on cell lines of the next coarser level, whole cells of {} from -domain_lower {}", cell,
                    reader.Text(c.domain.lower));
  }
}

/// How far inside level k - 1 the coupling needs the borders of level k to lie.
double NeededDepth(const Case &c, int k)
{
  if (c.hierarchy.coupling == LevelCoupling::kPoints)
    return GhostWidths{}.inside * c.CellSize(k - 2) + (c.hierarchy.ghost_cells + 2) * c.CellSize(k);
  return c.BorderMargin(k - 1);
}

/// How far inside level k - 1 a side of level k lies.
double DepthInside(const Case &c, int k, Side side) { return -SignOf(side) * (c.boxes[k].At(side) - c.boxes[k - 1].At(side)); }

/// The box of level k must lie in that of level k - 1, as deep as the coupling needs where a side is not the domain's.
void CheckNesting(OptionReader &reader, const Case &c, int k)
{
  const Box &box = c.boxes[k];
  for (const Side side : SidesOf{c.Dim()}) {
    const bool upper = SignOf(side) > 0;
    const std::string option = Format("-level_{}{}", k, upper ? "_upper" : "_lower");
    const Vec3 corner = upper ? box.upper : box.lower;
    const double depth = DepthInside(c, k, side), needed = c.IsBorder(k - 1, side) ? NeededDepth(c, k) : 0;
    if (depth < needed - kOnLine * c.CellSize(k - 1))
      reader.Refuse(option, corner, "at least {} inside level {} at its side {}; it is {}", needed, k - 1, kSideNames[side],
                    depth);
  }
}

void ReadBox(OptionReader &reader, Case *c, int k)
{
  const std::string name = Format("-level_{}", k);
  const double coarse = c->CellSize(k - 1);
  Box box;
  reader.Read({name + "_lower", "lower corner of the level's box", "m"}, &box.lower, kRequired);
  reader.Read({name + "_upper", "upper corner of the level's box", "m"}, &box.upper, kRequired);
  if (reader.Help()) return;
  CheckLines(reader, *c, name + "_lower", box.lower, coarse);
  CheckLines(reader, *c, name + "_upper", box.upper, coarse);
  for (int axis = 0; axis < c->Dim(); ++axis)
    if (box.upper[axis] - box.lower[axis] < (2 - kOnLine) * coarse)
      reader.Refuse(name + "_upper", box.upper, "at least two coarser cells, {}, above {}_lower {}", 2 * coarse, name,
                    reader.Text(box.lower));
  box = OnNearestLines(c->hierarchy.rules, box, coarse);
  c->boxes.push_back(box);
  CheckNesting(reader, *c, k);
  if (const double r = box.lower[0]; c->model.geometry.HasHoop() && r > 0 && r < 4 * coarse)
    reader.Refuse(name + "_lower", box.lower, "at x = 0, the axis, or at least four coarser cells, {}, from it", 4 * coarse);
  const double cell = c->CellSize(k);
  const int max_nodes = std::numeric_limits<int>::max() / NodeLayout::Viewed(c->Dim());
  double nodes = 1;
  for (int axis = 0; axis < c->Dim(); ++axis) nodes *= (box.upper[axis] - box.lower[axis]) / cell + 8;
  if (nodes > max_nodes)
    reader.Refuse("-levels", c->levels, "such that each grid has at most {} nodes; level {} would have {}",
                  FormatNumber(max_nodes), k, FormatNumber(nodes));
}

void ReadNodeCoupling(OptionReader &reader, Case *c)
{
  HierarchySettings &settings = c->hierarchy;
  double width = kBlendWidth;
  const bool given = reader.Read({"-blend_width",
                                  "nodes: width of the band inside a level's border in which levels blend, in coarser cells; "
                                  "the default is reduced down to 2 where boxes are closer",
                                  "", Closed(0, 64)},
                                 &width);
  settings.rules.blend_widths.assign(c->levels - 1, width);
  if (given) c->least_blend_width = width;
  settings.merge_siblings = settings.ratio > 2 || settings.follow.kind != FollowKind::kNone; // small points make noise
  constexpr double kMaxLoss = 3e-4; // of strain energy: what is near the tip of an indenter, where strain varies, stays small
  if (settings.follow.kind != FollowKind::kNone) settings.most_loss = kMaxLoss;
  reader.Read({"-merge_siblings", "nodes: points that leave a level are merged into the one they were split from (default: true "
                                  "for ratios above 2 and with -level_follow)"},
              &settings.merge_siblings);
}

void ReadPointCoupling(OptionReader &reader, Case *c)
{
  HierarchySettings &settings = c->hierarchy;
  CopyRepairs &repairs = settings.repairs;
  std::string ownership = "flags";
  settings.ghost_cells = 2 * settings.ratio;
  reader.Read({"-ghost_cells",
               "points: layers of cells around a level's box with copies of the coarser level's points (default: 2 x ratio)", "",
               Closed(settings.ratio, 64)},
              &settings.ghost_cells);
  reader.Choice({"-ghost_ownership", "points: one owner for ever (flags), or by place alone, as the paper prints (place)"},
                {"flags", "place"}, &ownership);
  repairs.owner_flags = ownership == "flags";
  reader.Read({"-velocity_shift", "points: copies get the velocity of their own level's half step"}, &repairs.velocity_shift);
  reader.Read({"-strain_smoothing", "points: copies on the finer level get F and stress as the coarser grid sees them"},
              &repairs.strain_smoothing);
  reader.Read({"-momentum_correction", "points: global momentum correction"}, &repairs.momentum_correction);
}

void ReadCoupling(OptionReader &reader, Case *c)
{
  std::string coupling = "nodes";
  reader.Choice({"-level_coupling", "how neighbouring levels act on each other: through nodes, or copies of points"},
                {"nodes", "points"}, &coupling);
  if (coupling == "points" && c->model.geometry.kind != GeometryKind::kPlaneStrain)
    reader.Refuse("-level_coupling", coupling, "nodes, as points is for plane strain alone");
  if (coupling == "points") c->hierarchy.coupling = LevelCoupling::kPoints;
  if (coupling == "nodes" || reader.Help()) ReadNodeCoupling(reader, c);
  if (coupling == "points" || reader.Help()) ReadPointCoupling(reader, c);
}

/// Narrows the band of each border to what the box of the next finer level leaves, but not below the least.
void FitBlendWidths(Case *c)
{
  std::vector<double> &widths = c->hierarchy.rules.blend_widths;
  for (int k = 1; k + 1 < c->levels && !widths.empty(); ++k)
    for (const Side side : SidesOf{c->Dim()}) {
      const double free_cells = (DepthInside(*c, k + 1, side) - kBorderCells * c->CellSize(k)) / c->CellSize(k - 1);
      if (c->IsBorder(k, side)) widths[k - 1] = std::max(c->least_blend_width, std::min(widths[k - 1], free_cells));
    }
}

} // namespace

void ReadLevels(OptionReader &reader, Case *c)
{
  reader.Read({"-levels", "number of grid levels; level 0 is the coarsest", "", Closed(1, 16)}, &c->levels);
  reader.Read({"-refinement_ratio", "cell-size and time-step ratio of neighbouring levels", "", Closed(2, 16)},
              &c->hierarchy.ratio);
  c->hierarchy.rules = {c->domain, c->cell_size, c->hierarchy.ratio, c->Dim(), c->levels, {}, kBorderCells};
  if (c->levels > 1 || reader.Help()) ReadFollowing(reader, c);
  if (c->levels > 1 || reader.Help()) ReadCoupling(reader, c);
  c->boxes = {c->domain};
  const int last = reader.Help() ? 1 : c->levels - 1;
  const bool finds_boxes = c->hierarchy.follow.kind == FollowKind::kContact; // when it knows the indenter
  if (finds_boxes) c->boxes.assign(c->levels, c->domain);
  for (int k = 1; k <= last && !finds_boxes; ++k) ReadBox(reader, c, k);
  if (!reader.Help() && !finds_boxes) FitBlendWidths(c);
}

void PlaceLevels(Case *c)
{
  HierarchySettings &settings = c->hierarchy;
  if (settings.follow.kind == FollowKind::kContact) {
    const Indenter &indenter = *c->model.indenter;
    BoxPlan now{c->boxes, c->levels}, first;
    const double surface = indenter.initial_surface, reach = indenter.HalfWidth(c->CellSize(c->levels - 1));
    FollowContact(settings.rules, settings.follow, {indenter.tip, 0, reach, surface, surface}, now, &first);
    c->boxes = first.boxes;
  }
  settings.follow.start = c->boxes;
  for (int k = 0; k < c->levels; ++k) {
    const int reach = settings.coupling == LevelCoupling::kPoints ? settings.ghost_cells + 2 : kHaloWidth;
    settings.levels.push_back(GeometryOf(settings.rules, c->model, c->boxes[k], k, k > 0 ? reach : 1));
  }
}

} // namespace mlgimp
