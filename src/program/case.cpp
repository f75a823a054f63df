// Options to case, group by group.
#include "program/case.hpp"

#include "level/contact.hpp"

#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <unistd.h>

namespace mlgimp
{

namespace
{

/// Index of a name in a list that another option gave.
PetscErrorCode FindName(OptionReader &reader, const std::string &option, const std::vector<std::string> &names,
                        const std::string &list, const std::string &name, int *place)
{
  PetscFunctionBeginUser;
  const auto found = std::find(names.begin(), names.end(), name);
  *place = static_cast<int>(found - names.begin());
  if (found == names.end() && !reader.Help())
    PetscCall(reader.Refuse(option, name, "one of the names in " + list + ": " + Join(names, ", ")));
  if (found == names.end()) *place = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadGrid(OptionReader &reader, Case *c)
{
  std::string geometry = "plane_strain";
  PetscFunctionBeginUser;
  PetscCall(reader.Choice({"-geometry", "kinematics", ""}, {"plane_strain", "axisymmetric", "3d"}, &geometry));
  if (geometry != "plane_strain") PetscCall(reader.Refuse("-geometry", geometry, "plane_strain: it is the only one built yet"));
  PetscCall(reader.Number({"-thickness", "out-of-plane thickness", "m"}, kPositive, false, &c->model.thickness));
  PetscCall(reader.Vector({"-domain_lower", "lower corner of the level-0 grid", "m"}, true, &c->domain.lower));
  PetscCall(reader.Vector({"-domain_upper", "upper corner of the level-0 grid", "m"}, true, &c->domain.upper));
  PetscCall(reader.Number({"-cell_size", "edge of a level-0 cell", "m"}, kPositive, true, &c->cell_size));
  PetscCall(reader.Integer({"-levels", "number of grid levels", ""}, Closed(1, 1), &c->levels));
  PetscCall(reader.Integer({"-refinement_ratio", "cell-size and time-step ratio of neighbouring levels", ""}, Closed(2, 16),
                           &c->refinement_ratio));
  for (int s = 0; s < kSides; ++s) {
    const std::string names[kSides] = {"x_lower", "x_upper", "y_lower", "y_upper"};
    const std::vector<std::string> kinds = {"free", "symmetry", "fixed"};
    std::string kind = "free";
    PetscCall(reader.Choice({"-boundary_" + names[s], "side of the domain", ""}, kinds, &kind));
    c->model.sides[s] = static_cast<SideKind>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
  }
  if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  for (int axis = 0; axis < 2; ++axis) {
    const double cells = (c->domain.upper[axis] - c->domain.lower[axis]) / c->cell_size;
    if (!(cells > 0)) PetscCall(reader.Refuse("-domain_upper", FormatVector(c->domain.upper), "above -domain_lower " + FormatVector(c->domain.lower)));
    if (cells > 1e6) PetscCall(reader.Refuse("-cell_size", FormatNumber(c->cell_size), "at least a millionth of the domain's edges"));
    if (std::abs(cells - std::round(cells)) > 1e-6 * std::max(1.0, cells) || std::round(cells) < 1)
      PetscCall(reader.Refuse("-cell_size", FormatNumber(c->cell_size),
                              "a whole fraction of the domain's edges " + FormatNumber(c->domain.upper[0] - c->domain.lower[0]) +
                                  " and " + FormatNumber(c->domain.upper[1] - c->domain.lower[1])));
  }
  // PETSc counts nodal values as PetscInt; four more nodes an axis leave room for the grid's padding.
  const double nodes = (c->Cells(0) + 4.0) * (c->Cells(1) + 4.0), most = PETSC_MAX_INT / NodeArrays::kSums;
  if (nodes > most)
    PetscCall(reader.Refuse("-cell_size", FormatNumber(c->cell_size),
                            "such that the grid has at most " + FormatNumber(most) + " nodes; it would have " + FormatNumber(nodes)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names)
{
  PetscFunctionBeginUser;
  PetscCall(reader.Names({"-materials", "names of the materials", ""}, true, names));
  for (const std::string &name : *names) {
    const std::string prefix = "-" + name + "_";
    std::string model = "neo_hookean";
    MaterialConstants k{NAN, NAN, NAN, NAN, NAN};
    PetscCall(reader.Choice({prefix + "model", "constitutive law", ""}, MaterialModels(), &model));
    PetscCall(reader.Number({prefix + "youngs_modulus", "Young's modulus", "Pa"}, kPositive, true, &k.youngs_modulus));
    PetscCall(reader.Number({prefix + "poissons_ratio", "Poisson's ratio", ""}, Open(-1, 0.5), true, &k.poissons_ratio));
    PetscCall(reader.Number({prefix + "density", "initial density", "kg/m3"}, kPositive, true, &k.density));
    if (ModelHasYield(model) || reader.Help()) {
      PetscCall(reader.Number({prefix + "yield_stress", "yield stress (j2)", "Pa"}, kPositive, true, &k.yield_stress));
      PetscCall(reader.Number({prefix + "hardening_modulus", "slope of the yield stress over plastic strain (j2)", "Pa"},
                              kNotNegative, true, &k.hardening_modulus));
    }
    c->model.materials.push_back(CreateMaterial(model, k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadRegion(OptionReader &reader, const std::string &name, std::unique_ptr<Region> *region)
{
  const std::string prefix = "-" + name + "_";
  std::string shape = "box";
  PetscFunctionBeginUser;
  PetscCall(reader.Choice({prefix + "shape", "shape of the body", ""}, {"box", "disk", "polygon"}, &shape));
  if (shape == "box" || reader.Help()) {
    Box box;
    PetscCall(reader.Vector({prefix + "lower", "lower corner (box)", "m"}, true, &box.lower));
    PetscCall(reader.Vector({prefix + "upper", "upper corner (box)", "m"}, true, &box.upper));
    if (!(box.upper[0] > box.lower[0] && box.upper[1] > box.lower[1]) && !reader.Help())
      PetscCall(reader.Refuse(prefix + "upper", FormatVector(box.upper), "above " + prefix + "lower " + FormatVector(box.lower)));
    *region = CreateBoxRegion(box);
  }
  if (shape == "disk" || reader.Help()) {
    Vec2 center{};
    double radius = 0;
    PetscCall(reader.Vector({prefix + "center", "centre (disk)", "m"}, true, &center));
    PetscCall(reader.Number({prefix + "radius", "radius (disk)", "m"}, kPositive, true, &radius));
    *region = CreateDiskRegion(center, radius);
  }
  if (shape == "polygon" || reader.Help()) {
    std::vector<double> numbers;
    std::vector<Vec2> vertices;
    PetscCall(reader.Numbers({prefix + "vertices", "x,y of the vertices in order (polygon)", "m"}, kAnyNumber, 6, 0, true, &numbers));
    if (numbers.size() % 2) PetscCall(reader.Refuse(prefix + "vertices", std::to_string(numbers.size()) + " numbers", "x,y pairs"));
    for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices.push_back({numbers[k], numbers[k + 1]});
    if (!reader.Help()) *region = CreatePolygonRegion(vertices);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A place inside both regions is looked for on a lattice over the common part of their bounds.
bool Overlap(const Region &a, const Region &b)
{
  constexpr int kLattice = 64;
  const Box A = a.Bounds(), B = b.Bounds();
  Vec2 lower, size;
  for (int d = 0; d < 2; ++d) {
    lower[d] = std::max(A.lower[d], B.lower[d]);
    size[d] = std::min(A.upper[d], B.upper[d]) - lower[d];
    if (size[d] <= 1e-9 * (A.upper[d] - A.lower[d])) return false;
  }
  for (int j = 0; j < kLattice; ++j)
    for (int i = 0; i < kLattice; ++i) {
      const Vec2 x = {lower[0] + (i + 0.5) / kLattice * size[0], lower[1] + (j + 0.5) / kLattice * size[1]};
      if (a.Contains(x) && b.Contains(x)) return true;
    }
  return false;
}

PetscErrorCode ReadBodies(OptionReader &reader, const std::vector<std::string> &materials, Case *c,
                          std::vector<std::string> *names)
{
  PetscFunctionBeginUser;
  PetscCall(reader.Names({"-bodies", "names of the bodies", ""}, true, names));
  for (const std::string &name : *names) {
    const std::string prefix = "-" + name + "_";
    Body body{name, nullptr, 0, {0, 0}, 2};
    std::string material = materials.size() == 1 ? materials[0] : "";
    PetscCall(ReadRegion(reader, name, &body.region));
    PetscCall(reader.Text({prefix + "material", "name of its material", ""}, materials.size() > 1, &material));
    PetscCall(FindName(reader, prefix + "material", materials, "-materials", material, &body.material));
    PetscCall(reader.Vector({prefix + "velocity", "initial velocity", "m/s"}, false, &body.velocity));
    PetscCall(reader.Integer({prefix + "points_per_cell", "material points per direction in a cell", ""}, Closed(1, 16),
                             &body.points_per_cell));
    if (!reader.Help()) {
      const Box bounds = body.region->Bounds();
      const double tolerance = 1e-9 * c->cell_size;
      for (int d = 0; d < 2; ++d)
        if (bounds.lower[d] < c->domain.lower[d] - tolerance || bounds.upper[d] > c->domain.upper[d] + tolerance)
          PetscCall(reader.Refuse("-bodies", name, "inside the domain; it reaches from " + FormatVector(bounds.lower) +
                                                       " to " + FormatVector(bounds.upper)));
      for (const Body &other : c->model.bodies)
        if (Overlap(*body.region, *other.region))
          PetscCall(reader.Refuse("-bodies", name, "clear of body " + other.name + ": they overlap"));
    }
    c->model.bodies.push_back(std::move(body));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Times and values of a piecewise-linear history.
PetscErrorCode ReadHistory(OptionReader &reader, const std::string &times_name, const OptionText &values_text,
                           PiecewiseLinear *history)
{
  std::vector<double> times, values;
  PetscFunctionBeginUser;
  PetscCall(reader.Numbers({times_name, "times of the history, increasing", "s"}, kNotNegative, 1, 0, true, &times));
  PetscCall(reader.Numbers(values_text, kAnyNumber, 1, 0, true, &values));
  if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  for (std::size_t k = 1; k < times.size(); ++k)
    if (times[k] <= times[k - 1]) PetscCall(reader.Refuse(times_name, FormatNumber(times[k]), "increasing"));
  if (times.size() != values.size())
    PetscCall(reader.Refuse(values_text.name, std::to_string(values.size()) + " values",
                            "as many as " + times_name + " has: " + std::to_string(times.size())));
  *history = PiecewiseLinear(times, values);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadLoads(OptionReader &reader, const std::vector<std::string> &bodies, Case *c)
{
  std::vector<std::string> names;
  const std::vector<std::string> sides = {"x_lower", "x_upper", "y_lower", "y_upper"};
  PetscFunctionBeginUser;
  PetscCall(reader.Names({"-loads", "names of pressures on sides of bodies", ""}, false, &names));
  if (names.size() > kMaxLoads)
    PetscCall(reader.Refuse("-loads", std::to_string(names.size()) + " names", "at most " + std::to_string(kMaxLoads)));
  for (const std::string &name : names) {
    const std::string prefix = "-" + name + "_";
    Load load{0, kXLower, {-HUGE_VAL, HUGE_VAL}, {}};
    std::string body = bodies[0], side = sides[0];
    std::vector<double> span = {load.span[0], load.span[1]};
    PetscCall(reader.Text({prefix + "body", "name of the body", ""}, bodies.size() > 1, &body));
    PetscCall(FindName(reader, prefix + "body", bodies, "-bodies", body, &load.body));
    PetscCall(reader.Choice({prefix + "side", "side of the body", ""}, sides, &side));
    load.side = static_cast<Side>(std::find(sides.begin(), sides.end(), side) - sides.begin());
    PetscCall(reader.Numbers({prefix + "span", "start,end along the side", "m"}, kAnyNumber, 2, 2, false, &span));
    load.span[0] = span[0];
    load.span[1] = span[1];
    if (!(span[1] > span[0])) PetscCall(reader.Refuse(prefix + "span", FormatVector({span[0], span[1]}), "start,end with end above start"));
    PetscCall(ReadHistory(reader, prefix + "times", {prefix + "pressures", "pressure at the times, positive into the body", "Pa"}, &load.pressure));
    c->model.loads.push_back(load);
    c->load_names.push_back(name);
  }
  PetscCall(reader.Vector({"-gravity", "body acceleration", "m/s2"}, false, &c->model.nodal.gravity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadSurface(OptionReader &reader, const std::string &kind, std::unique_ptr<IndenterSurface> *surface)
{
  double half_angle = NAN, radius = NAN, width = NAN, tip_radius = 0;
  PetscFunctionBeginUser;
  if (kind == "wedge" || reader.Help()) {
    PetscCall(reader.Number({"-indenter_half_angle", "angle of a wedge's face from its axis", "degrees"}, Open(0, 90), true, &half_angle));
    PetscCall(reader.Number({"-indenter_tip_radius", "radius of a wedge's rounded tip", "m"}, kNotNegative, false, &tip_radius));
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
    std::vector<Vec2> vertices;
    PetscCall(reader.Numbers({"-indenter_vertices", "x,y of a convex polygon; its lowest vertex is put at the tip", "m"}, kAnyNumber, 6, 0, true, &numbers));
    for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) vertices.push_back({numbers[k], numbers[k + 1]});
    if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
    if (numbers.size() % 2 || !IsConvex(vertices))
      PetscCall(reader.Refuse("-indenter_vertices", std::to_string(numbers.size()) + " numbers", "x,y pairs of a convex polygon"));
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
  PetscCall(reader.Number({"-indenter_max_depth", "tip depth below the body's initial surface that ends the run or turns to unloading", "m"},
                          kPositive, false, &depth, &has_depth));
  if (has_depth || reader.Help())
    PetscCall(reader.Number({"-indenter_unload_velocity", "speed of retraction from the largest depth on, until the tip is back", "m/s"},
                            kAnyNumber, false, &unload, &has_unload));
  if (has_unload && unload == 0) PetscCall(reader.Refuse("-indenter_unload_velocity", "0", "not zero"));
  if (!has_depth || reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  const double travel = depth + indenter.tip[1] - indenter.initial_surface;
  const double limit = std::isfinite(c->time.end_time) ? c->time.end_time : HUGE_VAL;
  const double reached = indenter.motion.speed.TimeOfIntegral(travel, limit);
  if (!std::isfinite(reached)) {
    if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0)
      PetscCall(reader.Refuse("-indenter_max_depth", FormatNumber(depth), "reached by the indenter's motion, or -end_time given"));
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

/// A type that PETSc knows, where the option is given.
PetscErrorCode CheckType(OptionReader &reader, const std::string &option, PetscFunctionList list)
{
  std::string text = "default";
  bool given = false;
  const char **names = nullptr;
  int count = 0;
  PetscFunctionBeginUser;
  PetscCall(reader.Text({option, "type of the solver of the contact pressures", ""}, false, &text, &given));
  PetscCall(PetscFunctionListGet(list, &names, &count));
  std::vector<std::string> known;
  for (int k = 0; k < count; ++k)
    if (names[k]) known.push_back(names[k]);
  PetscCall(PetscFree(names));
  if (given && std::find(known.begin(), known.end(), text) == known.end())
    PetscCall(reader.Refuse(option, text, "one of " + Join(known, ", ")));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The options that the solver of the contact pressures reads by itself, checked before it does so in PETSc's way.
PetscErrorCode CheckContactSolver(OptionReader &reader)
{
  double tolerance = 1e-10;
  int iterations = 10000;
  PetscFunctionBeginUser;
  PetscCall(KSPInitializePackage());
  PetscCall(PCInitializePackage());
  reader.Identify(false);
  PetscCall(CheckType(reader, "-contact_ksp_type", KSPList));
  PetscCall(CheckType(reader, "-contact_pc_type", PCList));
  PetscCall(reader.Number({"-contact_ksp_rtol", "relative tolerance of the contact pressures", ""}, Open(0, 1), false, &tolerance));
  PetscCall(reader.Integer({"-contact_ksp_max_it", "most iterations for the contact pressures", ""}, Closed(1, 2e9), &iterations));
  reader.Identify(true);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadIndenter(OptionReader &reader, Case *c)
{
  std::string kind = "none";
  std::vector<std::string> methods = ContactMethods();
  PetscFunctionBeginUser;
  methods.push_back("none");
  PetscCall(reader.Choice({"-indenter", "rigid indenter", ""}, {"none", "wedge", "cylinder", "flat_punch", "polygon"}, &kind));
  PetscCall(reader.Choice({"-contact", "contact method", ""}, methods, &c->model.contact));
  if (kind == "none" && !reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  const bool has_solver = c->model.contact == "pressure" || c->model.contact == "point_pressure";
  if (has_solver && !reader.Help()) PetscCall(CheckContactSolver(reader));
  Indenter &indenter = c->model.indenter.emplace();
  PetscCall(ReadSurface(reader, kind, &indenter.surface));
  PetscCall(reader.Vector({"-indenter_tip", "lowest point of the indenter at t = 0", "m"}, true, &indenter.tip));
  PetscCall(ReadHistory(reader, "-indenter_times", {"-indenter_velocities", "downward speed at the times, negative retracts", "m/s"}, &indenter.motion.speed));
  if (!reader.Help() && !SurfaceBelow(*c, indenter.tip[0], &indenter.initial_surface)) {
    indenter.initial_surface = -HUGE_VAL;
    for (const Body &body : c->model.bodies)
      indenter.initial_surface = std::max(indenter.initial_surface, body.region->Bounds().upper[1]);
  }
  PetscCall(ReadTurningPoint(reader, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadMethod(OptionReader &reader, Case *c)
{
  const std::vector<std::string> updates = {"usl", "usf", "musl"};
  std::string update = "musl";
  std::vector<double> viscosity = {0.001, 4};
  Model &model = c->model;
  PetscFunctionBeginUser;
  PetscCall(reader.Choice({"-shape_function", "weights of points on nodes", ""}, ShapeFunctions(), &model.shape_function));
  PetscCall(reader.Choice({"-stress_update", "when strain and stress advance in a step", ""}, updates, &update));
  model.stress_update = static_cast<StressUpdate>(std::find(updates.begin(), updates.end(), update) - updates.begin());
  PetscCall(reader.Numbers({"-short_wave_viscosity", "a,b of the viscosity min(0.3, a + b E^2) on the short-wave strain rate; 0,0 = none", ""},
                           kNotNegative, 2, 2, false, &viscosity));
  model.short_wave = {viscosity[0], viscosity[1]};
  PetscCall(reader.Number({"-xpic_fraction", "share of XPIC per step in the velocity update; 0 = pure FLIP", ""}, Closed(0, 1), false, &model.nodal.xpic_fraction));
  PetscCall(reader.Integer({"-xpic_order", "order of XPIC; 1 = PIC", ""}, Closed(1, 2), &model.nodal.xpic_order));
  PetscCall(reader.Number({"-damping", "mass-proportional damping rate for quasi-static runs", "1/s"}, kNotNegative, false, &model.nodal.damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadTime(OptionReader &reader, Case *c)
{
  PetscFunctionBeginUser;
  PetscCall(reader.Number({"-end_time", "end of the run", "s"}, kPositive, false, &c->time.end_time));
  PetscCall(reader.Integer({"-max_steps", "level-0 steps at which the run ends; 0 = no limit", ""}, kNotNegative, &c->time.max_steps));
  PetscCall(reader.Number({"-time_step", "level-0 time step; 0 = from -cfl", "s"}, kNotNegative, false, &c->time.time_step));
  PetscCall(reader.Number({"-cfl", "time step as a fraction of h/(c + |v|), c the current wave speed", ""},
                          {0, kLargestCfl, true, false}, false, &c->time.cfl));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadOutput(OptionReader &reader, Case *c)
{
  OutputSettings &out = c->output;
  PetscFunctionBeginUser;
  out.directory = "output/" + c->name;
  PetscCall(reader.Text({"-output_dir", "folder for the results", ""}, false, &out.directory));
  PetscCall(reader.Flag({"-overwrite", "replace the results that the folder holds", ""}, &out.overwrite));
  PetscCall(reader.Integer({"-history_interval", "level-0 steps between rows of history.csv", ""}, Closed(1, 2e9), &out.history_interval));
  PetscCall(reader.Integer({"-frames", "number of equally spaced point frames, the last at the end", ""}, Closed(0, 1e6), &out.frames));
  PetscCall(reader.Integer({"-checkpoint_interval", "level-0 steps between checkpoints; 0 = none", ""}, kNotNegative, &out.checkpoint_interval));
  PetscCall(reader.Text({"-restart", "checkpoint to go on from, on any number of ranks", ""}, false, &out.restart));
  out.monitor = isatty(STDOUT_FILENO);
  PetscCall(reader.Flag({"-monitor", "progress line (default: on a terminal)", ""}, &out.monitor));
  PetscCall(reader.Flag({"-contact_monitor", "a line per step about the contact solve", ""}, &c->model.contact_monitor));
  PetscCall(reader.Integer({"-sort_interval", "steps between sorts of the points", ""}, Closed(1, 2e9), &c->sort_interval));
  PetscCall(reader.Number({"-rebalance_threshold", "max/mean points per rank that triggers a re-cut of the grid", ""},
                          {1, HUGE_VAL, false, true}, false, &c->rebalance_threshold));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The last options file's name without folder and ending.
PetscErrorCode ReadName(Case *c)
{
  int count = 0;
  char **words = nullptr;
  std::string name;
  PetscFunctionBeginUser;
  PetscCall(PetscGetArgs(&count, &words));
  for (int k = 1; k + 1 < count; ++k)
    if (words[k] == std::string("-options_file")) name = words[k + 1];
  name = name.substr(name.find_last_of('/') + 1);
  name = name.substr(0, name.find_last_of('.'));
  c->name = name.empty() ? "run" : name;
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

/// Reads one titled group of options with `read`.
template <class Read> static PetscErrorCode Group(OptionReader &reader, const char *title, Read read)
{
  PetscFunctionBeginUser;
  PetscOptionsBegin(reader.Comm(), nullptr, title, nullptr);
  reader.SetItems(PetscOptionsObject);
  PetscCall(read());
  PetscOptionsEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadCase(OptionReader &reader, Case *c)
{
  std::vector<std::string> materials, bodies;
  PetscFunctionBeginUser;
  PetscCall(ReadName(c));
  PetscCall(Group(reader, "Grid", [&] { return ReadGrid(reader, c); }));
  PetscCall(Group(reader, "Materials (NAME: each name in -materials)", [&] { return ReadMaterials(reader, c, &materials); }));
  PetscCall(Group(reader, "Bodies (NAME: each name in -bodies)", [&] { return ReadBodies(reader, materials, c, &bodies); }));
  PetscCall(Group(reader, "Loads (NAME: each name in -loads)", [&] { return ReadLoads(reader, bodies, c); }));
  PetscCall(Group(reader, "Method", [&] { return ReadMethod(reader, c); }));
  reader.Identify(false);
  PetscCall(Group(reader, "Time", [&] { return ReadTime(reader, c); }));
  reader.Identify(true);
  PetscCall(Group(reader, "Indenter and contact", [&] { return ReadIndenter(reader, c); }));
  reader.Identify(false);
  PetscCall(Group(reader, "Output", [&] { return ReadOutput(reader, c); }));
  c->identity = reader.Identity();
  if (!std::isfinite(c->time.end_time) && c->time.max_steps == 0 && !reader.Help())
    PetscCall(reader.Refuse("-end_time", "", "given, or -max_steps"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
