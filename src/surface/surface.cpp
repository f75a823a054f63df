// Seeding, motion and halving of patches.
#include "surface/surface.hpp"

#include "surface/pieces.hpp"

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace mlgimp
{

/// Whether a place is at a side of the domain, or beyond it.
static bool IsAt(const Grid &grid, const BoundaryConditions &sides, Side side, Vec3 x)
{
  constexpr double kAt = 1e-6; // rounding; cells
  const double beyond = SignOf(side) * (x[AxisOf(side)] - grid.Geometry().Coordinate(AxisOf(side), sides.node[side]));
  return beyond > -kAt * grid.Geometry().spacing;
}

/// The motion of the nodes at a place, dt sum_i N_i v_i/sum_i N_i over those that have one.
static bool MotionByHats(const Grid &grid, Vec3 x, bool by_rates, double mass_cutoff, double dt, Vec3 *motion)
{
  const GridGeometry &geometry = grid.Geometry();
  const int *const stride = grid.IndexSpace().stride;
  std::ptrdiff_t first = 0;
  double hats[8] = {1}, sum = 0;
  Vec3 total{};
  for (int a = 0, count = 1; a < geometry.dim; ++a, count *= 2) {
    const double from_first = (x[a] - geometry.lower[a]) / geometry.spacing, below = std::floor(from_first),
                 part = from_first - below;
    const int cell = static_cast<int>(below) - grid.Ghosted().lower[a];
    if (cell < 0 || cell + 1 >= grid.Ghosted().Size(a)) return false;
    first += static_cast<std::ptrdiff_t>(stride[a]) * cell;
    for (int c = 0; c < count; ++c) hats[count + c] = part * hats[c], hats[c] *= 1 - part;
  }
  for (int c = 0; c < 1 << geometry.dim; ++c) {
    const std::ptrdiff_t place = first + (c & 1 ? stride[0] : 0) + (c & 2 ? stride[1] : 0) + (c & 4 ? stride[2] : 0);
    const double *const v = by_rates ? grid.Rates(place) : grid.Velocity(place).velocity;
    bool moves = false;
    for (int a = 0; a < geometry.dim; ++a) total[a] += hats[c] * v[a], moves = moves || v[a] != 0;
    moves = moves || grid.Sums()[place].mass > mass_cutoff;
    if (moves) sum += hats[c];
  }
  if (sum > 0) *motion = (dt / sum) * total;
  return sum > 0;
}

/// Takes off what the sides hold of the motion of a place at them.
static void HoldAtSides(const Grid &grid, const BoundaryConditions &sides, Vec3 x, Vec3 *motion)
{
  const int dim = grid.Geometry().dim;
  for (const Side side : SidesOf{dim}) {
    if (sides.kind[side] == BoundaryKind::kFree || !IsAt(grid, sides, side, x)) continue;
    for (int a = 0; a < dim; ++a)
      if (sides.Constrains(side, a)) (*motion)[a] = 0;
  }
}

namespace
{

/// The bits of a place and a body, as corners that patches share have them alike.
using CornerBits = std::array<std::uint64_t, 4>;
struct CornerHash {
  std::size_t operator()(const CornerBits &bits) const
  {
    std::uint64_t hash = 0;
    for (const std::uint64_t one : bits) hash = (hash ^ one) * 0x9e3779b97f4a7c15ULL, hash ^= hash >> 29;
    return hash;
  }
};

} // namespace

void Surface::NumberCorners(int dim)
{
  std::unordered_map<CornerBits, int, CornerHash> known;
  per_patch_ = std::size_t(1) << (dim - 1);
  corners_.clear(), number_.clear();
  for (const SurfacePatch &patch : patches_)
    for (std::size_t c = 0; c < per_patch_; ++c) {
      CornerBits bits{0, 0, 0, static_cast<std::uint64_t>(patch.body)};
      std::memcpy(bits.data(), patch.corner[c].data(), sizeof(Vec3));
      const auto [place, is_new] = known.try_emplace(bits, static_cast<int>(corners_.size()));
      if (is_new) corners_.push_back({patch.corner[c], patch.body, {-HUGE_VAL, {}}});
      number_.push_back(place->second);
    }
}

void Surface::Approach(const Indenter &indenter, Vec3 tip, double range)
{
  const double moved = Norm(tip - tip_);
  tip_ = tip;
  for (SurfaceCorner &corner : corners_) {
    corner.gap.distance -= moved;
    if (!(corner.gap.distance > range)) corner.gap = indenter.Gap(corner.x, tip);
  }
}

void Surface::Move(const Grid &grid, const BoundaryConditions &sides, const std::vector<char> &by_rates,
                   const std::vector<CornerMotion> &motion, double mass_cutoff, double dt)
{
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    SurfaceCorner &corner = corners_[k];
    const CornerMotion &one = motion[k];
    Vec3 by{};
    const bool near = one.sums.weight > 0;
    const bool moves = (near && one.by_nodes == 0) || MotionByHats(grid, corner.x, by_rates[corner.body], mass_cutoff, dt, &by);
    const double part = near ? (moves ? one.by_nodes : 0) : 1;
    if (part < 1) {
      Vec3 by_points = (1 / one.sums.weight) * one.sums.weighted - corner.x;
      HoldAtSides(grid, sides, corner.x, &by_points);
      by = part * by + (1 - part) * by_points;
    }
    const Vec3 to = corner.x + by;
    corner.gap.distance -= Norm(to - corner.x);
    corner.x = to;
  }
  for (std::size_t k = 0; k < number_.size(); ++k) patches_[k / per_patch_].corner[k % per_patch_] = corners_[number_[k]].x;
}

