// Creation of a level's grid, what its ranks send each other in a step, and its views.
#include "grid/grid.hpp"

#include <cstddef>

namespace mlgimp
{

PetscErrorCode Grid::Create(MPI_Comm world, const GridGeometry &geometry, const GridLayout &layout, int volume_averages,
                            bool marks_cells)
{
  PetscFunctionBeginUser;
  PetscCall(nodes_.Create(world, geometry, layout));
  PetscCall(arrays_.Create(geometry.dim, Ghosted().Count(), volume_averages, marks_cells));
  if (Participates()) PetscCall(halo_.Create(nodes_));
  lattice_.inverse_spacing = 1 / geometry.spacing;
  for (int axis = 0, stride = 1; axis < 3; stride *= Ghosted().Size(axis++)) {
    lattice_.origin[axis] = geometry.lower[axis];
    lattice_.first[axis] = Ghosted().lower[axis];
    lattice_.stride[axis] = stride;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// So many numbers from `first` on.
static void Choose(int first, int count, std::vector<int> *chosen)
{
  for (int k = 0; k < count; ++k) chosen->push_back(first + k);
}

PetscErrorCode Grid::ShareSums()
{
  const int dim = Geometry().dim;
  NodalField sums = {&Sums()->mass, NodeLayout::kSums, {}};
  PetscFunctionBeginUser;
  Choose(offsetof(NodeSums, mass) / sizeof(double), 2 + dim, &sums.chosen); // and owned mass, momentum
  Choose(offsetof(NodeSums, force) / sizeof(double), dim, &sums.chosen);
  if (arrays_.Marks())
    PetscCall(halo_.Sum({sums, {arrays_.Marks(), 1, {0}}}));
  else
    PetscCall(halo_.Sum({sums}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Grid::ShareRates(int count)
{
  NodalField rates = {arrays_.RatesArray(), NodeLayout::Rates(Geometry().dim), {}};
  NodalField cells = {reinterpret_cast<double *>(arrays_.Cells(0)),
                      arrays_.CellStride() * static_cast<int>(sizeof(CellSums) / sizeof(double)),
                      {}};
  PetscFunctionBeginUser;
  Choose(0, count, &rates.chosen);
  Choose(0, static_cast<int>(cells.size), &cells.chosen);
  PetscCall(halo_.Sum({rates, cells}));
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
  const DM nodes = nodes_.DistributedArray();
  const int dim = Geometry().dim;
  VecHandle values;
  PetscScalar *array = nullptr;
  PetscBool on = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectSetName(reinterpret_cast<PetscObject>(nodes), (prefix + "grid").c_str()));
  PetscCall(DMSetOptionsPrefix(nodes, prefix.c_str()));
  PetscCall(DMViewFromOptions(nodes, nullptr, "-dm_view"));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &on));
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Describe(nodes, Geometry()));
  PetscCall(DMCreateGlobalVector(nodes, values.Out()));
  PetscCall(VecGetArrayWrite(values, &array));
  PetscScalar *value = array;
  ForEach(Owned(), [&](Index node) {
    const NodeSums &sums = Sums()[Place(node)];
    const double per_mass = sums.mass > mass_cutoff ? 1 / sums.mass : 0;
    *value++ = sums.mass;
    for (int axis = 0; axis < dim; ++axis) {
      value[axis] = sums.momentum[axis];
      value[dim + axis] = sums.momentum[axis] * per_mass;
      value[2 * dim + axis] = sums.force[axis];
    }
    value += 3 * dim;
  });
  PetscCall(VecRestoreArrayWrite(values, &array));
  PetscCall(PetscObjectSetName(values.Object(), (prefix + "nodes").c_str()));
  PetscCall(VecSetOptionsPrefix(values, prefix.c_str()));
  PetscCall(VecViewFromOptions(values, nullptr, "-nodes_view"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
