// What a checkpoint may say.
#include "program/checkpoint/checks.hpp"

#include "base/exchange.hpp"
#include "base/index.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <limits>
#include <numeric>

namespace mlgimp
{

namespace
{

bool IsWhole(double x, double least, double most) { return x >= least && x <= most && x == std::floor(x); }

bool AllFinite(const double *values, std::size_t count)
{
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

bool AllWhole(const std::vector<double> &values, double least, double most)
{
  return std::all_of(values.begin(), values.end(), [=](double value) { return IsWhole(value, least, most); });
}

/// What is wrong with one point; null where nothing is.
const char *WrongPoint(const PointArrays &a, std::ptrdiff_t p, int bodies)
{
  constexpr std::int64_t kLargestId = std::int64_t{1} << 61; // size: see PointNumbers
  constexpr double kMinVolume = 1e-12;                       // rounding; of that at the start
  const auto finite = [&](const double *field, int components) {
    return !field || AllFinite(field + p * components, static_cast<std::size_t>(components));
  };
  const Vec3 size = a.HalfSize(static_cast<int>(p));
  const double det = Determinant(a.F + p * a.dim * a.dim, a.dim);
  if (a.id[p] < 0 || a.id[p] > kLargestId) return "a number that no point has";
  if (!finite(a.position, a.dim) || !finite(a.velocity, a.dim) || !finite(a.F, a.dim * a.dim) ||
      !finite(a.stress, a.stress_components) || !finite(a.short_wave_stress, a.rate_components) ||
      !finite(a.history, a.history_components) || !finite(a.initial_position, a.dim))
    return "a value that is not finite";
  if (!(det > kMinVolume && std::isfinite(det))) return "a deformation gradient whose determinant is not above zero";
  if (!(a.mass[p] > 0 && std::isfinite(a.mass[p]))) return "a mass that is not above zero";
  if (a.initial_radius && !(a.initial_radius[p] > 0 && std::isfinite(a.initial_radius[p]) && a.position[2 * p] > 0))
    return "a radius that is not above zero";
  for (int d = 0; d < a.dim; ++d)
    if (!(size[d] > 0 && std::isfinite(size[d]))) return "a size that is not above zero";
  if (a.body[p] < 0 || a.body[p] >= bodies) return "a body that is not there";
  if (a.faces[p] < 0 || a.faces[p] >= 1 << (2 * a.dim)) return "faces that are not there";
  for (int k = 0; k < a.loads; ++k)
    if (const double share = a.load_share[p * a.loads + k]; !(share >= 0 && std::isfinite(share)))
      return "a share of a load that is negative or not finite";
  return nullptr;
}

} // namespace

std::string WrongValues(const PointArrays &points, int bodies)
{
  for (int p = 0; p < points.count; ++p) {
    const char *what = WrongPoint(points, p, bodies);
    if (!what) continue;
    return Format("point {} at {} has {}", points.id[p], FormatPlace(points.Position(p), points.dim), what);
  }
  return "";
}

std::string WrongPlaces(const PointArrays &points, const Grid &grid, IndexBox allowed, bool own)
{
  constexpr int kStray = kHaloWidth - 1; // size: nodes beyond its own that a rank can serve: a stencil reaches one further
  if (own && !grid.Participates() && points.count > 0) return "a rank without a part of the grid has points";
  for (int axis = 0; axis < points.dim; ++axis) {
    if (own && points.count > 0) {
      allowed.lower[axis] = std::max(allowed.lower[axis], grid.Owned().lower[axis] - kStray);
      allowed.upper[axis] = std::min(allowed.upper[axis], grid.Owned().upper[axis] + kStray);
    }
    for (int p = 0; p < points.count; ++p) {
      const double node = std::floor((points.Position(p)[axis] - grid.Geometry().lower[axis]) / grid.Geometry().spacing + 0.5);
      if (!(node >= allowed.lower[axis] && node < allowed.upper[axis]))
        return Format("point {} is not on its part of the grid", points.id[p]);
    }
  }
  return "";
}

std::string WrongState(const std::vector<double> &n, const Case &settings)
{
  constexpr double kRounding = 1e-9, kMaxFrames = 1e6; // rounding
  const double time = n[0], time_step = n[1], end_time = n[2], given_step = n[3], cfl = n[4], wave_speed = n[5];
  for (std::size_t k = 0; k < n.size(); ++k)
    if (!std::isfinite(n[k]) && !(k == 2 && n[k] == HUGE_VAL)) return "its state has a value that is not finite";
  if (!(time > 0 && time_step > 0 && end_time > 0 && given_step >= 0 && cfl > 0 && cfl <= kLargestCfl && wave_speed > 0 &&
        time_step * wave_speed <= (1 + kRounding) * kLargestCfl * settings.cell_size))
    return "its times are inconsistent";
  if (!IsWhole(n[6], 1, kLargestWhole) || !IsWhole(n[7], 0, kMaxFrames)) return "its counts of steps and frames are inconsistent";
  if (!(n[8] > 0) || !IsWhole(n[9], 1, kLargestWhole) || !IsWhole(n[10], 0, kLargestWhole))
    return "its initial mass and points are inconsistent";
  if (!(n[12] >= 0 && n[12] <= (1 + kRounding) * time)) return "its last row is inconsistent";
  if (!(n[16] >= 0)) return "its time of the test is inconsistent";
  return "";
}

std::string WrongTip(const std::vector<double> &n, std::size_t count, double time)
{
  constexpr double kRounding = 1e-9; // rounding
  const bool right = n.size() == count && (count == 0 || (std::abs(n[0] - time) <= kRounding * time && n[3] >= 0));
  return right ? "" : "its tip of the indenter is inconsistent";
}

std::string WrongBoxes(const FollowState &now, const Case &settings)
{
  const LevelRules &rules = settings.hierarchy.rules;
  const FollowKind kind = settings.hierarchy.follow.kind;
  bool right = IsWhole(now.plan.active, 1, settings.levels) && now.half_width >= 0 && now.reach >= 0;
  right = right && (kind == FollowKind::kContact || now.plan.active == settings.levels);
  for (int l = 0; right && l < settings.levels; ++l)
    for (int axis = 0; right && axis < rules.dim; ++axis) {
      const double cell = rules.CellSize(std::max(0, l - 1)), first = rules.domain.lower[axis];
      const double from = (now.plan.boxes[l].lower[axis] - first) / cell, to = (now.plan.boxes[l].upper[axis] - first) / cell;
      right =
          to >= from + 1 && std::abs(from - std::round(from)) < kMovedOffLine && std::abs(to - std::round(to)) < kMovedOffLine;
      if (kind == FollowKind::kNone || l == 0)
        right = right && now.plan.boxes[l].lower[axis] == settings.boxes[l].lower[axis] &&
                now.plan.boxes[l].upper[axis] == settings.boxes[l].upper[axis];
    }
  right = right && (kind == FollowKind::kNone || FindMisplaced(rules, now.plan.boxes) == 0);
  return right ? "" : "its boxes are inconsistent with this case";
}

std::string WrongClock(const std::vector<double> &n, long step, const Case &settings, int l)
{
  const double most = static_cast<double>(step) * std::pow(settings.hierarchy.ratio, l);
  const bool rests = settings.hierarchy.follow.kind == FollowKind::kContact && l > 0; // at times, without points
  const bool whole = IsWhole(n[0], rests ? 0 : 1, kLargestWhole) && (rests ? n[0] <= most : n[0] == most);
  const bool drifts = n[1] >= 0 && n[1] <= 1 && n[2] > 0;
  const bool places = AllWhole({n.begin() + 4, n.end()}, INT_MIN, INT_MAX); // of nodes
  return whole && drifts && places && IsWhole(n[3], 0, 1) ? "" : Format("the steps of level {} are inconsistent", l);
}

std::string WrongCounts(const std::vector<double> &counts, std::size_t ranks, double rows)
{
  constexpr double kMaxCount = std::numeric_limits<int>::max(); // of a rank
  const bool add_up = counts.size() == ranks && AllWhole(counts, 0, kMaxCount) &&
                      rows <= kMaxCount * static_cast<double>(ranks) &&
                      std::accumulate(counts.begin(), counts.end(), 0.0) == rows;
  return add_up ? "" : "its counts of points do not add up";
}

std::string WrongLayout(const std::array<std::vector<double>, 3> &widths, const std::vector<double> &owners,
                        const GridGeometry &grid, std::size_t ranks)
{
  std::vector<double> sorted = owners;
  const double blocks =
      static_cast<double>(widths[0].size()) * static_cast<double>(widths[1].size()) * static_cast<double>(widths[2].size());
  bool right = static_cast<double>(owners.size()) == blocks && AllWhole(owners, 0, static_cast<double>(ranks) - 1);
  std::sort(sorted.begin(), sorted.end());
  right = right && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> &width = widths[axis];
    right = right && !width.empty() && AllWhole(width, width.size() > 1 ? kHaloWidth : 1, grid.Nodes(axis)) &&
            std::accumulate(width.begin(), width.end(), 0.0) == grid.Nodes(axis);
  }
  return right ? "" : "its grids are not divided among ranks as a run divides them";
}

std::string WrongPressures(const std::vector<double> &keys, const std::vector<double> &pressures, int per_column)
{
  bool right = keys.size() == pressures.size() && AllWhole(keys, -kLargestWhole, kLargestWhole);
  for (std::size_t k = 0; right && k < keys.size(); ++k)
    right = pressures[k] >= 0 || static_cast<std::int64_t>(keys[k]) % per_column != 0;
  right = right && std::is_sorted(keys.begin(), keys.end(), std::less_equal<>()); // as a map is: none twice
  return right ? "" : "its contact pressures are inconsistent";
}

std::string FindRepeated(MPI_Comm comm, std::vector<std::int64_t> ids)
{
  ExitOnError(ExchangeRecords(comm, &ids, [ranks = RanksOf(comm)](std::int64_t id) { return static_cast<int>(id % ranks); }));
  std::sort(ids.begin(), ids.end());
  const auto twice = std::adjacent_find(ids.begin(), ids.end());
  return twice == ids.end() ? "" : Format("two points have the number {}", *twice);
}

} // namespace mlgimp
