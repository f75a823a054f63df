// Options of contact: kernel, friction, and the solver of the pressures.
#include "program/case_groups.hpp"

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
  reader.NumberOrInfinity({"-indenter_friction", "Coulomb's coefficient of friction under the indenter; inf sticks"},
                          kNotNegative, &friction);
  if (friction > 0 && contact->method != "pressure")
    reader.Refuse("-indenter_friction", FormatNumber(friction), "0 with -contact " + contact->method);
  constexpr double kLargest = 3; // of dry surfaces; more is meant in per cent
  if (friction > kLargest && std::isfinite(friction))
    reader.WarnLater("-indenter_friction " + FormatNumber(friction) +
                     ": is Coulomb's coefficient, not per cent; surfaces hardly slip with as much");
  contact->friction = friction;
}

/// Those of PETSc's types that solve the contact equations; others end with PETSc's errors, or never.
const std::vector<std::string> kSolvers = {"cg",     "cr",  "minres", "symmlq", "gmres", "fgmres",
                                           "lgmres", "gcr", "bicg",   "bcgs",   "cgs",   "tfqmr"};
const std::vector<std::string> kSymmetricSolvers = {"cg", "cr", "minres", "symmlq"},
                               kSymmetricPreconditioners = {"eisenstat", "icc", "cholesky"};
const std::vector<std::string> kPreconditioners = {"jacobi", "none", "sor", "eisenstat", "icc", "ilu", "cholesky", "lu", "svd"};

/// One of the types, where the option is given; with friction none of those that ask for symmetry.
void CheckType(OptionReader &reader, const std::string &option, std::vector<std::string> types,
               const std::vector<std::string> &symmetric, bool friction)
{
  std::string text = "default";
  for (const std::string &type : symmetric)
    if (friction) types.erase(std::find(types.begin(), types.end(), type));
  if (reader.Text({option, "type of the solver of the contact pressures"}, false, &text) &&
      std::find(types.begin(), types.end(), text) == types.end())
    reader.Refuse(option, text, "one of " + Join(types, ", "));
}

/// The options that the solver of the contact pressures reads by itself, checked before it does so in PETSc's way.
void CheckContactSolver(OptionReader &reader, bool friction)
{
  constexpr double kLoosest = 1e-3; // with 0.01 loads are 1 % off, with 0.3 a fifth
  double tolerance = 1e-10;
  int iterations = 10000;
  reader.Identify(false);
  CheckType(reader, "-contact_ksp_type", kSolvers, kSymmetricSolvers, friction);
  CheckType(reader, "-contact_pc_type", kPreconditioners, kSymmetricPreconditioners, friction);
  reader.Number({"-contact_ksp_rtol", "relative tolerance of the contact pressures"}, {0, kLoosest, true, false}, false,
                &tolerance);
  reader.Integer({"-contact_ksp_max_it", "most iterations for the contact pressures"}, Closed(1, 2e9), &iterations);
  reader.Identify(true);
}

} // namespace

void ReadContact(OptionReader &reader, ContactSettings *contact)
{
  if (contact->method == "pressure" || reader.Help())
    contact->own_width = reader.Number(
        {"-contact_width",
         "half width of the kernel of a contact pressure in cells; 1 is the hat (default: 1; 0.7 under pointed tips on "
         "elastic bodies in plane strain)"},
        {0, 1, true, false}, false, &contact->width);
  ReadFriction(reader, contact);
  if (reader.Help() || (contact->method != "pressure" && contact->method != "point_pressure")) return;
  CheckContactSolver(reader, contact->friction > 0);
}

} // namespace mlgimp
