// Options of materials.
#include "program/input/read_case.hpp"

#include "program/options/presets.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

namespace
{

using Constants = MaterialConstants;

void ReadConstant(OptionReader &reader, const std::string &prefix, const HardeningConstant &constant, Constants *c)
{
  const Range range = {constant.least, constant.most, !constant.may_be_least, std::isinf(constant.most)};
  reader.Read({prefix + constant.name, constant.help, constant.unit, range}, &(c->*constant.value), constant.required);
}

/// The lists of a hardening table: strains that rise from 0, stresses that do not fall.
void ReadTable(OptionReader &reader, const std::string &prefix, Constants *c)
{
  const std::string strains = prefix + "plastic_strains", stresses = prefix + "flow_stresses";
  reader.Read({strains, "equivalent plastic strains, rising from 0 (table)", "", kNotNegative}, &c->plastic_strains, kRequired);
  reader.Read({stresses, "flow stresses at them, not falling (table)", "Pa", kPositive}, &c->flow_stresses, kRequired);
  if (reader.Help()) return;
  const auto &strain = c->plastic_strains, &stress = c->flow_stresses;
  if (strain[0] != 0) reader.Refuse(strains, strain[0], "0 at first: the initial yield stress is there");
  if (stress.size() != strain.size())
    reader.Refuse(stresses, Format("{} values", stress.size()), "as many as {} has: {}", strains, strain.size());
  for (std::size_t k = 1; k < strain.size(); ++k) {
    if (!(strain[k] > strain[k - 1])) reader.Refuse(strains, strain[k], "rising");
    if (stress[k] < stress[k - 1]) reader.Refuse(stresses, stress[k], "at least the one before it");
  }
  c->yield_stress = stress[0];
}

/// What the constants of a hardening law must be to each other.
void CheckHardening(const OptionReader &reader, const std::string &prefix, const Constants &c)
{
  if (c.saturation_stress < c.yield_stress)
    reader.Refuse(prefix + "saturation_stress", c.saturation_stress, "at least {}yield_stress {}", prefix,
                  FormatNumber(c.yield_stress));
  if (c.melting_temperature <= c.initial_temperature)
    reader.Refuse(prefix + "melting_temperature", c.melting_temperature, "above -initial_temperature {}",
                  FormatNumber(c.initial_temperature));
  if (c.melting_temperature <= c.reference_temperature)
    reader.Refuse(prefix + "melting_temperature", c.melting_temperature, "above {}reference_temperature {}", prefix,
                  FormatNumber(c.reference_temperature));
  if (c.adiabatic && std::isnan(c.heat_capacity)) reader.Refuse(prefix + "heat_capacity", "", "given with {}adiabatic", prefix);
}

/// Warns of a temperature that is probably in degrees Celsius; it must be in K.
void WarnIfCelsius(OptionReader &reader, const std::string &option, double temperature)
{
  constexpr double kColdest = 60; // K; oxygen boils at 90
  if (temperature < kColdest) reader.WarnLater("{} {}: is it in K? 20 degrees are 293", option, FormatNumber(temperature));
}

/// Warns of a stress that no solid flows at.
void WarnOfStress(OptionReader &reader, const std::string &option, double stress, double youngs_modulus)
{
  constexpr double kSoftest = 1e-6; // of Young's modulus; the purest metals yield at 1e-5
  const bool soft = stress > 0 && stress < kSoftest * youngs_modulus;
  if (soft || stress >= youngs_modulus)
    reader.WarnLater("{} {}: is {} Young's modulus; is it in Pa?", option, FormatNumber(stress),
                     soft ? "less than a millionth of" : "no less than");
}

/// Warns of constants that are probably in another unit: without a warning such a metal would flow away, never flow, or not
/// harden.
void WarnOfUnits(OptionReader &reader, const std::string &prefix, const Constants &c)
{
  const bool table = c.hardening == "table";
  const std::pair<const char *, double> stresses[] = {
      {table ? "flow_stresses" : "yield_stress", table ? c.flow_stresses.front() : c.yield_stress},
      {"flow_stresses", table && c.flow_stresses.size() > 1 ? c.flow_stresses.back() : NAN},
      {"hardening_modulus", c.hardening_modulus},
      {"saturation_stress", c.saturation_stress}}; // NaN where not given
  for (const auto &[name, stress] : stresses) WarnOfStress(reader, prefix + name, stress, c.youngs_modulus);
  constexpr double kLargestStrain = 5, kMaxSensitive = 0.5, kMinHeat = 50,
                   kMaxHeat = 2e4; // J/(kg K); gold 128, hydrogen 14e3
  const std::pair<const char *, double> strains[] = {{"plastic_strains", table ? c.plastic_strains.back() : NAN},
                                                     {"saturation_strain", c.saturation_strain},
                                                     {"hardening_strain", c.hardening_strain}}; // NaN where not given
  for (const auto &[name, strain] : strains)
    if (strain > kLargestStrain)
      reader.WarnLater("{}{} {}: is a strain of 500 per cent or more; 0.1 is 10", prefix, name, FormatNumber(strain));
  if (c.rate_sensitivity > kMaxSensitive)
    reader.WarnLater("{}rate_sensitivity {}: adds half of the flow stress and more at three times the rate; 0.01 is one per cent",
                     prefix, FormatNumber(c.rate_sensitivity));
  constexpr double kSlowest = 1e-5; // 1/s; those of creep are slower, but not those of this law
  if (c.reference_rate < kSlowest)
    reader.WarnLater("{}reference_rate {}: is slower than tests are; is it in 1/s?", prefix, FormatNumber(c.reference_rate));
  WarnIfCelsius(reader, prefix + "reference_temperature", c.reference_temperature);
  if (!c.adiabatic && !std::isnan(c.heat_capacity))
    reader.WarnLater("{}heat_capacity: nothing is heated without {}adiabatic", prefix, prefix);
  if (c.heat_capacity < kMinHeat || c.heat_capacity > kMaxHeat)
    reader.WarnLater("{}heat_capacity {}: is that of no metal; is it in J/(kg K)?", prefix, FormatNumber(c.heat_capacity));
}

/// Warns of constants of all materials that no law reads.
void WarnOfUnused(OptionReader &reader, const Model &model, const Constants &common, double rate_scale, bool knows_temperature)
{
  const auto none = [&](auto knows) { return std::none_of(model.materials.begin(), model.materials.end(), knows); };
  if (rate_scale > 1 && !none([](const auto &material) { return material->Traits().has_rate; }))
    reader.WarnLater("-rate_scale {}: the simulation is slower than the test; is it its time over that of the test? 1e-8 where "
                     "100 ns stand for 10 s",
                     FormatNumber(rate_scale));
  if (rate_scale != TimeSettings().rate_scale && none([](const auto &material) { return material->Traits().has_rate; }))
    reader.WarnLater("-rate_scale {}: changes nothing, as no material knows a rate", FormatNumber(rate_scale));
  if (common.initial_temperature != Constants().initial_temperature && !knows_temperature)
    reader.WarnLater("-initial_temperature {}: changes nothing, as no material knows a temperature",
                     FormatNumber(common.initial_temperature));
  WarnIfCelsius(reader, "-initial_temperature", common.initial_temperature);
}

/// Warns of a wave speed that no solid has: it makes the run slow and all its times wrong.
void WarnOfWaveSpeed(OptionReader &reader, const std::string &prefix, double poissons_ratio, const Material &material)
{
  constexpr double kFastest = 30e3; // m/s; diamond has 18e3
  const double speed = material.SpeedOfSound();
  if (speed > kFastest && std::isfinite(speed) && poissons_ratio < 0.49) // a nearly incompressible one is fast by its ratio
    reader.WarnLater("{}density {}: waves have {} m/s, more than in any solid; is it in kg/m3, and Young's modulus in Pa?",
                     prefix, FormatNumber(material.Density()), speed);
}

/// Cells of a body that hardly changes its volume lock: a cylinder on one cell of contact meets 1.6 times the load at a ratio of
/// 0.499, on three 1.08 times.
void WarnOfLocking(OptionReader &reader, const std::string &prefix, double poissons_ratio, bool average)
{
  constexpr double kNearlyIncompressible = 0.49;
  if (poissons_ratio >= kNearlyIncompressible && !average)
    reader.WarnLater("{}poissons_ratio {}: cells of a body that hardly changes its volume lock, and loads under a tip are too "
                     "large; add {}volume_average",
                     prefix, FormatNumber(poissons_ratio), prefix);
}

/// Reads the constants of the law that the user has named; with -help those of all laws, each once.
void ReadConstants(OptionReader &reader, const std::string &prefix, const std::vector<HardeningLaw> &laws,
                   const std::string &name, Constants *c)
{
  std::vector<std::string> known;
  for (const HardeningLaw &law : laws)
    for (const HardeningConstant &constant : law.constants) {
      const bool is_new = std::find(known.begin(), known.end(), constant.name) == known.end();
      if (!(reader.Help() ? is_new : law.name == name)) continue;
      ReadConstant(reader, prefix, constant, c);
      known.emplace_back(constant.name);
    }
}

std::vector<std::string> NamesOf(const std::vector<HardeningLaw> &laws)
{
  std::vector<std::string> names;
  for (const HardeningLaw &law : laws) names.emplace_back(law.name);
  return names;
}

void ReadHardening(OptionReader &reader, const std::string &prefix, Constants *c)
{
  reader.Choice({prefix + "hardening", "flow stress over plastic strain (j2)"}, NamesOf(HardeningLaws()), &c->hardening);
  ReadConstants(reader, prefix, HardeningLaws(), c->hardening, c);
  if (c->hardening == "table" || reader.Help()) ReadTable(reader, prefix, c);
  if (c->hardening == "johnson_cook" || reader.Help())
    reader.Read({prefix + "adiabatic", "plastic work heats the points (johnson_cook)"}, &c->adiabatic);
  if (reader.Help()) return;
  CheckHardening(reader, prefix, *c);
  WarnOfUnits(reader, prefix, *c);
}

/// How a metal flows: at a stress that hardening gives, at a rate that the stress gives, or both.
void ReadFlow(OptionReader &reader, const std::string &prefix, Constants *c)
{
  reader.Choice({prefix + "rate_law", "how flow depends on its rate (j2)"}, NamesOf(RateLaws()), &c->rate_law);
  ReadConstants(reader, prefix, RateLaws(), c->rate_law, c);
  if (c->rate_law == "eyring") c->creep_exponent = 1;
  if (c->rate_law == "none" || c->rate_law == "perzyna" || reader.Help()) ReadHardening(reader, prefix, c);
  if (reader.Help()) return;
  if (c->rate_law == "perzyna" && c->hardening == "johnson_cook")
    reader.Refuse(prefix + "rate_law", c->rate_law, "left out with johnson_cook, which has a rate of its own");
  WarnOfStress(reader, prefix + "creep_stress", c->creep_stress, c->youngs_modulus);
  constexpr double kLowest = 1e3; // J/mol; those of creep are tens to hundreds of thousands
  if (c->activation_energy > 0 && c->activation_energy < kLowest)
    reader.WarnLater("{}activation_energy {}: is less than that of any creep; is it in J/mol?", prefix,
                     FormatNumber(c->activation_energy));
}

/// Shares of a modulus that terms forget: one for each relaxation time, and less than all together.
void ReadShares(OptionReader &reader, const Option &option, const Constants &c, std::vector<double> *shares, bool required)
{
  if (!reader.Read(option, shares, required) || reader.Help()) return;
  if (shares->size() != c.relaxation_times.size())
    reader.Refuse(option.name, Format("{} values", shares->size()), "as many as there are relaxation times: {}",
                  c.relaxation_times.size());
  const double sum = std::accumulate(shares->begin(), shares->end(), 0.0);
  if (!(sum < 1)) reader.Refuse(option.name, sum, "less than 1 in sum: a solid keeps some of its stress");
}

/// The terms of a generalized Maxwell solid.
void ReadRelaxation(OptionReader &reader, const std::string &prefix, Constants *c)
{
  const std::string times = prefix + "relaxation_times";
  reader.Read({times, "times in which terms relax, rising (viscoelastic)", "s", kPositive}, &c->relaxation_times, kRequired);
  for (std::size_t k = 1; k < c->relaxation_times.size() && !reader.Help(); ++k)
    if (!(c->relaxation_times[k] > c->relaxation_times[k - 1])) reader.Refuse(times, c->relaxation_times[k], "rising");
  ReadShares(reader,
             {prefix + "relaxation_shares", "shares of the shear modulus that relax in them (viscoelastic)", "", kNotNegative},
             *c, &c->relaxation_shares, kRequired);
  c->relaxation_bulk_shares = c->relaxation_shares;
  ReadShares(
      reader,
      {prefix + "relaxation_bulk_shares",
       "shares of the bulk modulus; where left out those of the shear modulus, so that Poisson's ratio stays (viscoelastic)", "",
       kNotNegative},
      *c, &c->relaxation_bulk_shares, false);
}

/// Share of its own growth of volume that a point keeps: enough to resist what the mean of its cell does not see, too little to
/// lock.
double KeptVolumeShare(const Constants &c)
{
  constexpr double kMaxShare = 0.05, kYieldStrains = 15;
  return std::isnan(c.yield_stress) ? kMaxShare : std::min(kMaxShare, kYieldStrains * c.yield_stress / c.youngs_modulus);
}

} // namespace

