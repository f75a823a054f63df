// Materials and tips by their names, with where their constants come from.
#pragma once

#include "program/options/options.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// One option of a preset. percent: standard uncertainty of the value, 0 where it is a choice or exact.
struct PresetConstant {
  std::string option, value; ///< without the prefix of a material; as a user would give it, with its unit
  double percent = 0;
};

/// A material or a tip that has a name. Constants of a law follow the option that chooses the law.
struct Preset {
  std::string name, source;
  std::vector<PresetConstant> constants;
};

/// Those of -NAME_preset.
const std::vector<Preset> &MaterialPresets();
/// Those that -indenter takes beside its kinds.
const std::vector<Preset> &TipPresets();

/// A line for each: its name, options with their uncertainties, and the source.
std::string PresetTable();

/// Gives the options of a material's preset that the user has not given. What belongs to a law that the user has replaced is left
/// out. prefix: "-NAME_". notes: gains a line with all that was set, and the source.
void ReadMaterialPreset(OptionReader &reader, const std::string &prefix, std::vector<std::string> *notes);
/// The same of a tip that -indenter names. cone_of: in axisymmetry, half the angle of the cone that stands for a kind of pyramid,
/// degrees, 0 for other kinds; null elsewhere. kinds: what -indenter takes beside them; another name is refused with the nearest.
void ReadTipPreset(const OptionReader &reader, double (*cone_of)(const std::string &), const std::vector<std::string> &kinds,
                   std::vector<std::string> *notes);

} // namespace mlgimp
