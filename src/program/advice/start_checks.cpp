// Compares the sums over the points of each body at the start with its shape.
#include "program/advice/case_checks.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kSame = 1e-9; ///< rounding: relative; sums over many points are exact to 1e-12

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

/// Circumference at a radius, m; 1 where there is no axis.
double RoundAxis(const Geometry &geometry, double radius) { return geometry.HasHoop() ? geometry.OutOfPlane(radius) : 1; }

/// Half the edges of a point's box, which is not sheared at the start, m.
Vec3 HalfEdges(const PointArrays &a, int p)
{
  Vec3 half{};
  for (int axis = 0; axis < a.dim; ++axis) half[axis] = CurrentHalfSize(a, p, axis);
  return half;
}

/// Sums of all bodies, and the area of the faces that each load acts on. Collective.
void SumBodies(Hierarchy &hierarchy, const Model &model, std::vector<BodySums> *bodies, std::vector<double> *loads)
{
  bodies->assign(model.bodies.size(), {});
  loads->assign(model.loads.size(), 0.0);
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    const PointArrays a = hierarchy.At(l).PointStore().Arrays();
    for (int p = 0; p < a.count; ++p) {
      BodySums &body = (*bodies)[a.body[p]];
      ++body.points;
      body.mass += a.mass[p];
      const auto area = [&](Side side) { return SideArea(side, 2 * HalfEdges(a, p), a.dim); };
      for (const Side side : SidesOf{a.dim})
        if (a.faces[p] & OuterFaceBit(side)) body.faces[side] += area(side);
      for (int k = 0; k < a.loads; ++k) {
        const Side side = model.loads[k].side;
        const double x = a.Position(p)[0] + (AxisOf(side) == 0 ? SignOf(side) * HalfEdges(a, p)[0] : 0);
        (*loads)[k] += a.load_share[PointArrays::At(p, a.loads) + k] * area(side) * RoundAxis(model.geometry, x);
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, bodies->data(), static_cast<int>(bodies->size() * sizeof(BodySums) / sizeof(double)), MPI_DOUBLE,
                MPI_SUM, hierarchy.Comm());
  MPI_Allreduce(MPI_IN_PLACE, loads->data(), static_cast<int>(loads->size()), MPI_DOUBLE, MPI_SUM, hierarchy.Comm());
}

bool Differ(double a, double b) { return std::abs(a - b) > kSame * std::abs(b); }

/// True where neither another body nor a held side of the domain is within a cell of a side of a body.
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

/// Why points cannot fill a box that is a small part of a cell thin, and what cells it needs; empty for others.
std::string DescribeThin(const Case &c, const Box &bounds)
{
  const double cell = c.CellSize(c.LevelAt(0.5 * (bounds.lower + bounds.upper)));
  double thinnest = HUGE_VAL;
  for (int axis = 0; axis < c.Dim(); ++axis) thinnest = std::min(thinnest, bounds.upper[axis] - bounds.lower[axis]);
  if (thinnest >= kSliver * cell) return "";
  return Format(", as it is {} m thin, {} of a cell of {} m; take cells of at most {} m there (-cell_size, -levels)", thinnest,
                thinnest / cell, cell, 0.5 * thinnest);
}

/// A box has its mass and its sides' lengths.
void CheckBody(const Case &c, std::size_t b, const BodySums &sums)
{
  const Body &body = c.model.bodies[b];
  const Box bounds = body.region->Bounds();
  const Vec3 size = bounds.upper - bounds.lower;
  const std::string start = Format("-bodies {}: must have ", body.name), unit = c.Dim() == 3 ? " m2" : " m";
  if (sums.points == 0)
    Refuse("-bodies {}: must hold at least one material point; it is too small for -cell_size {}{}", body.name,
           FormatNumber(c.cell_size), DescribeThin(c, bounds));
  double volume = c.model.geometry.OutOfPlane(0.5 * (bounds.lower[0] + bounds.upper[0]));
  for (int axis = 0; axis < c.Dim(); ++axis) volume *= size[axis];
  const double growth = body.stretch[0] * body.stretch[1] * body.stretch[2];
  const double mass = volume / growth * c.model.materials[body.material]->Density();
  if (body.region->IsBox() && Differ(sums.mass, mass))
    Refuse("{}the mass of its box, {} kg; its points have {} kg{}", start, FormatNumber(mass), FormatNumber(sums.mass),
           DescribeThin(c, bounds));
  for (int axis = 0; axis < c.Dim(); ++axis) {
    const auto [lower, upper] = SidesAcross(axis);
    for (const Side side : {lower, upper})
      if (const double area = SideArea(side, size, c.Dim());
          body.region->IsBox() && IsFree(c, b, side) && Differ(sums.faces[side], area))
        Refuse("{}outer faces along its whole side {}, {}{}; they add up to {}{}", start, kSideNames[side], FormatNumber(area),
               unit, FormatNumber(sums.faces[side]), unit);
  }
}

/// Refuses a hole along the axis of less than two cells that no other body fills: usually r = 0 was meant.
void CheckHole(const Case &c, std::size_t b)
{
  const Box bounds = c.model.bodies[b].region->Bounds();
  const double radius = bounds.lower[0], cell = c.CellSize(c.LevelAt({radius, bounds.upper[1] - kRounding * c.cell_size, 0}));
  if (!c.model.geometry.HasHoop() || radius <= 0 || radius >= 2 * cell) return;
  for (const Body &other : c.model.bodies)
    if (other.region->Bounds().lower[0] < radius) return;
  Refuse("-bodies {}: must begin at x = 0, the axis, or at least two cells, {} m, from it; it leaves a hole of {} m",
         c.model.bodies[b].name, 2 * cell, radius);
}

/// Half the thickness, in cells, of each body's thinnest outer point that begins at a line of cells, so that it is alone beyond
/// that line; HUGE_VAL where there is none. Collective.
std::vector<double> ThinnestAlone(Hierarchy &hierarchy, const Model &model)
{
  std::vector<double> thinnest(model.bodies.size(), HUGE_VAL);
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    const PointArrays a = hierarchy.At(l).PointStore().Arrays();
    const GridGeometry &grid = hierarchy.At(l).Mesh().Geometry();
    for (const int p : hierarchy.At(l).PointStore().SurfacePoints())
      for (const Side side : SidesOf{a.dim}) {
        const int axis = AxisOf(side);
        const double half = HalfEdges(a, p)[axis],
                     inner = (a.Position(p)[axis] - SignOf(side) * half - grid.lower[axis]) / grid.spacing;
        if (a.faces[p] & OuterFaceBit(side) && std::abs(inner - std::round(inner)) < kRounding)
          thinnest[a.body[p]] = std::min(thinnest[a.body[p]], half / grid.spacing);
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, thinnest.data(), static_cast<int>(thinnest.size()), MPI_DOUBLE, MPI_MIN, hierarchy.Comm());
  return thinnest;
}

/// Such points are unstable from half a square of the Courant number down where they follow the new velocity:
/// docs/decisions.md.
void CheckThinPoints(const Case &c, std::size_t b, double thinnest, std::vector<std::string> *warnings)
{
  const Body &body = c.model.bodies[b];
  const double speed = c.model.materials[body.material]->SpeedOfSound();
  const double courant = c.time.time_step > 0 ? speed * c.time.time_step / c.cell_size : c.time.cfl;
  const bool follows = c.model.stress_update == StressUpdate::kUsl || c.levels > 1 || c.model.VolumeAverages() > 0;
  if (!follows || std::max(thinnest, c.model.LeastHalfSize()) >= 0.5 * courant * courant) return;
  warnings->push_back(Format("-bodies {}: has points {} of a cell thin, alone beyond a line of cells: unstable with usl, in "
                             "metals and at borders of levels; move its sides, or take a -cfl below {}",
                             body.name, 2 * thinnest, std::sqrt(2 * thinnest)));
}

/// A side that nothing holds, and no load, gives way to the stress across it.
void CheckInitialStress(const Case &c, std::size_t b, std::vector<std::string> *warnings)
{
  const Body &body = c.model.bodies[b];
  const Vec3 across = {body.stress.xx, body.stress.yy, body.stress.zz};
  const double largest = std::max({std::abs(across[0]), std::abs(across[1]), std::abs(across[2])});
  for (const Side side : SidesOf{c.Dim()}) {
    const auto acts = [&](const Load &load) { return load.body == static_cast<int>(b) && load.side == side; };
    if (std::abs(across[AxisOf(side)]) <= kSame * largest || !IsFree(c, b, side) ||
        std::any_of(c.model.loads.begin(), c.model.loads.end(), acts))
      continue;
    warnings->push_back(
        Format("-{}_initial_stress: nothing holds the side {} of the body against the {} Pa across it, and it will "
               "move; let it be 0, or let the body reach a side of the domain with -boundary_{} symmetry",
               body.name, kSideNames[side], across[AxisOf(side)], kSideNames[side]));
  }
}

/// area: of the faces that the load acts on, m2 (in plane strain by its thickness, m).
void CheckLoad(const Case &c, std::size_t k, double area, std::vector<std::string> *warnings)
{
  const Load &load = c.model.loads[k];
  const Body &body = c.model.bodies[load.body];
  const Box bounds = body.region->Bounds();
  const std::string name = c.load_names[k], start = Format("-loads {}: ", name),
                    unit = c.model.geometry.kind == GeometryKind::kPlaneStrain ? " m" : " m2";
  const double farthest = RoundAxis(c.model.geometry, bounds.upper[0]);
  double wanted = AxisOf(load.side) == 0 ? RoundAxis(c.model.geometry, bounds.At(load.side)) : 1, largest_edge = 0;
  std::string beyond; // what the user gave where it reaches beyond the side
  if (area == 0) Refuse("{}must cover a free face of body {}; see its side and span", start, body.name);
  if (!body.region->IsBox()) return;
  for (int t = 0; t < c.Dim() - 1; ++t) {
    const int along = TangentAxis(load.side, t);
    const double *const span = load.span[t];
    const double from = std::max(bounds.lower[along], span[0]), to = std::min(bounds.upper[along], span[1]), part = to - from;
    const double first = std::isfinite(span[0]) ? span[0] : bounds.lower[along];
    const double last = std::isfinite(span[1]) ? span[1] : bounds.upper[along];
    if (last - first > part + 2 * kRounding * c.cell_size)
      beyond += Format("{}{},{}", beyond.empty() ? "" : ",", FormatNumber(first), FormatNumber(last));
    wanted *= part * (along == 0 ? RoundAxis(c.model.geometry, 0.5 * (from + to)) : 1);
    largest_edge = std::max(largest_edge, part);
  }
  const double tolerance = 2 * kRounding * c.cell_size * (c.Dim() == 3 ? 2 * largest_edge : farthest);
  if (IsFree(c, load.body, load.side) && !(std::abs(area - wanted) < tolerance))
    Refuse("{}must act on {}{} of body {}; the faces it acts on add up to {}{}", start, FormatNumber(wanted), unit, body.name,
           FormatNumber(area), unit);
  if (!beyond.empty())
    warnings->push_back(
        Format("-{}_span {}: reaches beyond the side of body {}; the load acts on {}{}", name, beyond, body.name, wanted, unit));
  if (area < wanted - tolerance)
    warnings->push_back(Format("{}acts on {} of the {}{} of its side; the rest touches a body or a held side of the domain",
                               start, area, wanted, unit));
}

} // namespace

