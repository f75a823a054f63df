// A tip by a map of heights over x and y, as an atomic force microscope measures it.
#pragma once

#include "physics/indenter.hpp"

#include <vector>

namespace mlgimp
{

/// Heights of a tip that points down, in rows along x: height(i, j) is heights[i + columns * j], x grows with i and y with j.
struct HeightTable {
  int columns = 0, rows = 0;
  double dx = 0, dy = 0;       ///< between neighbours, m
  std::vector<double> heights; ///< m

  double &At(int i, int j) { return heights[i + static_cast<std::size_t>(columns) * j]; }
  double At(int i, int j) const { return heights[i + static_cast<std::size_t>(columns) * j]; }
};

/// Column and row of the lowest height, of several alike the one nearest to their mean.
struct TablePlace {
  int column, row;
};
TablePlace LowestPlace(const HeightTable &table);
/// The lowest height on the rim of the table, above its lowest place, m: up to it the table holds the whole of a section.
double RimHeight(const HeightTable &table);

/// Of space: bicubic between the heights (Keys, IEEE Trans. Acoust. 29 (1981) 1153), straight on beyond them. The tip is the
/// table's lowest place, which must not lie on its rim. At least 4 columns and rows.
std::unique_ptr<IndenterSurface> CreateMapTip(const HeightTable &table);

} // namespace mlgimp
