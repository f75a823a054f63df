// The tables of materials and tips by name.
#include "program/options/presets.hpp"

#include "program/options/nearest.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>

namespace mlgimp
{

namespace
{

// Standard uncertainties, per cent. Where a source has none of its own: how far published values of a metal's modulus, of flow
// stresses of different heats and of a crystal's constants lie apart.
constexpr double kModulus = 2, kFlow = 10, kCrystal = 1, kRatio = 3, kDensity = 0.5; // size: what is printed beside values

/// A metal whose flow stress is that of Johnson and Cook at rest and at room temperature, A + B eps^n.
Preset Metal(const char *name, const char *modulus, const char *ratio, const char *density, const char *a, const char *b,
             const char *n,
             const std::string &source = "G. R. Johnson, W. H. Cook, 7th Int. Symp. Ballistics (1983) 541: A, B, n")
{
  return {name,
          source + "; elastic constants of handbooks",
          {{"density", density, kDensity},
           {"youngs_modulus", modulus, kModulus},
           {"poissons_ratio", ratio, kRatio},
           {"model", "j2"},
           {"hardening", "ludwik"},
           {"yield_stress", a, kFlow},
           {"hardening_modulus", b, kFlow},
           {"hardening_exponent", n, kFlow}}};
}

Preset Crystal(const char *name, const char *constants, const char *density, const char *source)
{
  return {name, source, {{"density", density, kDensity}, {"model", "anisotropic"}, {"elastic_constants", constants, kCrystal}}};
}

Preset Elastic(const char *name, const char *modulus, double percent, const char *ratio, const char *density, const char *source)
{
  return {name,
          source,
          {{"density", density, kDensity},
           {"youngs_modulus", modulus, percent},
           {"poissons_ratio", ratio, kRatio},
           {"model", "neo_hookean"}}};
}

Preset Plastic(const char *name, const char *modulus, const char *ratio, const char *density, const char *yield_stress,
               const char *source)
{
  return {name,
          source,
          {{"density", density, kDensity},
           {"youngs_modulus", modulus, 5},
           {"poissons_ratio", ratio, kRatio},
           {"model", "j2"},
           {"hardening", "linear"},
           {"yield_stress", yield_stress, kFlow},
           {"hardening_modulus", "0"}}};
}

/// All options that are given so far, with their values; that they are looked at here does not count as being read.
std::map<std::string, std::string> GivenOptions()
{
  char *all = nullptr;
  std::map<std::string, std::string> given;
  ExitOnError(PetscOptionsGetAll(nullptr, &all));
  std::istringstream words(all);
  ExitOnError(PetscFree(all));
  for (std::string word, name; words >> word;) {
    const bool is_name = word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
    if (is_name) name = LowerCase(word);
    given[name] = is_name ? "" : word;
  }
  return given;
}

const Preset *Find(const std::vector<Preset> &presets, const std::string &name)
{
  const auto found = std::find_if(presets.begin(), presets.end(), [&](const Preset &one) { return one.name == name; });
  return found == presets.end() ? nullptr : &*found;
}

/// Options that choose a law, to which what follows in a preset belongs.
bool ChoosesLaw(const std::string &option) { return option == "model" || option == "hardening" || option == "rate_law"; }

/// An option with its value and uncertainty.
std::string Text(const std::string &prefix, const PresetConstant &constant)
{
  return Format("{}{} {}{}", prefix, constant.option, constant.value,
                constant.percent > 0 ? Format(" +- {} %", FormatNumber(constant.percent)) : "");
}

/// Gives all options of a preset that the user has not given, until one that chooses a law has another value; returns them as
/// text.
std::string Give(const Preset &preset, const std::string &prefix)
{
  const std::map<std::string, std::string> given = GivenOptions();
  std::vector<std::string> words;
  for (const PresetConstant &constant : preset.constants) {
    const std::string option = prefix + constant.option;
    const auto own = given.find(LowerCase(option));
    if (own == given.end()) {
      ExitOnError(PetscOptionsSetValue(nullptr, option.c_str(), constant.value.c_str()));
      words.push_back(Text(prefix, constant));
    } else if (ChoosesLaw(constant.option) && own->second != constant.value) {
      break;
    }
  }
  return Join(words, ", ");
}

std::vector<std::string> NamesOf(const std::vector<Preset> &presets)
{
  std::vector<std::string> names;
  for (const Preset &preset : presets) names.push_back(preset.name);
  return names;
}

/// Metals and glasses.
std::vector<Preset> MetalsAndGlasses()
{
  return {
      Metal("aluminium_6061", "68.9GPa", "0.33", "2.70g/cm3", "324MPa", "114MPa", "0.42",
            "D. R. Lesuer, G. J. Kay, M. M. LeBlanc, UCRL-JC-134118 (2001), temper T6: A, B, n"),
      Metal("aluminium_2024", "73.1GPa", "0.33", "2.77g/cm3", "265MPa", "426MPa", "0.34"),
      Metal("brass_cartridge", "110GPa", "0.35", "8.52g/cm3", "112MPa", "505MPa", "0.42"),
      Metal("copper_ofhc", "124GPa", "0.34", "8.96g/cm3", "90MPa", "292MPa", "0.31"),
      Metal("iron_armco", "207GPa", "0.29", "7.89g/cm3", "175MPa", "380MPa", "0.32"),
      Metal("nickel_200", "204GPa", "0.31", "8.90g/cm3", "163MPa", "648MPa", "0.33"),
      Metal("steel_1006", "203GPa", "0.29", "7.89g/cm3", "350MPa", "275MPa", "0.36"),
      Metal("steel_4340", "200GPa", "0.29", "7.83g/cm3", "792MPa", "510MPa", "0.26"),
      Metal("steel_s7", "207GPa", "0.29", "7.75g/cm3", "1539MPa", "477MPa", "0.18"),
      Metal("titanium_6al4v", "113.8GPa", "0.342", "4.43g/cm3", "1098MPa", "1092MPa", "0.93",
            "D. R. Lesuer, DOT/FAA/AR-00/25 (2000): A, B, n"),
      {"indium",
       "B. N. Lucas, W. C. Oliver, Metall. Mater. Trans. A 30 (1999) 601: exponent of creep; 3 MPa at 1e-3/s; elastic constants "
       "of handbooks",
       {{"density", "7.31g/cm3", kDensity},
        {"youngs_modulus", "12.7GPa", 5},
        {"poissons_ratio", "0.45", kRatio},
        {"model", "j2"},
        {"rate_law", "norton"},
        {"creep_stress", "3MPa", 20},
        {"creep_rate", "1e-3/s"},
        {"creep_exponent", "7.3", 5}}},
      Plastic("fused_silica", "72GPa", "0.17", "2.20g/cm3", "5.7GPa",
              "W. C. Oliver, G. M. Pharr, J. Mater. Res. 7 (1992) 1564: elastic constants; the flow stress with which the "
              "hardness of options/fused_silica_tip.opts is the 9.3 GPa of the usual test piece, without densification"),
      Plastic("gold", "78GPa", "0.42", "19.3g/cm3", "205MPa",
              "ASM Handbook 2 (1990): yield stress after 60 % of cold work, annealed gold has less and thin films more; elastic "
              "constants: the mean of Voigt's and Reuss' averages of gold_crystal"),
      Elastic("silicon_isotropic", "163GPa", 2, "0.223", "2.33g/cm3",
              "the mean of Voigt's and Reuss' averages of silicon_crystal, as of many grains; it does not flow"),
      Elastic("bk7", "82GPa", 1, "0.206", "2.51g/cm3", "Schott AG, data sheet of N-BK7")};
}

/// Crystals, whose orientation the user gives.
std::vector<Preset> Crystals()
{
  return {
      Crystal("aluminium_crystal", "106.8GPa,60.7GPa,28.2GPa", "2.70g/cm3",
              "J. Vallin and others, J. Appl. Phys. 35 (1964) 1825"),
      Crystal("copper_crystal", "168.4GPa,121.4GPa,75.4GPa", "8.96g/cm3", "W. C. Overton, J. Gaffney, Phys. Rev. 98 (1955) 969"),
      Crystal("diamond_crystal", "1079GPa,124GPa,578GPa", "3.515g/cm3",
              "H. J. McSkimin, P. Andreatch, J. Appl. Phys. 43 (1972) 2944"),
      Crystal("gallium_arsenide_crystal", "118.8GPa,53.8GPa,59.4GPa", "5.32g/cm3",
              "J. S. Blakemore, J. Appl. Phys. 53 (1982) R123"),
      Crystal("germanium_crystal", "129.2GPa,47.9GPa,67.0GPa", "5.32g/cm3",
              "J. J. Wortman, R. A. Evans, J. Appl. Phys. 36 (1965) 153"),
      Crystal("gold_crystal", "192.3GPa,163.1GPa,42.0GPa", "19.3g/cm3",
              "J. R. Neighbours, G. A. Alers, Phys. Rev. 111 (1958) 707"),
      Crystal("nickel_crystal", "250.8GPa,150.0GPa,123.5GPa", "8.90g/cm3",
              "G. A. Alers, J. R. Neighbours, H. Sato, J. Phys. Chem. Solids 13 (1960) 40"),
      Crystal("sapphire_crystal", "497GPa,163GPa,116GPa,501GPa,147GPa,-22GPa", "3.98g/cm3",
              "T. Goto and others, J. Geophys. Res. 94 (1989) 7588"),
      Crystal("silicon_crystal", "165.7GPa,63.9GPa,79.6GPa", "2.33g/cm3",
              "J. J. Wortman, R. A. Evans, J. Appl. Phys. 36 (1965) 153"),
      Crystal("tungsten_crystal", "523.3GPa,204.5GPa,160.7GPa", "19.3g/cm3",
              "F. H. Featherston, J. R. Neighbours, Phys. Rev. 130 (1963) 1324"),
      Crystal("zinc_crystal", "163.7GPa,36.4GPa,53.0GPa,63.5GPa,38.8GPa", "7.14g/cm3",
              "G. A. Alers, J. R. Neighbours, J. Phys. Chem. Solids 7 (1958) 58")};
}

/// Polymers, gels and tissue.
std::vector<Preset> SoftMatter()
{
  return {
      Plastic("polycarbonate", "2.4GPa", "0.37", "1.20g/cm3", "62MPa",
              "J. E. Mark, Polymer Data Handbook (1999); in tension, slowly"),
      Plastic("pmma", "3.1GPa", "0.38", "1.19g/cm3", "110MPa",
              "J. E. Mark, Polymer Data Handbook (1999); yield in compression, slowly"),
      Elastic("pdms_10_1", "2.05MPa", 6, "0.49", "1.03g/cm3",
              "I. D. Johnston and others, J. Micromech. Microeng. 24 (2014) 035017: Sylgard 184, 10:1, cured at 100 degC"),
      Elastic("polyacrylamide_4kPa", "4.47kPa", 27, "0.457", "1.03g/cm3",
              "J. R. Tse, A. J. Engler, Curr. Protoc. Cell Biol. 47 (2010) 10.16: 5 % acrylamide, 0.15 % bis; T. Takigawa and "
              "others, Polym. Gels "
              "Netw. 4 (1996) 1: Poisson's ratio"),
      Elastic("polyacrylamide_40kPa", "40.4kPa", 6, "0.457", "1.03g/cm3",
              "J. R. Tse, A. J. Engler, Curr. Protoc. Cell Biol. 47 (2010) 10.16: 8 % acrylamide, 0.48 % bis; T. Takigawa and "
              "others, Polym. Gels "
              "Netw. 4 (1996) 1: Poisson's ratio"),
      Elastic("brain_white_matter", "1.895kPa", 31, "0.49", "1.04g/cm3",
              "S. Budday and others, J. Mech. Behav. Biomed. Mater. 46 (2015) 318: bovine, by a flat punch")};
}

} // namespace

const std::vector<Preset> &MaterialPresets()
{
  static const std::vector<Preset> presets = [] {
    std::vector<Preset> all = MetalsAndGlasses();
    for (const std::vector<Preset> &some : {Crystals(), SoftMatter()}) all.insert(all.end(), some.begin(), some.end());
    return all;
  }();
  return presets;
}

const std::vector<Preset> &TipPresets()
{
  static const std::string iso = "ISO 14577-2", makers = "as makers specify new tips; a used one is blunter";
  static const std::vector<Preset> presets = {
      {"berkovich_R50", makers, {{"indenter", "berkovich"}, {"indenter_tip_radius", "50nm", 50}}},
      {"berkovich_R150", "a usual worn tip", {{"indenter", "berkovich"}, {"indenter_tip_radius", "150nm", 50}}},
      {"cube_corner_R40", makers, {{"indenter", "cube_corner"}, {"indenter_tip_radius", "40nm", 50}}},
      {"vickers_R500", iso, {{"indenter", "vickers"}, {"indenter_tip_radius", "0.5um", 50}}},
      {"cone_60_R1um", makers, {{"indenter", "cone"}, {"indenter_half_angle", "30deg", 3}, {"indenter_tip_radius", "1um", 10}}},
      {"cone_90_R5um", makers, {{"indenter", "cone"}, {"indenter_half_angle", "45deg", 3}, {"indenter_tip_radius", "5um", 10}}},
      {"rockwell_c",
       "ISO 6508-2",
       {{"indenter", "cone"}, {"indenter_half_angle", "60deg", 0.2}, {"indenter_tip_radius", "200um", 2}}},
      {"brinell_1", "ISO 6506-2", {{"indenter", "sphere"}, {"indenter_radius", "0.5mm", 0.3}}},
      {"brinell_10", "ISO 6506-2", {{"indenter", "sphere"}, {"indenter_radius", "5mm", 0.05}}},
      {"afm_colloid_R10um", makers, {{"indenter", "sphere"}, {"indenter_radius", "10um", 5}}},
  };
  return presets;
}

std::string PresetTable()
{
  std::string text;
  const auto add = [&](const std::vector<Preset> &presets, const std::string &prefix) {
    for (const Preset &preset : presets) {
      std::vector<std::string> words;
      for (const PresetConstant &constant : preset.constants) words.push_back(Text(prefix, constant));
      text += Format("{}: {} ({})\n", preset.name, Join(words, ", "), preset.source);
    }
  };
  add(MaterialPresets(), "-NAME_");
  add(TipPresets(), "-");
  return text;
}

void ReadMaterialPreset(OptionReader &reader, const std::string &prefix, std::vector<std::string> *notes)
{
  std::vector<std::string> names = NamesOf(MaterialPresets());
  names.insert(names.begin(), "none");
  std::string name = names[0];
  reader.Identify(false); // what it gives counts
  reader.Choice({prefix + "preset", "a material by its name, whose constants are those that are not given"}, names, &name);
  reader.Identify(true);
  const Preset *preset = reader.Help() ? nullptr : Find(MaterialPresets(), name);
  if (!preset) return;
  const std::string given = Give(*preset, prefix);
  notes->push_back(
      Format("{}preset {}: {} ({})", prefix, name, given.empty() ? "nothing, as all is given" : given, preset->source));
}

void ReadTipPreset(const OptionReader &reader, double (*cone_of)(const std::string &), const std::vector<std::string> &kinds,
                   std::vector<std::string> *notes)
{
  std::string name;
  FindValue("-indenter", &name);
  const Preset *preset = Find(TipPresets(), name);
  const bool is_kind = std::find(kinds.begin(), kinds.end(), name) != kinds.end();
  std::vector<std::string> all = NamesOf(TipPresets());
  all.insert(all.end(), kinds.begin(), kinds.end());
  if (!preset && !is_kind && !name.empty())
    reader.Refuse("-indenter", name, "{} (-presets lists those with numbers)", OneOf(name, all));
  if (!preset) return;
  Preset tip = *preset;
  std::string &kind = tip.constants[0].value;
  if (const double angle = cone_of ? cone_of(kind) : 0; angle > 0) {
    kind = "cone";
    tip.constants.push_back({"indenter_half_angle", FormatNumber(angle)});
  }
  ExitOnError(PetscOptionsClearValue(nullptr, "-indenter"));
  notes->push_back(Format("-indenter {}: {} ({})", name, Give(tip, "-"), tip.source));
}

} // namespace mlgimp
