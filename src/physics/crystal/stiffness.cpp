// Turning elastic constants, their eigenvalues, wave speeds and the indentation modulus.
#include "physics/crystal/stiffness.hpp"

#include "base/spectral.hpp"

#include <algorithm>

namespace mlgimp
{

namespace
{

/// Place in Voigt's order of a pair of axes.
int Pair(int i, int j) { return i == j ? i : 6 - i - j; }

/// C_ijkl a_j b_l.
Mat3 Acoustic(const Stiffness &C, const Vec3 &a, const Vec3 &b)
{
  double q[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < 3; ++l) q[i][k] += C.At(Pair(i, j), Pair(k, l)) * a[j] * b[l];
  return {q[0][0], q[0][1], q[0][2], q[1][0], q[1][1], q[1][2], q[2][0], q[2][1], q[2][2]};
}

Mat3 Product(const Mat3 &a, const Mat3 &b)
{
  return {
      a.xx * b.xx + a.xy * b.yx + a.xz * b.zx, a.xx * b.xy + a.xy * b.yy + a.xz * b.zy, a.xx * b.xz + a.xy * b.yz + a.xz * b.zz,
      a.yx * b.xx + a.yy * b.yx + a.yz * b.zx, a.yx * b.xy + a.yy * b.yy + a.yz * b.zy, a.yx * b.xz + a.yy * b.yz + a.yz * b.zz,
      a.zx * b.xx + a.zy * b.yx + a.zz * b.zx, a.zx * b.xy + a.zy * b.yy + a.zz * b.zy, a.zx * b.xz + a.zy * b.yz + a.zz * b.zz};
}

Sym3 Inverse(const Sym3 &a) { return (1 / Determinant(a)) * Adjugate(a); }
Mat3 Full(const Sym3 &a) { return {a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz}; }

/// The largest principal value, and its direction.
double Largest(const Spectrum &spectrum, Vec3 *direction)
{
  const Mat3 &d = spectrum.directions;
  const Vec3 columns[3] = {{d.xx, d.yx, d.zx}, {d.xy, d.yy, d.zy}, {d.xz, d.yz, d.zz}};
  const auto k = std::max_element(spectrum.value.begin(), spectrum.value.end()) - spectrum.value.begin();
  *direction = columns[k];
  return spectrum.value[k];
}

/// n L^-1 n for a direction t along the surface, with L = 1/(2 pi) times the integral over m, p across t of
/// (m m) - (m p) (p p)^-1 (p m).
double SurfaceCompliance(const Stiffness &C, const Vec3 &t, const Vec3 &normal)
{
  constexpr int kSteps = 120; // size: of half a turn, after which all repeats; periodic, so the sum converges fast
  const Vec3 across = Cross(normal, t);
  Sym3 L{};
  for (int k = 0; k < kSteps; ++k) {
    const double c = std::cos(k * M_PI / kSteps), s = std::sin(k * M_PI / kSteps);
    const Vec3 m = c * across + s * normal, p = c * normal - s * across;
    const Mat3 mp = Acoustic(C, m, p);
    const Mat3 part = Product(Product(mp, Full(Inverse(SymmetricPart(Acoustic(C, p, p))))), Transposed(mp));
    L = L + (1.0 / kSteps) * (SymmetricPart(Acoustic(C, m, m)) - SymmetricPart(part));
  }
  const Mat3 inverse = Full(Inverse(L));
  const Vec3 rows = {Dot({inverse.xx, inverse.xy, inverse.xz}, normal), Dot({inverse.yx, inverse.yy, inverse.yz}, normal),
                     Dot({inverse.zx, inverse.zy, inverse.zz}, normal)};
  return Dot(rows, normal);
}

} // namespace

Stiffness IsotropicStiffness(double lambda, double mu)
{
  Stiffness C;
  C.c.fill(0);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) C.At(i, j) = lambda + (i == j ? 2 * mu : 0);
    C.At(i + 3, i + 3) = mu;
  }
  return C;
}

