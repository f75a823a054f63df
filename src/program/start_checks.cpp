// Sums over the points of each body at the start, against its shape.
#include "program/start_checks.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kSame = 1e-9; ///< relative; sums over many points are exact to 1e-12

/// What the points of a body add up to.
struct BodySums {
  double points, mass, faces[kSides]; ///< -, kg, length of the outer faces on each side, m
};

/// Sums of all bodies, and the length of the faces that each load acts on, m. Collective.
PetscErrorCode SumBodies(Hierarchy &hierarchy, const Model &model, std::vector<BodySums> *bodies, std::vector<double> *loads)
{
  PetscFunctionBeginUser;
  bodies->assign(model.bodies.size(), {});
  loads->assign(model.loads.size(), 0.0);
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    PointArrays a;
    PetscCall(hierarchy.At(l).PointStore().Arrays(&a));
    for (int p = 0; p < a.count; ++p) {
      BodySums &body = (*bodies)[a.body[p]];
      ++body.points;
      body.mass += a.mass[p];
      const auto length = [&](Side side) { return 2 * a.half_size[2 * p + 1 - AxisOf(side)]; };
      for (int s = 0; s < kSides; ++s)
        if (a.faces[p] & OuterFaceBit(static_cast<Side>(s))) body.faces[s] += length(static_cast<Side>(s));
      for (int k = 0; k < a.loads; ++k) (*loads)[k] += a.load_share[a.loads * p + k] * length(model.loads[k].side);
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bodies->data(), static_cast<int>(bodies->size() * sizeof(BodySums) / sizeof(double)),
                             MPI_DOUBLE, MPI_SUM, hierarchy.Comm()));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, loads->data(), static_cast<int>(loads->size()), MPI_DOUBLE, MPI_SUM, hierarchy.Comm()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool Differ(double a, double b) { return std::abs(a - b) > kSame * std::abs(b); }

/// True where nothing can cover a side of a body: neither another body nor a held side of the domain is within a cell.
bool IsFree(const Case &c, std::size_t body, Side side)
{
  const Box bounds = c.model.bodies[body].region->Bounds();
  if (c.model.sides[side] != BoundaryKind::kFree && std::abs(bounds.At(side) - c.domain.At(side)) < c.cell_size) return false;
  for (std::size_t b = 0; b < c.model.bodies.size(); ++b) {
    const Box other = c.model.bodies[b].region->Bounds();
    bool near = b != body;
    for (int d = 0; d < 2; ++d)
      near = near && other.lower[d] < bounds.upper[d] + c.cell_size && other.upper[d] > bounds.lower[d] - c.cell_size;
    if (near) return false;
  }
  return true;
}

