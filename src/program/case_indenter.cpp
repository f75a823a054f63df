// Options of the indenter, its motion and the contact solver.
#include "program/case_groups.hpp"

#include "level/contact/contact.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

PetscErrorCode ReadSurface(OptionReader &reader, const std::string &kind, std::unique_ptr<IndenterSurface> *surface)
{
  double half_angle = NAN, radius = NAN, width = NAN, tip_radius = 0;
  PetscFunctionBeginUser;
  if (kind == "wedge" || reader.Help()) {
    PetscCall(reader.Number({"-indenter_half_angle", "angle of a wedge's face from its axis", "degrees"}, Open(0, 90), true,
                            &half_angle));
    PetscCall(reader.Number({"-indenter_tip_radius", "radius of a wedge's rounded tip", "m"}, kNotNegative, false, &tip_radius));
    if (!reader.Help() && std::sin(half_angle * M_PI / 180) <= kLeastFacing)
      PetscCall(reader.Refuse("-indenter_half_angle", FormatNumber(half_angle),
                              "above 5.74 degrees; contact acts on faces that lean toward the surface, and misses steeper ones"));
    if (!reader.Help()) *surface = CreateWedge(half_angle, tip_radius);
  }
  if (kind == "cylinder" || reader.Help()) {
    PetscCall(reader.Number({"-indenter_radius", "radius of a cylinder", "m"}, kPositive, true, &radius));
    if (!reader.Help()) *surface = CreateCylinder(radius);
  }
  if (kind == "flat_punch" || reader.Help()) {
    PetscCall(reader.Number({"-indenter_width", "width of a flat punch", "m"}, kPositive, true, &width));
    if (!reader.Help()) *surface = CreateFlatPunch(width);
  }
  if (kind == "polygon" || reader.Help()) {
    std::vector<double> numbers;
    std::vector<Vec3> vertices;
    PetscCall(reader.Numbers({"-indenter_vertices", "x,y of a convex polygon; its lowest vertex is put at the tip", "m"},
                             kAnyNumber, 6, 0, true, &numbers));
    for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices.push_back({numbers[k], numbers[k + 1]});
    if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
    if (numbers.size() % 2 || !IsConvex(vertices))
      PetscCall(
          reader.Refuse("-indenter_vertices", std::to_string(numbers.size()) + " numbers", "x,y pairs of a convex polygon"));
    *surface = CreatePolygonIndenter(vertices);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Height of the highest body under a place; false where there is none.
bool SurfaceBelow(const Case &c, double x, double *height)
{
  constexpr int kLattice = 4096;
  bool found = false;
  for (const Body &body : c.model.bodies) {
    const Box bounds = body.region->Bounds();
    const double step = (bounds.upper[1] - bounds.lower[1]) / kLattice, width = bounds.upper[0] - bounds.lower[0];
    for (double shift : {0.0, 1e-6 * width, -1e-6 * width})
      for (int k = 0; k < kLattice; ++k) {
        double inside = bounds.upper[1] - (k + 0.5) * step, outside = inside + step;
        if (!body.region->Contains({x + shift, inside})) continue;
        for (int halving = 0; halving < 40; ++halving) {
          const double middle = 0.5 * (inside + outside);
          (body.region->Contains({x + shift, middle}) ? inside : outside) = middle;
        }
        if (std::abs(inside - bounds.upper[1]) < 1e-9 * (bounds.upper[1] - bounds.lower[1])) inside = bounds.upper[1];
        *height = found ? std::max(*height, inside) : inside;
        found = true;
        break;
      }
  }
  return found;
}

/// The turn at the largest depth, and the end of the run that follows from the motion.
PetscErrorCode ReadTurningPoint(OptionReader &reader, Case *c)
{
  double depth = HUGE_VAL, unload = 0;
  bool has_depth = false, has_unload = false;
  Indenter &indenter = *c->model.indenter;
  PetscFunctionBeginUser;
  PetscCall(reader.Number(
      {"-indenter_max_depth", "tip depth below the body's initial surface that ends the run or turns to unloading", "m"},
      kPositive, false, &depth, &has_depth));
  if (has_depth || reader.Help())
    PetscCall(reader.Number(
        {"-indenter_unload_velocity", "speed of retraction from the largest depth on, until the tip is back", "m/s"}, kAnyNumber,
        false, &unload, &has_unload));
  if (has_unload && unload == 0) PetscCall(reader.Refuse("-indenter_unload_velocity", "0", "not zero"));
  if (!has_depth || reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  const double travel = depth + indenter.tip[1] - indenter.initial_surface;
  if (travel <= 0)
    PetscCall(reader.Refuse("-indenter_tip", reader.Text(indenter.tip), "above the depth that -indenter_max_depth gives"));
  const double limit = std::isfinite(c->time.end_time) ? c->time.end_time : HUGE_VAL;
  const double reached = indenter.motion.speed.TimeOfIntegral(travel, limit);
  if (!std::isfinite(reached)) {
    if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0)
      PetscCall(
          reader.Refuse("-indenter_max_depth", FormatNumber(depth), "reached by the indenter's motion, or -end_time given"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (has_unload) {
    indenter.motion.turning_time = reached;
    indenter.motion.unload_speed = std::abs(unload);
    c->time.end_time = std::min(c->time.end_time, reached + travel / std::abs(unload));
  } else {
    c->time.end_time = reached;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Those of PETSc's types that solve the contact equations; others end with PETSc's errors, or never.
const std::vector<std::string> kSolvers = {"cg",     "cr",  "minres", "symmlq", "gmres", "fgmres",
                                           "lgmres", "gcr", "bicg",   "bcgs",   "cgs",   "tfqmr"};
const std::vector<std::string> kPreconditioners = {"jacobi", "none", "sor", "eisenstat", "icc", "ilu", "cholesky", "lu", "svd"};

/// One of the types, where the option is given.
PetscErrorCode CheckType(OptionReader &reader, const std::string &option, const std::vector<std::string> &types)
{
  std::string text = "default";
  bool given = false;
  PetscFunctionBeginUser;
  PetscCall(reader.Text({option, "type of the solver of the contact pressures", ""}, false, &text, &given));
  if (given && std::find(types.begin(), types.end(), text) == types.end())
    PetscCall(reader.Refuse(option, text, "one of " + Join(types, ", ")));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The options that the solver of the contact pressures reads by itself, checked before it does so in PETSc's way.
PetscErrorCode CheckContactSolver(OptionReader &reader)
{
  double tolerance = 1e-10;
  int iterations = 10000;
  PetscFunctionBeginUser;
  reader.Identify(false);
  PetscCall(CheckType(reader, "-contact_ksp_type", kSolvers));
  PetscCall(CheckType(reader, "-contact_pc_type", kPreconditioners));
  PetscCall(
      reader.Number({"-contact_ksp_rtol", "relative tolerance of the contact pressures", ""}, Open(0, 1), false, &tolerance));
  PetscCall(
      reader.Integer({"-contact_ksp_max_it", "most iterations for the contact pressures", ""}, Closed(1, 2e9), &iterations));
  reader.Identify(true);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lowest place of the tip during the run; -infinity where the end of the run is not known.
double LowestTip(const Indenter &indenter, double end_time)
{
  constexpr int kSamples = 1000;
  if (!std::isfinite(end_time)) return -HUGE_VAL;
  double lowest = indenter.Tip(std::min(end_time, indenter.motion.turning_time))[1];
  for (int k = 0; k <= kSamples; ++k) lowest = std::min(lowest, indenter.Tip(end_time * k / kSamples)[1]);
  return lowest;
}

/// An indenter of which less than a cell ever meets the surface does not act, as a pressure belongs to a column of cells.
PetscErrorCode CheckIndenterSize(OptionReader &reader, const Case &c, const std::string &kind)
{
  const Indenter &indenter = *c.model.indenter;
  const int level = c.LevelAtTip();
  const double h = c.CellSize(level), depth = indenter.initial_surface - LowestTip(indenter, c.time.end_time);
  const std::string cell = FormatRounded(h) + " m, a cell of level " + std::to_string(level) + ", which it meets";
  PetscFunctionBeginUser;
  if (indenter.surface->Width(HUGE_VAL) < h * (1 - kRounding))
    PetscCall(
        reader.Refuse("-indenter", kind,
                      "at least as wide as " + cell + "; it is " + FormatRounded(indenter.surface->Width(HUGE_VAL)) + " m wide"));
  if (c.model.contact.method != "none" && depth > 0 && indenter.surface->Width(depth) < h)
    PetscCall(PetscFPrintf(
        reader.Comm(), PETSC_STDERR,
        "mlgimp: warning: -indenter %s: at its largest depth of %s m it is %s m wide, less than %s: the load is "
        "that of the cells\n",
        kind.c_str(), FormatRounded(depth).c_str(), FormatRounded(indenter.surface->Width(depth)).c_str(), cell.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A level that the tip meets must hold it with the band of its border for the whole run.
PetscErrorCode CheckIndenterPath(OptionReader &reader, const Case &c)
{
  const Indenter &indenter = *c.model.indenter;
  const double x = indenter.tip[0], lowest = LowestTip(indenter, c.time.end_time);
  PetscFunctionBeginUser;
  for (int k = 1; k < c.levels; ++k) {
    const Box &box = c.boxes[k];
    const double margin = c.least_blend_width * c.CellSize(k - 1) + kBorderCells * c.CellSize(k);
    const double just_below = indenter.initial_surface - 1e-6 * c.CellSize(k);
    if (just_below < box.lower[1] || just_below >= box.upper[1] || x < box.lower[0] - margin || x > box.upper[0] + margin)
      continue;
    const std::string needed = " from the indenter's tip at x = " + FormatNumber(x) + ", or the level away from it";
    if (c.IsBorder(k, kXLower) && x < box.lower[0] + margin)
      PetscCall(reader.Refuse("-level_" + std::to_string(k) + "_lower", reader.Text(box.lower),
                              "at least " + FormatRounded(margin) + needed));
    if (c.IsBorder(k, kXUpper) && x > box.upper[0] - margin)
      PetscCall(reader.Refuse("-level_" + std::to_string(k) + "_upper", reader.Text(box.upper),
                              "at least " + FormatRounded(margin) + needed));
    if (c.IsBorder(k, kYLower) && std::isfinite(lowest) && lowest < box.lower[1] + margin)
      PetscCall(
          reader.Refuse("-level_" + std::to_string(k) + "_lower", reader.Text(box.lower),
                        "at least " + FormatRounded(margin) + " below the indenter's lowest place, " + FormatRounded(lowest)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode ReadIndenter(OptionReader &reader, Case *c)
{
  std::string kind = "none";
  std::vector<std::string> methods = ContactMethods(GeometryKind::kPlaneStrain);
  PetscFunctionBeginUser;
  methods.push_back("none");
  PetscCall(reader.Choice({"-indenter", "rigid indenter", ""}, {"none", "wedge", "cylinder", "flat_punch", "polygon"}, &kind));
  PetscCall(reader.Choice({"-contact", "contact method", ""}, methods, &c->model.contact.method));
  if (kind == "none" && !reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string &method = c->model.contact.method;
  const bool has_solver = method == "pressure" || method == "point_pressure";
  if (method == "pressure" || reader.Help())
    PetscCall(reader.Number({"-contact_width", "half width of the kernel of a contact pressure in cells; 1 is the hat", ""},
                            {0, 1, true, false}, false, &c->model.contact.width));
  if (has_solver && !reader.Help()) PetscCall(CheckContactSolver(reader));
  Indenter &indenter = c->model.indenter.emplace();
  PetscCall(ReadSurface(reader, kind, &indenter.surface));
  PetscCall(reader.Vector({"-indenter_tip", "lowest point of the indenter at t = 0", "m"}, true, &indenter.tip));
  PetscCall(ReadHistory(reader, "-indenter_times",
                        {"-indenter_velocities", "downward speed at the times, negative retracts", "m/s"},
                        &indenter.motion.speed));
  if (!reader.Help() && !SurfaceBelow(*c, indenter.tip[0], &indenter.initial_surface)) {
    indenter.initial_surface = -HUGE_VAL;
    for (const Body &body : c->model.bodies)
      indenter.initial_surface = std::max(indenter.initial_surface, body.region->Bounds().upper[1]);
  }
  PetscCall(ReadTurningPoint(reader, c));
  if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CheckIndenterPath(reader, *c));
  PetscCall(CheckIndenterSize(reader, *c, kind));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
