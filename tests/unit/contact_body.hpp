// A body on a grid, as the parts of contact see it.
#pragma once

#include "level/contact/columns.hpp"

namespace mlgimp
{

inline constexpr double kH = 0.25; ///< size of its cells, m

/// A grid of 16 cells along each axis on all ranks of a communicator, in columns of blocks, and what contact sees of it.
struct PressedBody {
  Grid grid;
  ContactGroup group;
  Points points;
  BodyTable bodies;
  BoundaryConditions sides;
  Indenter indenter;
  Geometry geometry;

  PetscErrorCode Create(MPI_Comm comm)
  {
    PetscMPIInt size;
    const GridGeometry shape = {{0, 0, 0}, kH, {16, 16, 16}, 1, geometry.Dim()};
    GridLayout layout;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_size(comm, &size));
    layout.widths[1] = {shape.Nodes(1)};
    layout.widths[2] = {shape.Nodes(2)};
    for (int rank = 0; rank < size; ++rank) {
      layout.widths[0].push_back(shape.Nodes(0) * (rank + 1) / size - shape.Nodes(0) * rank / size);
      layout.ranks.push_back(rank);
    }
    PetscCall(grid.Create(comm, shape, layout));
    PetscCall(group.Create(grid, kAllNodes));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ContactView View() { return {grid, group, points, bodies, sides, indenter, geometry, 0, 0, 1e-3}; }
};

} // namespace mlgimp
