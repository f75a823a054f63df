// Pressure on the sides of bodies: it acts on the current faces of the points and follows them.
#pragma once

#include "grid/grid.hpp"
#include "level/sweeps/kernels.hpp"
#include "physics/indenter.hpp"
#include "points/face.hpp"
#include "points/points.hpp"

#include <vector>

namespace mlgimp
{

/// A pressure history on one side of a body.
struct Load {
  int body;
  Side side;
  double span[2][2];        ///< start and end along each axis of the side, m
  PiecewiseLinear pressure; ///< positive pushes into the body, Pa
};

/// The force of a load on a point's face, and the weights of the 3 nodes along each axis around the face's centre.
struct FaceForce {
  Index nearest;
  AxisWeights<double> at[3];
  Vec3 force; ///< N
};

/// Adds the forces of the loads at `time` to the nodal forces, and to the list `applied` those on points that the level owns.
/// f_i = -p n int_face N_i ds: the hat function across the face and its mean along the face (paper's Eq. 10).
/// failure: a point whose face has left this rank's nodes.
void AddLoads(const Grid &grid, Points &points, bool owned, const std::vector<Load> &loads, const Geometry &geometry, double time,
              std::vector<FaceForce> &applied, PointFailure &failure);

/// Adds up the impulse of the forces in a step, from the sums as points have given them. Forces on nodes with no more than a mass
/// are lost. Masses must be known on ghosts.
void AddLoadImpulse(const Grid &grid, const std::vector<FaceForce> &applied, double mass_cutoff, double dt, Budgets &budgets);
/// (p + P)/2m of all local nodes, P the momentum after the step (MomentumAfter), m/s [ghosted nodes][dim]. Sums, velocities and
/// rates must be known on ghosts.
std::vector<double> MeanMotion(const Grid &grid, double mass_cutoff, bool spread);
/// Adds up the work of the forces, from the motion of all nodes with those that hang on others.
void AddLoadWork(const Grid &grid, const std::vector<FaceForce> &applied, const std::vector<double> &motion, double dt,
                 Budgets &budgets);

} // namespace mlgimp
