// The table of point fields: it drives registration, sorting, exchange and restart.
#pragma once

#include "base/tensor.hpp"
#include "physics/geometry.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace mlgimp
{

/// Places in the table below.
enum PointField : int {
  kId,
  kPosition,
  kVelocity,
  kDeformation,
  kStress,
  kShortWaveStress,
  kMass,
  kHalfSize,
  kInitialRadius,
  kInitialPosition,
  kBody,
  kFaces,
  kLoadShare,
  kHistory,
  kPointFields
};

enum class FieldType { kReal, kInt32, kInt64 };

/// What the parent of merged siblings gets: what the first of them has, their mean by mass, their sum, the largest, or all
/// bits. Fields that follow from others are set by MergeSiblings itself.
enum class MergeRule { kFirst, kMean, kSum, kLargest, kBits };

struct PointFieldInfo {
  const char *name;
  FieldType type;
  int components;
  const char *unit;
  MergeRule merge;
  bool evolves;   ///< changes in a step: copies of points are renewed with it
  bool in_frames; ///< written with the frames
};

/// What a point carries, each field [count][components]. A child of a split point has what its parent has where
/// MakeChild (hierarchy/transfer/splitting.cpp) says nothing else.
inline std::array<PointFieldInfo, kPointFields> PointFieldTable(GeometryKind geometry, int loads, int history_components)
{
  const auto [dim, gradient, stress, rate, hoop] = WithGeometry(geometry, [](auto policy) {
    using G = decltype(policy);
    return std::array<int, 5>{G::kDim, G::kGradient, G::kStress, G::kRate, G::kHoop};
  });
  constexpr FieldType kReal = FieldType::kReal, kInt32 = FieldType::kInt32;
  return {{
      {"id", FieldType::kInt64, 1, "", MergeRule::kFirst, false, true},
      {"position", kReal, dim, "m", MergeRule::kMean, true, true},
      {"velocity", kReal, dim, "m/s", MergeRule::kMean, true, true},
      {"deformation_gradient", kReal, gradient, "", MergeRule::kMean, true, true}, // by rows
      {"stress", kReal, stress, "Pa", MergeRule::kMean, true, true},               // Cauchy: xx, yy, zz, xy, in space yz, xz
      {"short_wave_stress", kReal, rate, "Pa", MergeRule::kMean, true, false},     // acts with the stress, is no material stress
      {"mass", kReal, 1, "kg", MergeRule::kSum, false, true},
      {"initial_half_size", kReal, dim, "m", MergeRule::kFirst, false, false},
      {"initial_radius", kReal, hoop, "m", MergeRule::kFirst, false, false}, // of the centre, in axisymmetry; F_zz = r/R
      {"initial_position", kReal, dim, "m", MergeRule::kMean, false, false}, // for pictures: no equation knows it
      {"body", kInt32, 1, "", MergeRule::kFirst, false, true},
      {"faces", kInt32, 1, "", MergeRule::kBits, false, true}, // bits: see below
      {"load_share", kReal, loads, "", MergeRule::kLargest, false,
       false}, // area that each load acts on over that of the point's face
      {"history", kReal, history_components, "", MergeRule::kMean, true, false},
  }};
}

inline std::size_t FieldBytes(const PointFieldInfo &field)
{
  return static_cast<std::size_t>(field.components) * (field.type == FieldType::kInt32 ? 4 : 8);
}

/// Sides of a point, of a body and of the domain, in this order everywhere.
enum Side : int { kXLower, kXUpper, kYLower, kYUpper, kZLower, kZUpper, kSides };

/// As options name them.
inline constexpr const char *kSideNames[kSides] = {"x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"};

/// All, and those in so many dimensions, which are the first ones.
inline constexpr std::array<Side, kSides> kAllSides = {kXLower, kXUpper, kYLower, kYUpper, kZLower, kZUpper};
struct SidesOf {
  int dim;
  const Side *begin() const { return kAllSides.data(); }
  const Side *end() const { return kAllSides.data() + 2 * dim; }
};
/// The lower and the upper one across an axis.
inline std::array<Side, 2> SidesAcross(int axis) { return {kAllSides[2 * axis], kAllSides[2 * axis + 1]}; }

inline int AxisOf(Side side) { return side / 2; }
inline int SignOf(Side side) { return side % 2 ? 1 : -1; }
/// The k-th axis along a side, in their order.
inline int TangentAxis(Side side, int k) { return k < AxisOf(side) ? k : k + 1; }

/// Bits of the field `faces`: the outer sides of the body that the point has.
inline int OuterFaceBit(Side side) { return 1 << side; }

/// The fields of a rank's points as plain arrays [count][components]. Null: history where no material has any, load_share
/// where there is no load, initial_radius where there is no hoop direction.
struct PointArrays {
  int count;
  int dim, stress_components, rate_components, loads, history_components; ///< F has dim x dim
  std::int64_t *id;
  double *position, *velocity, *F, *stress, *short_wave_stress, *mass, *half_size, *initial_radius, *initial_position;
  int *body, *faces;
  double *load_share, *history;

  /// Place of a point's first number in a field of so many components.
  static std::ptrdiff_t At(int p, int components) { return static_cast<std::ptrdiff_t>(p) * components; }
  Vec3 Position(int p) const { return Load(position, p); }
  Vec3 Velocity(int p) const { return Load(velocity, p); }
  Vec3 HalfSize(int p) const { return Load(half_size, p); }
  /// F_zz of two dimensions: r/R in axisymmetry, else one.
  double HoopStretch(int p) const { return initial_radius ? position[At(p, dim)] / initial_radius[p] : 1; }
  /// J = det F, in two dimensions with F_zz.
  double VolumeRatio(int p) const { return Determinant(F + At(p, dim * dim), dim) * HoopStretch(p); }
  /// F a, for a vector of the undeformed point.
  Vec3 Deform(int p, Vec3 a) const
  {
    const double *const f = F + At(p, dim * dim);
    Vec3 deformed{};
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j) deformed[i] += f[dim * i + j] * a[j];
    return deformed;
  }
  /// Half an edge of its deformed box, along an axis of the undeformed one, m.
  Vec3 HalfEdge(int p, int axis) const
  {
    const double *const f = F + At(p, dim * dim), half = half_size[At(p, dim) + axis];
    return {half * f[axis], half * f[dim + axis], dim == 3 ? half * f[6 + axis] : 0};
  }

private:
  Vec3 Load(const double *field, int p) const
  {
    const double *const first = field + At(p, dim);
    return {first[0], first[1], dim == 3 ? first[2] : 0};
  }
};

