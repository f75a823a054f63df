// The sweeps over the points of a level: points to grid, grid to points, and strain with stress.
//
// Each sweep works on blocks of kBlock points: weights, then gather, then the points' own update, then scatter, while
// the block is in the cache. Every array is touched once a sweep. Nodal arrays: see NodeSums and NodeLayout in nodal_arrays.hpp.
#pragma once

#include "grid/budgets.hpp"
#include "grid/grid.hpp"
#include "physics/body_table.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mlgimp
{

/// a and b of the strength of the short-wave viscosity (short_wave.hpp); none where both are zero.
struct ShortWaveViscosity {
  double a = 0, b = 0;
  bool On() const { return a > 0 || b > 0; }
};

/// Acceleration of `count` points from ids and positions [count][dim] at a time: acceleration [count][dim], m/s2.
using BodyAcceleration =
    std::function<void(double time, int count, const std::int64_t *id, const double *position, double *acceleration)>;

/// What went wrong first with a point.
struct PointFailure {
  enum Kind { kNone, kLeftGrid, kDeformedTooFast, kNotFinite } kind = kNone;
  std::int64_t id = -1;
  Vec3 position{};
};

/// What happens to the velocities of points beside the change that they take.
struct VelocityPlan {
  double damped = 0;          ///< share of the points' motion that the nodes do not have which `-damping` takes in the step
  bool counts_energy = false; ///< add what the points get to Budgets::exchange_energy
};

/// Settings of the sweep that adds to nodes and cells what the step does to the points.
struct SpreadPlan {
  double dt;     ///< s
  bool momentum; ///< change the points' velocities, and add m_p sum S dv to `rates`
  bool project;  ///< and, for XPIC, m_p sum S v
  VelocityPlan velocity;
};

/// Settings of the sweep from the grid to the points.
struct GridToPointsPlan {
  double dt, scale;                   ///< s; simulated time over that of the test
  bool second_velocity = false;       ///< points that do not average their volume follow the velocities in `rates`
  bool change_velocity = true;        ///< where SpreadChange has not
  VelocityPlan velocity = {};         ///< then
  bool strain = true;                 ///< advance F and stress
  bool move = true;                   ///< move the points
  ShortWaveViscosity short_wave = {}; ///< uses the smooth strain rates in `rates`
  double xpic_fraction = 0;           ///< share of the projected velocity in `rates`
};

/// One rank's points and nodes during a sweep.
struct SweepView {
  const Grid &grid;
  PointArrays points;
  const BodyTable &bodies;
  bool owned = true; ///< false for copies of another level's points: they act, but do not count
};

/// The nodal velocity of the last step at a point: its change in the step, m/s, and the gradient of the new one, 1/s.
struct VelocitySample {
  Vec3 change{};
  std::array<double, 9> L{}; ///< [dim][dim], by rows
};

inline constexpr int kTensors = 8; ///< size: components of F and stress in two dimensions

/// The sweeps, in one geometry with one shape function.
class Kernels
{
public:
  virtual ~Kernels() = default;

  /// Adds mass, momentum and internal force (and `acceleration` times mass, where given) to the nodal sums.
  virtual void PointsToGrid(const SweepView &view, const BodyAcceleration &acceleration, double time, Budgets &budgets) const = 0;

  /// v_p += sum S dv (FLIP), and what that adds to the momenta of nodes; of points that average their volume its growth to the
  /// cells.
  virtual void SpreadChange(const SweepView &view, const SpreadPlan &plan, Budgets &budgets) const = 0;

  /// v_p += sum S dv where that is still to do, XPIC; strain, stress and short-wave stress; moves the points.
  virtual void GridToPoints(const SweepView &view, const GridToPointsPlan &plan, Budgets &budgets,
                            PointFailure &failure) const = 0;

  /// The nodal velocity at one point, from the nodes with more than a mass: a point that has just moved may reach nodes that
  /// no point had reached in the step.
  virtual VelocitySample VelocityAt(const SweepView &view, int point, double mass_cutoff) const = 0;

  /// In two dimensions: adds F and stress, times mass, to an array of the nodes [ghosted nodes][kTensors].
  virtual void ScatterTensors(const SweepView &view, double *nodes) const = 0;
  /// F and stress at one point, tensors [kTensors], from those of the nodes.
  virtual void TensorsAt(const SweepView &view, double *nodes, int point, double *tensors) const = 0;
};

/// Names that -shape_function accepts: linear, ugimp, cpgimp.
std::vector<std::string> ShapeFunctions();
std::unique_ptr<Kernels> CreateKernels(GeometryKind geometry, const std::string &shape_function);

} // namespace mlgimp
