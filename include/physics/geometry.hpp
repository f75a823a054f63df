// The three geometries: what a point of each stores of its tensors, and how it lies in space.
//
// Indices and vectors have three components everywhere; two dimensions are one layer. The kernels are templates on one of
// the policies below; all other code has the kind, the dimension and the thickness at run time.
#pragma once

#include "base/tensor.hpp"

namespace mlgimp
{

/// As -geometry names them: plane_strain, axisymmetric, 3d.
enum class GeometryKind { kPlaneStrain, kAxisymmetric, kSpatial };

/// The names.
inline constexpr const char *kGeometryNames[] = {"plane_strain", "axisymmetric", "3d"};

/// The last axis, along which the indenter comes down.
inline int UpAxis(GeometryKind kind) { return kind == GeometryKind::kSpatial ? 2 : 1; }

/// Components that a point stores: F by rows; stress as xx, yy, zz, xy and in space yz, xz; the strain rate and the
/// short-wave stress of which the kernels keep what is not zero, in the order of the stress: kRateAxes are the axes of each
/// component.
struct PlaneStrain {
  static constexpr GeometryKind kKind = GeometryKind::kPlaneStrain;
  static constexpr int kDim = 2, kGradient = 4, kStress = 4, kRate = 3; ///< size; rate: xx, yy, xy
  static constexpr bool kHoop = false;
  static constexpr int kRateAxes[kRate][2] = {{0, 0}, {1, 1}, {0, 1}};
};

/// x is the radius, y the axis; zz is the hoop direction, with F_zz = r/R.
struct Axisymmetric {
  static constexpr GeometryKind kKind = GeometryKind::kAxisymmetric;
  static constexpr int kDim = 2, kGradient = 4, kStress = 4, kRate = 4; ///< size; rate: xx, yy, zz, xy
  static constexpr bool kHoop = true;
  static constexpr int kRateAxes[kRate][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}};
};

struct Spatial {
  static constexpr GeometryKind kKind = GeometryKind::kSpatial;
  static constexpr int kDim = 3, kGradient = 9, kStress = 6, kRate = 6; ///< size; rate: as the stress
  static constexpr bool kHoop = false;
  static constexpr int kRateAxes[kRate][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
};

/// The same at run time.
struct Geometry {
  GeometryKind kind = GeometryKind::kPlaneStrain;
  double thickness = 1; ///< of the slab in plane strain, m

  int Dim() const { return kind == GeometryKind::kSpatial ? 3 : 2; }
  bool HasHoop() const { return kind == GeometryKind::kAxisymmetric; }
  /// What a length or an area of the plane is multiplied by to be an area or a volume: thickness, 2 pi r, or 1.
  double OutOfPlane(double r) const
  {
    constexpr double kTwoPi = 6.283185307179586; // exact
    return kind == GeometryKind::kPlaneStrain ? thickness : kind == GeometryKind::kAxisymmetric ? kTwoPi * r : 1;
  }
};

/// Calls work(policy) with the policy of a kind.
template <class Work> auto WithGeometry(GeometryKind kind, Work work)
{
  if (kind == GeometryKind::kAxisymmetric) return work(Axisymmetric{});
  if (kind == GeometryKind::kSpatial) return work(Spatial{});
  return work(PlaneStrain{});
}

/// The tensor that a point stores as `a` [kGradient], its components so many doubles apart; zz where the geometry does not
/// store it.
template <class Geometry, int stride = 1> inline Mat3 LoadGradient(const double *a, double zz)
{
  constexpr int s = stride;
  if constexpr (Geometry::kDim == 3)
    return {a[0], a[s], a[2 * s], a[3 * s], a[4 * s], a[5 * s], a[6 * s], a[7 * s], a[8 * s]};
  else
    return {a[0], a[s], 0, a[2 * s], a[3 * s], 0, 0, 0, zz};
}

/// The symmetric tensor that a point stores as `a` [kStress].
template <class Geometry> inline Sym3 LoadStress(const double *a)
{
  if constexpr (Geometry::kDim == 3)
    return {a[0], a[1], a[2], a[3], a[4], a[5]};
  else
    return {a[0], a[1], a[2], a[3], 0, 0};
}
template <class Geometry> inline void StoreStress(const Sym3 &s, double *a)
{
  a[0] = s.xx, a[1] = s.yy, a[2] = s.zz, a[3] = s.xy;
  if constexpr (Geometry::kDim == 3) a[4] = s.yz, a[5] = s.xz;
}

} // namespace mlgimp
