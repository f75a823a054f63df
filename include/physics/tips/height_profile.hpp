// Indenters by the height of their surface over the distance from the axis: a table, tips of revolution and pyramids of it.
#pragma once

#include "physics/indenter.hpp"

#include <functional>
#include <vector>

namespace mlgimp
{

/// A height and its slope.
struct HeightAndSlope {
  double height, slope;
};

/// The height z(s) of a surface that rises from z(0) = 0, by cubic pieces through values and slopes. The pieces are shorter near
/// the tip, where it bends most; beyond them the height goes on in a straight line.
class HeightProfile
{
public:
  /// Takes curve(s) up to the distance `reach`, m; the height must not fall.
  HeightProfile(double reach, const std::function<HeightAndSlope(double)> &curve);
  HeightAndSlope At(double s) const;
  /// The largest s below a height, m.
  double Reach(double height) const;
  /// The s of the place that is farthest in a direction with the parts `outward` and `up`; infinite where that rises without end.
  double Farthest(double outward, double up) const;

private:
  double Place(std::size_t k) const { return reach_ * (k * k) / (kPieces * kPieces); }

  static constexpr double kPieces = 4096; // size
  double reach_;
  std::vector<HeightAndSlope> nodes_;
};

/// Heights at distances from the axis, from 0,0 on, both increasing, m; between them the monotone cubic of Fritsch and Carlson,
/// SIAM J. Numer. Anal. 17 (1980) 238.
HeightProfile ProfileThrough(const std::vector<double> &distances, const std::vector<double> &heights);

/// A tip of revolution, in plane strain one that is the same on both sides.
std::unique_ptr<IndenterSurface> CreateProfileTip(GeometryKind geometry, HeightProfile profile, HeightRange known);
/// A regular pyramid of space whose faces are at the distance s from the axis where the profile has their height, the normal of
/// the first at the angle `turn` from x, degrees.
std::unique_ptr<IndenterSurface> CreateProfilePyramid(HeightProfile profile, int faces, double turn, HeightRange known);

} // namespace mlgimp
