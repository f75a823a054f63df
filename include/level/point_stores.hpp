// The points of a level on this rank: its own and copies of others', the ranks that own them, and their order.
//
// A point is on the rank that owns its nearest node. Between migrations it may drift by less than a cell, for which halos have
// room.
#pragma once

#include "level/level_parts.hpp"

#include <array>
#include <vector>

namespace mlgimp
{

/// How far points may have moved.
struct PointDrift {
  double now = 0;      ///< since they were last sent to their owners, cells
  double per_step = 1; ///< cells
  double path = 0;     ///< since the run began or went on, cells
};

class PointStores
{
public:
  /// step: of the level, which must stay: it takes what fails, and says when.
  PointStores(const LogEvents &events, LevelStep &step) : events_(events), step_(step) {}

  /// Empty stores for the points of a grid, which is kept by reference; allowed: the nearest nodes that points may have.
  /// Collective on all ranks, `world`.
  PetscErrorCode Create(MPI_Comm world, const Model &model, const Grid &grid, const IndexBox &allowed);
  /// Another grid takes the place of the one before: all points go to their owners there. Collective on all ranks.
  PetscErrorCode Redistribute(const Grid &grid, const IndexBox &allowed);

  Points &Own() { return own_; }
  /// Copies of points that the next coarser (0) or finer level (1) owns. They move and act with the level's own points, but do
  /// not count in any budget.
  Points &Copies(int origin) { return copies_[origin]; }
  /// The level's own points, then both stores of copies.
  std::array<Points *, 3> All() { return {&own_, &copies_[0], &copies_[1]}; }

  /// The rank, among all, that owns the node nearest to point p of some level's arrays; -1, and a failure, where no point of
  /// this level may be: its weights would reach beyond the grid.
  PetscMPIInt OwnerOf(const PointArrays &points, int p);
  /// Sends the level's points to their owners; `everywhere` where they may be on any rank. A point beyond the grid is a failure;
  /// it is put back to the grid's edge, so that it does no harm until the run ends. Collective on the grid's ranks, or on all.
  PetscErrorCode Migrate(bool everywhere = false);
  /// Sends copies to their owners, from any rank. Collective on all ranks.
  PetscErrorCode MigrateCopies();
  /// Puts points of the level that lie more than a cell beyond where they may back among this rank's nodes. Such is the place of
  /// a child of a point that deforms without bound, which is a failure.
  void PutBack(const std::vector<int> &points);
  /// Orders the level's points by their nearest node.
  PetscErrorCode Sort();

  /// Bounds the drift of points in a step by the largest speed now: they migrate before they drift out of the halo.
  void BoundDrift(double largest_speed, double dt);
  /// Points have moved by a step: whether they must migrate now. To be asked on all ranks, so that all have the same drift.
  bool CountDrift();
  PointDrift &Drift() { return drift_; }

private:
  LogEvents events_;
  LevelStep &step_;
  MPI_Comm world_ = MPI_COMM_NULL;
  const Grid *grid_ = nullptr;
  IndexBox allowed_;
  Points own_, copies_[2];
  PointDrift drift_;
};

} // namespace mlgimp
