// Options of materials.
#include "program/case_groups.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

using Constants = MaterialConstants;

PetscErrorCode ReadConstant(OptionReader &reader, const std::string &prefix, const HardeningConstant &constant, Constants *c)
{
  const Range range = {constant.least, constant.most, !constant.may_be_least, std::isinf(constant.most)};
  PetscFunctionBeginUser;
  PetscCall(
      reader.Number({prefix + constant.name, constant.help, constant.unit}, range, constant.required, &(c->*constant.value)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The lists of a hardening table: strains that rise from 0, stresses that do not fall.
PetscErrorCode ReadTable(OptionReader &reader, const std::string &prefix, Constants *c)
{
  const std::string strains = prefix + "plastic_strains", stresses = prefix + "flow_stresses";
  PetscFunctionBeginUser;
  PetscCall(reader.Numbers({strains, "equivalent plastic strains, rising from 0 (table)", ""}, kNotNegative, 1, 0, true,
                           &c->plastic_strains));
  PetscCall(
      reader.Numbers({stresses, "flow stresses at them, not falling (table)", "Pa"}, kPositive, 1, 0, true, &c->flow_stresses));
  if (reader.Help()) PetscFunctionReturn(PETSC_SUCCESS);
  const auto &strain = c->plastic_strains, &stress = c->flow_stresses;
  if (strain[0] != 0) PetscCall(reader.Refuse(strains, FormatNumber(strain[0]), "0 at first: the initial yield stress is there"));
  if (stress.size() != strain.size())
    PetscCall(reader.Refuse(stresses, std::to_string(stress.size()) + " values",
                            "as many as " + strains + " has: " + std::to_string(strain.size())));
  for (std::size_t k = 1; k < strain.size(); ++k) {
    if (!(strain[k] > strain[k - 1])) PetscCall(reader.Refuse(strains, FormatNumber(strain[k]), "rising"));
    if (stress[k] < stress[k - 1]) PetscCall(reader.Refuse(stresses, FormatNumber(stress[k]), "at least the one before it"));
  }
  c->yield_stress = stress[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the constants of a hardening law must be to each other.
PetscErrorCode CheckHardening(const OptionReader &reader, const std::string &prefix, const Constants &c)
{
  PetscFunctionBeginUser;
  if (c.saturation_stress < c.yield_stress)
    PetscCall(reader.Refuse(prefix + "saturation_stress", FormatNumber(c.saturation_stress),
                            "at least " + prefix + "yield_stress " + FormatNumber(c.yield_stress)));
  if (c.melting_temperature <= c.initial_temperature)
    PetscCall(reader.Refuse(prefix + "melting_temperature", FormatNumber(c.melting_temperature),
                            "above -initial_temperature " + FormatNumber(c.initial_temperature)));
  if (c.adiabatic && std::isnan(c.heat_capacity))
    PetscCall(reader.Refuse(prefix + "heat_capacity", "", "given with " + prefix + "adiabatic"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadHardening(OptionReader &reader, const std::string &prefix, Constants *c)
{
  std::vector<std::string> names, known;
  PetscFunctionBeginUser;
  for (const HardeningLaw &law : HardeningLaws()) names.emplace_back(law.name);
  PetscCall(reader.Choice({prefix + "hardening", "flow stress over plastic strain (j2)", ""}, names, &c->hardening));
  for (const HardeningLaw &law : HardeningLaws())
    for (const HardeningConstant &constant : law.constants) {
      const bool is_new = std::find(known.begin(), known.end(), constant.name) == known.end();
      if (!(reader.Help() ? is_new : law.name == c->hardening)) continue;
      PetscCall(ReadConstant(reader, prefix, constant, c));
      known.emplace_back(constant.name);
    }
  if (c->hardening == "table" || reader.Help()) PetscCall(ReadTable(reader, prefix, c));
  if (c->hardening == "johnson_cook" || reader.Help())
    PetscCall(reader.Flag({prefix + "adiabatic", "plastic work heats the points (johnson_cook)", ""}, &c->adiabatic));
  if (!reader.Help()) PetscCall(CheckHardening(reader, prefix, *c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Share of its own growth of volume that a point keeps: enough to resist what the mean of its cell does not see, too little to
/// lock.
double OwnGrowth(const Constants &c)
{
  constexpr double kMost = 0.05, kYieldStrains = 15;
  return std::isnan(c.yield_stress) ? kMost : std::min(kMost, kYieldStrains * c.yield_stress / c.youngs_modulus);
}

} // namespace

PetscErrorCode ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names)
{
  Constants common;
  PetscFunctionBeginUser;
  PetscCall(reader.Names({"-materials", "names of the materials", ""}, true, names));
  PetscCall(reader.Number({"-rate_scale", "simulated time over real time, for laws that know a rate", ""}, kPositive, false,
                          &common.rate_scale));
  PetscCall(reader.Number({"-initial_temperature", "temperature at the start, and that of the constants", "K"}, kPositive, false,
                          &common.initial_temperature));
  for (const std::string &name : *names) {
    const std::string prefix = "-" + name + "_";
    std::string model = "neo_hookean";
    Constants k = common;
    PetscCall(reader.Choice({prefix + "model", "constitutive law", ""}, MaterialModels(), &model));
    PetscCall(reader.Number({prefix + "youngs_modulus", "Young's modulus", "Pa"}, kPositive, true, &k.youngs_modulus));
    PetscCall(reader.Number({prefix + "poissons_ratio", "Poisson's ratio", ""}, Open(-1, 0.5), true, &k.poissons_ratio));
    PetscCall(reader.Number({prefix + "density", "initial density", "kg/m3"}, kPositive, true, &k.density));
    bool average = model == "j2";
    if (average || reader.Help()) PetscCall(ReadHardening(reader, prefix, &k));
    PetscCall(reader.Flag({prefix + "volume_average", "mean of the volume change over a cell, against locking (true for j2)", ""},
                          &average));
    c->model.materials.push_back(CreateMaterial(model, k, c->model.geometry.kind));
    if (average) c->model.materials.back()->AverageVolume(OwnGrowth(k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
