// What indenters that are the same all round their axis have in common.
#pragma once

#include "physics/indenter.hpp"

namespace mlgimp
{

/// The distance of a place from a profile, and the parts of its gradient.
struct ProfileGap {
  double distance, outward, up;
};

/// A place of a profile: its distance from the axis and its height above the tip, m.
struct ProfilePlace {
  double rho, height;
};

/// A surface of revolution, or one that is the same on both sides of the axis: functions of the distance rho from it, At(rho,
/// height), Radius(height) and Farthest(outward, up) for the parts of a direction.
template <class Shape> class Profile : public IndenterSurface
{
public:
  explicit Profile(GeometryKind geometry) : up_(UpAxis(geometry)) {}
  SurfaceGap Gap(Vec3 x) const final
  {
    Vec3 outward = x;
    outward[up_] = 0;
    const double rho = Norm(outward);
    const ProfileGap gap = AsShape().At(rho, x[up_]);
    Vec3 normal = rho > 0 ? (gap.outward / rho) * outward : Vec3{gap.outward, 0, 0};
    normal[up_] = gap.up;
    return {gap.distance, normal};
  }
  double Width(double height) const final { return 2 * AsShape().Radius(height); }
  bool MayBeMirrored(int) const final { return true; }
  Vec3 Farthest(Vec3 direction) const final
  {
    Vec3 outward = direction;
    outward[up_] = 0;
    const double size = Norm(outward);
    const ProfilePlace place = AsShape().FarthestAt(size, direction[up_]);
    Vec3 x = size > 0 ? (place.rho / size) * outward : Vec3{};
    x[up_] = place.height;
    return x;
  }

private:
  const Shape &AsShape() const { return *static_cast<const Shape *>(this); }
  int up_;
};

} // namespace mlgimp
