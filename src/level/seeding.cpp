// Placement of points, their numbers, and the marking of outer and loaded faces.
#include "level/seeding.hpp"

#include <algorithm>

namespace mlgimp
{

/// A place on the other side of a tile's face.
static Vec3 BeyondFace(const Tile &tile, Side side)
{
  constexpr double kBeyond = 1e-3; // of the tile's half size
  Vec3 x = tile.center;
  x[AxisOf(side)] += SignOf(side) * tile.half_size[AxisOf(side)] * (1 + kBeyond);
  return x;
}

Seeding::Seeding(const Model &model, const SeedingLevels &levels, int level, const BoundaryConditions &sides,
                 std::int64_t first_id)
    : model_(model), levels_(levels), level_(level), geometry_(levels.grids[level]), sides_(sides), first_id_(first_id)
{
  const CellSizeAt cell_size_at = [levels](Vec3 x) { return levels.grids[levels.at(x)].spacing; };
  for (const GridGeometry &grid : levels.grids) {
    std::vector<Tiling> &tilings = tilings_.emplace_back();
    for (const Body &body : model.bodies)
      tilings.emplace_back(body.region->Bounds(), body.region->IsBox(), grid.lower, grid.spacing, body.points_per_cell,
                           cell_size_at);
  }
  for (const Body &body : model.bodies) {
    const int most = Tiling::MostTiles(body.points_per_cell, levels.ratio);
    tiles_per_cell_ = std::max(tiles_per_cell_, geometry_.dim == 3 ? most * most * most : most * most);
  }
}

/// Beside a coarser level the outline of a body has the steps of its tiles, or those of the two would leave parts of faces open:
/// true where `tile` has become the coarser one that it is part of.
bool Seeding::TakeStepsOfCoarser(std::size_t body, Tile &tile) const
{
  const Vec3 center = tile.center;
  const int level = levels_.at(center);
  for (int s = 0; s < 2 * geometry_.dim && level > 0; ++s) {
    const double width = levels_.grids[level - 1].spacing / model_.bodies[body].points_per_cell;
    Vec3 beside = center;
    beside[AxisOf(static_cast<Side>(s))] += SignOf(static_cast<Side>(s)) * width;
    const int other = levels_.at(beside);
    if (other < level && tilings_[other][body].At(center, tile)) return true;
  }
  return false;
}

/// What of a tile a body has. The tiles of a box fill it.
PartOfTile Seeding::Inside(std::size_t body, const Tile &tile, Vec3 origin) const
{
  const Region &region = *model_.bodies[body].region;
  Tile coarse = tile;
  if (region.IsBox()) return WholeOf(tile, origin, geometry_.dim);
  if (!TakeStepsOfCoarser(body, coarse)) return PartInside(region, tile, origin, geometry_.dim);
  PartOfTile part;
  part.Add(WholeOf(tile, origin, geometry_.dim), PartInside(region, coarse, origin, geometry_.dim).share);
  return part;
}

/// A tile is a body's where at least half of it is; see PointOf for others.
bool Seeding::IsInside(std::size_t body, const Tile &tile) const
{
  constexpr double kMinInside = 0.5;
  return model_.bodies[body].region->IsBox() || Inside(body, tile, tile.center).share >= kMinInside * (1 - kRounding);
}

/// Calls work(tile) for the tiles of a body's level on the other sides of a tile's faces.
template <class Work> void Seeding::ForEachBeside(std::size_t body, const Tile &tile, Work work) const
{
  for (const Side side : SidesOf{geometry_.dim}) {
    const Vec3 beyond = BeyondFace(tile, side);
    Tile beside;
    if (levels_.at(beyond) == level_ && tilings_[level_][body].At(beyond, beside)) work(beside);
  }
}

/// The tile that a point stands for: what of the seed's the body has, and what it has less than half of beside, which goes to
/// those next to it in equal parts. Points that are smaller would be alone with nodes beyond the body.
Tile Seeding::PointOf(const Seed &seed) const
{
  const Tile &tile = seed.tile;
  const Vec3 origin = tile.center;
  if (model_.bodies[seed.body].region->IsBox()) return tile;
  PartOfTile part = Inside(seed.body, tile, origin);
  ForEachBeside(seed.body, tile, [&](const Tile &beside) {
    int takers = 0;
    double volume = 1;
    if (IsInside(seed.body, beside)) return;
    const PartOfTile small = Inside(seed.body, beside, origin);
    if (small.share == 0) return;
    ForEachBeside(seed.body, beside, [&](const Tile &other) { takers += IsInside(seed.body, other); });
    for (int axis = 0; axis < geometry_.dim; ++axis) volume *= beside.half_size[axis] / tile.half_size[axis];
    part.Add(small, volume / takers);
  });
  return TileOf(part, tile, geometry_.dim);
}

/// All cells, those of the padding included.
IndexBox Seeding::Cells() const
{
  IndexBox cells = geometry_.NodeBox();
  for (int axis = 0; axis < geometry_.dim; ++axis) --cells.upper[axis];
  return cells;
}

void Seeding::ForEachSeed(const IndexBox &cells, const std::function<void(const Seed &)> &work) const
{
  const std::int64_t bodies = static_cast<std::int64_t>(model_.bodies.size());
  const IndexBox all = Cells();
  ForEach(Intersection(cells, all), [&](Index at) {
    if (levels_.at(tilings_[level_][0].CellCenter(at)) != level_) return;
    std::int64_t cell = 0;
    for (int axis = 2; axis >= 0; --axis) cell = cell * all.Size(axis) + at[axis] - all.lower[axis];
    for (int b = 0; b < bodies; ++b) {
      std::int64_t id = first_id_ + (cell * bodies + b) * tiles_per_cell_;
      for (const Tile &tile : tilings_[level_][b].InCell(at)) {
        if (IsInside(b, tile)) work({b, tile, id});
        ++id;
      }
    }
  });
}

std::int64_t Seeding::EndId() const
{
  return first_id_ + Cells().Count() * static_cast<std::int64_t>(model_.bodies.size()) * tiles_per_cell_;
}

/// One part of the cells; each rank has another one.
IndexBox Seeding::CellsOf(MPI_Comm comm) const
{
  const IndexBox all = Cells();
  std::int64_t rank = RankIn(comm);
  int parts[3] = {};
  IndexBox cells = all;
  MPI_Dims_create(RanksOf(comm), geometry_.dim, parts);
  for (int axis = 0; axis < geometry_.dim; rank /= parts[axis++]) {
    const std::int64_t part = rank % parts[axis];
    cells.lower[axis] = all.lower[axis] + static_cast<int>(all.Size(axis) * part / parts[axis]);
    cells.upper[axis] = all.lower[axis] + static_cast<int>(all.Size(axis) * (part + 1) / parts[axis]);
  }
  return cells;
}

void Seeding::ListNodes(MPI_Comm comm, std::vector<Index> *nodes) const
{
  nodes->clear();
  ForEachSeed(CellsOf(comm),
              [&](const Seed &seed) { nodes->push_back(geometry_.Nearest(seed.tile.center) - geometry_.NodeBox().lower); });
}

PetscErrorCode Seeding::JoinTouching(MPI_Comm comm, std::vector<int> *groups) const
{
  const std::size_t bodies = model_.bodies.size();
  std::vector<char> touch(bodies * bodies, 0);
  PetscFunctionBeginUser;
  if (bodies == 1) PetscFunctionReturn(PETSC_SUCCESS);
  ForEachSeed(CellsOf(comm), [&](const Seed &seed) {
    for (const Side side : SidesOf{geometry_.dim})
      if (const int other = BodyAt(BeyondFace(seed.tile, side)); other >= 0) touch[bodies * seed.body + other] = 1;
  });
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, touch.data(), static_cast<int>(touch.size()), MPI_CHAR, MPI_MAX, comm));
  for (std::size_t a = 0; a < bodies; ++a)
    for (std::size_t b = 0; b < bodies; ++b)
      if (const int from = (*groups)[a], to = (*groups)[b]; touch[bodies * a + b] && from != to)
        std::replace(groups->begin(), groups->end(), from, to);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The first body that has the tile there, or -1.
