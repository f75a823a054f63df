// PETSc's headers, the few names that its versions spell differently, and this rank's place among others.
#pragma once

#include <petscdmda.h>
#include <petscdmswarm.h>
#include <petscksp.h>
#include <petscsf.h>

#if PETSC_VERSION_LT(3, 19, 0)
inline constexpr PetscErrorCode PETSC_SUCCESS = 0;
/// Only later versions of MINRES bound the norm of their solution.
inline PetscErrorCode KSPMINRESSetRadius(KSP, PetscReal) { return PETSC_SUCCESS; }
#endif

#if PETSC_VERSION_LT(3, 22, 0)
inline constexpr int PETSC_CURRENT = PETSC_DEFAULT;
inline constexpr auto PetscOptionsCreateViewer = PetscOptionsGetViewer;
#endif

#if PETSC_VERSION_LT(3, 23, 0)
using OptionItems = PetscOptionItems *;
#else
using OptionItems = PetscOptionItems;
#endif

namespace mlgimp
{

/// This rank in a communicator, and the number of its ranks.
inline PetscMPIInt RankIn(MPI_Comm comm)
{
  PetscMPIInt rank;
  MPI_Comm_rank(comm, &rank);
  return rank;
}
inline PetscMPIInt RanksOf(MPI_Comm comm)
{
  PetscMPIInt ranks;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

} // namespace mlgimp
