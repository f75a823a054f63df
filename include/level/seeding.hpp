// Fills bodies with material points.
#pragma once

#include "grid/node_partition.hpp"
#include "level/model.hpp"
#include "points/points.hpp"
#include "surface/surface.hpp"

#include <functional>

namespace mlgimp
{

/// A point to be: its body, the tile where it is, and its number, the same on any number of ranks.
struct Seed {
  int body;
  Tile tile;
  std::int64_t id;
};

/// The grids of all levels, and which of them has the points of a place.
struct SeedingLevels {
  std::vector<GridGeometry> grids;
  std::function<int(Vec3)> at;
  int ratio; ///< of the cell sizes of neighbouring levels
};

/// The places where one level's points start.
class Seeding
{
public:
  /// first_id: the least number of the level's points.
  Seeding(const Model &model, const SeedingLevels &levels, int level, const BoundaryConditions &sides, std::int64_t first_id);

  /// Calls work for every seed with its cell in a box, row by row.
  void ForEachSeed(const IndexBox &cells, const std::function<void(const Seed &)> &work) const;

  /// The nodes nearest to the seeds of one part of the cells, counted from the first of the padding; each rank has another part.
  void ListNodes(MPI_Comm comm, std::vector<Index> *nodes) const;

  /// Numbers of the bodies that touch, directly or by others: those have the same [bodies]. Collective on `comm`, for each level.
  PetscErrorCode JoinTouching(MPI_Comm comm, std::vector<int> *groups) const;

  /// Adds the points of the tiles whose nearest node this rank owns.
  PetscErrorCode Fill(const NodePartition &nodes, Points &points) const;
  /// Adds the surface of these tiles' bodies, but at sides that hold it: their outer faces with corners on the outlines.
  void AddPatches(const NodePartition &nodes, Surface *surface) const;

  /// One more than the largest number a point of this level can have.
  std::int64_t EndId() const;

private:
  void MakePoint(const Seed &seed, const PointArrays &arrays, int p) const;
  PartOfTile Inside(std::size_t body, const Tile &tile, Vec3 origin) const;
  bool IsInside(std::size_t body, const Tile &tile) const;
  template <class Work> void ForEachBeside(std::size_t body, const Tile &tile, Work work) const;
  Tile PointOf(const Seed &seed) const;
  bool TakeStepsOfCoarser(std::size_t body, Tile &tile) const;
  IndexBox CellsAround(const NodePartition &nodes) const;
  bool EndsAt(const Seed &seed, Side side, Vec3 corner) const;
  Vec3 OnOutline(const Seed &seed, Side side, Vec3 corner) const;
  void AddPatches(const Seed &seed, Side side, Surface *surface) const;
  bool AtWall(const Seed &seed, Side side) const;
  int FaceBits(const Seed &seed) const;
  int BodyAt(Vec3 x) const;
  IndexBox CellsOf(MPI_Comm comm) const;
  IndexBox Cells() const;

  const Model &model_;
  SeedingLevels levels_;
  int level_;
  GridGeometry geometry_; ///< of the level
  BoundaryConditions sides_;
  std::int64_t first_id_;
  int tiles_per_cell_ = 1;                   ///< the most of any body
  std::vector<std::vector<Tiling>> tilings_; ///< by levels, of the bodies
};

} // namespace mlgimp
