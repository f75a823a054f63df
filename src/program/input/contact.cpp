// Options of contact: kernel, friction, and the solver of the pressures.
#include "program/input/read_case.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// Coulomb's coefficient, which one method of contact has.
void ReadFriction(OptionReader &reader, ContactSettings *contact)
{
  double friction = 0;
  reader.Read(
      {"-indenter_friction", "Coulomb's coefficient of friction under the indenter; inf sticks", "", OrInfinity(kNotNegative)},
      &friction);
  if (friction > 0 && contact->method != "pressure")
    reader.Refuse("-indenter_friction", friction, "0 with -contact {}", contact->method);
  constexpr double kMaxFriction = 3; // of dry surfaces; more is meant in per cent
  if (friction > kMaxFriction && std::isfinite(friction))
    reader.WarnLater("-indenter_friction {}: is Coulomb's coefficient, not per cent; surfaces hardly slip with as much",
                     FormatNumber(friction));
  contact->friction = friction;
}

/// Those of PETSc's types that solve the contact equations, whose matrix is never formed; others end with PETSc's errors, or
/// never.
const std::vector<std::string> kSolvers = {"cg",     "cr",  "minres", "symmlq", "gmres", "fgmres",
                                           "lgmres", "gcr", "bicg",   "bcgs",   "cgs",   "tfqmr"};
const std::vector<std::string> kPreconditioners = {"jacobi", "none"};

/// One of the types, where the option is given.
void CheckType(OptionReader &reader, const std::string &option, const std::vector<std::string> &types)
{
  std::string text = "default";
  if (reader.Read({option, "type of the solver of the contact pressures"}, &text) &&
      std::find(types.begin(), types.end(), text) == types.end())
    reader.Refuse(option, text, "one of {}", Join(types, ", "));
}

/// The options that the solver of the contact pressures reads by itself, checked before it does so in PETSc's way.
void CheckContactSolver(OptionReader &reader)
{
  constexpr double kMaxTolerance = 1e-3; // with 0.01 loads are 1 % off, with 0.3 a fifth
  double tolerance = 1e-10;
  int iterations = 10000;
  reader.Identify(false);
  CheckType(reader, "-contact_ksp_type", kSolvers);
  CheckType(reader, "-contact_pc_type", kPreconditioners);
  reader.Read({"-contact_ksp_rtol", "relative tolerance of the contact pressures", "", {0, kMaxTolerance, true, false}},
              &tolerance);
  reader.Read({"-contact_ksp_max_it", "most iterations for the contact pressures", "", Closed(1, 2e9)}, &iterations);
  reader.Identify(true);
}

} // namespace

void ReadContact(OptionReader &reader, ContactSettings *contact)
{
  ReadFriction(reader, contact);
  if (reader.Help() || (contact->method != "pressure" && contact->method != "point_pressure")) return;
  CheckContactSolver(reader);
  if (contact->method == "point_pressure")
    reader.WarnLater(
        "-contact point_pressure: is rank deficient, its diagonal is raised by 1 %; single pressures mean little and "
        "contact comes late");
}

} // namespace mlgimp
