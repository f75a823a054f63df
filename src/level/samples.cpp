// Sums and extremes over the points of a level, and what the nodes have at some.
#include "level/samples.hpp"

#include "level/sweeps/point_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlgimp
{

/// F_zz = r/R of at most kBlock points; null where the geometry has none.
static const double *HoopStretch(const PointArrays &points, double *hoop)
{
  if (!points.initial_radius) return nullptr;
  for (int p = 0; p < points.count; ++p) hoop[p] = points.position[points.dim * p] / points.initial_radius[p];
  return hoop;
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

void SumPoints(Level &level, Budgets *sums)
{
  ForEachBlock(level.Parts().View(), [&](const Block &b) { AddPoints(b, b.material, sums); });
}

Budgets SumPoints(Level &level, const std::vector<int> &points)
{
  const SweepView view = level.Parts().View();
  Budgets sums;
  for (int p : points) AddPoints(Slice(view.points, p, p + 1), view.bodies.Of(view.points, p), &sums);
  return sums;
}

void FindLargestSpeeds(Level &level, double *wave, double *point)
{
  *wave = *point = 0;
  ForEachBlock(level.Parts().View(), [&](const Block &b) {
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
      if (std::isnan(speeds[p])) level.Step().Record({PointFailure::kNotFinite, b.id[p], b.Position(p)});
    *point = std::max(*point, fastest_point);
    *wave = std::max(*wave, fastest_wave);
  });
}

void FindNearIndenter(Level &level, Vec3 tip, double range, Box *near)
{
  const Model &model = level.Parts().model;
  if (!model.HasContact()) return;
  const PointArrays points = level.PointStore().Arrays();
  for (int p : level.PointStore().SurfacePoints()) {
    const Vec3 x = points.Position(p);
    if (!(model.indenter->Gap(x, tip).distance < range)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      near->lower[axis] = std::min(near->lower[axis], x[axis]);
      near->upper[axis] = std::max(near->upper[axis], x[axis]);
    }
  }
}

std::vector<VelocitySample> SampleVelocity(Level &level, const std::vector<int> &points)
{
  const LevelParts parts = level.Parts();
  std::vector<VelocitySample> samples(points.size());
  if (!parts.grid.Participates()) return samples;
  const SweepView view = parts.View();
  for (std::size_t k = 0; k < points.size(); ++k) samples[k] = parts.kernels.VelocityAt(view, points[k], parts.nodal.mass_cutoff);
  return samples;
}

PetscErrorCode FindVelocities(Level &level)
{
  const LevelParts parts = level.Parts();
  Budgets discarded;
  PetscFunctionBeginUser;
  if (!parts.grid.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  parts.grid.Arrays().ClearSums();
  parts.kernels.PointsToGrid(parts.View(), {}, 0, discarded);
  PetscCall(parts.grid.ShareSums());
  UpdateVelocities(parts.grid, parts.nodal, 0);
  ApplyBoundaryConditions(parts.grid, parts.geometry.sides, parts.nodal, discarded);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherForcesOf(Level &level, const std::vector<int> &points, double sign)
{
  const LevelParts parts = level.Parts();
  Budgets discarded;
  PetscFunctionBeginUser;
  if (!parts.grid.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  const PointArrays all = parts.points.Arrays();
  parts.grid.Arrays().ClearSums();
  for (int p : points) {
    double mass = sign * all.mass[p];
    PointArrays one = Slice(all, p, p + 1);
    one.mass = &mass;
    parts.kernels.PointsToGrid({parts.grid, one, parts.bodies}, {}, 0, discarded);
  }
  PetscCall(parts.grid.ShareSums());
  PetscCall(parts.light.Restrict(parts.grid.Halo(), &parts.grid.Sums()->mass, NodeLayout::kSums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SmoothTensors(Level &level, const std::vector<int> &points, std::vector<double> *tensors)
{
  const LevelParts parts = level.Parts();
  Grid &grid = parts.grid;
  Budgets discarded;
  PetscFunctionBeginUser;
  tensors->resize(kTensors * points.size());
  if (!grid.Participates()) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<double> nodes(kTensors * grid.Ghosted().Count());
  std::vector<int> all(kTensors);
  std::iota(all.begin(), all.end(), 0);
  grid.Arrays().ClearSums();
  for (Points *store : level.Stores().All()) {
    const SweepView view = {grid, store->Arrays(), parts.bodies, store == &parts.points};
    parts.kernels.ScatterTensors(view, nodes.data());
    parts.kernels.PointsToGrid(view, {}, 0, discarded);
  }
  PetscCall(grid.Halo().Sum({{nodes.data(), kTensors, all}}));
  PetscCall(grid.ShareSums());
  for (std::ptrdiff_t node = 0; node < grid.Ghosted().Count(); ++node) {
    const double mass = std::max(grid.Sums()[node].mass, parts.nodal.mass_cutoff);
    for (int c = 0; c < kTensors; ++c) nodes[kTensors * node + c] /= mass;
  }
  const SweepView view = parts.View();
  for (std::size_t k = 0; k < points.size(); ++k)
    parts.kernels.TensorsAt(view, nodes.data(), points[k], &(*tensors)[kTensors * k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
