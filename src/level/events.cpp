// The log events of a step's phases, by the names that -log_view has.
#include "level/events.hpp"

#include <string>

namespace mlgimp
{

PetscErrorCode RegisterLogEvents(LogEvents *events)
{
  PetscClassId id;
  PetscFunctionBeginUser;
  PetscCall(PetscClassIdRegister("mlgimp", &id));
  PetscCall(PetscLogEventRegister("P2G", id, &events->points_to_grid));
  PetscCall(PetscLogEventRegister("Halo", id, &events->halo));
  PetscCall(PetscLogEventRegister("GridUpdate", id, &events->grid_update));
  PetscCall(PetscLogEventRegister("Contact", id, &events->contact));
  PetscCall(PetscLogEventRegister("Surface", id, &events->surface));
  PetscCall(PetscLogEventRegister("G2PStress", id, &events->grid_to_points));
  PetscCall(PetscLogEventRegister("Coupling", id, &events->coupling));
  PetscCall(PetscLogEventRegister("Transfer", id, &events->transfer));
  PetscCall(PetscLogEventRegister("Migrate", id, &events->migrate));
  PetscCall(PetscLogEventRegister("Sort", id, &events->sort));
  PetscCall(PetscLogEventRegister("Balance", id, &events->balance));
  PetscCall(PetscLogEventRegister("Output", id, &events->output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RegisterLevelStage(int l, PetscLogStage *stage)
{
  const std::string name = "level " + std::to_string(l);
  PetscFunctionBeginUser;
  PetscCall(PetscLogStageGetId(name.c_str(), stage));
  if (*stage < 0) PetscCall(PetscLogStageRegister(name.c_str(), stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
