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
  double points, mass, faces[kSides]; ///< -, kg, area of the outer faces on each side, m2 (m in the plane)
};

/// Area of a side of a box with such edges; in the plane its length.
double SideArea(Side side, Vec3 size, int dim)
{
  double area = 1;
  for (int k = 0; k < dim - 1; ++k) area *= size[TangentAxis(side, k)];
  return area;
}

/// Sums of all bodies, and the area of the faces that each load acts on. Collective.
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
      const auto area = [&](int s) { return SideArea(static_cast<Side>(s), 2 * a.HalfSize(p), a.dim); };
      for (int s = 0; s < 2 * a.dim; ++s)
        if (a.faces[p] & OuterFaceBit(static_cast<Side>(s))) body.faces[s] += area(s);
      for (int k = 0; k < a.loads; ++k) (*loads)[k] += a.load_share[PointArrays::At(p, a.loads) + k] * area(model.loads[k].side);
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
    for (int d = 0; d < c.Dim(); ++d)
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
  double volume = c.model.geometry.OutOfPlane(0.5 * (bounds.lower[0] + bounds.upper[0]));
  for (int axis = 0; axis < c.Dim(); ++axis) volume *= size[axis];
  const double mass = volume * c.model.materials[body.material]->Density();
  PetscCheck(!body.region->IsBox() || !Differ(sums.mass, mass), comm, PETSC_ERR_USER_INPUT,
             "-bodies %s: must have the mass of its box, %s kg; its points have %s kg", body.name.c_str(),
             FormatNumber(mass).c_str(), FormatNumber(sums.mass).c_str());
  const char *const unit = c.Dim() == 3 ? "m2" : "m";
  for (int axis = 0; axis < c.Dim(); ++axis) {
    const Side lower = static_cast<Side>(2 * axis), upper = static_cast<Side>(2 * axis + 1);
    for (const Side side : {lower, upper})
      PetscCheck(!body.region->IsBox() || !IsFree(c, b, side) || !Differ(sums.faces[side], SideArea(side, size, c.Dim())), comm,
                 PETSC_ERR_USER_INPUT, "-bodies %s: must have outer faces along its whole side %s, %s %s; they add up to %s %s",
                 body.name.c_str(), kSideNames[side], FormatNumber(SideArea(side, size, c.Dim())).c_str(), unit,
                 FormatNumber(sums.faces[side]).c_str(), unit);
    PetscCheck(!IsFree(c, b, lower) || !IsFree(c, b, upper) || !Differ(sums.faces[lower], sums.faces[upper]), comm,
               PETSC_ERR_USER_INPUT, "-bodies %s: must have as many outer faces on side %s as on %s; they are %s and %s %s",
               body.name.c_str(), kSideNames[lower], kSideNames[upper], FormatNumber(sums.faces[lower]).c_str(),
               FormatNumber(sums.faces[upper]).c_str(), unit);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// area: of the faces that the load acts on, m2 (m in the plane).
PetscErrorCode CheckLoad(MPI_Comm comm, const Case &c, std::size_t k, double area)
{
  const Load &load = c.model.loads[k];
  const Body &body = c.model.bodies[load.body];
  const Box bounds = body.region->Bounds();
  const std::string name = c.load_names[k], unit = c.Dim() == 3 ? " m2" : " m";
  double wanted = 1, largest_edge = 0;
  std::string beyond; // what the user gave where it reaches beyond the side
  PetscFunctionBeginUser;
  PetscCheck(area > 0, comm, PETSC_ERR_USER_INPUT, "-loads %s: must cover a free face of body %s; see its side and span",
             name.c_str(), body.name.c_str());
  if (!body.region->IsBox()) PetscFunctionReturn(PETSC_SUCCESS);
  for (int t = 0; t < c.Dim() - 1; ++t) {
    const int along = TangentAxis(load.side, t);
    const double *const span = load.span[t];
    const double part = std::min(bounds.upper[along], span[1]) - std::max(bounds.lower[along], span[0]);
    const double start = std::isfinite(span[0]) ? span[0] : bounds.lower[along];
    const double end = std::isfinite(span[1]) ? span[1] : bounds.upper[along];
    if (end - start > part + 2 * kRounding * c.cell_size)
      beyond += (beyond.empty() ? "" : ",") + FormatNumber(start) + "," + FormatNumber(end);
    wanted *= part;
    largest_edge = std::max(largest_edge, part);
  }
  const double tolerance = 2 * kRounding * c.cell_size * (c.Dim() == 3 ? 2 * largest_edge : 1);
  PetscCheck(!IsFree(c, load.body, load.side) || std::abs(area - wanted) < tolerance, comm, PETSC_ERR_USER_INPUT,
             "-loads %s: must act on %s%s of body %s; the faces it acts on add up to %s%s", name.c_str(),
             FormatNumber(wanted).c_str(), unit.c_str(), body.name.c_str(), FormatNumber(area).c_str(), unit.c_str());
  if (!beyond.empty())
    PetscCall(PetscFPrintf(comm, PETSC_STDERR,
                           "mlgimp: warning: -%s_span %s: reaches beyond the side of body %s; the load acts on %s%s\n",
                           name.c_str(), beyond.c_str(), body.name.c_str(), FormatRounded(wanted).c_str(), unit.c_str()));
  if (area < wanted - tolerance)
    PetscCall(PetscFPrintf(comm, PETSC_STDERR,
                           "mlgimp: warning: -loads %s: acts on %s of the %s%s of its side; the rest touches a body or a held "
                           "side of the domain\n",
                           name.c_str(), FormatRounded(area).c_str(), FormatRounded(wanted).c_str(), unit.c_str()));
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
      for (int corner = 0; corner < 1 << a.dim; ++corner) {
        Vec3 x = a.Position(p);
        for (int d = 0; d < a.dim; ++d) x[d] += (corner >> d & 1 ? 1 : -1) * a.HalfSize(p)[d];
        deepest = std::max(deepest, -c.model.indenter->Gap(x, 0).distance);
      }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, hierarchy.Comm()));
  const Vec3 tip = c.model.indenter->tip;
  PetscCheck(deepest <= 1e-6 * c.cell_size, hierarchy.Comm(), PETSC_ERR_USER_INPUT,
             "-indenter_tip %s: must leave the indenter outside every body; it starts %s m inside one",
             FormatVector(tip, c.Dim()).c_str(), FormatRounded(deepest).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
