// What PETSc's viewers show of a level.
#include "level/level.hpp"

namespace mlgimp
{

PetscErrorCode Level::View(const std::string &prefix, double time)
{
  PetscBool nodes = PETSC_FALSE;
  const Budgets before = budgets_;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(stores_.own.View(prefix));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &nodes));
  if (nodes) {
    PetscCall(PointsToGrid(time));
    PetscCall(grid_->ShareSums());
    budgets_ = before;
  }
  PetscCall(grid_->View(prefix, settings_.nodal.mass_cutoff));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Names of the components of a node and the place that each node has in space, for viewers that write them.
static PetscErrorCode Describe(DM nodes, const GridGeometry &geometry)
{
  const std::string vectors[] = {"momentum_", "velocity_", "force_"};
  Vec3 lower{}, upper{};
  PetscFunctionBeginUser;
  PetscCall(DMDASetFieldName(nodes, 0, "mass"));
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < geometry.dim; ++axis)
      PetscCall(DMDASetFieldName(nodes, 1 + k * geometry.dim + axis, (vectors[k] + static_cast<char>('x' + axis)).c_str()));
  const IndexBox box = geometry.NodeBox();
  for (int axis = 0; axis < 3; ++axis) {
    lower[axis] = geometry.lower[axis] + geometry.spacing * box.lower[axis];
    upper[axis] = geometry.lower[axis] + geometry.spacing * (box.upper[axis] - 1);
  }
  PetscCall(DMDASetUniformCoordinates(nodes, lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::View(const std::string &prefix, double mass_cutoff) const
{
  VecHandle values;
  PetscScalar *array = nullptr;
  PetscBool on = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectSetName(nodes_.Object(), (prefix + "grid").c_str()));
  PetscCall(DMSetOptionsPrefix(nodes_, prefix.c_str()));
  PetscCall(DMViewFromOptions(nodes_, nullptr, "-dm_view"));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &on));
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Describe(nodes_, geometry_));
  PetscCall(DMCreateGlobalVector(nodes_, values.Out()));
  PetscCall(VecGetArrayWrite(values, &array));
  PetscScalar *value = array;
  ForEach(owned_, [&](Index node) {
    const NodeSums &sums = sums_[Place(node)];
    const double per_mass = sums.mass > mass_cutoff ? 1 / sums.mass : 0;
    *value++ = sums.mass;
    for (int axis = 0; axis < geometry_.dim; ++axis) {
      value[axis] = sums.momentum[axis];
      value[geometry_.dim + axis] = sums.momentum[axis] * per_mass;
      value[2 * geometry_.dim + axis] = sums.force[axis];
    }
    value += 3 * geometry_.dim;
  });
  PetscCall(VecRestoreArrayWrite(values, &array));
  PetscCall(PetscObjectSetName(values.Object(), (prefix + "nodes").c_str()));
  PetscCall(VecSetOptionsPrefix(values, prefix.c_str()));
  PetscCall(VecViewFromOptions(values, nullptr, "-nodes_view"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