int Seeding::BodyAt(Vec3 x) const
{
  const std::vector<Tiling> &tilings = tilings_[levels_.at(x)];
  for (std::size_t b = 0; b < tilings.size(); ++b) {
    Tile tile;
    if (tilings[b].At(x, tile) && IsInside(b, tile)) return static_cast<int>(b);
  }
  return -1;
}

/// True for a face on a held side of the domain, or beyond it, or nearer to it than a tenth of a point.
bool Seeding::AtWall(const Seed &seed, Side side) const
{
  const int axis = AxisOf(side);
  if (sides_.kind[side] == BoundaryKind::kFree) return false;
  const double face = seed.tile.center[axis] + SignOf(side) * seed.tile.half_size[axis];
  const double wall = geometry_.lower[axis] + sides_.node[side] * geometry_.spacing;
  return SignOf(side) * (wall - face) <= kThinnestPoint * geometry_.spacing / model_.bodies[seed.body].points_per_cell;
}

int Seeding::FaceBits(const Seed &seed) const
{
  const Region &region = *model_.bodies[seed.body].region;
  int bits = 0;
  for (const Side side : SidesOf{geometry_.dim}) {
    const Vec3 beyond = BeyondFace(seed.tile, side);
    if (region.IsBox() && region.Contains(beyond)) continue; // the body's own tiles fill it
    if (!AtWall(seed, side) && BodyAt(beyond) < 0) bits |= OuterFaceBit(side);
  }
  return bits;
}

