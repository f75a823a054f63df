// Free and held bodies that vibrate: energy over many periods, the exact period and displacement of a bar.
//
// Without arguments: the tests. With "table": energy of all updates.
#include "level/samples.hpp"
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>

using namespace mlgimp;

namespace
{

const MaterialConstants kMaterial = {1e7, 0.3, 1000, NAN, NAN};

const Scheme kUpdates[] = {
    {"MUSL + short-wave viscosity (default)", StressUpdate::kMusl, {0.001, 8}, 0},
    {"MUSL", StressUpdate::kMusl, {0, 0}, 0},
    {"USL", StressUpdate::kUsl, {0, 0}, 0},
    {"USF", StressUpdate::kUsf, {0, 0}, 0},
    {"MUSL + XPIC(2) 2 %", StressUpdate::kMusl, {0, 0}, 0.02},
    {"MUSL + XPIC(2) 10 %", StressUpdate::kMusl, {0, 0}, 0.1},
    {"USL + short-wave viscosity", StressUpdate::kUsl, {0.001, 8}, 0},
};

/// Energy after 20 periods over that at the start of a free block of side 1 on 24 x 24 cells, each the mean of a period.
PetscErrorCode BlockEnergy(const Scheme &update, double strain, double spin, const std::string &law, double *ratio)
{
  constexpr int kPeriods = 20, kCells = 24;
  LevelsRun run;
  PetscFunctionBeginUser;
  run.SetScheme(update);
  AddBody(run.model, CreateBoxRegion({{0, 0}, {1, 1}}), law, kMaterial);
  const double c = run.model.materials[0]->SpeedOfSound();
  PetscCall(run.Create(OneLevel(run.model, {{-0.5, -0.5}, {1.5, 1.5}}, 1.0 / kCells)));
  PetscCall(run.ForEachPoint([&](const PointArrays &points, int p, int) {
    const double *x = points.position + 2 * p;
    double *v = points.velocity + 2 * p;
    v[0] = strain * c * std::sin(M_PI * (x[0] - 0.5)) - spin * c * (x[1] - 0.5);
    v[1] = spin * c * (x[0] - 0.5);
  }));
  const int steps = static_cast<int>(std::ceil(2 * kCells / 0.36)); // in a period 2 L/c
  run.dt = 2 / c / steps;
  double first = 0, last = 0;
  for (int step = 0; step < kPeriods * steps && !run.Failed(); ++step) {
    Budgets point_sums;
    PetscCall(run.Advance());
    if (step >= steps && step < (kPeriods - 1) * steps) continue;
    SumPoints(run.hierarchy.At(0), &point_sums);
    (step < steps ? first : last) += point_sums.kinetic_energy + point_sums.strain_energy;
  }
  *ratio = run.Failed() ? NAN : last / first;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A bar held at x = 0 with v0 = V sin(pi x/2L): u = (V/w) sin(pi x/2L) sin(w t), w = pi c/2L.
PetscErrorCode VibratingBar()
{
  constexpr double kLength = 1, kSpeed = 1e-5; // of the wave speed
  constexpr int kCells = 32;
  LevelsRun run;
  PetscFunctionBeginUser;
  run.model.sides = {BoundaryKind::kSymmetry, BoundaryKind::kFree, BoundaryKind::kSymmetry, BoundaryKind::kSymmetry};
  run.SetScheme(kUpdates[0]);
  const double h = kLength / kCells;
  AddBody(run.model, CreateBoxRegion({{0, 0}, {kLength, 4 * h}}), "neo_hookean", kMaterial);
  const double c = run.model.materials[0]->SpeedOfSound(), w = M_PI * c / (2 * kLength), V = kSpeed * c;
  run.dt = 0.4 * h / c;
  HierarchySettings settings = OneLevel(run.model, {{0, 0}, {kLength + 4 * h, 4 * h}}, h);
  settings.sort_interval = 1 << 30; // point numbers stay
  PetscCall(run.Create(settings));
  PetscCall(run.ForEachPoint([&](const PointArrays &points, int p, int) {
    const double *x = points.position + 2 * p;
    double *v = points.velocity + 2 * p;
    v[0] = V * std::sin(0.5 * M_PI * x[0] / kLength) * std::cos(0.5 * w * run.dt);
  }));
  const PointArrays a = run.hierarchy.At(0).PointStore().Arrays();
  int end = 0;
  for (int p = 0; p < a.count; ++p)
    if (a.position[2 * p] > a.position[2 * end]) end = p;
  const double X = a.position[2 * end], amplitude = V / w * std::sin(0.5 * M_PI * X / kLength);
  double largest_error = 0, crossing = 0, before = 0;
  int crossings = 0;
  while (crossings < 10) {
    PetscCall(run.Advance());
    const double u = a.position[2 * end] - X;
    largest_error = Largest({largest_error, std::abs(u - amplitude * std::sin(w * run.time))});
    if (before * u < 0) {
      crossing = run.time - run.dt * u / (u - before);
      ++crossings;
    }
    before = u;
  }
  ExpectAtMost("bar: error of the period after 5 periods", std::abs(crossing * w / (10 * M_PI) - 1), 0.005);
  ExpectAtMost("bar: displacement of the end against its amplitude, 5 periods", largest_error / amplitude, 0.05);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Table(int)
{
  PetscFunctionBeginUser;
  std::printf("| update | 0.5 %% | 5 %% | 5 %%, rotating |\n| --- | --- | --- | --- |\n");
  for (const Scheme &update : kUpdates) {
    double small, large, turning;
    PetscCall(BlockEnergy(update, 0.005, 0, "neo_hookean", &small));
    PetscCall(BlockEnergy(update, 0.05, 0, "neo_hookean", &large));
    PetscCall(BlockEnergy(update, 0.05, 0.05, "neo_hookean", &turning));
    std::printf("| %s | %.3f | %.3f | %.3f |\n", update.name, small, large, turning);
    std::fflush(stdout);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Vibration, FreeBlock)
{
  double ratio;
  ASSERT_EQ(BlockEnergy(kUpdates[0], 0.005, 0, "neo_hookean", &ratio), PETSC_SUCCESS);
  ExpectAtMost("free block, strain 0.5 %: |E/E0 - 1| after 20 periods", std::abs(ratio - 1), 0.03);
  ASSERT_EQ(BlockEnergy(kUpdates[0], 0.05, 0, "neo_hookean", &ratio), PETSC_SUCCESS);
  ExpectAtMost("free block, strain 5 %: |E/E0 - 1| after 20 periods", std::abs(ratio - 1), 0.03);
  ASSERT_EQ(BlockEnergy(kUpdates[0], 0.05, 0.05, "neo_hookean", &ratio), PETSC_SUCCESS);
  ExpectAtMost("rotating block, strain 5 %: |E/E0 - 1| after 20 periods", std::abs(ratio - 1), 0.03);
}

TEST(Vibration, Bar) { EXPECT_EQ(VibratingBar(), PETSC_SUCCESS); }

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv, Table); }
