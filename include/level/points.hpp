// The material points of one level: a DMSwarm of type BASIC as storage, sorting, and moving points between ranks.
#pragma once

#include "base/handle.hpp"
#include "pointwise/point_fields.hpp"

#include <functional>
#include <vector>

namespace mlgimp
{

class Points
{
public:
  /// The storage of this rank alone; points move between ranks by MovePoints.
  PetscErrorCode Create(GeometryKind geometry, int loads, int history_components);

  int Count() const { return count_; }
  /// Changes whenever points come, go or change places in storage.
  long Version() const { return version_; }
  const std::array<PointFieldInfo, kPointFields> &Table() const { return table_; }

  /// The fields as arrays; valid until the next Resize.
  PetscErrorCode Arrays(PointArrays *arrays);
  PetscErrorCode Field(PointField field, void **data);

  /// Keeps the first `count` points, or adds uninitialised ones. Storage grows by a tenth at a time.
  PetscErrorCode Resize(int count);

  /// Removes points, given in ascending order; the last points take their places.
  PetscErrorCode Remove(const std::vector<int> &points);

  /// Makes point `target` equal to point `source`.
  PetscErrorCode Copy(int source, int target);

  /// Reorders the points so that point k is the one that was at order[k].
  PetscErrorCode Reorder(const std::vector<int> &order);

  /// Points with a bit of `faces` set, in storage order; found anew after points have moved in storage.
  PetscErrorCode SurfacePoints(const std::vector<int> **indices);

  ~Points();
  Points() = default;
  Points(const Points &) = delete;
  Points &operator=(const Points &) = delete;

private:
  PetscErrorCode ReleaseFields();
  int dim_ = 2;

  DMHandle swarm_;
  std::array<PointFieldInfo, kPointFields> table_{};
  std::array<void *, kPointFields> data_{};
  bool have_fields_ = false;
  int count_ = 0, capacity_ = 0;
  long version_ = 0;
  std::vector<int> surface_;
  bool surface_known_ = false;
};

/// Points that leave, and the rank each goes to.
struct Migrants {
  std::vector<int> points;        ///< indices, ascending
  std::vector<PetscMPIInt> ranks; ///< destination of each
  /// A point without a destination (-1) stays where it is.
  void Add(int point, PetscMPIInt rank)
  {
    if (rank < 0) return;
    points.push_back(point);
    ranks.push_back(rank);
  }
};

/// Moves points out of `from` into `to` (the same object for migration within a level), across the ranks of `comm`.
/// Collective. Arrivals are ordered by source rank and place, so that a fixed number of ranks repeats bit for bit.
PetscErrorCode MovePoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants);

/// The same, but the points stay in `from` as well. Departures are ordered by rank. origins: of each arrival, in the order
/// of storage, its rank and its place among that rank's migrants.
PetscErrorCode CopyPoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants, std::vector<PetscSFNode> *origins);

} // namespace mlgimp