/// Whether outer faces of the body across other axes end at a corner of a seed's face. Sides that hold the body do not.
bool Seeding::EndsAt(const Seed &seed, Side side, Vec3 corner) const
{
  const Tile &tile = seed.tile;
  for (int around = 1; geometry_.dim == 3 && around < 4; ++around) {
    Vec3 x = corner;
    bool beyond = false;
    x[AxisOf(side)] -= 0.5 * SignOf(side) * tile.half_size[AxisOf(side)];
    for (int k = 0; k < 2; ++k) {
      const int axis = TangentAxis(side, k), sign = corner[axis] > tile.center[axis] ? 1 : -1;
      const bool crosses = around >> k & 1;
      x[axis] += (crosses ? 0.5 : -0.5) * sign * tile.half_size[axis];
      beyond = beyond || (crosses && AtWall(seed, SidesAcross(axis)[sign > 0]));
    }
    Tile there;
    if (!beyond && !(tilings_[levels_.at(x)][seed.body].At(x, there) && IsInside(seed.body, there))) return true;
  }
  return false;
}

/// Where a corner of a seed's face lies on the outline of its body. A corner at a side that holds the body stays there.
Vec3 Seeding::OnOutline(const Seed &seed, Side face, Vec3 corner) const
{
  constexpr int kTurns = 8; // rounding: between the outline and the sides, to which it is all but normal
  const Region &region = *model_.bodies[seed.body].region;
  const bool at_edge = !region.IsBox() && EndsAt(seed, face, corner);
  Vec3 x = corner;
  for (int turn = 0; turn < kTurns; ++turn) {
    x = region.OnOutline(x, AxisOf(face), at_edge);
    for (const Side side : SidesOf{geometry_.dim})
      if (SignOf(side) * (corner[AxisOf(side)] - seed.tile.center[AxisOf(side)]) > 0 && AtWall(seed, side))
        x[AxisOf(side)] = corner[AxisOf(side)];
  }
  return x;
}

/// Adds a face of a tile with its corners on the outline of its body; in the plane it ends at sharp vertices.
void Seeding::AddPatches(const Seed &seed, Side side, Surface *surface) const
{
  const int dim = geometry_.dim, axis = AxisOf(side), corners = 1 << (dim - 1);
  const Vec3 half = seed.tile.half_size;
  Vec3 normal{}, along{}, across{}, center = seed.tile.center;
  normal[axis] = SignOf(side);
  center[axis] += SignOf(side) * half[axis];
  along[TangentAxis(side, 0)] = half[TangentAxis(side, 0)];
  if (dim == 3) across[TangentAxis(side, 1)] = half[TangentAxis(side, 1)];
  if (dim == 3 ? Dot(normal, Cross(along, across)) < 0 : Dot(normal, TurnRight(along)) < 0) along = -1 * along;
  SurfacePatch patch{kSides * seed.id + side, 1, seed.body, {center - along - across, center + along - across}, 1, 0};
  if (dim == 3) patch.corner[2] = center + along + across, patch.corner[3] = center - along + across;
  for (int c = 0; c < corners; ++c) patch.corner[c] = OnOutline(seed, side, patch.corner[c]);
  if (dim == 2)
    for (const Vec3 &vertex : model_.bodies[seed.body].region->Between(patch.corner[0], patch.corner[1])) {
      SurfacePatch first = patch;
      first.corner[1] = patch.corner[0] = vertex;
      first.path = 2 * patch.path, patch.path = first.path + 1;
      surface->Add(first);
    }
  surface->Add(patch);
}

void Seeding::AddPatches(const NodePartition &nodes, Surface *surface) const
{
  if (!nodes.Participates()) return;
  const PetscMPIInt rank = RankIn(nodes.Comm());
  ForEachSeed(CellsAround(nodes), [&](const Seed &seed) {
    if (nodes.BlockOf(nodes.Geometry().Nearest(seed.tile.center)) != rank) return;
    const int faces = FaceBits(seed);
    for (const Side side : SidesOf{geometry_.dim})
      if (faces & OuterFaceBit(side)) AddPatches(seed, side, surface);
  });
}

