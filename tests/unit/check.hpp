// What unit tests share: a line "ok NAME: detail" or "FAIL NAME: detail" per check, and small set-ups.
#pragma once

#include "levels/hierarchy.hpp"

#include <cstdio>
#include <string>

namespace mlgimp
{

/// Prints one check; on one rank.
inline void Check(const std::string &name, bool good, const std::string &detail = "")
{
  std::printf("%s %s%s%s\n", good ? "ok" : "FAIL", name.c_str(), detail.empty() ? "" : ": ", detail.c_str());
}

/// Passes where value <= limit; a NaN does not.
inline void CheckAtMost(const std::string &name, double value, double limit)
{
  char detail[80];
  std::snprintf(detail, sizeof detail, "%.3g (<= %.3g)", value, limit);
  Check(name, value <= limit, detail);
}

inline void CheckAtLeast(const std::string &name, double value, double limit)
{
  char detail[80];
  std::snprintf(detail, sizeof detail, "%.3g (>= %.3g)", value, limit);
  Check(name, value >= limit, detail);
}

/// One level over a box with the model's sides.
inline HierarchySettings OneLevel(const Model &model, const Box &box, double spacing)
{
  LevelGeometry geometry;
  geometry.grid = {box.lower, spacing, {}, 1};
  for (int d = 0; d < 2; ++d)
    geometry.grid.cells[d] = static_cast<int>(std::lround((box.upper[d] - box.lower[d]) / spacing));
  geometry.sides.kind = model.sides;
  geometry.sides.node = {0, geometry.grid.cells[0], 0, geometry.grid.cells[1]};
  HierarchySettings settings;
  settings.levels = {geometry};
  return settings;
}

/// A model with one material and one body.
inline void AddBody(Model &model, std::unique_ptr<Region> region, const std::string &law, const MaterialConstants &constants,
                    Vec2 velocity = {0, 0}, int points_per_cell = 2)
{
  model.materials.push_back(CreateMaterial(law, constants));
  model.bodies.push_back({"body", std::move(region), static_cast<int>(model.materials.size()) - 1, velocity, points_per_cell});
}

} // namespace mlgimp
