// The axis-aligned manufactured solution (see manufactured.cpp) across the borders of finer levels, in the plane and in space:
// order of convergence.
//
// Without arguments: the tests. With "table N": errors of all levels and schemes up to N x N coarse cells; with "table -N" those
// in space.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <unordered_map>

using namespace mlgimp;

namespace
{

constexpr double kE = 1e7, kNu = 0.3, kRho = 1000, kA = 0.05, kPeriod = 0.02;
const double kC = std::sqrt(kE / kRho);

/// The unit square or cube.
Box Unit(int dim) { return {{0, 0, 0}, {1, 1, dim == 3 ? 1.0 : 0}}; }
/// Displacement and acceleration in reference coordinates along axis d, whose phase is that of the first plus d pi; J:
/// determinant of F.
double Displacement(double X, double phase) { return kA * std::sin(2 * M_PI * X) * std::sin(phase); }
double Stretch(double X, double phase) { return 1 + 2 * M_PI * kA * std::cos(2 * M_PI * X) * std::sin(phase); }

double BodyForce(double X, double phase, double J, const Material &material)
{
  const double lambda = material.Elastic().lambda, mu = material.Elastic().mu, u = Displacement(X, phase),
               own = Stretch(X, phase);
  return M_PI * M_PI * u * (4 * mu / kRho - kC * kC - 4 * (lambda * (std::log(J) - 1) - mu) / (kRho * own * own));
}

/// Tiles of the undeformed body by the points' numbers; those of children are parts of their parent's.
class Reference
{
public:
  /// Takes the points as they are before the first step.
  PetscErrorCode Take(LevelsRun &run, const HierarchySettings &settings)
  {
    std::int64_t seeds = 0;
    PetscFunctionBeginUser;
    for (const LevelGeometry &level : settings.levels)
      seeds = Seeding(run.model, {{level.grid}, {}, settings.ratio}, 0, level.sides, seeds).EndId();
    ratio_ = settings.ratio;
    children_ = run.model.geometry.Dim() == 3 ? ratio_ * ratio_ * ratio_ : ratio_ * ratio_;
    numbers_ = PointNumbers(seeds, children_);
    PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) { tiles_[a.id[p]] = {a.Position(p), a.HalfSize(p)}; }));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Tile &At(std::int64_t id)
  {
    const auto found = tiles_.find(id);
    if (found != tiles_.end()) return found->second;
    if (numbers_.Parent(id) < 0) return tiles_[id] = Whole(id);
    Tile tile = At(numbers_.Parent(id));
    const int child = numbers_.ChildIndex(id), place[3] = {child % ratio_, child / ratio_ % ratio_, child / (ratio_ * ratio_)};
    for (int d = 0; d < 3; ++d) {
      tile.center[d] += ((2 * place[d] + 1.0) / ratio_ - 1) * tile.half_size[d];
      tile.half_size[d] /= ratio_;
    }
    return tiles_[id] = tile;
  }

private:
  /// A seed that was split before the first step and has been put together again.
  Tile Whole(std::int64_t id)
  {
    const Tile &first = At(numbers_.Child(id, 0)), &last = At(numbers_.Child(id, children_ - 1));
    return {0.5 * (first.center + last.center), static_cast<double>(ratio_) * first.half_size};
  }
  std::unordered_map<std::int64_t, Tile> tiles_;
  PointNumbers numbers_{1, 4};
  int ratio_ = 2, children_ = 4;
};

struct Case {
  const char *name;
  std::vector<Box> boxes;
  int ratio = 2;
  bool merge = false;
  int dim = 2;
};

const Case kOne = {"one level", {}}, kHalf = {"two, half", {{{0.5, 0}, {1, 1}}}},
           kInside = {"two, centred", {{{0.25, 0.25}, {0.75, 0.75}}}},
           kSmall = {"two, small box", {{{0.3125, 0.3125}, {0.625, 0.625}}}},
           kThree = {"three, centred", {{{0.125, 0.125}, {0.875, 0.875}}, {{0.375, 0.375}, {0.625, 0.625}}}},
           kSpace = {"space, one level", {}, 2, false, 3},
           kSpaceInside = {"space, two, centred", {{{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}}}, 2, false, 3};

struct Errors {
  double largest = 0, rms = 0; ///< over points (by mass), the worst of all steps, in lengths of the side
  double split = 0;
};

