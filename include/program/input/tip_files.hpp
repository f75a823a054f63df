// Files that describe an indenter's surface.
#pragma once

#include "physics/tips/height_map.hpp"
#include "program/options/options.hpp"

#include <string>
#include <vector>

namespace mlgimp
{

/// A profile's distances from the axis and heights above the tip, m.
struct ProfileTable {
  std::vector<double> distances, heights;
};

/// Lines of two numbers, which begin at 0 0 and rise; what comes behind a # is left out. What is wrong with the file is refused
/// as the value of the option. Collective on all ranks.
ProfileTable ReadProfileFile(OptionReader &reader, const std::string &option, const std::string &path);

/// The option that names a file.
struct FileOption {
  std::string name, path;
};
/// Extents of a map, from the first to the last column and row with half a pixel around, m; zero where they are not given.
struct MapSize {
  double x = 0, y = 0;
};

/// A Gwyddion Simple Field, whose head has the extents, or rows of numbers, for which they must be given; heights in m, the first
/// row at the largest y. Refuses what is no such file. Collective on all ranks.
HeightTable ReadMapFile(OptionReader &reader, const FileOption &file, MapSize size);

} // namespace mlgimp
