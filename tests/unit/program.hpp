// The main function of the test programs: GoogleTest between the start and the end of PETSc and MPI.
#pragma once

#include "base/petsc.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace mlgimp
{

/// Runs the tests on every rank; 1 if one of them failed anywhere. The first rank writes what --gtest_output asks for.
inline PetscErrorCode RunAllTests(int *failed)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  testing::TestEventListeners &listeners = testing::UnitTest::GetInstance()->listeners();
  if (rank > 0) delete listeners.Release(listeners.default_xml_generator());
  *failed = RUN_ALL_TESTS();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Runs the tests of a program, or with the argument "table" the study behind them, which gets the number that follows
/// (0 for none).
inline int RunProgram(int argc, char **argv, PetscErrorCode (*table)(int) = nullptr)
{
  int failed = 0;
  testing::InitGoogleTest(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  if (table && argc > 1 && std::string(argv[1]) == "table")
    PetscCall(table(argc > 2 ? std::atoi(argv[2]) : 0));
  else
    PetscCall(RunAllTests(&failed));
  PetscCall(PetscFinalize());
  return failed;
}

} // namespace mlgimp
