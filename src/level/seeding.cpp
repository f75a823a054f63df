// Placement of points, their numbers, and the marking of outer and loaded faces.
#include "level/seeding.hpp"

#include <algorithm>

namespace mlgimp
{

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
/// `tile` becomes the coarser one that it is part of.
void Seeding::TakeStepsOfCoarser(std::size_t body, Tile &tile) const
{
  if (model_.bodies[body].region->IsBox()) return;
  const Vec3 center = tile.center;
  const int level = levels_.at(center);
  for (int s = 0; s < 2 * geometry_.dim && level > 0; ++s) {
    const double width = levels_.grids[level - 1].spacing / model_.bodies[body].points_per_cell;
    Vec3 beside = center;
    beside[AxisOf(static_cast<Side>(s))] += SignOf(static_cast<Side>(s)) * width;
    const int other = levels_.at(beside);
    if (other < level && tilings_[other][body].At(center, tile)) return;
  }
}

/// A tile belongs to a body by its centre. Of bodies whose outlines meet at the centre the first has it.
bool Seeding::IsInside(std::size_t body, Tile tile) const
{
  TakeStepsOfCoarser(body, tile);
  const double tolerance =
      kRounding * std::min({tile.half_size[0], tile.half_size[1], geometry_.dim == 3 ? tile.half_size[2] : HUGE_VAL});
  if (!model_.bodies[body].region->Contains(tile.center, tolerance)) return false;
  if (body == 0 || model_.bodies[body].region->Contains(tile.center, -tolerance)) return true;
  for (std::size_t b = 0; b < body; ++b)
    if (model_.bodies[b].region->Contains(tile.center, tolerance)) return false;
  return true;
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

PetscErrorCode Seeding::ListNodes(MPI_Comm comm, std::vector<Index> *nodes) const
{
  const IndexBox all = Cells();
  std::int64_t rank = RankIn(comm);
  int parts[3] = {};
  IndexBox cells = all;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Dims_create(RanksOf(comm), geometry_.dim, parts));
  for (int axis = 0; axis < geometry_.dim; rank /= parts[axis++]) {
    const std::int64_t part = rank % parts[axis];
    cells.lower[axis] = all.lower[axis] + static_cast<int>(all.Size(axis) * part / parts[axis]);
    cells.upper[axis] = all.lower[axis] + static_cast<int>(all.Size(axis) * (part + 1) / parts[axis]);
  }
  nodes->clear();
  ForEachSeed(cells,
              [&](const Seed &seed) { nodes->push_back(geometry_.Nearest(seed.tile.center) - geometry_.NodeBox().lower); });
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool Seeding::Occupied(Vec3 x) const
{
  const std::vector<Tiling> &tilings = tilings_[levels_.at(x)];
  for (std::size_t b = 0; b < tilings.size(); ++b) {
    Tile tile;
    if (tilings[b].At(x, tile) && IsInside(b, tile)) return true;
  }
  return false;
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
  int bits = 0;
  for (const Side side : SidesOf{geometry_.dim}) {
    Vec3 beyond = seed.tile.center;
    beyond[AxisOf(side)] += SignOf(side) * seed.tile.half_size[AxisOf(side)] * (1 + 1e-3);
    if (!AtWall(seed, side) && !Occupied(beyond)) bits |= OuterFaceBit(side);
  }
  return bits;
}

/// The part of the area of a tile's face that lies within the span of a load.
static double ShareOf(const Load &load, const Tile &tile, const Geometry &geometry)
{
  double share = 1;
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

void Seeding::MakePoint(const Seed &seed, const PointArrays &a, int p) const
{
  const Body &body = model_.bodies[seed.body];
  const Material &material = model_.MaterialOf(seed.body);
  const int dim = geometry_.dim;
  double volume = 1;
  a.id[p] = seed.id;
  a.body[p] = seed.body;
  a.faces[p] = FaceBits(seed);
  for (int d = 0; d < dim; ++d) {
    const std::ptrdiff_t at = PointArrays::At(p, dim) + d;
    a.position[at] = a.initial_position[at] = seed.tile.center[d];
    a.velocity[at] = body.velocity[d];
    a.half_size[at] = seed.tile.half_size[d];
    volume *= 2 * seed.tile.half_size[d];
  }
  a.mass[p] = volume * model_.geometry.OutOfPlane(seed.tile.center[0]) * material.Density();
  if (a.initial_radius) a.initial_radius[p] = seed.tile.center[0];
  for (int c = 0; c < dim * dim; ++c) a.F[PointArrays::At(p, dim * dim) + c] = c % (dim + 1) == 0 ? 1 : 0;
  std::fill_n(a.stress + PointArrays::At(p, a.stress_components), a.stress_components, 0.0);
  std::fill_n(a.short_wave_stress + PointArrays::At(p, a.rate_components), a.rate_components, 0.0);
  for (int k = 0; k < a.loads; ++k) {
    const Load &load = model_.loads[k];
    const bool acts = load.body == seed.body && a.faces[p] & OuterFaceBit(load.side);
    a.load_share[PointArrays::At(p, a.loads) + k] = acts ? ShareOf(load, seed.tile, model_.geometry) : 0;
  }
  if (!a.history) return;
  std::fill_n(a.history + PointArrays::At(p, a.history_components), a.history_components, 0.0);
  material.InitialHistory(a.history + PointArrays::At(p, a.history_components));
}

PetscErrorCode Seeding::Fill(const Grid &grid, Points &points) const
{
  int count = points.Count();
  PetscFunctionBeginUser;
  if (!grid.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscMPIInt rank = RankIn(grid.Comm());
  IndexBox cells = grid.Owned();
  for (int d = 0; d < geometry_.dim; ++d) cells.lower[d] -= 2, ++cells.upper[d]; // a point may lie beyond a cell with a sliver
  const auto mine = [&](const Seed &seed) { return grid.BlockOfNode(grid.Nearest(seed.tile.center)) == rank; };
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
