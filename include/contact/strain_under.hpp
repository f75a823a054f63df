// What points at the surface flow in a step under the columns of the grid, which lets the surface between nodes flow.
#pragma once

#include "contact/contact.hpp"

#include <utility>
#include <vector>

namespace mlgimp
{

class StrainUnder
{
public:
  /// None in the step.
  void Clear() { before_.clear(), columns_.clear(); }
  /// Before points strain: keeps the plastic strains of points of metal at the surface near the indenter.
  void Begin(const SurfaceInputs &surface, Vec3 tip);
  /// After it: what they have flowed, by columns. The points must be stored as they were.
  const std::vector<ColumnStrain> &End(const PointArrays &points);

private:
  std::vector<std::pair<int, double>> before_; ///< points and their plastic strains
  std::vector<ColumnStrain> columns_;          ///< their parts in columns, for each point in turn
};

} // namespace mlgimp
