// What is found of a level between its steps: sums, extremes, velocities and forces of points.
#pragma once

#include "level/level.hpp"

#include <vector>

namespace mlgimp
{

/// Adds mass, momentum, energies and number of all points of a level on this rank; and those of some.
void SumPoints(Level &level, Budgets *sums);
Budgets SumPoints(Level &level, const std::vector<int> &points);
/// Largest of c + |v| and of |v| over this rank's points, m/s. A speed that is not finite is a failure of the level.
void FindLargestSpeeds(Level &level, double *wave, double *point);
/// Widens a box by the places of this rank's surface points that are nearer than `range` to the indenter with its tip there.
void FindNearIndenter(Level &level, Vec3 tip, double range, Box *near);

/// The nodal velocity of the last step at some points of this rank.
std::vector<VelocitySample> SampleVelocity(Level &level, const std::vector<int> &points);

// What follows puts other sums in the place of those of the step. Collective on the level's ranks.

/// Velocities of all nodes, p/m of the points where they are now, without a change.
PetscErrorCode FindVelocities(Level &level);
/// Force of some points times a sign on the nodes, in `sums` of owned nodes, without loads and body forces.
PetscErrorCode GatherForcesOf(Level &level, const std::vector<int> &points, double sign);
/// F and stress of some points as the grid sees them: sum_i S_ip (sum_q m_q S_iq F_q)/(sum_q m_q S_iq), [points][8], in two
/// dimensions.
PetscErrorCode SmoothTensors(Level &level, const std::vector<int> &points, std::vector<double> *tensors);

} // namespace mlgimp
