// The physics that all levels share: bodies, materials, loads, indenter, and the variants of the step.
#pragma once

#include "contact/settings.hpp"
#include "grid/nodes.hpp"
#include "level/loads.hpp"
#include "level/sweeps/kernels.hpp"
#include "physics/geometry.hpp"
#include "physics/indenter.hpp"
#include "physics/material.hpp"
#include "physics/region.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace mlgimp
{

enum class StressUpdate { kUsl, kUsf, kMusl };

struct Body {
  std::string name;
  std::unique_ptr<Region> region;
  int material;                     ///< place in Model::materials
  Vec3 velocity;                    ///< initial, m/s
  int points_per_cell;              ///< per direction
  Sym3 stress = {};                 ///< initial, Pa
  Vec3 stretch = {1, 1, 1};         ///< initial, along the axes: shape and place are those of the stretched body
  std::vector<double> history = {}; ///< of the material with this stress; empty where there is none
};

struct Model {
  Geometry geometry;
  std::array<BoundaryKind, kSides> sides{};
  std::vector<std::unique_ptr<Material>> materials;
  std::vector<Body> bodies;
  std::vector<Load> loads;
  std::optional<Indenter> indenter;
  ContactSettings contact;
  std::string shape_function = "cpgimp";
  StressUpdate stress_update = StressUpdate::kMusl;
  ShortWaveViscosity short_wave;
  NodalSettings nodal;                     ///< mass_cutoff is set by each level
  PiecewiseLinear gravity_share{{0}, {1}}; ///< of nodal.gravity, over time
  BodyAcceleration acceleration;           ///< beside gravity; empty for none

  /// Whether points follow a second extrapolation of velocities: with MUSL those that do not average their volume.
  bool HasSecondVelocity() const
  {
    return stress_update == StressUpdate::kMusl && VolumeAverages() < static_cast<int>(materials.size());
  }
  bool HasContact() const { return indenter && contact.method != "none"; }
  const Material &MaterialOf(int body) const { return *materials[bodies[body].material]; }
  int HistoryComponents() const
  {
    int largest = 0;
    for (const auto &material : materials) largest = std::max(largest, material->Traits().history);
    return largest;
  }
  /// Whether any material flows.
  bool Flows() const
  {
    return std::any_of(materials.begin(), materials.end(), [](const auto &material) { return material->Traits().flows; });
  }
  /// Whether the stress of any material depends on how fast it is strained.
  bool HasRate() const
  {
    return std::any_of(materials.begin(), materials.end(), [](const auto &material) { return material->Traits().has_rate; });
  }
  /// Whether any material creeps or relaxes under a stress that stays.
  bool Creeps() const
  {
    return std::any_of(materials.begin(), materials.end(), [](const auto &material) { return material->Traits().creeps; });
  }
  /// Whether any material splits points that are drawn out.
  bool SplitsStretched() const
  {
    return std::any_of(materials.begin(), materials.end(), [](const auto &material) { return material->SplitsStretched(); });
  }
  /// Half size that points have at least in their weights, in cells: half that of undeformed ones, so that those of a quarter,
  /// which lie beside a finer level, still fill space, twofold.
  double LeastHalfSize() const
  {
    constexpr double kMinOfUndeformed = 0.5;
    double least = SplitsStretched() ? kMinFlowHalfSize : kMinHalfSize;
    for (const Body &body : bodies) least = std::min(least, kMinOfUndeformed * 0.5 / body.points_per_cell);
    return least;
  }
  /// Number of materials that average the growth of volume over cells.
  int VolumeAverages() const
  {
    return static_cast<int>(
        std::count_if(materials.begin(), materials.end(), [](const auto &material) { return material->AveragesVolume(); }));
  }
  BodyTable Table() const
  {
    BodyTable table;
    std::vector<int> average;
    int averages = 0;
    for (const auto &material : materials) average.push_back(material->AveragesVolume() ? averages++ : -1);
    for (const Body &body : bodies) {
      table.material.push_back(materials[body.material].get());
      table.average.push_back(average[body.material]);
    }
    const auto &all = table.material;
    table.one_material = std::all_of(all.begin(), all.end(), [&](auto *one) { return one == all[0]; });
    return table;
  }
};

} // namespace mlgimp
