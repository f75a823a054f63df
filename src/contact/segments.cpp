// Segments of patches, and the exchange that brings them together.
#include "contact/segments.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace mlgimp
{

namespace
{

constexpr double kWallDepth = 0.1;                           ///< cells; see PressedShare
constexpr double kLevelFacing = 0.5, kMinLevelFacing = 0.25; ///< of a level surface's; from the first on all of a segment counts

/// The part of a segment that counts. What does not face down its axis, as the side of a flat punch, closes no gap as the
/// indenter moves, nor does surface that faces the indenter less than half as much as a level one, as the side of a bar under a
/// plate once it leans, or the wall of a hole with a ball on its rim: it counts as far as it has got in.
double PressedShare(double h, int up, const SurfaceSegment &segment, const SurfaceGap &gap)
{
  const double level = -gap.normal[up], facing = std::min(segment.normal[up], -Dot(segment.normal, gap.normal));
  if (level > kMinFacing && facing >= kLevelFacing * level) return 1;
  const double within = std::clamp(-gap.distance / (kWallDepth * h), 0.0, 1.0);
  if (level <= kMinFacing) return within;
  const double least = std::min(kMinFacing, kMinLevelFacing * level);
  return std::max(within, (facing - least) / (kLevelFacing * level - least));
}

} // namespace

/// To the indenter at the end of the step, from that to its nearest face. What nodes show of the surface goes into the indenter
/// where pressures rise, as beside an edge; there the wall may be nearer than the face that presses, which is the one that a way
/// down comes out of.
static SurfaceGap GapAt(const SurfaceInputs &surface, Vec3 tip, Vec3 x, const SurfaceGap &nearest)
{
  constexpr double kMaxIn = 0.25; // cells; of a wall itself what is nearer to its foot is not known to lie beside it
  constexpr int kSteps = 8;
  const int up = surface.geometry.Dim() - 1;
  if (nearest.distance >= 0 || -nearest.normal[up] > kMinFacing) return nearest;
  for (int step = 1; step <= kSteps; ++step) {
    const Vec3 down = surface.indenter.Up(-kMaxIn * step / kSteps * surface.grid.Geometry().spacing);
    const SurfaceGap below = surface.indenter.Gap(x + down, tip);
    if (-below.normal[up] > kMinFacing) return {below.distance - Dot(below.normal, down), below.normal};
  }
  return nearest;
}

/// A place in a patch and the share of the patch that it stands for.
struct PartOfPatch {
  double s, t, share;
};

/// What lies under a face of the indenter, where an edge of it lies across the k-th patch.
static PartOfPatch PartUnderFace(const SurfaceInputs &surface, Vec3 tip, std::size_t k)
{
  constexpr int kColumns = 16;
  const int dim = surface.geometry.Dim(), rows = dim == 2 ? 1 : kColumns;
  const double range = kPointRange * surface.grid.Geometry().spacing;
  const SurfacePatch &patch = surface.patches.Patches()[k];
  const auto is_under_face = [&](Vec3 x, const SurfaceGap &nearest) {
    return -GapAt(surface, tip, x, nearest).normal[dim - 1] > kMinFacing;
  };
  const auto is_under = [&](Vec3 x) { return is_under_face(x, surface.indenter.Gap(x, tip)); };
  int count = 0;
  for (int c = 0; c < 1 << (dim - 1); ++c) {
    const SurfaceCorner &corner = surface.patches.CornerOf(k, c);
    count += corner.gap.distance > range ? is_under(corner.x) : is_under_face(corner.x, corner.gap);
  }
  PartOfPatch sum{0, 0, 0};
  if (count != 0 && count != 1 << (dim - 1))
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < kColumns; ++i) {
        const double s = (i + 0.5) / kColumns, t = (j + 0.5) / rows;
        if (is_under(SegmentOf(patch, s, t, surface.geometry).x)) sum.s += s, sum.t += t, sum.share += 1;
      }
  if (sum.share == 0) return {0.5, 0.5, 1};
  return {sum.s / sum.share, sum.t / sum.share, sum.share / (kColumns * rows)};
}

