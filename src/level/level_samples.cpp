// What a level tells about its points: sums, extremes, velocities and forces of some.
#include "level/level.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

PetscErrorCode Level::SampleVelocity(const std::vector<int> &points, std::vector<VelocitySample> *samples)
{
  PointArrays arrays;
  PetscFunctionBeginUser;
  samples->resize(points.size());
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(grid_->Broadcast(grid_->Arrays().sums, NodeArrays::kSums)); // nodes without mass have no velocity
  PetscCall(points_.Arrays(&arrays));
  const SweepView view = {*grid_, arrays, nullptr, bodies_};
  for (std::size_t k = 0; k < points.size(); ++k)
    kernels_->VelocityAt(view, points[k], nodal_.mass_cutoff, (*samples)[k].change.data(), (*samples)[k].L);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::GatherForcesOf(const std::vector<int> &points, double sign)
{
  PointArrays all;
  SweepTotals discarded;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(points_.Arrays(&all));
  std::fill_n(grid_->Arrays().sums, NodeArrays::kSums * static_cast<std::size_t>(grid_->GhostedNodes()), 0.0);
  for (int p : points) {
    double mass = sign * all.mass[p];
    PointArrays one = Slice(all, p, p + 1);
    one.mass = &mass;
    kernels_->PointsToGrid({*grid_, one, nullptr, bodies_}, {}, time_, discarded);
  }
  PetscCall(grid_->ReduceToOwners(grid_->Arrays().sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds at most kBlock points of one material.
static void AddPoints(const PointArrays &points, const Material &material, PointSums *point_sums)
{
  double energy[kBlock];
  material.StoredEnergy(points.count, points.F, nullptr, points.stress, points.history, points.history_components, energy);
  const double *const masses = points.mass, *const velocity = points.velocity;
  double kinetic = 0, strain = 0, mass = 0, momentum_x = 0, momentum_y = 0;
#pragma omp simd reduction(+ : kinetic, strain, mass, momentum_x, momentum_y)
  for (int p = 0; p < points.count; ++p) {
    const double m = masses[p], x = velocity[2 * p], y = velocity[2 * p + 1];
    kinetic += 0.5 * m * (x * x + y * y);
    strain += energy[p] * m;
    mass += m;
    momentum_x += m * x;
    momentum_y += m * y;
  }
  point_sums->kinetic_energy += kinetic;
  point_sums->strain_energy += strain / material.Density();
  point_sums->mass += mass;
  point_sums->momentum = point_sums->momentum + Vec3{momentum_x, momentum_y};
  point_sums->count += points.count;
}

PetscErrorCode Level::SumPoints(PointSums *point_sums)
{
  PointArrays points;
  PetscFunctionBeginUser;
  *point_sums = {};
  PetscCall(points_.Arrays(&points));
  for (int first = 0, end; first < points.count; first = end) {
    end = bodies_.BlockEnd(points, first);
    AddPoints(Slice(points, first, end), bodies_.Of(points, first), point_sums);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::SumPoints(const std::vector<int> &list, PointSums *point_sums)
{
  PointArrays points;
  PetscFunctionBeginUser;
  *point_sums = {};
  PetscCall(points_.Arrays(&points));
  for (int p : list) AddPoints(Slice(points, p, p + 1), bodies_.Of(points, p), point_sums);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::IndenterDistance(double time, double *distance)
{
  const std::vector<int> *surface = nullptr;
  PointArrays points;
  PetscFunctionBeginUser;
  *distance = HUGE_VAL;
  if (!contact_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(points_.Arrays(&points));
  PetscCall(points_.SurfacePoints(&surface));
  for (int p : *surface) {
    const double *x = points.position + 2 * p;
    *distance = std::min(*distance, model_.indenter->Gap({x[0], x[1]}, time).distance);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::LargestSpeeds(double *wave, double *point)
{
  PointArrays points;
  double speed2[kBlock];
  PetscFunctionBeginUser;
  *wave = *point = 0;
  PetscCall(points_.Arrays(&points));
  for (int first = 0, end; first < points.count; first = end) {
    end = bodies_.BlockEnd(points, first);
    bodies_.Of(points, first).WaveSpeedSquared(end - first, points.F + 4 * first, nullptr, speed2);
    double fastest_point = 0, fastest_wave = 0, sum = 0; // the largest of numbers hides one that is none; their sum does not
#pragma omp simd reduction(max : fastest_point, fastest_wave) reduction(+ : sum)
    for (int p = first; p < end; ++p) {
      const double *v = points.velocity + 2 * p, speed = std::sqrt(v[0] * v[0] + v[1] * v[1]);
      fastest_point = std::max(fastest_point, speed);
      fastest_wave = std::max(fastest_wave, speed + std::sqrt(speed2[p - first]));
      sum += speed;
    }
    for (int p = first; std::isnan(sum) && p < end; ++p)
      if (std::isnan(points.velocity[2 * p] + points.velocity[2 * p + 1]))
        NoteFailure({PointFailure::kNotFinite, points.id[p], {points.position[2 * p], points.position[2 * p + 1]}}, time_);
    *point = std::max(*point, fastest_point);
    *wave = std::max(*wave, fastest_wave);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
