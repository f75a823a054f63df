// PETSc's headers, and the few names that its versions spell differently.
#pragma once

#include <petscdmda.h>
#include <petscdmswarm.h>
#include <petscksp.h>
#include <petscsf.h>

#if PETSC_VERSION_LT(3, 19, 0)
inline constexpr PetscErrorCode PETSC_SUCCESS = 0;
#endif

#if PETSC_VERSION_LT(3, 23, 0)
using OptionItems = PetscOptionItems *;
#else
using OptionItems = PetscOptionItems;
#endif