/// Calls visit(field, array, components) for every array, which may be set.
template <class Visit> void ForEachArray(PointArrays &a, Visit visit)
{
  visit(kId, a.id, 1);
  visit(kPosition, a.position, a.dim);
  visit(kVelocity, a.velocity, a.dim);
  visit(kDeformation, a.F, a.dim * a.dim);
  visit(kStress, a.stress, a.stress_components);
  visit(kShortWaveStress, a.short_wave_stress, a.rate_components);
  visit(kMass, a.mass, 1);
  visit(kHalfSize, a.half_size, a.dim);
  visit(kInitialRadius, a.initial_radius, 1);
  visit(kInitialPosition, a.initial_position, a.dim);
  visit(kBody, a.body, 1);
  visit(kFaces, a.faces, 1);
  visit(kLoadShare, a.load_share, a.loads);
  visit(kHistory, a.history, a.history_components);
}

/// Points start to end as arrays of their own.
inline PointArrays Slice(PointArrays points, int start, int end)
{
  points.count = end - start;
  ForEachArray(points, [start](PointField, auto *&array, int components) {
    if (array) array += PointArrays::At(start, components);
  });
  return points;
}

/// Half size of a point's box along an axis in the current configuration, m: the root of sum_b (F_ab l0_b)^2.
inline double CurrentHalfSize(const PointArrays &points, int p, int axis)
{
  const int dim = points.dim;
  const double *const F = points.F + PointArrays::At(p, dim * dim) + dim * axis, *const l0 =
                                                                                     points.half_size + PointArrays::At(p, dim);
  double square = 0;
  for (int b = 0; b < dim; ++b) square += F[b] * l0[b] * F[b] * l0[b];
  return std::sqrt(square);
}

} // namespace mlgimp
