// Options of the law anisotropic: constants, and how the crystal lies.
#include "program/input/read_case.hpp"

#include <algorithm>
#include <cmath>
#include <petscksp.h>

namespace mlgimp
{

namespace
{

using Numbers = std::vector<double>;

Vec3 VectorOf(const Numbers &v) { return {v[0], v[1], v[2]}; }
Mat3 Rows(const Vec3 &x, const Vec3 &y, const Vec3 &z) { return {x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]}; }

/// The axes of the run by the directions of the crystal along x and up: z = x cross y, also where y is up.
Mat3 AxesOf(GeometryKind kind, const Vec3 &x, const Vec3 &up)
{
  return UpAxis(kind) == 2 ? Rows(x, Cross(up, x), up) : Rows(x, up, Cross(x, up));
}

/// Bunge's angles in degrees turn the axes along x, across and up into those of the crystal, about its third, first and third
/// one.
Mat3 AxesOf(GeometryKind kind, const Numbers &angles)
{
  constexpr double kDegree = M_PI / 180; // exact
  const double c1 = std::cos(kDegree * angles[0]), s1 = std::sin(kDegree * angles[0]);
  const double c = std::cos(kDegree * angles[1]), s = std::sin(kDegree * angles[1]);
  const double c2 = std::cos(kDegree * angles[2]), s2 = std::sin(kDegree * angles[2]);
  return AxesOf(kind, {c1 * c2 - s1 * s2 * c, -c1 * s2 - s1 * c2 * c, s1 * s}, {s2 * s, c2 * s, c});
}

/// By the lattice plane that lies up and the direction along x.
Mat3 AxesOf(const OptionReader &reader, const std::string &prefix, GeometryKind kind, const Numbers &surface,
            const Numbers &along)
{
  constexpr double kRight = 1e-6; // rounding: cosine of the angle between the two
  const Vec3 up = VectorOf(surface), x = VectorOf(along);
  const std::string text = FormatVector(x, 3);
  if (Norm(up) == 0) reader.Refuse(prefix + "surface", FormatVector(up, 3), "a plane; all indices are 0");
  if (Norm(x) == 0) reader.Refuse(prefix + "along", text, "a direction; all indices are 0");
  const double cosine = Dot(up, x) / (Norm(up) * Norm(x));
  if (std::abs(cosine) > kRight)
    reader.Refuse(prefix + "along", text, "in the plane of {}surface {}: at 90 degrees to its normal; the angle is {}", prefix,
                  FormatVector(up, 3), std::acos(cosine) * 180 / M_PI);
  const Vec3 n = (1 / Norm(up)) * up;
  return AxesOf(kind, (1 / Norm(x - Dot(x, n) * n)) * (x - Dot(x, n) * n), n);
}

/// What of a stiffness should be zero in a geometry: by its name, in Voigt's order.
struct Breach {
  const char *name;
  double value;
};

/// In plane strain strains in the plane must bring no shear stress out of it; in axisymmetry all directions about the axis y must
/// be alike. The largest breach.
Breach LargestBreach(const Stiffness &C, GeometryKind kind)
{
  std::vector<Breach> all;
  constexpr const char *kNames[21] = {"C11", "C12", "C13", "C14", "C15", "C16", "C22", "C23", "C24", "C25", "C26",
                                      "C33", "C34", "C35", "C36", "C44", "C45", "C46", "C55", "C56", "C66"};
  const auto zero = [&](int i, int j) { all.push_back({kNames[Stiffness::PlaceOf(i, j)], C.At(i, j)}); };
  if (kind != GeometryKind::kSpatial)
    for (const int i : {0, 1, 5}) zero(i, 3), zero(i, 4);
  if (kind == GeometryKind::kAxisymmetric) {
    for (const int i : {0, 1, 2}) zero(i, 5);
    zero(2, 3), zero(2, 4), zero(3, 4);
    all.push_back({"C11 - C33", C.At(0, 0) - C.At(2, 2)});
    all.push_back({"C12 - C23", C.At(0, 1) - C.At(1, 2)});
    all.push_back({"C44 - C66", C.At(3, 3) - C.At(5, 5)});
    all.push_back({"C11 - C13 - 2 C55", C.At(0, 0) - C.At(0, 2) - 2 * C.At(4, 4)});
  }
  Breach largest = {"", 0};
  for (const Breach &one : all)
    if (std::abs(one.value) > std::abs(largest.value)) largest = one;
  return largest;
}

/// Refuses a crystal that the geometry cannot have.
void CheckSymmetry(const OptionReader &reader, const std::string &option, const std::string &value, GeometryKind kind,
                   const Stiffness &C)
{
  constexpr double kZero = 1e-6; // rounding: of the largest constant
  const double largest = *std::max_element(C.c.begin(), C.c.end());
  const Breach breach = LargestBreach(C, kind);
  if (std::abs(breach.value) <= kZero * largest) return;
  if (kind == GeometryKind::kPlaneStrain)
    reader.Refuse(option, value,
                  "such that the plane of x and y is a mirror of the crystal (or -geometry 3d): there {} is {} Pa, so "
                  "that strains in the plane shear it out of the plane",
                  breach.name, breach.value);
  reader.Refuse(
      option, value,
      "such that all directions about y, the axis, are alike, as about the c axis of a hexagonal crystal: in the axes of "
      "the run {} is {} Pa; cubic crystals need -geometry 3d, or a stand-in without directions by its Young's modulus, "
      "as the presets silicon_isotropic and gold",
      breach.name, breach.value);
}

Stiffness ReadConstants(OptionReader &reader, const std::string &prefix)
{
  constexpr double kSoftestCrystal = 1e6; // Pa; crystals have 1e9 and more
  const std::string name = prefix + "elastic_constants";
  Numbers constants;
  reader.Read(
      {name,
       "C11,C12,C44 (cubic), C11,C12,C13,C33,C44 (hexagonal), these and C14 (trigonal), C11,C22,C33,C12,C13,C23,C44,C55,C66 "
       "(orthotropic), or the 21 of the upper triangle by rows, in the order 11,22,33,23,13,12 (anisotropic)",
       "Pa"},
      &constants, kRequired);
  if (reader.Help()) return {};
  const Stiffness C = StiffnessOf(constants);
  const std::string count = Format("{} values", constants.size());
  if (!C.Given()) reader.Refuse(name, count, "3 (cubic), 5 (hexagonal), 6 (trigonal), 9 (orthotropic) or 21 constants");
  const double least = LeastEigenvalue(C), most = *std::max_element(C.c.begin(), C.c.end());
  if (!(least > 1e-9 * most)) // rounding
    reader.Refuse(name, count, "positive definite, as else some strain would set energy free; the smallest eigenvalue is {} Pa",
                  least);
  if (most < kSoftestCrystal) reader.WarnLater("{} up to {}: no crystal is as soft; are they in Pa?", name, FormatNumber(most));
  return C;
}

} // namespace