/// A box has its mass and its sides' lengths; any closed outline shows as much to one side as to the other.
PetscErrorCode CheckBody(MPI_Comm comm, const Case &c, std::size_t b, const BodySums &sums)
{
  const Body &body = c.model.bodies[b];
  const Box bounds = body.region->Bounds();
  const Vec3 size = bounds.upper - bounds.lower;
  PetscFunctionBeginUser;
  PetscCheck(sums.points > 0, comm, PETSC_ERR_USER_INPUT,
             "-bodies %s: must hold at least one material point; it is too small for -cell_size %s", body.name.c_str(),
             FormatNumber(c.cell_size).c_str());
  const double mass = size[0] * size[1] * c.model.thickness * c.model.materials[body.material]->Density();
  PetscCheck(!body.region->IsBox() || !Differ(sums.mass, mass), comm, PETSC_ERR_USER_INPUT,
             "-bodies %s: must have the mass of its box, %s kg; its points have %s kg", body.name.c_str(),
             FormatNumber(mass).c_str(), FormatNumber(sums.mass).c_str());
  for (int axis = 0; axis < 2; ++axis) {
    const Side lower = static_cast<Side>(2 * axis), upper = static_cast<Side>(2 * axis + 1);
    for (const Side side : {lower, upper})
      PetscCheck(!body.region->IsBox() || !IsFree(c, b, side) || !Differ(sums.faces[side], size[1 - axis]), comm,
                 PETSC_ERR_USER_INPUT, "-bodies %s: must have outer faces along its whole side %s, %s m; they add up to %s m",
                 body.name.c_str(), kSideNames[side], FormatNumber(size[1 - axis]).c_str(),
                 FormatNumber(sums.faces[side]).c_str());
    PetscCheck(!IsFree(c, b, lower) || !IsFree(c, b, upper) || !Differ(sums.faces[lower], sums.faces[upper]), comm,
               PETSC_ERR_USER_INPUT, "-bodies %s: must have as many outer faces on side %s as on %s; they are %s and %s m",
               body.name.c_str(), kSideNames[lower], kSideNames[upper], FormatNumber(sums.faces[lower]).c_str(),
               FormatNumber(sums.faces[upper]).c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// length: of the faces that the load acts on, m.
PetscErrorCode CheckLoad(MPI_Comm comm, const Case &c, std::size_t k, double length)
{
  const Load &load = c.model.loads[k];
  const Body &body = c.model.bodies[load.body];
  const Box bounds = body.region->Bounds();
  const int along = 1 - AxisOf(load.side);
  PetscFunctionBeginUser;
  PetscCheck(length > 0, comm, PETSC_ERR_USER_INPUT, "-loads %s: must cover a free face of body %s; see its side and span",
             c.load_names[k].c_str(), body.name.c_str());
  if (!body.region->IsBox()) PetscFunctionReturn(PETSC_SUCCESS);
  const double wanted = std::min(bounds.upper[along], load.span[1]) - std::max(bounds.lower[along], load.span[0]);
  PetscCheck(!IsFree(c, load.body, load.side) || std::abs(length - wanted) < 2 * kRounding * c.cell_size, comm,
             PETSC_ERR_USER_INPUT, "-loads %s: must act on %s m of body %s; the faces it acts on add up to %s m",
             c.load_names[k].c_str(), FormatNumber(wanted).c_str(), body.name.c_str(), FormatNumber(length).c_str());
  const double start = std::isfinite(load.span[0]) ? load.span[0] : bounds.lower[along];
  const double end = std::isfinite(load.span[1]) ? load.span[1] : bounds.upper[along];
  if (end - start > wanted + 2 * kRounding * c.cell_size)
    PetscCall(PetscFPrintf(
        comm, PETSC_STDERR, "mlgimp: warning: -%s_span %s: reaches beyond the side of body %s; the load acts on %s m\n",
        c.load_names[k].c_str(), FormatVector({start, end}).c_str(), body.name.c_str(), FormatRounded(wanted).c_str()));
  if (length < wanted - 2 * kRounding * c.cell_size)
    PetscCall(PetscFPrintf(comm, PETSC_STDERR,
                           "mlgimp: warning: -loads %s: acts on %s of the %s m of its side; the rest touches a body or a held "
                           "side of the domain\n",
                           c.load_names[k].c_str(), FormatRounded(length).c_str(), FormatRounded(wanted).c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode CheckBodies(Hierarchy &hierarchy, const Case &c)
{
  std::vector<BodySums> bodies;
  std::vector<double> loads;
  PetscFunctionBeginUser;
  PetscCall(SumBodies(hierarchy, c.model, &bodies, &loads));
  for (std::size_t b = 0; b < bodies.size(); ++b) PetscCall(CheckBody(hierarchy.Comm(), c, b, bodies[b]));
  for (std::size_t k = 0; k < loads.size(); ++k) PetscCall(CheckLoad(hierarchy.Comm(), c, k, loads[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckIndenter(Hierarchy &hierarchy, const Case &c)
{
  double deepest = 0;
  PetscFunctionBeginUser;
  if (!c.model.indenter) PetscFunctionReturn(PETSC_SUCCESS);
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    PointArrays a;
    const std::vector<int> *surface = nullptr;
    PetscCall(hierarchy.At(l).PointStore().Arrays(&a));
    PetscCall(hierarchy.At(l).PointStore().SurfacePoints(&surface));
    for (int p : *surface)
      for (int corner = 0; corner < 4; ++corner) {
        const Vec3 x = {a.position[2 * p] + (corner % 2 ? 1 : -1) * a.half_size[2 * p],
                        a.position[2 * p + 1] + (corner / 2 ? 1 : -1) * a.half_size[2 * p + 1]};
        deepest = std::max(deepest, -c.model.indenter->Gap(x, 0).distance);
      }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, hierarchy.Comm()));
  const Vec3 tip = c.model.indenter->tip;
  PetscCheck(deepest <= 1e-6 * c.cell_size, hierarchy.Comm(), PETSC_ERR_USER_INPUT,
             "-indenter_tip %s: must leave the indenter outside every body; it starts %s m inside one", FormatVector(tip).c_str(),
             FormatRounded(deepest).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
