// The border between two levels as in the paper (Sec. 3.2, Fig. 5): each level carries copies of the other's points in a
// region on both sides of the border, steps by itself, and the copies are renewed after each step of the coarser level.
//
// Owners are the roots of a PetscSF and copies its leaves; it is rebuilt only when points have come, gone or changed
// places. Three repairs make the scheme stable, see docs/levels.md; without them it is the paper's.
#pragma once

#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// What `points` coupling adds to the paper's exchange.
struct CopyRepairs {
  bool owner_flags = true;         ///< a point has one owner for ever; else its place alone decides, as printed
  bool velocity_shift = true;      ///< velocities belong to half steps, which differ between levels
  bool strain_smoothing = true;    ///< copies on the finer level get F and stress as the coarser grid sees them
  bool momentum_correction = true; ///< momentum lost at borders is put back into the points that have copies
};

/// How far copies reach.
struct GhostWidths {
  int outside;    ///< cells of the finer level outside its box: copies of the coarser level's points
  int inside = 4; ///< cells of the coarser level inside the box: copies of the finer level's points
};

/// Copies of one level's points on a neighbour, in the neighbour's store of copies.
class PointCopies
{
public:
  /// `finer`: the points of the coarser level are copied to the finer one; else the other way. The levels are kept by
  /// reference.
  PetscErrorCode Create(MPI_Comm world, Level &coarse, Level &fine, bool finer, const GhostWidths &widths);

  /// Makes the copies equal to their owners. step: the owners' last time step, s; dt_shift: time from the owner's half
  /// step to the copy's, s; smooth: F and stress as the owners' grid sees them. Collective.
  PetscErrorCode Renew(double step, double dt_shift, bool smooth);
  /// Points of this rank that have copies.
  const std::vector<int> &Sources() const { return sources_.points; }
  Level &Owner() { return *from_; }

private:
  Migrants FindSources();
  PetscErrorCode Rebuild();
  PetscErrorCode PackState(double step, double dt_shift, bool smooth);
  void UnpackState();
  int StateSize() const;

  MPI_Comm world_ = MPI_COMM_NULL;
  Level *from_ = nullptr, *to_ = nullptr;
  Box inner_{}, outer_{}; ///< sources lie in the outer box, but not in the inner one
  int origin_ = 0;        ///< which store of copies
  Migrants sources_;      ///< points of this rank that have copies, and where
  long version_ = -1, copy_version_ = -1;
  SFHandle exchange_;
  UnitHandle unit_;                    ///< what changes of a point
  std::vector<double> state_, copies_; ///< what changes, of sources and of copies
};

/// Both directions of copying at one border.
class CopyBorder
{
public:
  PetscErrorCode Create(MPI_Comm world, Level &coarse, Level &fine, int ratio, const CopyRepairs &repairs,
                        const GhostWidths &widths);

  /// Renews the copies on both sides when both levels are at the same time; dt: the coarse step. Collective.
  PetscErrorCode Exchange(double dt);
  /// Ownership as printed: a point inside the box belongs to the finer level, be it a copy or not. Loses and doubles points
  /// whose copy and owner disagree. Collective.
  PetscErrorCode DecideByPlace();
  /// Mass of this rank's points that have copies, kg.
  double RingMass();
  /// Adds a velocity to the points that have copies.
  void CorrectMomentum(Vec3 dv);

private:
  Level *coarse_ = nullptr, *fine_ = nullptr;
  int ratio_ = 2;
  CopyRepairs repairs_;
  PointCopies to_fine_, to_coarse_;
};

} // namespace mlgimp
