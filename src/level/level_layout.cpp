// Where the points of a level are kept: their owners, their order, and other grids and layouts under them.
#include "level/level.hpp"

#include <algorithm>

namespace mlgimp
{

PetscMPIInt Level::OwnerOf(const PointArrays &points, int p)
{
  const Vec3 x = points.Position(p);
  const Index node = grid_->Geometry().Nearest(x);
  const PetscMPIInt owner = geometry_.PointNodes().Contains(node) ? grid_->Nodes().OwnerOf(node) : -1;
  if (owner < 0) RecordFailure({PointFailure::kLeftGrid, points.id[p], x}, step_.time);
  return owner;
}

void Level::PutBack(const std::vector<int> &points)
{
  const IndexBox allowed = geometry_.PointNodes();
  const PointArrays a = stores_.own.Arrays();
  for (int p : points)
    for (int axis = 0; axis < a.dim; ++axis) {
      double &x = a.position[PointArrays::At(p, a.dim) + axis];
      const double first = grid_->Geometry().Coordinate(axis, allowed.lower[axis]),
                   last = grid_->Geometry().Coordinate(axis, allowed.upper[axis] - 1);
      const double room = 0.5 * geometry_.grid.spacing;
      if (x >= first - room && x < last + room) continue; // a NaN does not
      RecordFailure({PointFailure::kLeftGrid, a.id[p], a.Position(p)}, step_.time);
      x = grid_->Geometry().Coordinate(axis, std::max(grid_->Owned().lower[axis], allowed.lower[axis]));
    }
}

PetscErrorCode Level::Migrate(bool everywhere)
{
  const IndexBox allowed = geometry_.PointNodes();
  PetscMPIInt rank;
  Migrants migrants;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.migrate, 0, 0, 0, 0));
  const MPI_Comm comm = everywhere ? world_ : grid_->Nodes().Comm();
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  const PointArrays points = stores_.own.Arrays();
  clock_.drift = 0;
  for (int p = 0; p < points.count; ++p) {
    const Index nearest = grid_->Geometry().Nearest(points.Position(p));
    Index node = nearest;
    for (int axis = 0; axis < points.dim; ++axis) {
      node[axis] = std::clamp(nearest[axis], allowed.lower[axis], allowed.upper[axis] - 1);
      if (node[axis] == nearest[axis]) continue;
      RecordFailure({PointFailure::kLeftGrid, points.id[p], points.Position(p)}, step_.time);
      points.position[PointArrays::At(p, points.dim) + axis] = grid_->Geometry().Coordinate(axis, node[axis]);
    }
    const PetscMPIInt owner = everywhere ? grid_->Nodes().OwnerOf(node) : grid_->Nodes().BlockOf(node);
    if (owner != rank) migrants.Add(p, owner);
  }
  PetscCall(MovePoints(comm, stores_.own, stores_.own, migrants));
  PetscCall(PetscLogEventEnd(events_.migrate, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::MigrateCopies()
{
  PetscFunctionBeginUser;
  for (Points &copies : stores_.copies) {
    Migrants migrants;
    const PointArrays points = copies.Arrays();
    for (int p = 0; p < points.count; ++p) migrants.Add(p, OwnerOf(points, p));
    PetscCall(MovePoints(world_, copies, copies, migrants));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::Repartition(const GridLayout &layout)
{
  PetscFunctionBeginUser;
  PetscCall(contact_.SharePressures(world_, *grid_));
  PetscCall(CreateGrid(layout));
  PetscCall(contact_.Regroup(*grid_));
  coupled_.nodes.clear();
  PetscCall(Migrate(true));
  PetscCall(MigrateCopies());
  for (Points *store : {&stores_.own, &stores_.copies[0], &stores_.copies[1]})
    PetscCall(store->MoveTo(grid_->Nodes().PointsComm()));
  PetscCall(Sort());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::Move(const LevelGeometry &geometry, const GridLayout &layout)
{
  PetscFunctionBeginUser;
  geometry_ = geometry;
  PetscCall(Repartition(layout));
  contact_.SetPressures({}); // of columns that are others now
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The points by their nearest nodes, and by their places where these are the same.
static std::vector<int> SortedByNode(const NodePartition &nodes, const PointArrays &points)
{
  std::vector<int> start(nodes.Ghosted().Count() + 1, 0), key(points.count), order(points.count);
  for (int p = 0; p < points.count; ++p) {
    key[p] = static_cast<int>(nodes.Place(nodes.Geometry().Nearest(points.Position(p))));
    ++start[key[p] + 1];
  }
  for (std::size_t k = 1; k < start.size(); ++k) start[k] += start[k - 1];
  for (int p = 0; p < points.count; ++p) order[start[key[p]]++] = p;
  return order;
}

PetscErrorCode Level::Sort()
{
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.sort, 0, 0, 0, 0));
  stores_.own.Reorder(SortedByNode(grid_->Nodes(), stores_.own.Arrays()));
  PetscCall(PetscLogEventEnd(events_.sort, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Level::Deactivate()
{
  contact_.Rest();
  budgets_.noise_energy = 0;
}

PetscErrorCode Level::Activate()
{
  PetscFunctionBeginUser;
  clock_.drift_per_step = LevelClock().drift_per_step;
  PetscCall(WatchContact(true, kAllNodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