PetscErrorCode Solve(int n, const Case &levels, const Scheme &scheme, Errors *errors)
{
  LevelsRun run;
  Reference reference;
  PetscFunctionBeginUser;
  const int dim = levels.dim;
  if (dim == 3) run.model.geometry.kind = GeometryKind::kSpatial;
  run.model.sides.fill(BoundaryKind::kSymmetry);
  run.SetScheme(scheme);
  AddBody(run.model, CreateBoxRegion(Unit(dim)), "neo_hookean", {kE, kNu, kRho, NAN, NAN});
  const Material &material = *run.model.materials[0];
  run.model.acceleration = [&](double time, int count, const std::int64_t *id, const double *, double *a) {
    const double phase = kC * M_PI * time;
    for (int p = 0; p < count; ++p) {
      const Vec3 X = reference.At(id[p]).center;
      double J = 1;
      for (int d = 0; d < dim; ++d) J *= Stretch(X[d], phase + d * M_PI);
      for (int d = 0; d < dim; ++d) a[dim * p + d] = BodyForce(X[d], phase + d * M_PI, J, material);
    }
  };
  HierarchySettings settings = NestedLevels(run.model, Unit(dim), 1.0 / n, levels.ratio, levels.boxes);
  settings.merge_siblings = levels.merge;
  PetscCall(run.Create(settings));
  PetscCall(reference.Take(run, settings));
  const int steps = static_cast<int>(std::ceil(kPeriod * n * material.SpeedOfSound() * 1.2 / 0.4));
  run.dt = kPeriod / steps;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int l) {
    // The scheme's velocities belong to half steps of the level.
    const double phase = -0.5 * kC * M_PI * run.dt / std::pow(levels.ratio, l);
    for (int d = 0; d < dim; ++d)
      a.velocity[dim * p + d] = kA * kC * M_PI * std::sin(2 * M_PI * a.position[dim * p + d]) * std::cos(phase + d * M_PI);
  }));
  *errors = {};
  for (int step = 0; step < steps && !run.Failed(); ++step) {
    PetscCall(run.Advance());
    const double phase = kC * M_PI * run.time;
    double sum = 0, mass = 0;
    PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
      const Vec3 X = reference.At(a.id[p]).center;
      Vec3 error = a.Position(p) - X;
      for (int d = 0; d < dim; ++d) error[d] -= Displacement(X[d], phase + d * M_PI);
      errors->largest = Largest({errors->largest, Norm(error)});
      sum += a.mass[p] * Dot(error, error);
      mass += a.mass[p];
    }));
    errors->rms = Largest({errors->rms, std::sqrt(sum / mass)});
  }
  Budgets budgets;
  PetscCall(run.hierarchy.ReduceBudgets(&budgets));
  errors->split = budgets.points_split;
  if (run.Failed()) *errors = {NAN, NAN, 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TableRows(const Case &levels, const Scheme &scheme, int first_n, int last_n)
{
  Errors previous;
  PetscFunctionBeginUser;
  for (int n = first_n; n <= last_n; n *= 2) {
    Errors e;
    PetscCall(Solve(n, levels, scheme, &e));
    std::printf("| %s | %d | %s | %d | %.2e | %.2f | %.2e | %.2f | %.0f |\n", levels.name, levels.ratio, scheme.name, n,
                e.largest, n > first_n ? std::log2(previous.largest / e.largest) : NAN, e.rms,
                n > first_n ? std::log2(previous.rms / e.rms) : NAN, e.split);
    std::fflush(stdout);
    previous = e;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Up to n cells along each axis of the square, or for a negative n of the cube.
PetscErrorCode Table(int n)
{
  const std::vector<Case> plane = {kOne,
                                   kHalf,
                                   kInside,
                                   kThree,
                                   {"two, half", kHalf.boxes, 3},
                                   {"two, centred", kInside.boxes, 3},
                                   {"two, half", kHalf.boxes, 4},
                                   {"two, centred", kInside.boxes, 4},
                                   {"two, centred, merging", kInside.boxes, 2, true}};
  PetscFunctionBeginUser;
  std::printf("| levels | ratio | scheme | n | max error | order | rms error | order | points split |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  if (n < 0)
    for (const Case &levels : {kSpace, kSpaceInside}) PetscCall(TableRows(levels, kDefaultScheme, 8, -n));
  else
    for (const Case &levels : plane)
      for (const Scheme &scheme : {kUsl, kXpic10, kDefaultScheme}) PetscCall(TableRows(levels, scheme, 16, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestOrder(const Case &levels, const Scheme &scheme, int last)
{
  const std::string name =
      std::string("manufactured, ") + levels.name + ", " + scheme.name + ": order, n = 16.." + std::to_string(last) + ", of the ";
  const double doublings = std::log2(last / 16.0);
  Errors coarse, fine;
  PetscFunctionBeginUser;
  PetscCall(Solve(16, levels, scheme, &coarse));
  PetscCall(Solve(last, levels, scheme, &fine));
  ExpectAtLeast(name + "max error", std::log2(coarse.largest / fine.largest) / doublings, 1.6);
  ExpectAtLeast(name + "rms error", std::log2(coarse.rms / fine.rms) / doublings, 1.6);
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsManufactured, BorderAcross) { EXPECT_EQ(TestOrder(kHalf, kDefaultScheme, 64), PETSC_SUCCESS); }

TEST(LevelsManufactured, SmallBoxUsl) { EXPECT_EQ(TestOrder(kSmall, kUsl, 32), PETSC_SUCCESS); }

TEST(LevelsManufactured, SmallBoxXpic) { EXPECT_EQ(TestOrder(kSmall, kXpic10, 64), PETSC_SUCCESS); }

TEST(LevelsManufactured, ThreeLevels)
{
  const Case three = {"three, small boxes", {{{0.1875, 0.1875}, {0.8125, 0.8125}}, {{0.4375, 0.4375}, {0.5625, 0.5625}}}};
  EXPECT_EQ(TestOrder(three, kDefaultScheme, 32), PETSC_SUCCESS);
}

PetscErrorCode TestOrderInSpace(const Case &levels, int last)
{
  const std::string name = std::string("manufactured, ") + levels.name;
  Errors coarse, fine;
  PetscFunctionBeginUser;
  PetscCall(Solve(8, levels, kDefaultScheme, &coarse));
  PetscCall(Solve(last, levels, kDefaultScheme, &fine));
  ExpectAtLeast(name + ": order, n = 8.." + std::to_string(last) + ", of the rms error",
                std::log(coarse.rms / fine.rms) / std::log(last / 8.0), 1.8);
  ExpectTrue(name + ": points split where there are levels", (fine.split > 0) == !levels.boxes.empty());
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsManufactured, Space) { EXPECT_EQ(TestOrderInSpace(kSpace, 16), PETSC_SUCCESS); }

TEST(LevelsManufactured, SpaceOnLevels) { EXPECT_EQ(TestOrderInSpace(kSpaceInside, 12), PETSC_SUCCESS); }

} // namespace

int main(int argc, char **argv) { return RunProgram(argc, argv, Table); }