/// Of the matrix in Mandel's form, by PETSc's solver of small dense matrices.
static PetscErrorCode FindLeastEigenvalue(const Stiffness &C, double *least)
{
  constexpr PetscInt kRows = 6; // size
  PetscReal values[kRows], imaginary[kRows];
  Mat mandel;
  KSP solver;
  PC none;
  PetscFunctionBeginUser;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, kRows, kRows, nullptr, &mandel));
  for (PetscInt i = 0; i < kRows; ++i)
    for (PetscInt j = 0; j < kRows; ++j)
      PetscCall(MatSetValue(mandel, i, j, C.At(i, j) * (i < 3 ? 1 : M_SQRT2) * (j < 3 ? 1 : M_SQRT2), INSERT_VALUES));
  PetscCall(MatAssemblyBegin(mandel, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(mandel, MAT_FINAL_ASSEMBLY));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &solver));
  PetscCall(KSPSetOperators(solver, mandel, mandel));
  PetscCall(KSPGetPC(solver, &none));
  PetscCall(PCSetType(none, PCNONE));
  PetscCall(KSPSetUp(solver));
  PetscCall(KSPComputeEigenvaluesExplicitly(solver, kRows, values, imaginary));
  *least = *std::min_element(values, values + kRows);
  PetscCall(KSPDestroy(&solver));
  PetscCall(MatDestroy(&mandel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double LeastEigenvalue(const Stiffness &C)
{
  double least;
  ExitOnError(FindLeastEigenvalue(C, &least));
  return least;
}

void ReadCrystal(OptionReader &reader, const std::string &prefix, GeometryKind kind, MaterialConstants *c)
{
  const std::string surface_name = prefix + "surface", along_name = prefix + "along", angles_name = prefix + "euler_angles";
  const Stiffness C = ReadConstants(reader, prefix);
  Numbers surface = {0, 0, 1}, along = {1, 0, 0}, angles;
  const bool by_surface = reader.Read(
      {surface_name, "Miller indices of the lattice plane that lies up (anisotropic)", "", kAnyNumber, 3, 3}, &surface);
  const bool by_along =
      reader.Read({along_name, "lattice direction along x, in that plane (anisotropic)", "", kAnyNumber, 3, 3}, &along);
  const bool by_angles = reader.Read(
      {angles_name, "Bunge's phi1,Phi,phi2 in place of these two (anisotropic)", "degrees", kAnyNumber, 3, 3}, &angles);
  if (reader.Help()) return;
  if (by_angles && (by_surface || by_along))
    reader.Refuse(angles_name, FormatVector(VectorOf(angles), 3), "left out with {}", by_surface ? surface_name : along_name);
  const Mat3 axes = by_angles ? AxesOf(kind, angles) : AxesOf(reader, prefix, kind, surface, along);
  c->crystal = {Turned(C, axes), UpAxis(kind)};
  CheckSymmetry(reader, by_angles ? angles_name : surface_name, FormatVector(VectorOf(by_angles ? angles : surface), 3), kind,
                c->crystal.stiffness);
  const double bulk = MeanBulk(C), shear = MeanShear(C);
  c->youngs_modulus = 9 * bulk * shear / (3 * bulk + shear);
  c->poissons_ratio = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
}

} // namespace mlgimp
