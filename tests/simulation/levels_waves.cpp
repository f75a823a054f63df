// A packet of three wavelengths that meets the border of a finer level: how much of it is thrown back.
//
// The reflected wave is measured where the packet came from, twice: its largest speed less that on one level with the same
// cells, and the largest difference from that level, point by point, behind which nothing can hide.
// Without arguments: pressure waves at normal incidence, in plane strain and along the axis of axisymmetry. With "table": also
// shear waves, 30 degrees, and other ratios.
#include "simulation/setup.hpp"
#include "unit/largest.hpp"

#include <cmath>
#include <map>

using namespace mlgimp;

namespace
{

constexpr double kStrain = 1e-4;

struct Wave {
  double length = 16; ///< coarse cells
  bool into = true;   ///< from the coarse into the fine level, or back
  int ratio = 2;
  bool shear = false;
  double angle = 0;  ///< of incidence, degrees
  bool axis = false; ///< along the axis of axisymmetry
};

/// Lengths in coarse cells. The border lies at x = 0, or in axisymmetry at z = 0; the packet's middle starts `distance` before
/// it.
struct Course {
  Box domain, window;    ///< what starts at the domain's sides does not reach the window in time
  double distance, path; ///< the wave's path until its reflection is measured
};

Course CourseOf(const Wave &wave)
{
  const double n = wave.length;
  const auto box = [n](double x0, double x1, double y) {
    return Box{{std::floor(n * x0), -std::ceil(n * y)}, {std::ceil(n * x1), std::ceil(n * y)}};
  };
  if (wave.shear) return {box(-3.3, 1.9, 4.8), box(-3, -0.2, 0.25), 1.6 * n, 3.2 * n};
  if (wave.angle > 0) return {box(-5.5, 3, 3.6), box(-2.3, -0.3, 0.4), 1.5 * n, 3 * n};
  if (wave.axis) return {{{0, -4 * n}, {2, 4 * n}}, {{0, -3.7 * n}, {2, -0.3 * n}}, 2 * n, 4 * n};
  return {{{-4 * n, -1}, {4 * n, 1}}, box(-3.7, -0.3, 1), 2 * n, 4 * n}; // a strip between rollers
}

/// sin(2 pi s) in a Hann window for s in [0, 3].
double Packet(double s) { return s > 0 && s < 3 ? 0.5 * std::sin(2 * M_PI * s) * (1 - std::cos(2 * M_PI * s / 3)) : 0; }

/// Velocities of points, relative to the packet's largest, by their places in quarters of a cell.
using Field = std::map<std::pair<long, long>, Vec3>;

/// Lets the packet travel on two levels, or on one with the cells of the side that it comes from.
PetscErrorCode Travel(const Wave &wave, bool two_levels, Field *field)
{
  const Course course = CourseOf(wave);
  const Box &domain = course.domain;
  const double own = wave.into ? 1 : 1.0 / wave.ratio; // cell where the packet starts
  LevelsRun run;
  PetscFunctionBeginUser;
  if (wave.axis) {
    run.model.geometry.kind = GeometryKind::kAxisymmetric;
    run.model.sides[kXLower] = run.model.sides[kXUpper] = BoundaryKind::kSymmetry;
  } else if (!wave.shear && wave.angle == 0)
    run.model.sides[kYLower] = run.model.sides[kYUpper] = BoundaryKind::kSymmetry;
  run.SetScheme(kDefaultScheme);
  // Without lateral contraction shear waves are quick against pressure waves, which come from the sides.
  AddBody(run.model, CreateBoxRegion(domain), "neo_hookean", {1e7, wave.shear ? 0 : 0.3, 1000, NAN, NAN});
  const Material &material = *run.model.materials[0];
  const double lambda = material.Elastic().lambda, mu = material.Elastic().mu;
  const double c = wave.shear ? std::sqrt(mu / material.Density()) : material.SpeedOfSound();
  Box fine = domain;
  (wave.into ? fine.lower : fine.upper)[wave.axis] = 0;
  PetscCall(run.Create(two_levels ? NestedLevels(run.model, domain, 1, wave.ratio, {fine}) : OneLevel(run.model, domain, own)));
  const int steps = static_cast<int>(std::ceil(course.path / c * material.SpeedOfSound() / 0.4)),
            parts = two_levels || wave.into ? 1 : wave.ratio;
  run.dt = course.path / c / steps / parts;

  const double angle = wave.axis ? M_PI / 2 : wave.angle * M_PI / 180;
  const Vec3 along = {std::cos(angle), std::sin(angle)}, motion = wave.shear ? Vec3{-along[1], along[0]} : along;
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int l) {
    const double s = (Dot(along, {a.position[2 * p], a.position[2 * p + 1]}) + course.distance) / wave.length + 1.5;
    const double half_step = 0.5 * c * run.dt / std::pow(wave.ratio, l) / wave.length; // velocities are that much older
    double G[4];                                                                       // displacement gradient
    for (int d = 0; d < 2; ++d) {
      a.velocity[2 * p + d] = kStrain * c * Packet(s + half_step) * motion[d];
      for (int k = 0; k < 2; ++k) G[2 * d + k] = -kStrain * Packet(s) * motion[d] * along[k];
    }
    const double pressure = lambda * (G[0] + G[3]),
                 stress[4] = {pressure + 2 * mu * G[0], pressure + 2 * mu * G[3], pressure, mu * (G[1] + G[2])};
    for (int k = 0; k < 4; ++k) a.F[4 * p + k] += G[k], a.stress[4 * p + k] = stress[k];
  }));
  for (int step = 0; step < steps * parts; ++step) PetscCall(run.Advance());
  field->clear();
  PetscCall(run.ForEachPoint([&](const PointArrays &a, int p, int) {
    const Vec3 x = {a.position[2 * p], a.position[2 * p + 1]};
    if (course.window.Contains(x))
      (*field)[{std::lround(4 * x[0] / own), std::lround(4 * x[1] / own)}] =
          1 / (kStrain * c * Packet(1.75)) * Vec3{a.velocity[2 * p], a.velocity[2 * p + 1]};
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Amplitudes relative to the packet's.
struct Reflection {
  double residual = 0;      ///< on one level
  double less_residual = 0; ///< on two, less the residual
  double difference = 0;    ///< of two and one
};

PetscErrorCode Reflect(const Wave &wave, Reflection *r)
{
  Field one, two;
  double both = 0;
  PetscFunctionBeginUser;
  PetscCall(Travel(wave, false, &one));
  PetscCall(Travel(wave, true, &two));
  *r = {};
  for (const auto &[place, v] : one) {
    const auto found = two.find(place);
    const Vec3 other = found == two.end() ? Vec3{NAN, NAN} : found->second;
    if (!(Norm(other) <= both)) both = Norm(other);
    if (!(Norm(other - v) <= r->difference)) r->difference = Norm(other - v);
    r->residual = Largest({r->residual, Norm(v)});
  }
  r->less_residual = both - r->residual;
  if (one.empty() || one.size() != two.size()) *r = {NAN, NAN, NAN};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TableRows(const char *name, Wave wave, const std::vector<double> &lengths)
{
  PetscFunctionBeginUser;
  for (bool into : {true, false}) {
    std::printf("| %s | %d | %s |", name, wave.ratio, into ? "into" : "out of");
    for (double length : lengths) {
      Reflection r;
      wave.length = length, wave.into = into;
      PetscCall(Reflect(wave, &r));
      std::printf(" %.0f: %.4f, %.4f, %.4f |", length, r.less_residual, r.difference, r.residual);
      std::fflush(stdout);
    }
    std::printf("\n");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Table(bool plane_only)
{
  PetscFunctionBeginUser;
  std::printf("| wave | ratio | fine level | wavelength in coarse cells: reflected less residual, difference, residual |\n| --- "
              "| --- | --- | --- |\n");
  for (int ratio : {2, 3, 4}) PetscCall(TableRows("pressure, 0 degrees", {16, true, ratio}, {8, 12, 16, 24, 32}));
  if (plane_only) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TableRows("shear, 0 degrees", {16, true, 2, true}, {8, 12, 16, 24}));
  PetscCall(TableRows("pressure, along the axis", {16, true, 2, false, 0, true}, {8, 16, 32}));
  PetscCall(TableRows("pressure, 30 degrees", {16, true, 2, false, 30}, {8, 12, 16, 24}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TestReflection(bool into, bool axis = false)
{
  const std::string name = std::string("pressure wave ") + (axis ? "along the axis " : "") + (into ? "into" : "out of") +
                           " the fine level: reflected, of the packet, ";
  Reflection longer, shorter;
  PetscFunctionBeginUser;
  PetscCall(Reflect({16, into, 2, false, 0, axis}, &shorter));
  PetscCall(Reflect({32, into, 2, false, 0, axis}, &longer));
  ExpectAtMost(name + "wavelength of 16 coarse cells", shorter.difference, 0.01);
  ExpectAtMost(name + "wavelength of 32 coarse cells", longer.difference, 0.003);
  ExpectTrue(name + "falls with refinement", longer.difference < 0.5 * shorter.difference);
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(LevelsWaves, IntoTheFineLevel) { EXPECT_EQ(TestReflection(true), PETSC_SUCCESS); }

TEST(LevelsWaves, OutOfTheFineLevel) { EXPECT_EQ(TestReflection(false), PETSC_SUCCESS); }

TEST(LevelsWaves, AlongTheAxis)
{
  for (bool into : {true, false}) EXPECT_EQ(TestReflection(into, true), PETSC_SUCCESS);
}

} // namespace

int main(int argc, char **argv)
{
  return RunProgram(argc, argv, [](int plane_only) { return Table(plane_only > 0); });
}
