// What a level consists of, for those that work on its parts: contact, and all that reads or changes its points.
#pragma once

#include "contact/border_nodes.hpp"
#include "grid/light_nodes.hpp"
#include "level/events.hpp"
#include "level/following_nodes.hpp"
#include "level/level_geometry.hpp"
#include "points/points.hpp"
#include "surface/pieces.hpp"

#include <cstddef>
#include <map>
#include <vector>

namespace mlgimp
{

/// Why a level cannot go on; the first reason that this rank met.
struct LevelFailure {
  enum Kind { kNone, kPoint, kContact } kind = kNone;
  PointFailure point;
  double time = 0; ///< s
};

/// The step that a level takes, or took last.
struct LevelStep {
  long taken = 0;                         ///< steps before it; after its end also itself
  double time = 0;                        ///< at its start, s
  double scale = 1;                       ///< simulated time over that of the test
  bool measures_noise = false;            ///< of the points' velocities, for Level::Totals
  std::vector<FaceForce> applied;         ///< by loads
  std::map<std::ptrdiff_t, double> ahead; ///< see AdvanceContactNodes
  LevelFailure failure;                   ///< in it or before

  /// Keeps why the level cannot go on, if it is the first reason.
  void Fail(LevelFailure::Kind kind, const PointFailure &point = {})
  {
    if (failure.kind == LevelFailure::kNone) failure = {kind, point, time};
  }
  /// The same where a point has failed.
  void Record(const PointFailure &point)
  {
    if (point.kind != PointFailure::kNone) Fail(LevelFailure::kPoint, point);
  }
};

/// Nodes whose velocities neighbouring levels have a part in, and the borders to these.
struct CoupledLevel {
  bool on = false;                      ///< their exchange of energy is added up
  std::vector<std::ptrdiff_t> nodes;    ///< places of owned ones
  CoupledPlaces places;                 ///< all that this rank has
  FollowingNodes following;             ///< blended ones beside the indenter
  BorderNodes *coarser = nullptr;       ///< the border to the next coarser level; null where there is none
  SharedNode *finer = nullptr;          ///< by place, nodes that also move the next finer level's; null where there is none
  const double *finer_masses = nullptr; ///< by place, what the next finer level's points give nodes, kg; likewise
};

/// The parts of a level on this rank; valid until the level moves or gets another layout.
struct LevelParts {
  const Model &model;
  const LogEvents &events;
  const LevelGeometry &geometry;
  const NodalSettings &nodal;
  const Kernels &kernels;
  const BodyTable &bodies;
  const LightNodes &light;
  Grid &grid;
  Points &points; ///< its own
  LevelStep &step;

  SweepView View() const { return {grid, points.Arrays(), bodies}; }
  /// For contact, where the model has an indenter.
  SurfaceInputs InputsOf(const Surface &surface) const
  {
    return {grid, model.geometry, surface, points, bodies, *model.indenter};
  }
};

} // namespace mlgimp