Stiffness StiffnessOf(const std::vector<double> &v)
{
  Stiffness C;
  const std::size_t n = v.size();
  const auto block = [&](double c11, double c22, double c33, double c12, double c13, double c23) {
    C.c.fill(0);
    C.At(0, 0) = c11, C.At(1, 1) = c22, C.At(2, 2) = c33, C.At(0, 1) = c12, C.At(0, 2) = c13, C.At(1, 2) = c23;
  };
  const auto shears = [&](double c44, double c55, double c66) { C.At(3, 3) = c44, C.At(4, 4) = c55, C.At(5, 5) = c66; };
  if (n == 3) block(v[0], v[0], v[0], v[1], v[1], v[1]), shears(v[2], v[2], v[2]);
  if (n == 5 || n == 6) block(v[0], v[0], v[3], v[1], v[2], v[2]), shears(v[4], v[4], 0.5 * (v[0] - v[1]));
  if (n == 6) C.At(0, 3) = C.At(4, 5) = v[5], C.At(1, 3) = -v[5];
  if (n == 9) block(v[0], v[1], v[2], v[3], v[4], v[5]), shears(v[6], v[7], v[8]);
  if (n == C.c.size()) std::copy(v.begin(), v.end(), C.c.begin());
  return C;
}

Stiffness Turned(const Stiffness &old, const Mat3 &axes)
{
  constexpr double kZero = 1e-14; // rounding: of the largest constant
  const double r[3][3] = {{axes.xx, axes.xy, axes.xz}, {axes.yx, axes.yy, axes.yz}, {axes.zx, axes.zy, axes.zz}};
  Stiffness C;
  double largest = 0;
  for (int u = 0; u < 6; ++u)
    for (int v = u; v < 6; ++v) {
      const auto [i, j] = Stiffness::kAxes[u];
      const auto [k, l] = Stiffness::kAxes[v];
      double sum = 0;
      for (int n = 0; n < 81; ++n) {
        const int a = n / 27, b = n / 9 % 3, c = n / 3 % 3, d = n % 3;
        sum += r[i][a] * r[j][b] * r[k][c] * r[l][d] * old.At(Pair(a, b), Pair(c, d));
      }
      C.At(u, v) = sum;
      largest = std::max(largest, std::abs(sum));
    }
  for (double &c : C.c)
    if (std::abs(c) < kZero * largest) c = 0;
  return C;
}

bool IsSkew(const Stiffness &C, int axis)
{
  constexpr double kZero = 1e-6; // rounding: of the largest constant
  double largest = 0, odd = 0;
  for (int u = 0; u < 6; ++u)
    for (int v = 0; v < 6; ++v) {
      int turns = 0;
      for (const int place : {u, v})
        for (const int other : Stiffness::kAxes[place]) turns += other == axis;
      largest = std::max(largest, std::abs(C.At(u, v)));
      if (turns % 2) odd = std::max(odd, std::abs(C.At(u, v)));
    }
  return odd > kZero * largest;
}

double MeanBulk(const Stiffness &C)
{
  return (C.At(0, 0) + C.At(1, 1) + C.At(2, 2) + 2 * (C.At(0, 1) + C.At(0, 2) + C.At(1, 2))) / 9;
}

double MeanShear(const Stiffness &C)
{
  return (C.At(0, 0) + C.At(1, 1) + C.At(2, 2) - C.At(0, 1) - C.At(0, 2) - C.At(1, 2) +
          3 * (C.At(3, 3) + C.At(4, 4) + C.At(5, 5))) /
         15;
}

/// u and n have the same part in u_i n_j C_ijkl u_k n_l: with one of them fixed the other is a principal direction, and in turns
/// they climb to a maximum.
double FastestModulus(const Stiffness &C)
{
  constexpr int kRings = 8, kAround = 16, kTurns = 40; // size: of starts over half a sphere, and of turns from each
  double fastest = 0;
  for (int start = 0; start < kRings * kAround; ++start) {
    const int ring = start / kAround, around = start % kAround;
    const double z = (ring + 0.5) / kRings, angle = 2 * M_PI * around / kAround;
    Vec3 n = {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z};
    for (int turn = 0; turn < kTurns; ++turn)
      fastest = std::max(fastest, Largest(Decompose(SymmetricPart(Acoustic(C, n, n))), &n));
  }
  return fastest;
}

double IndentationModulus(const Crystal &crystal)
{
  constexpr int kDirections = 60; // size: of half a turn along the surface
  Vec3 normal{}, first{};
  normal[crystal.up] = first[(crystal.up + 1) % 3] = 1;
  const Vec3 second = Cross(normal, first);
  double sum = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = k * M_PI / kDirections;
    sum += SurfaceCompliance(crystal.stiffness, std::cos(angle) * first + std::sin(angle) * second, normal);
  }
  return 2 * kDirections / sum;
}

} // namespace mlgimp
