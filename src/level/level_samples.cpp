// What a level shows of its points: sums, extremes, velocities and forces of some, and views.
#include "level/level.hpp"
#include "level/sweeps/point_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

std::vector<VelocitySample> Level::SampleVelocity(const std::vector<int> &points)
{
  std::vector<VelocitySample> samples(points.size());
  if (!grid_->Participates()) return samples;
  const PointArrays arrays = stores_.own.Arrays();
  const SweepView view = {*grid_, arrays, sweeps_.bodies};
  for (std::size_t k = 0; k < points.size(); ++k)
    samples[k] = sweeps_.kernels->VelocityAt(view, points[k], settings_.nodal.mass_cutoff);
  return samples;
}

PetscErrorCode Level::FindVelocities()
{
  Budgets discarded;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  grid_->Arrays().ClearSums();
  sweeps_.kernels->PointsToGrid({*grid_, stores_.own.Arrays(), sweeps_.bodies}, {}, step_.time, discarded);
  PetscCall(grid_->ShareSums());
  UpdateVelocities(*grid_, settings_.nodal, 0);
  ApplyBoundaryConditions(*grid_, geometry_.sides, settings_.nodal, &step_.held_nodes, discarded);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Level::GatherForcesOf(const std::vector<int> &points, double sign)
{
  Budgets discarded;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  const PointArrays all = stores_.own.Arrays();
  grid_->Arrays().ClearSums();
  for (int p : points) {
    double mass = sign * all.mass[p];
    PointArrays one = Slice(all, p, p + 1);
    one.mass = &mass;
    sweeps_.kernels->PointsToGrid({*grid_, one, sweeps_.bodies}, {}, step_.time, discarded);
  }
  PetscCall(grid_->ShareSums());
  PetscCall(light_.Restrict(grid_->Halo(), &grid_->Sums()->mass, NodeLayout::kSums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// F_zz = r/R of at most kBlock points; null where the geometry has none.
static const double *HoopStretch(const PointArrays &points, double *hoop)
{
  if (!points.initial_radius) return nullptr;
  for (int p = 0; p < points.count; ++p) hoop[p] = points.position[points.dim * p] / points.initial_radius[p];
  return hoop;
}

double Level::NoiseEnergy()
{
  const PointArrays points = stores_.own.Arrays();
  double energy = 0;
  for (int p = 0; p < points.count; ++p) {
    const Vec3 v = points.Velocity(p);
    energy += 0.5 * points.mass[p] * Dot(v, v);
  }
  return energy - KineticEnergy(*grid_, settings_.nodal);
}

/// Adds at most kBlock points of one material.
static void AddPoints(const PointArrays &points, const Material &material, Budgets *sums)
{
  double energy[kBlock];
  double hoop[kBlock];
  material.StoredEnergy(points.count, points.F, HoopStretch(points, hoop), points.stress, points.history,
                        points.history_components, energy);
  const double *const masses = points.mass, *const velocity = points.velocity;
  const int dim = points.dim;
  double strain = 0, mass = 0;
#pragma omp simd reduction(+ : strain, mass)
  for (int p = 0; p < points.count; ++p) strain += energy[p] * masses[p], mass += masses[p];
  for (int axis = 0; axis < dim; ++axis) {
    double kinetic = 0, momentum = 0;
#pragma omp simd reduction(+ : kinetic, momentum)
    for (int p = 0; p < points.count; ++p) {
      const double v = velocity[dim * p + axis];
      kinetic += 0.5 * masses[p] * v * v;
      momentum += masses[p] * v;
    }
    sums->kinetic_energy += kinetic;
    sums->momentum[axis] += momentum;
  }
  sums->strain_energy += strain / material.Density();
  sums->mass += mass;
  sums->points += points.count;
}

void Level::SumPoints(Budgets *sums)
{
  ForEachBlock({*grid_, stores_.own.Arrays(), sweeps_.bodies}, [&](const Block &b) { AddPoints(b, b.material, sums); });
}

Budgets Level::SumPoints(const std::vector<int> &list)
{
  Budgets sums;
  const PointArrays points = stores_.own.Arrays();
  for (int p : list) AddPoints(Slice(points, p, p + 1), sweeps_.bodies.Of(points, p), &sums);
  return sums;
}

void Level::FindNearIndenter(Vec3 tip, double range, Box *near)
{
  if (!contact_.Exists()) return;
  const PointArrays points = stores_.own.Arrays();
  const std::vector<int> &surface = stores_.own.SurfacePoints();
  for (int p : surface) {
    const Vec3 x = points.Position(p);
    if (!(model_.indenter->Gap(x, tip).distance < range)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      near->lower[axis] = std::min(near->lower[axis], x[axis]);
      near->upper[axis] = std::max(near->upper[axis], x[axis]);
    }
  }
}

void Level::LargestSpeeds(double *wave, double *point)
{
  *wave = *point = 0;
  ForEachBlock({*grid_, stores_.own.Arrays(), sweeps_.bodies}, [&](const Block &b) {
    double speed2[kBlock], hoop[kBlock], speeds[kBlock];
    double fastest_point = 0, fastest_wave = 0, sum = 0; // a maximum hides what is no number; a sum does not
    b.material.WaveSpeedSquared(b.count, b.F, HoopStretch(b, hoop), speed2);
    for (int p = 0; p < b.count; ++p) speeds[p] = Norm(b.Velocity(p));
#pragma omp simd reduction(max : fastest_point, fastest_wave) reduction(+ : sum)
    for (int p = 0; p < b.count; ++p) {
      fastest_point = std::max(fastest_point, speeds[p]);
      fastest_wave = std::max(fastest_wave, speeds[p] + std::sqrt(speed2[p]));
      sum += speeds[p];
    }
    for (int p = 0; std::isnan(sum) && p < b.count; ++p)
      if (std::isnan(speeds[p])) RecordFailure({PointFailure::kNotFinite, b.id[p], b.Position(p)}, step_.time);
    *point = std::max(*point, fastest_point);
    *wave = std::max(*wave, fastest_wave);
  });
}

PetscErrorCode Level::View(const std::string &prefix, double time)
{
  PetscBool nodes = PETSC_FALSE;
  const Budgets before = budgets_;
  PetscFunctionBeginUser;
  if (!grid_->Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(stores_.own.View(prefix));
  PetscCall(PetscOptionsHasName(nullptr, prefix.c_str(), "-nodes_view", &nodes));
  if (nodes) {
    PetscCall(PointsToGrid(time));
    PetscCall(grid_->ShareSums());
    budgets_ = before;
  }
  PetscCall(grid_->View(prefix, settings_.nodal.mass_cutoff));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
