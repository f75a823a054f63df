// Fields of a block of points by components: what a point stores side by side lies in rows, which vectorise.
#pragma once

#include "base/pack.hpp"

#include <algorithm>
#include <cstdint>

namespace mlgimp
{

/// Points are worked on in blocks of this many, small enough for the first-level cache.
inline constexpr int kBlock = 64; // size

/// One number of each point of a block, and room for a vector that begins at the last one.
using Row = double[kBlock + kLanes];

/// Asks the memory for n components of points p to p + kLanes - 1, field [][stride]; there may be no such points.
template <int n, class Number> [[gnu::always_inline]] inline void Prefetch(const Number *field, int p, int stride = n)
{
  constexpr int kLine = 64 / sizeof(Number); // size: numbers of a cache line
  const auto first = reinterpret_cast<std::uintptr_t>(field) + sizeof(Number) * stride * static_cast<std::uintptr_t>(p);
#pragma GCC unroll 5
  for (int k = 0; k < n * kLanes; k += kLine)
    __builtin_prefetch(reinterpret_cast<const void *>(first + sizeof(Number) * k)); // NOLINT(performance-no-int-to-ptr)
}

/// Puts n components of points p to p + kLanes - 1 into rows, from `field`, that of the first of them; so many numbers lie
/// between those of a point and of the next. By pairs of components, each of which is one load of a point; three by themselves
/// are as many vectors.
template <int n> inline void LoadLanes(const double *field, int p, Row *rows, int stride = n)
{
  if constexpr (n == 1) return StoreVector(rows[0] + p, LoadVector(field));
  if (n == 3 && stride == 3) {
    const Pack first = LoadVector(field), second = LoadVector(field + 4), third = LoadVector(field + 8);
    const Pack a = Join(Low(first), High(second)), b = Join(High(first), Low(third)), c = Join(Low(second), High(third));
    StoreVector(rows[0] + p, Alternate(a, b)), StoreVector(rows[1] + p, Swapped(a, c)), StoreVector(rows[2] + p, Alternate(b, c));
    return;
  }
  const double *const second = field + stride, *const third = second + stride, *const fourth = third + stride;
#pragma GCC unroll 5
  for (int k = 0; k + 1 < n; k += 2) {
    const Pack even = Join(LoadVector<HalfPack>(field + k), LoadVector<HalfPack>(third + k)),
               odd = Join(LoadVector<HalfPack>(second + k), LoadVector<HalfPack>(fourth + k));
    StoreVector(rows[k] + p, EvenLanes(even, odd)), StoreVector(rows[k + 1] + p, OddLanes(even, odd));
  }
  constexpr int last = n - 1;
  if constexpr (n % 2 == 1) StoreVector(rows[last] + p, Pack{field[last], second[last], third[last], fourth[last]});
}
/// The same for the points p to count - 1; the last of them fills up the vector.
template <int n> inline void LoadLast(const double *field, int p, int count, Row *rows, int stride = n)
{
  for (; p < count || p % kLanes != 0; ++p)
    for (int k = 0; k < n; ++k) rows[k][p] = field[stride * std::min(p, count - 1) + k];
}

/// Puts n components of `count` points, field [count][stride], into rows.
template <int n> inline void LoadRows(const double *field, int count, Row *rows, int stride = n)
{
  int p = 0;
  for (; p + kLanes <= count; p += kLanes) LoadLanes<n>(field + stride * p, p, rows, stride);
  LoadLast<n>(field, p, count, rows, stride);
}

/// The lanes of four vectors become four vectors, `stride` apart.
inline void StoreTransposed(const Pack *parts, double *vectors, int stride)
{
  const Pack even[2] = {EvenLanes(parts[0], parts[1]), EvenLanes(parts[2], parts[3])},
             odd[2] = {OddLanes(parts[0], parts[1]), OddLanes(parts[2], parts[3])};
  StoreVector(vectors, Join(Low(even[0]), Low(even[1]))), StoreVector(vectors + stride, Join(Low(odd[0]), Low(odd[1])));
  StoreVector(vectors + 2 * stride, Join(High(even[0]), High(even[1])));
  StoreVector(vectors + 3 * stride, Join(High(odd[0]), High(odd[1])));
}

/// The other way, of points p to p + kLanes - 1.
template <int n> inline void StoreLanes(const Row *rows, int p, double *field, int stride = n)
{
  if (n == 3 && stride == 3) {
    const Pack x = LoadVector(rows[0] + p), y = LoadVector(rows[1] + p), z = LoadVector(rows[2] + p);
    const Pack a = EvenLanes(x, y), b = Alternate(z, x), c = OddLanes(y, z);
    StoreVector(field, Join(Low(a), Low(b))), StoreVector(field + 4, Join(Low(c), High(a)));
    StoreVector(field + 8, Join(High(b), High(c)));
    return;
  }
#pragma GCC unroll 5
  for (int k = 0; k + 1 < n; k += 2) {
    const Pack first = LoadVector(rows[k] + p), second = LoadVector(rows[k + 1] + p), even = EvenLanes(first, second),
               odd = OddLanes(first, second);
    StoreVector(field + k, Low(even)), StoreVector(field + stride + k, Low(odd));
    StoreVector(field + 2 * stride + k, High(even)), StoreVector(field + 3 * stride + k, High(odd));
  }
#pragma GCC unroll 4
  for (int i = 0; n % 2 == 1 && i < kLanes; ++i) field[stride * i + n - 1] = rows[n - 1][p + i];
}
template <int n> inline void StoreRows(const Row *rows, int count, double *field, int stride = n)
{
  int p = 0;
  for (; p + kLanes <= count; p += kLanes) StoreLanes<n>(rows, p, field + stride * p, stride);
  for (; p < count; ++p)
    for (int k = 0; k < n; ++k) field[stride * p + k] = rows[k][p];
}

} // namespace mlgimp
