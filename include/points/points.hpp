// The material points of one level: a DMSwarm of type BASIC as storage, sorting, and moving points between ranks.
#pragma once

#include "base/handle.hpp"
#include "physics/point_fields.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

class Points
{
public:
  /// Each rank stores points of its own; PETSc sees them on `comm`. Collective on it.
  PetscErrorCode Create(MPI_Comm comm, GeometryKind geometry, int loads, int history_components);
  /// The points of this rank, as they are, in a swarm on another communicator. Collective on that.
  PetscErrorCode MoveTo(MPI_Comm comm);

  int Count() const { return count_; }
  /// Changes whenever points come, go or change places in storage.
  long Version() const { return version_; }
  const std::array<PointFieldInfo, kPointFields> &Table() const { return table_; }

  /// The fields as arrays; valid until the next Resize or View.
  PointArrays Arrays();
  void *Field(PointField field) { return data_[field]; }

  /// Keeps the first `count` points, or adds uninitialised ones. Storage grows by a tenth at a time.
  PetscErrorCode Resize(int count);

  /// Removes points, given in ascending order; the last points take their places.
  void Remove(const std::vector<int> &points);

  /// Makes point `target` equal to point `source`.
  void Copy(int source, int target);

  /// Reorders the points in place so that point k is the one that was at order[k].
  void Reorder(std::vector<int> order);

  /// Points with a bit of `faces` set, in storage order; found anew after points have moved in storage.
  const std::vector<int> &SurfacePoints();
  /// Must be called after bits of `faces` have changed.
  void RecordSurface() { surface_known_ = false; }

  /// A whole point as a record of so many bytes.
  std::size_t RecordBytes() const
  {
    std::size_t bytes = 0;
    for (const PointFieldInfo &field : table_) bytes += FieldBytes(field);
    return bytes;
  }
  void Pack(int point, char *record) const;
  void Unpack(const char *record, int point);

  /// Shows the points to the viewer that the option -PREFIXpoints_view names: their number, or in HDF5 all fields of real
  /// numbers. Collective.
  PetscErrorCode View(const std::string &prefix);

  ~Points();
  Points() = default;
  Points(const Points &) = delete;
  Points &operator=(const Points &) = delete;

private:
  /// A field as bytes.
  struct FieldMemory {
    char *data;
    std::size_t bytes; ///< of a point
    char *Of(int point) const { return data + bytes * point; }
  };
  std::vector<FieldMemory> Memory() const;
  MPI_Comm Comm() const { return PetscObjectComm(swarm_.Object()); }
  PetscErrorCode CreateSwarm(MPI_Comm comm);
  PetscErrorCode AccessFields();
  PetscErrorCode ReleaseFields();
  PetscErrorCode ViewSwarm(const std::string &prefix, PetscViewer viewer);
  PetscErrorCode ViewFields(const std::string &prefix, PetscViewer viewer) const;
  void RecordChange();
  int dim_ = 2;

  DMHandle swarm_;
  std::array<PointFieldInfo, kPointFields> table_{};
  std::array<void *, kPointFields> data_{};
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

/// Adds copies of points of this rank to another store of the same fields.
PetscErrorCode AppendPoints(const Points &from, const std::vector<int> &points, Points &to);

} // namespace mlgimp
