// Axis-aligned manufactured solution (Wallstedt & Guilkey 2008): order of convergence of the whole step.
//
//   u = A sin(2 pi X) sin(c pi t), v = A sin(2 pi Y) sin(c pi t + pi) on the unit square between rollers.
// Without arguments: the tests. With "table N": errors of all variants up to N x N cells.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <unordered_map>

using namespace mlgimp;

namespace
{

constexpr double kE = 1e7, kNu = 0.3, kRho = 1000, kA = 0.05, kPeriod = 0.02;
const double kC = std::sqrt(kE / kRho);

/// Displacement and acceleration in reference coordinates along one axis; the other axis has the phase shifted by pi.
double Displacement(double X, double phase) { return kA * std::sin(2 * M_PI * X) * std::sin(phase); }
double Stretch(double X, double phase) { return 1 + 2 * M_PI * kA * std::cos(2 * M_PI * X) * std::sin(phase); }

double BodyForce(double X, double phase, double own, double other, const Material &material)
{
  const double lambda = material.Elastic().lambda, mu = material.Elastic().mu, u = Displacement(X, phase);
  return M_PI * M_PI * u * (4 * mu / kRho - kC * kC - 4 * (lambda * (std::log(own * other) - 1) - mu) / (kRho * own * own));
}

struct Variant {
  const char *name, *shape;
  StressUpdate update;
  ShortWaveViscosity viscosity;
  double xpic;
  double own_growth = 1; ///< less: growth of volume is averaged over cells, but for this share
};

struct Errors {
  double largest = 0, rms = 0; ///< over points, the worst of all steps, in lengths of the square's side
};

PetscErrorCode Solve(int n, const Variant &variant, double cfl, Errors *errors)
{
  Model model;
  std::unordered_map<std::int64_t, Vec3> reference;
  PetscFunctionBeginUser;
  model.sides.fill(BoundaryKind::kSymmetry);
  model.shape_function = variant.shape;
  model.stress_update = variant.update;
  model.short_wave = variant.viscosity;
  model.nodal.xpic_fraction = variant.xpic;
  const Box square = {{0, 0}, {1, 1}};
  AddBody(model, CreateBoxRegion(square), "neo_hookean", {kE, kNu, kRho, NAN, NAN});
  model.materials[0]->AverageVolume(variant.own_growth);
  const Material &material = *model.materials[0];
  model.acceleration = [&](double time, int count, const std::int64_t *id, const double *, double *a) {
    const double phase = kC * M_PI * time;
    for (int p = 0; p < count; ++p) {
      const Vec3 X = reference.at(id[p]);
      const double Fxx = Stretch(X[0], phase), Fyy = Stretch(X[1], phase + M_PI);
      a[2 * p] = BodyForce(X[0], phase, Fxx, Fyy, material);
      a[2 * p + 1] = BodyForce(X[1], phase + M_PI, Fyy, Fxx, material);
    }
  };
  LogEvents events;
  Hierarchy hierarchy;
  PetscCall(RegisterLogEvents(&events));
  PetscCall(hierarchy.Create(PETSC_COMM_WORLD, model, OneLevel(model, square, 1.0 / n), events, true));
  PointArrays points;
  points = hierarchy.At(0).PointStore().Arrays();
  const int steps = static_cast<int>(std::ceil(kPeriod * n * material.SpeedOfSound() * 1.2 / cfl));
  const double dt = kPeriod / steps;
  for (int p = 0; p < points.count; ++p) {
    const Vec3 X = {points.position[2 * p], points.position[2 * p + 1]};
    reference[points.id[p]] = X;
    // The scheme's velocities belong to half steps.
    points.velocity[2 * p] = kA * kC * M_PI * std::sin(2 * M_PI * X[0]) * std::cos(-0.5 * kC * M_PI * dt);
    points.velocity[2 * p + 1] = kA * kC * M_PI * std::sin(2 * M_PI * X[1]) * std::cos(-0.5 * kC * M_PI * dt + M_PI);
  }
  *errors = {};
  for (int step = 0; step < steps; ++step) {
    PetscCall(hierarchy.Advance({step * dt, dt}));
    if (hierarchy.At(0).Step().failure.kind != LevelFailure::kNone) {
      *errors = {NAN, NAN};
      break;
    }
    points = hierarchy.At(0).PointStore().Arrays();
    const double phase = kC * M_PI * (step + 1) * dt;
    double sum = 0;
    for (int p = 0; p < points.count; ++p) {
      const Vec3 X = reference.at(points.id[p]);
      const Vec3 error = {points.position[2 * p] - X[0] - Displacement(X[0], phase),
                          points.position[2 * p + 1] - X[1] - Displacement(X[1], phase + M_PI)};
      errors->largest = Largest({errors->largest, Norm(error)});
      sum += Dot(error, error);
    }
    errors->rms = Largest({errors->rms, std::sqrt(sum / points.count)});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Variant kVariants[] = {
    {"cpGIMP USL", "cpgimp", StressUpdate::kUsl, {0, 0}, 0},
    {"cpGIMP MUSL XPIC(2) 10 %", "cpgimp", StressUpdate::kMusl, {0, 0}, 0.1},
    {"cpGIMP default", "cpgimp", StressUpdate::kMusl, {0.001, 8}, 0},
    {"cpGIMP MUSL XPIC(2) 2 %", "cpgimp", StressUpdate::kMusl, {0, 0}, 0.02},
    {"cpGIMP MUSL", "cpgimp", StressUpdate::kMusl, {0, 0}, 0},
    {"cpGIMP USF", "cpgimp", StressUpdate::kUsf, {0, 0}, 0},
    {"uGIMP default", "ugimp", StressUpdate::kMusl, {0.001, 8}, 0},
    {"original MPM USL", "linear", StressUpdate::kUsl, {0, 0}, 0},
    {"cpGIMP default, volume average", "cpgimp", StressUpdate::kMusl, {0.001, 8}, 0, 0.05},
};

PetscErrorCode Table(int largest_n)
{
  PetscFunctionBeginUser;
  std::printf("| variant | n | max error | order | rms error | order |\n| --- | --- | --- | --- | --- | --- |\n");
  for (const Variant &variant : kVariants) {
    Errors previous;
    for (int n = 8; n <= largest_n; n *= 2) {
      Errors e;
      PetscCall(Solve(n, variant, 0.4, &e));
      std::printf("| %s | %d | %.2e | %.2f | %.2e | %.2f |\n", variant.name, n, e.largest,
                  n > 8 ? std::log2(previous.largest / e.largest) : NAN, e.rms, n > 8 ? std::log2(previous.rms / e.rms) : NAN);
      std::fflush(stdout);
      previous = e;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// largest_error: at n = 32.
PetscErrorCode TestOrder(const Variant &variant, double largest_error, double order)
{
  Errors coarse, middle, fine;
  PetscFunctionBeginUser;
  PetscCall(Solve(16, variant, 0.4, &coarse));
  PetscCall(Solve(32, variant, 0.4, &middle));
  PetscCall(Solve(64, variant, 0.4, &fine));
  const std::string name = variant.name;
  ExpectAtMost(name + ", max error at n = 32", middle.largest, largest_error);
  ExpectAtLeast(name + ", order of the max error, n = 16..64", 0.5 * std::log2(coarse.largest / fine.largest), order);
  ExpectAtLeast(name + ", order of the rms error, n = 16..64", 0.5 * std::log2(coarse.rms / fine.rms), order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(Manufactured, Usl) { EXPECT_EQ(TestOrder(kVariants[0], 7e-4, 1.8), PETSC_SUCCESS); }

TEST(Manufactured, Xpic) { EXPECT_EQ(TestOrder(kVariants[1], 7e-4, 1.8), PETSC_SUCCESS); }

TEST(Manufactured, Default) { EXPECT_EQ(TestOrder(kVariants[2], 7e-4, 1.8), PETSC_SUCCESS); }

TEST(Manufactured, VolumeAverage) { EXPECT_EQ(TestOrder(kVariants[8], 8e-4, 1.9), PETSC_SUCCESS); }

TEST(Manufactured, OriginalMpmDoesNotConverge)
{
  Errors coarse, fine;
  ASSERT_EQ(Solve(16, kVariants[7], 0.4, &coarse), PETSC_SUCCESS);
  ASSERT_EQ(Solve(64, kVariants[7], 0.4, &fine), PETSC_SUCCESS);
  ExpectTrue("original MPM does not converge", !(fine.largest < 0.5 * coarse.largest));
}

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv, Table); }