/// Area of a tile's face.
static double AreaOf(const Tile &tile, Side side, const Geometry &geometry)
{
  double area = geometry.OutOfPlane(tile.center[0] + (AxisOf(side) == 0 ? SignOf(side) * tile.half_size[0] : 0));
  for (int k = 0; k < geometry.Dim() - 1; ++k) area *= 2 * tile.half_size[TangentAxis(side, k)];
  return area;
}

/// The area of a tile's face within the span of a load over that of its point's face.
static double ShareOf(const Load &load, const Tile &tile, const Tile &point, const Geometry &geometry)
{
  double share = AreaOf(tile, load.side, geometry) / AreaOf(point, load.side, geometry);
  for (int k = 0; k < geometry.Dim() - 1; ++k) {
    const int along = TangentAxis(load.side, k);
    const double half = tile.half_size[along], center = tile.center[along];
    const double start = std::max(center - half, load.span[k][0]), end = std::min(center + half, load.span[k][1]);
    const double radius = geometry.HasHoop() && along == 0 ? 0.5 * (start + end) / center : 1; // of the part, of that of the face
    const double part = radius * std::max(0.0, end - start) / (2 * half);
    share *= part < kRounding ? 0 : part > 1 - kRounding ? 1 : part;
  }
  return share;
}

/// A body with an initial stress has the shape that its stretches have brought about: a point's box is its tile, and the mass is
/// that of the undeformed box.
void Seeding::MakePoint(const Seed &seed, const PointArrays &a, int p) const
{
  const Body &body = model_.bodies[seed.body];
  const Material &material = model_.MaterialOf(seed.body);
  const int dim = geometry_.dim;
  const Tile point = PointOf(seed);
  const Vec3 x = point.center, half_size = point.half_size;
  double volume = 1;
  a.id[p] = seed.id;
  a.body[p] = seed.body;
  a.faces[p] = FaceBits(seed);
  for (int d = 0; d < dim; ++d) {
    const std::ptrdiff_t at = PointArrays::At(p, dim) + d;
    a.position[at] = a.initial_position[at] = x[d];
    a.velocity[at] = body.velocity[d];
    a.half_size[at] = half_size[d] / body.stretch[d];
    volume *= 2 * a.half_size[at];
  }
  const double radius = x[0] / body.stretch[2]; // undeformed, in axisymmetry
  a.mass[p] = volume * model_.geometry.OutOfPlane(radius) * material.Density();
  if (a.initial_radius) a.initial_radius[p] = radius;
  for (int c = 0; c < dim * dim; ++c) a.F[PointArrays::At(p, dim * dim) + c] = c % (dim + 1) == 0 ? body.stretch[c / dim] : 0;
  WithGeometry(model_.geometry.kind, [&](auto policy) {
    StoreStress<decltype(policy)>(body.stress, a.stress + PointArrays::At(p, a.stress_components));
  });
  std::fill_n(a.short_wave_stress + PointArrays::At(p, a.rate_components), a.rate_components, 0.0);
  for (int k = 0; k < a.loads; ++k) {
    const Load &load = model_.loads[k];
    const bool acts = load.body == seed.body && a.faces[p] & OuterFaceBit(load.side);
    a.load_share[PointArrays::At(p, a.loads) + k] = acts ? ShareOf(load, seed.tile, point, model_.geometry) : 0;
  }
  if (!a.history) return;
  std::fill_n(a.history + PointArrays::At(p, a.history_components), a.history_components, 0.0);
  material.InitialHistory(a.history + PointArrays::At(p, a.history_components));
  std::copy(body.history.begin(), body.history.end(), a.history + PointArrays::At(p, a.history_components));
}

/// The cells whose tiles may be this rank's.
IndexBox Seeding::CellsAround(const NodePartition &nodes) const
{
  IndexBox cells = nodes.Owned();
  for (int d = 0; d < geometry_.dim; ++d) cells.lower[d] -= 2, ++cells.upper[d]; // a point may lie beyond a cell with a sliver
  return cells;
}

PetscErrorCode Seeding::Fill(const NodePartition &nodes, Points &points) const
{
  int count = points.Count();
  PetscFunctionBeginUser;
  if (!nodes.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscMPIInt rank = RankIn(nodes.Comm());
  const IndexBox cells = CellsAround(nodes);
  const auto mine = [&](const Seed &seed) { return nodes.BlockOf(nodes.Geometry().Nearest(seed.tile.center)) == rank; };
  int p = count;
  ForEachSeed(cells, [&](const Seed &seed) { count += mine(seed); }); // counted first: a list would be most of the memory
  PetscCall(points.Resize(count));
  const PointArrays arrays = points.Arrays();
  ForEachSeed(cells, [&](const Seed &seed) {
    if (mine(seed)) MakePoint(seed, arrays, p++);
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
