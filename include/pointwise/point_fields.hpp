// The table of point fields: it drives registration, sorting, exchange and restart.
#pragma once

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
  kBody,
  kFaces,
  kLoadShare,
  kHistory,
  kPointFields
};

enum class FieldType { kReal, kInt32, kInt64 };

struct PointFieldInfo {
  const char *name;
  FieldType type;
  int components;
  const char *unit;
};

/// What a point carries. The number of internal variables depends on the materials, that of shares on the loads.
inline std::array<PointFieldInfo, kPointFields> PointFieldTable(int loads, int history_components)
{
  return {{
      {"id", FieldType::kInt64, 1, ""},
      {"position", FieldType::kReal, 2, "m"},
      {"velocity", FieldType::kReal, 2, "m/s"},
      {"deformation_gradient", FieldType::kReal, 4, ""}, // xx, xy, yx, yy
      {"stress", FieldType::kReal, 4, "Pa"},             // Cauchy: xx, yy, zz, xy
      {"short_wave_stress", FieldType::kReal, 3, "Pa"},  // xx, yy, xy: acts with the stress, is no material stress
      {"mass", FieldType::kReal, 1, "kg"},
      {"initial_half_size", FieldType::kReal, 2, "m"},
      {"body", FieldType::kInt32, 1, ""},
      {"faces", FieldType::kInt32, 1, ""},         // bits: see below
      {"load_share", FieldType::kReal, loads, ""}, // part of the point's face that each load acts on
      {"history", FieldType::kReal, history_components, ""},
  }};
}

inline std::size_t FieldBytes(const PointFieldInfo &field)
{
  return static_cast<std::size_t>(field.components) * (field.type == FieldType::kInt32 ? 4 : 8);
}

/// Sides of a point, of a body and of the domain, in this order everywhere.
enum Side : int { kXLower, kXUpper, kYLower, kYUpper, kSides };

/// As options name them.
inline constexpr const char *kSideNames[kSides] = {"x_lower", "x_upper", "y_lower", "y_upper"};

inline int AxisOf(Side side) { return side / 2; }
inline int SignOf(Side side) { return side % 2 ? 1 : -1; }

/// Bits of the field `faces`: the outer sides of the body that the point has.
inline int OuterFaceBit(Side side) { return 1 << side; }

/// The fields of a rank's points as plain arrays [count][components]; history is null where no material has any, and
/// load_share where there is no load.
struct PointArrays {
  int count;
  std::int64_t *id;
  double *position, *velocity, *F, *stress, *short_wave_stress, *mass, *half_size;
  int *body, *faces;
  double *load_share, *history;
  int loads, history_components;
};

/// Points start to end as arrays of their own.
inline PointArrays Slice(PointArrays points, int start, int end)
{
  const std::ptrdiff_t first = start;
  points.count = end - start;
  points.id += first;
  points.position += 2 * first;
  points.velocity += 2 * first;
  points.F += 4 * first;
  points.stress += 4 * first;
  points.short_wave_stress += 3 * first;
  points.mass += first;
  points.half_size += 2 * first;
  points.body += first;
  points.faces += first;
  if (points.load_share) points.load_share += points.loads * first;
  if (points.history) points.history += points.history_components * first;
  return points;
}

/// Half size of a point's rectangle along an axis in the current configuration, m: the root of sum_b (F_ab l0_b)^2.
inline double CurrentHalfSize(const PointArrays &points, int p, int axis)
{
  const double *F = points.F + 4 * p + 2 * axis, *l0 = points.half_size + 2 * p;
  return std::sqrt(F[0] * l0[0] * F[0] * l0[0] + F[1] * l0[1] * F[1] * l0[1]);
}

} // namespace mlgimp