void ReadMaterials(OptionReader &reader, Case *c, std::vector<std::string> *names)
{
  Constants common;
  bool knows_temperature = false;
  reader.Read({"-materials", "names of the materials"}, names, kRequired);
  reader.Read({"-rate_scale", "simulated time over real time, for laws that know a rate", "", kPositive}, &c->time.rate_scale);
  reader.Read(
      {"-initial_temperature", "temperature at the start, and T0 of johnson_cook where a material gives none", "K", kPositive},
      &common.initial_temperature);
  for (const std::string &name : *names) {
    const std::string prefix = "-" + name + "_";
    std::string model = "neo_hookean";
    Constants k = common;
    ReadMaterialPreset(reader, prefix, &c->notes);
    reader.Choice({prefix + "model", "constitutive law"}, MaterialModels(), &model);
    if (model != "anisotropic" || reader.Help()) {
      reader.Read({prefix + "youngs_modulus", "Young's modulus", "Pa", kPositive}, &k.youngs_modulus, kRequired);
      reader.Read({prefix + "poissons_ratio", "Poisson's ratio", "", Open(-1, 0.5)}, &k.poissons_ratio, kRequired);
    }
    reader.Read({prefix + "density", "initial density", "kg/m3", kPositive}, &k.density, kRequired);
    if (model == "anisotropic" || reader.Help()) ReadCrystal(reader, prefix, c->model.geometry.kind, &k);
    if (model == "j2" || reader.Help()) ReadFlow(reader, prefix, &k);
    if (model == "viscoelastic" || reader.Help()) ReadRelaxation(reader, prefix, &k);
    c->model.materials.push_back(CreateMaterial(model, k, c->model.geometry.kind));
    Material &material = *c->model.materials.back();
    knows_temperature = knows_temperature || material.PlaceOf(kTemperature) >= 0 || k.activation_energy > 0;
    bool average = material.Traits().averages_volume, split = material.Traits().splits;
    reader.Read({prefix + "volume_average", "mean of the volume change over a cell, against locking (true for j2)"}, &average);
    reader.Read({prefix + "split_stretched", "halve points that are drawn out longer than a cell (true for j2)"}, &split);
    material.SplitStretched(split);
    if (!reader.Help()) WarnOfLocking(reader, prefix, k.poissons_ratio, average);
    WarnOfWaveSpeed(reader, prefix, k.poissons_ratio, material);
    if (average) material.AverageVolume(KeptVolumeShare(k));
  }
  if (!reader.Help()) WarnOfUnused(reader, c->model, common, c->time.rate_scale, knows_temperature);
}

} // namespace mlgimp
