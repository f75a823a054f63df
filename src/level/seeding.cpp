// Placement of points, their numbers, and the marking of outer and loaded faces.
#include "level/seeding.hpp"

#include <algorithm>

namespace mlgimp
{

Seeding::Seeding(const Model &model, const GridGeometry &geometry, const BoundaryConditions &sides, CellSizeAt cell_size_at,
                 int ratio, std::int64_t first_id)
    : model_(model), geometry_(geometry), sides_(sides), cell_size_at_(std::move(cell_size_at)), first_id_(first_id)
{
  for (const Body &body : model.bodies) {
    tilings_.emplace_back(body.region->Bounds(), geometry.lower, geometry.spacing, body.points_per_cell, cell_size_at_);
    // With slivers of the coarser level's points on both sides.
    const int most = static_cast<int>(std::floor(body.points_per_cell + 2 * kSliver * ratio + 0.5 + kRounding));
    tiles_per_cell_ = std::max(tiles_per_cell_, most * most);
  }
}

/// A tile belongs to a body by its centre. Of bodies whose outlines meet at the centre the first has it.
bool Seeding::IsInside(std::size_t body, const Tile &tile) const
{
  const double tolerance = kRounding * std::min(tile.half_size[0], tile.half_size[1]);
  if (!model_.bodies[body].region->Contains(tile.center, tolerance)) return false;
  if (body == 0 || model_.bodies[body].region->Contains(tile.center, -tolerance)) return true;
  for (std::size_t b = 0; b < body; ++b)
    if (model_.bodies[b].region->Contains(tile.center, tolerance)) return false;
  return true;
}

void Seeding::ForEach(const int lower[2], const int upper[2], const std::function<void(const Seed &)> &work) const
{
  const std::int64_t bodies = static_cast<std::int64_t>(model_.bodies.size());
  const std::int64_t row = geometry_.cells[0] + 2 * geometry_.padding;
  for (int j = std::max(lower[1], -geometry_.padding); j < std::min(upper[1], geometry_.cells[1] + geometry_.padding); ++j)
    for (int i = std::max(lower[0], -geometry_.padding); i < std::min(upper[0], geometry_.cells[0] + geometry_.padding); ++i) {
      if (cell_size_at_(tilings_[0].CellCenter(i, j)) != geometry_.spacing) continue;
      for (int b = 0; b < bodies; ++b) {
        const std::int64_t cell = (j + geometry_.padding) * row + i + geometry_.padding;
        std::int64_t id = first_id_ + (cell * bodies + b) * tiles_per_cell_;
        for (const Tile &tile : tilings_[b].InCell(i, j)) {
          if (IsInside(b, tile)) work({b, tile, id});
          ++id;
        }
      }
    }
}

std::int64_t Seeding::EndId() const
{
  std::int64_t cells = 1;
  for (int axis = 0; axis < 2; ++axis) cells *= geometry_.cells[axis] + 2 * geometry_.padding;
  return first_id_ + cells * static_cast<std::int64_t>(model_.bodies.size()) * tiles_per_cell_;
}

std::vector<double> Seeding::CountByNode() const
{
  const int width = geometry_.Nodes(0);
  std::vector<double> counts(static_cast<std::size_t>(width) * geometry_.Nodes(1), 0.0);
  const int lower[2] = {-geometry_.padding, -geometry_.padding};
  const int upper[2] = {geometry_.cells[0] + geometry_.padding, geometry_.cells[1] + geometry_.padding};
  ForEach(lower, upper, [&](const Seed &seed) {
    int node[2];
    for (int axis = 0; axis < 2; ++axis)
      node[axis] = static_cast<int>(std::floor((seed.tile.center[axis] - geometry_.lower[axis]) / geometry_.spacing + 0.5)) +
                   geometry_.padding;
    ++counts[static_cast<std::size_t>(node[1]) * width + node[0]];
  });
  return counts;
}

bool Seeding::Occupied(Vec3 x) const
{
  for (std::size_t b = 0; b < tilings_.size(); ++b) {
    Tile tile;
    if (tilings_[b].At(x, tile) && IsInside(b, tile)) return true;
  }
  return false;
}

/// True for a face on a held side of the domain, or beyond it, or nearer to it than a sliver.
bool Seeding::AtWall(const Seed &seed, Side side) const
{
  const int axis = AxisOf(side);
  if (sides_.kind[side] == BoundaryKind::kFree) return false;
  const double face = seed.tile.center[axis] + SignOf(side) * seed.tile.half_size[axis];
  const double wall = geometry_.lower[axis] + sides_.node[side] * geometry_.spacing;
  return SignOf(side) * (wall - face) <= kSliver * geometry_.spacing / model_.bodies[seed.body].points_per_cell;
}

int Seeding::FaceBits(const Seed &seed) const
{
  int bits = 0;
  for (int s = 0; s < kSides; ++s) {
    const Side side = static_cast<Side>(s);
    Vec3 beyond = seed.tile.center;
    beyond[AxisOf(side)] += SignOf(side) * seed.tile.half_size[AxisOf(side)] * (1 + 1e-3);
    if (!AtWall(seed, side) && !Occupied(beyond)) bits |= OuterFaceBit(side);
  }
  return bits;
}

/// The part of a tile's face that lies within the span of a load.
static double ShareOf(const Load &load, const Tile &tile)
{
  const int along = 1 - AxisOf(load.side);
  const double half = tile.half_size[along], start = tile.center[along] - half, end = tile.center[along] + half;
  const double share = (std::min(end, load.span[1]) - std::max(start, load.span[0])) / (2 * half);
  return share < kRounding ? 0 : share > 1 - kRounding ? 1 : share;
}

void Seeding::MakePoint(const Seed &seed, const PointArrays &a, int p) const
{
  const Body &body = model_.bodies[seed.body];
  const Material &material = *model_.materials[body.material];
  a.id[p] = seed.id;
  a.body[p] = seed.body;
  a.faces[p] = FaceBits(seed);
  a.mass[p] = 4 * seed.tile.half_size[0] * seed.tile.half_size[1] * model_.thickness * material.Density();
  for (int d = 0; d < 2; ++d) {
    a.position[2 * p + d] = seed.tile.center[d];
    a.velocity[2 * p + d] = body.velocity[d];
    a.half_size[2 * p + d] = seed.tile.half_size[d];
  }
  for (int c = 0; c < 4; ++c) a.F[4 * p + c] = c == 0 || c == 3 ? 1 : 0, a.stress[4 * p + c] = 0;
  for (int c = 0; c < 3; ++c) a.short_wave_stress[3 * p + c] = 0;
  for (int k = 0; k < a.loads; ++k) {
    const Load &load = model_.loads[k];
    const bool acts = load.body == seed.body && a.faces[p] & OuterFaceBit(load.side);
    a.load_share[a.loads * p + k] = acts ? ShareOf(load, seed.tile) : 0;
  }
  if (!a.history) return;
  std::fill_n(a.history + a.history_components * p, a.history_components, 0.0);
  material.InitialHistory(a.history + a.history_components * p);
}

PetscErrorCode Seeding::Fill(const Grid &grid, Points &points) const
{
  PointArrays arrays;
  PetscMPIInt rank;
  int lower[2], upper[2], count = points.Count();
  PetscFunctionBeginUser;
  if (!grid.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(grid.Comm(), &rank));
  for (int d = 0; d < 2; ++d) {
    lower[d] = grid.OwnedLower(d) - 2; // a point of a cell with a sliver may lie in the next cell
    upper[d] = grid.OwnedUpper(d) + 1;
  }
  const auto mine = [&](const Seed &seed) {
    return grid.BlockOfNode(grid.Nearest(0, seed.tile.center[0]), grid.Nearest(1, seed.tile.center[1])) == rank;
  };
  int p = count;
  ForEach(lower, upper, [&](const Seed &seed) { count += mine(seed); }); // counted first: a list would be most of the memory
  PetscCall(points.Resize(count));
  PetscCall(points.Arrays(&arrays));
  ForEach(lower, upper, [&](const Seed &seed) {
    if (mine(seed)) MakePoint(seed, arrays, p++);
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