std::vector<std::string> CheckBodies(Hierarchy &hierarchy, const Case &c)
{
  std::vector<std::string> warnings;
  std::vector<BodySums> bodies;
  std::vector<double> loads;
  SumBodies(hierarchy, c.model, &bodies, &loads);
  const std::vector<double> thinnest = ThinnestAlone(hierarchy, c.model);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    CheckHole(c, b);                               // -bodies: a narrow hole along the axis
    CheckBody(c, b, bodies[b]);                    // -bodies: no points, or not the mass or the faces of a box
    CheckThinPoints(c, b, thinnest[b], &warnings); // -bodies: points too thin for the steps
    CheckInitialStress(c, b, &warnings);           // -BODY_initial_stress: across sides that nothing holds
  }
  for (std::size_t k = 0; k < loads.size(); ++k)
    CheckLoad(c, k, loads[k], &warnings); // -loads, -LOAD_span: no face, or not all of the span
  return warnings;
}

void CheckIndenter(Hierarchy &hierarchy, const Case &c)
{
  double deepest = 0;
  if (!c.model.indenter) return;
  for (int l = 0; l < hierarchy.Levels(); ++l) {
    const PointArrays a = hierarchy.At(l).PointStore().Arrays();
    const std::vector<int> &surface = hierarchy.At(l).PointStore().SurfacePoints();
    for (int p : surface)
      for (int corner = 0; corner < 1 << a.dim; ++corner) {
        Vec3 x = a.Position(p);
        for (int d = 0; d < a.dim; ++d) x[d] += (corner >> d & 1 ? 1 : -1) * HalfEdges(a, p)[d];
        const Region &region = *c.model.bodies[a.body[p]].region;
        if (!region.IsBox() && !region.Contains(x)) continue; // a corner of a step
        deepest = std::max(deepest, -c.model.indenter->Gap(x, c.model.indenter->tip).distance);
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, hierarchy.Comm());
  if (!(deepest <= 1e-6 * c.cell_size))
    Refuse("-indenter_tip {}: must be such that the indenter starts outside every body; it starts {} m inside one",
           FormatVector(c.model.indenter->tip, c.Dim()), deepest);
}

} // namespace mlgimp
