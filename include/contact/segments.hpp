// The surface near the indenter in segments, brought to one rank.
//
// Segments come in the order of their patches' numbers, so that the rank that solves finds the same numbers in the same order on
// any number of ranks.
#pragma once

#include "grid/cell_place.hpp"
#include "surface/pieces.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace mlgimp
{

/// A patch that the indenter may press, or the part of it under a face of the indenter.
struct Segment {
  std::int64_t patch; ///< number of its patch, and that of the part of it
  std::int64_t path;
  PetscMPIInt rank;      ///< of the group, that has the patch
  int at;                ///< its place in the list there
  double offset;         ///< by which it has flowed out of the line of the corners, m
  Vec3 corner[4];        ///< of the patch, m
  double corner_part[4]; ///< their weights in its centre
  CellPlace place;       ///< of its centre
  Vec3 normal;           ///< of the indenter
  double area;           ///< of the body's surface, m2
  double pressed;        ///< the part of it that the indenter may press; 0 of surface beside it, m2
  double ring;           ///< its radius over that of the face at the start that it is part of, which areas are taken at: an even
                         ///< pressure then gives nodes near an axis what an even stress of points does; 1 without an axis
  double gap;            ///< to the indenter at the end of the step, with a free tip where it was, m
  double modulus;        ///< plane-strain modulus E/(1 - nu^2) of its material, Pa
  double flow;           ///< mean pressure at which its material flows, infinite where it does not, Pa; 0 where it creeps at any
};

/// A change of a segment's offset for the rank that has its patch.
struct SegmentFlow {
  PetscMPIInt rank;
  int at;
  double by; ///< m
};

/// Adds the segments of this rank's patches that are near the indenter, and face it or lie beside it. least_gap: of all near it,
/// m; penetration: deepest place inside the indenter at the start of the step, m; both as they were where nothing is less, or
/// deeper. rank: this one, in the group.
void CollectSegments(const SurfaceInputs &surface, const TipStep &tip, PetscMPIInt rank, std::vector<Segment> *segments,
                     double *least_gap, double *penetration);

/// Brings segments to the first rank of the group, by their numbers. Collective on the group.
PetscErrorCode GatherSegments(MPI_Comm comm, std::vector<Segment> *segments);

/// The nodes that their patches' corners move with.
std::vector<Index> NodesOf(const Grid &grid, const std::vector<Segment> &segments);

} // namespace mlgimp