void CollectSegments(const SurfaceInputs &surface, const TipStep &tip, PetscMPIInt rank, std::vector<Segment> *segments,
                     double *least_gap, double *penetration)
{
  const int dim = surface.geometry.Dim();
  const double range = kContactRange * surface.grid.Geometry().spacing, moves = Norm(tip.end - tip.start);
  for (std::size_t k = 0; k < surface.patches.Patches().size(); ++k) {
    const SurfacePatch &patch = surface.patches.Patches()[k];
    const SurfaceCorner &first = surface.patches.CornerOf(k, 0);
    const double reach = Norm(patch.Center(dim) - first.x);
    if (first.gap.distance - reach > range || !std::isfinite(reach)) continue; // not: beside a failed point
    SurfaceSegment s = SegmentOf(patch, 0.5, 0.5, surface.geometry);
    SurfaceGap nearest = surface.indenter.Gap(s.x, tip.end);
    if (nearest.distance > range) continue;
    const double center = s.x[0];
    const PartOfPatch part = PartUnderFace(surface, tip.end, k);
    if (part.share < 1) s = SegmentOf(patch, part.s, part.t, surface.geometry), nearest = surface.indenter.Gap(s.x, tip.end);
    const double ring = surface.geometry.OutOfPlane(s.x[0]) / (patch.ring * surface.geometry.OutOfPlane(center));
    s.area /= ring;
    const SurfaceGap gap = GapAt(surface, tip.end, s.x, nearest);
    *least_gap = std::min(*least_gap, gap.distance);
    if (nearest.distance <= moves) *penetration = std::max(*penetration, -surface.indenter.Gap(s.x, tip.start).distance);
    const double pressed =
        Faces(s, gap.normal) ? part.share * s.area * PressedShare(surface.grid.Geometry().spacing, dim - 1, s, gap) : 0;
    if (pressed == 0 && s.normal[dim - 1] <= kMinFacing) continue;
    const Material &material = *surface.bodies.material[patch.body];
    const double modulus = material.Elastic().PlaneModulus();
    const double yields = ContactPressureOfFlow(material), flow = material.Traits().flows && std::isinf(yields) ? 0 : yields;
    const double offset = std::isfinite(flow) ? patch.flow : 0;
    Segment one{
        patch.number, patch.path, rank, static_cast<int>(k), offset,  {},  {}, Locate(surface.grid.Geometry(), s.x), gap.normal,
        s.area,       pressed,    ring, gap.distance,        modulus, flow};
    const std::array<double, 4> weights = CornerWeights(part.s, part.t, dim);
    std::copy_n(patch.corner, 4, one.corner);
    std::copy(weights.begin(), weights.end(), one.corner_part);
    segments->push_back(one);
  }
}

PetscErrorCode GatherSegments(MPI_Comm comm, std::vector<Segment> *segments)
{
  PetscFunctionBeginUser;
  PetscCall(ExchangeRecords(
      comm, segments, [](const Segment &) { return 0; }, kAllToFirst));
  const auto key = [](const Segment &one) { return std::tie(one.patch, one.path); };
  std::sort(segments->begin(), segments->end(), [&](const Segment &a, const Segment &b) { return key(a) < key(b); });
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<Index> NodesOf(const Grid &grid, const std::vector<Segment> &segments)
{
  std::vector<Index> cells, nodes;
  const auto unite = [](std::vector<Index> *list) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  };
  const int dim = grid.Geometry().dim;
  for (const Segment &segment : segments)
    for (int c = 0; c < 1 << (dim - 1); ++c)
      if (const Index cell = Locate(grid.Geometry(), segment.corner[c]).cell; cells.empty() || cells.back() != cell)
        cells.push_back(cell);
  unite(&cells);
  for (const Index cell : cells)
    for (int c = 0; c < 1 << dim; ++c) nodes.push_back(Corner(cell, c));
  unite(&nodes);
  return nodes;
}

} // namespace mlgimp
