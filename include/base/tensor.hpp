// Small vectors and 2 x 2 tensors for the code outside the inner loops.
#pragma once

#include <array>
#include <cmath>

namespace mlgimp
{

using Vec2 = std::array<double, 2>;

inline Vec2 operator+(Vec2 a, Vec2 b) { return {a[0] + b[0], a[1] + b[1]}; }
inline Vec2 operator-(Vec2 a, Vec2 b) { return {a[0] - b[0], a[1] - b[1]}; }
inline Vec2 operator*(double s, Vec2 a) { return {s * a[0], s * a[1]}; }
inline double Dot(Vec2 a, Vec2 b) { return a[0] * b[0] + a[1] * b[1]; }
inline double Norm(Vec2 a) { return std::hypot(a[0], a[1]); }

/// The vector turned by -90 degrees: from a tangent with the body on its left to the outward normal.
inline Vec2 TurnRight(Vec2 a) { return {a[1], -a[0]}; }

/// F a, for F stored as xx, xy, yx, yy.
inline Vec2 Multiply(const double F[4], Vec2 a) { return {F[0] * a[0] + F[1] * a[1], F[2] * a[0] + F[3] * a[1]}; }

} // namespace mlgimp
