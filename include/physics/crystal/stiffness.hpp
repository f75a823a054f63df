// Elastic constants without isotropy: how they turn, and what follows from them.
#pragma once

#include "base/tensor.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace mlgimp
{

/// A symmetric 6 x 6 matrix by the rows of its upper triangle, Pa: stresses from strains with doubled shears, both in Voigt's
/// order 11, 22, 33, 23, 13, 12.
struct Stiffness {
  static constexpr int kAxes[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}; // exact

  static int PlaceOf(int i, int j) { return i <= j ? i * (11 - i) / 2 + j : PlaceOf(j, i); }
  double At(int i, int j) const { return c[PlaceOf(i, j)]; }
  double &At(int i, int j) { return c[PlaceOf(i, j)]; }
  bool Given() const { return !std::isnan(c[0]); }

  /// C : e.
  [[gnu::always_inline]] Sym3 operator*(const Sym3 &e) const
  {
    const double yz = 2 * e.yz, xz = 2 * e.xz, xy = 2 * e.xy;
    return {c[0] * e.xx + c[1] * e.yy + c[2] * e.zz + c[3] * yz + c[4] * xz + c[5] * xy,
            c[1] * e.xx + c[6] * e.yy + c[7] * e.zz + c[8] * yz + c[9] * xz + c[10] * xy,
            c[2] * e.xx + c[7] * e.yy + c[11] * e.zz + c[12] * yz + c[13] * xz + c[14] * xy,
            c[5] * e.xx + c[10] * e.yy + c[14] * e.zz + c[17] * yz + c[19] * xz + c[20] * xy,
            c[3] * e.xx + c[8] * e.yy + c[12] * e.zz + c[15] * yz + c[16] * xz + c[17] * xy,
            c[4] * e.xx + c[9] * e.yy + c[13] * e.zz + c[16] * yz + c[18] * xz + c[19] * xy};
  }

  std::array<double, 21> c = {NAN};
};

/// A crystal in the axes of the run.
struct Crystal {
  Stiffness stiffness;
  int up = 2; ///< axis across the surface
};

Stiffness IsotropicStiffness(double lambda, double mu);

/// From the constants of a class, by their number: C11, C12, C44 (cubic); C11, C12, C13, C33, C44 (hexagonal); these and C14
/// (trigonal); C11, C22, C33, C12, C13, C23, C44, C55, C66 (orthotropic); the 21 of the upper triangle. Not given for another
/// one.
Stiffness StiffnessOf(const std::vector<double> &constants);

/// In other axes, whose rows in the old ones `axes` has, a rotation. What symmetry makes zero is.
Stiffness Turned(const Stiffness &stiffness, const Mat3 &axes);

/// Whether it is another one in the mirror across an axis.
bool IsSkew(const Stiffness &stiffness, int axis);

/// Bulk and shear modulus of the mean of the stiffness over all orientations (Voigt), Pa.
double MeanBulk(const Stiffness &stiffness);
double MeanShear(const Stiffness &stiffness);

/// rho c^2 of the fastest plane wave, Pa: the largest u_i n_j C_ijkl u_k n_l of unit vectors.
double FastestModulus(const Stiffness &stiffness);

/// By which a half space yields to a round rigid tip, Pa: 2 over the mean of n L^-1 n over the directions along the surface, with
/// the tensor L of Barnett and Lothe; E/(1 - nu^2) of isotropic ones.
double IndentationModulus(const Crystal &crystal);

} // namespace mlgimp
