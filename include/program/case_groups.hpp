// The groups of options that ReadCase is made of, where they fill a file of their own.
#pragma once

#include "program/case.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

PetscErrorCode ReadLevels(OptionReader &reader, Case *c);
PetscErrorCode ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names);
PetscErrorCode ReadBodies(OptionReader &reader, const std::vector<std::string> &materials, Case *c,
                          std::vector<std::string> *names);
PetscErrorCode ReadLoads(OptionReader &reader, const std::vector<std::string> &bodies, Case *c);
PetscErrorCode ReadIndenter(OptionReader &reader, Case *c);

/// A value of an option and the geometries that have it.
struct NamedInGeometry {
  const char *name;
  bool has[3]; ///< by GeometryKind
};

/// Chooses one of the values that the geometry has; -help lists all.
PetscErrorCode ChooseInGeometry(OptionReader &reader, const OptionText &option, GeometryKind geometry,
                                const std::vector<NamedInGeometry> &values, std::string *value);

/// Times and values of a piecewise-linear history.
PetscErrorCode ReadHistory(OptionReader &reader, const std::string &times_name, const OptionText &values_text,
                           PiecewiseLinear *history);

} // namespace mlgimp
