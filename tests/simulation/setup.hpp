// What tests that run a hierarchy of levels share: expectations with a figure, and small set-ups.
#pragma once

#include "hierarchy/hierarchy.hpp"
#include "unit/program.hpp"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace mlgimp
{

/// EXPECT_TRUE with a line "ok NAME: detail" or "FAIL NAME: detail", which the page of `make verify` shows.
inline void ExpectTrue(const std::string &name, bool good, const std::string &detail = "")
{
  std::printf("%s %s%s%s\n", good ? "ok" : "FAIL", name.c_str(), detail.empty() ? "" : ": ", detail.c_str());
  EXPECT_TRUE(good) << name << ": " << detail;
}

/// The same for value <= limit, which a NaN is not.
inline void ExpectAtMost(const std::string &name, double value, double limit)
{
  char detail[80];
  std::snprintf(detail, sizeof detail, "%.3g (<= %.3g)", value, limit);
  ExpectTrue(name, value <= limit, detail);
}

inline void ExpectAtLeast(const std::string &name, double value, double limit)
{
  char detail[80];
  std::snprintf(detail, sizeof detail, "%.3g (>= %.3g)", value, limit);
  ExpectTrue(name, value >= limit, detail);
}

/// The whole grid on the first rank.
inline GridLayout OneBlock(const GridGeometry &grid) { return {{{{grid.Nodes(0)}, {grid.Nodes(1)}, {grid.Nodes(2)}}}, {0}}; }

/// One level over a box with the model's sides.
inline HierarchySettings OneLevel(const Model &model, const Box &box, double spacing)
{
  LevelGeometry geometry;
  geometry.grid = {box.lower, spacing, {}, 1, model.geometry.Dim()};
  for (int d = 0; d < geometry.grid.dim; ++d)
    geometry.grid.cells[d] = static_cast<int>(std::lround((box.upper[d] - box.lower[d]) / spacing));
  PlaceSides(model, &geometry);
  HierarchySettings settings;
  settings.levels = {geometry};
  return settings;
}

/// Nested levels, each with cells `ratio` times smaller than the one before; boxes: of levels 1, 2, ...
inline HierarchySettings NestedLevels(const Model &model, const Box &domain, double spacing, int ratio,
                                      const std::vector<Box> &boxes)
{
  HierarchySettings settings = OneLevel(model, domain, spacing);
  settings.ratio = ratio;
  for (const Box &box : boxes) {
    spacing /= ratio;
    LevelGeometry geometry = OneLevel(model, box, spacing).levels[0];
    geometry.grid.padding = kHaloWidth;
    for (int s = 0; s < 2 * geometry.grid.dim; ++s) {
      const double own = s % 2 ? box.upper[s / 2] : box.lower[s / 2], outer = s % 2 ? domain.upper[s / 2] : domain.lower[s / 2];
      geometry.border[s] = std::abs(own - outer) > 1e-6 * spacing;
    }
    PlaceSides(model, &geometry);
    settings.levels.push_back(geometry);
  }
  return settings;
}

/// The variants of the step that are compared everywhere.
struct Scheme {
  const char *name;
  StressUpdate update;
  ShortWaveViscosity viscosity;
  double xpic;
};

inline const Scheme kDefaultScheme = {"default", StressUpdate::kMusl, {0.001, 8}, 0};
inline const Scheme kMusl = {"MUSL", StressUpdate::kMusl, {0, 0}, 0};
inline const Scheme kUsl = {"USL", StressUpdate::kUsl, {0, 0}, 0};
inline const Scheme kXpic2 = {"MUSL XPIC(2) 2 %", StressUpdate::kMusl, {0, 0}, 0.02};
inline const Scheme kXpic10 = {"MUSL XPIC(2) 10 %", StressUpdate::kMusl, {0, 0}, 0.1};

/// A run on several levels.
struct LevelsRun {
  Model model;
  Hierarchy hierarchy;
  double time = 0, dt = 0; ///< of level 0

  void SetScheme(const Scheme &scheme)
  {
    model.stress_update = scheme.update;
    model.short_wave = scheme.viscosity;
    model.nodal.xpic_fraction = scheme.xpic;
  }
  PetscErrorCode Create(const HierarchySettings &settings)
  {
    LogEvents events;
    PetscFunctionBeginUser;
    PetscCall(RegisterLogEvents(&events));
    PetscCall(hierarchy.Create(PETSC_COMM_WORLD, model, settings, events, true));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscErrorCode Advance()
  {
    PetscFunctionBeginUser;
    PetscCall(hierarchy.Advance({time, dt}));
    time += dt;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /// Calls work(arrays, p, l) for every point p of every level l.
  template <class Work> PetscErrorCode ForEachPoint(Work work)
  {
    PetscFunctionBeginUser;
    for (int l = 0; l < hierarchy.Levels(); ++l) {
      const PointArrays a = hierarchy.At(l).PointStore().Arrays();
      for (int p = 0; p < a.count; ++p) work(a, p, l);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  bool Failed()
  {
    for (int l = 0; l < hierarchy.Levels(); ++l)
      if (hierarchy.At(l).Step().failure.kind != LevelFailure::kNone) return true;
    return false;
  }
};

/// Adds a material and a body of it to a model, whose geometry is known.
inline void AddBody(Model &model, std::unique_ptr<Region> region, const std::string &law, const MaterialConstants &constants,
                    Vec3 velocity = {0, 0}, int points_per_cell = 2)
{
  model.materials.push_back(CreateMaterial(law, constants, model.geometry.kind));
  model.bodies.push_back({"body", std::move(region), static_cast<int>(model.materials.size()) - 1, velocity, points_per_cell});
}

} // namespace mlgimp