/// Cells: longer than a point's face, than half of it, and than a quarter: where segments come into contact row by row, each is a
/// step of the load; in space, where there are many, that counts while the contact is small.
static double LongestInCells(const SurfacePatch &patch, const Indenter &indenter, Vec3 tip, double h)
{
  constexpr double kLengthFar = 0.55, kLengthNear = 0.375, kLengthTouching = 0.19, kTouchRange = 0.95, kSmallTip = 2;
  const int dim = indenter.up + 1;
  const Vec3 center = patch.Center(dim);
  const double off = indenter.Gap(center, tip).distance / h;
  const bool beside = dim == 3 && std::hypot(center[0] - tip[0], center[1] - tip[1]) > kSmallTip * h;
  return off > kPointRange ? kLengthFar : off > kTouchRange || beside ? kLengthNear : kLengthTouching;
}

void Surface::Split(const Geometry &geometry, const Indenter &indenter, Vec3 tip, double h)
{
  const int dim = geometry.Dim();
  constexpr double kTorn =
      256; // more than patches of levels that follow are too long; beside a point that has failed they may be
  const std::size_t before = patches_.size();
  for (std::size_t k = 0; k < patches_.size();) {
    const SurfacePatch whole = patches_[k];
    const Vec3 *const x = whole.corner;
    const double along = dim == 2 ? Norm(x[1] - x[0]) : std::max(Norm(x[1] - x[0]), Norm(x[2] - x[3])),
                 across = dim == 2 ? 0 : std::max(Norm(x[3] - x[0]), Norm(x[2] - x[1]));
    const double length = std::max(along, across), most = h * LongestInCells(whole, indenter, tip, h);
    if (!(length > most && length < kTorn * most)) {
      ++k;
      continue;
    }
    SurfacePatch first = whole, second = whole;
    first.path = 2 * whole.path, second.path = first.path + 1;
    if (along >= across) {
      first.corner[1] = second.corner[0] = 0.5 * (x[0] + x[1]);
      if (dim == 3) first.corner[2] = second.corner[3] = 0.5 * (x[3] + x[2]);
    } else {
      first.corner[3] = second.corner[0] = 0.5 * (x[0] + x[3]);
      first.corner[2] = second.corner[1] = 0.5 * (x[1] + x[2]);
    }
    const double gap = indenter.Gap(whole.Center(dim), tip).distance;
    for (SurfacePatch *part : {&first, &second}) {
      part->ring *= geometry.OutOfPlane(whole.Center(dim)[0]) / geometry.OutOfPlane(part->Center(dim)[0]);
      if (gap + whole.flow < 0) part->flow += gap - indenter.Gap(part->Center(dim), tip).distance;
    }
    patches_[k] = first;
    patches_.push_back(second);
  }
  if (patches_.size() > before) NumberCorners(dim);
}

} // namespace mlgimp
