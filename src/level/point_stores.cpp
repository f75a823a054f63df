// Migration of the points of a level to their owners, and their order.
#include "level/point_stores.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode PointStores::Create(MPI_Comm world, const Model &model, const Grid &grid, const IndexBox &allowed)
{
  PetscFunctionBeginUser;
  world_ = world, grid_ = &grid, allowed_ = allowed;
  for (Points *store : All())
    PetscCall(store->Create(grid.Nodes().PointsComm(), model.geometry.kind, static_cast<int>(model.loads.size()),
                            model.HistoryComponents()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointStores::Redistribute(const Grid &grid, const IndexBox &allowed)
{
  PetscFunctionBeginUser;
  grid_ = &grid, allowed_ = allowed;
  PetscCall(Migrate(true));
  PetscCall(MigrateCopies());
  for (Points *store : All()) PetscCall(store->MoveTo(grid.Nodes().PointsComm()));
  PetscCall(Sort());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscMPIInt PointStores::OwnerOf(const PointArrays &points, int p)
{
  const Vec3 x = points.Position(p);
  const Index node = grid_->Geometry().Nearest(x);
  const PetscMPIInt owner = allowed_.Contains(node) ? grid_->Nodes().OwnerOf(node) : -1;
  if (owner < 0) step_.Record({PointFailure::kLeftGrid, points.id[p], x});
  return owner;
}

PetscErrorCode PointStores::Migrate(bool everywhere)
{
  PetscMPIInt rank;
  Migrants migrants;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events_.migrate, 0, 0, 0, 0));
  const MPI_Comm comm = everywhere ? world_ : grid_->Nodes().Comm();
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  const PointArrays points = own_.Arrays();
  drift_.now = 0;
  for (int p = 0; p < points.count; ++p) {
    const Index nearest = grid_->Geometry().Nearest(points.Position(p));
    Index node = nearest;
    for (int axis = 0; axis < points.dim; ++axis) {
      node[axis] = std::clamp(nearest[axis], allowed_.lower[axis], allowed_.upper[axis] - 1);
      if (node[axis] == nearest[axis]) continue;
      step_.Record({PointFailure::kLeftGrid, points.id[p], points.Position(p)});
      points.position[PointArrays::At(p, points.dim) + axis] = grid_->Geometry().Coordinate(axis, node[axis]);
    }
    const PetscMPIInt owner = everywhere ? grid_->Nodes().OwnerOf(node) : grid_->Nodes().BlockOf(node);
    if (owner != rank) migrants.Add(p, owner);
  }
  PetscCall(MovePoints(comm, own_, own_, migrants));
  PetscCall(PetscLogEventEnd(events_.migrate, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PointStores::MigrateCopies()
{
  PetscFunctionBeginUser;
  for (Points &copies : copies_) {
    Migrants migrants;
    const PointArrays points = copies.Arrays();
    for (int p = 0; p < points.count; ++p) migrants.Add(p, OwnerOf(points, p));
    PetscCall(MovePoints(world_, copies, copies, migrants));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PointStores::PutBack(const std::vector<int> &points)
{
  const double room = 0.5 * grid_->Geometry().spacing;
  const PointArrays a = own_.Arrays();
  for (int p : points)
    for (int axis = 0; axis < a.dim; ++axis) {
      double &x = a.position[PointArrays::At(p, a.dim) + axis];
      const double first = grid_->Geometry().Coordinate(axis, allowed_.lower[axis]),
                   last = grid_->Geometry().Coordinate(axis, allowed_.upper[axis] - 1);
      if (x >= first - room && x < last + room) continue; // a NaN does not
      step_.Record({PointFailure::kLeftGrid, a.id[p], a.Position(p)});
      x = grid_->Geometry().Coordinate(axis, std::max(grid_->Owned().lower[axis], allowed_.lower[axis]));
    }
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

PetscErrorCode PointStores::Sort()
{
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(events_.sort, 0, 0, 0, 0));
  own_.Reorder(SortedByNode(grid_->Nodes(), own_.Arrays()));
  PetscCall(PetscLogEventEnd(events_.sort, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PointStores::BoundDrift(double largest_speed, double dt)
{
  // Speeds may double before they are measured again, and a body at rest may be set in motion.
  constexpr double kSafety = 2, kSurprise = 0.02; // -, cells a step
  drift_.per_step = std::max(kSafety * largest_speed * dt / grid_->Geometry().spacing, kSurprise);
}

bool PointStores::CountDrift()
{
  constexpr double kMaxDrift = 0.9; // cells; the halo has room for one
  drift_.now += drift_.per_step, drift_.path += drift_.per_step;
  const bool due = drift_.now + drift_.per_step > kMaxDrift;
  if (due) drift_.now = 0;
  return due;
}

} // namespace mlgimp
