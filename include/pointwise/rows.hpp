// Fields of a block of points by components: what a point stores side by side lies in rows, which vectorise.
#pragma once

#include "base/pack.hpp"

#include <algorithm>
#include <cstdint>

namespace mlgimp
{

/// Points are worked on in blocks of this many, small enough for the first-level cache.
inline constexpr int kBlock = 64;

/// One number of each point of a block, and room for a vector that begins at the last one.
using Row = double[kBlock + kLanes];

/// Asks the memory for the n components of points p to p + kLanes - 1, field [][n]; there may be no such points.
template <int n> [[gnu::always_inline]] inline void Prefetch(const double *field, int p)
{
  constexpr int kLine = 8; // numbers of a cache line
  const auto first = reinterpret_cast<std::uintptr_t>(field) + sizeof(double) * n * static_cast<std::uintptr_t>(p);
#pragma GCC unroll 5
  for (int k = 0; k < n * kLanes; k += kLine)
    __builtin_prefetch(reinterpret_cast<const void *>(first + sizeof(double) * k)); // NOLINT(performance-no-int-to-ptr)
}

/// Puts the n components of points p to p + kLanes - 1, field [n] of the first of them, into rows: by pairs of components, each
/// of which is one load of a point.
template <int n> inline void LoadLanes(const double *field, int p, Row *rows)
{
  if constexpr (n == 1) return StoreVector(rows[0] + p, LoadVector(field));
  if constexpr (n == 3) {
    const Pack first = LoadVector(field), second = LoadVector(field + 4), third = LoadVector(field + 8);
    const Pack a = Join(Low(first), High(second)), b = Join(High(first), Low(third)), c = Join(Low(second), High(third));
    StoreVector(rows[0] + p, Alternate(a, b)), StoreVector(rows[1] + p, Swapped(a, c)), StoreVector(rows[2] + p, Alternate(b, c));
    return;
  }
#pragma GCC unroll 5
  for (int k = 0; k + 1 < n; k += 2) {
    const Pack even = Join(LoadVector<HalfPack>(field + k), LoadVector<HalfPack>(field + 2 * n + k)),
               odd = Join(LoadVector<HalfPack>(field + n + k), LoadVector<HalfPack>(field + 3 * n + k));
    StoreVector(rows[k] + p, EvenLanes(even, odd)), StoreVector(rows[k + 1] + p, OddLanes(even, odd));
  }
  constexpr int last = n - 1;
  if constexpr (n % 2 == 1)
    StoreVector(rows[last] + p, Pack{field[last], field[n + last], field[2 * n + last], field[3 * n + last]});
}
/// The same for the points p to count - 1; the last of them fills up the vector.
template <int n> inline void LoadLast(const double *field, int p, int count, Row *rows)
{
  for (; p < count || p % kLanes != 0; ++p)
    for (int k = 0; k < n; ++k) rows[k][p] = field[n * std::min(p, count - 1) + k];
}

/// Puts the n components of `count` points, field [count][n], into rows.
template <int n> inline void LoadRows(const double *field, int count, Row *rows)
{
  int p = 0;
  for (; p + kLanes <= count; p += kLanes) LoadLanes<n>(field + n * p, p, rows);
  LoadLast<n>(field, p, count, rows);
}

/// The other way.
template <int n> inline void StoreRows(const Row *rows, int count, double *field)
{
  int p = 0;
  for (; p + kLanes <= count; p += kLanes) {
    double *const f = field + n * p;
    if constexpr (n == 3) {
      const Pack x = LoadVector(rows[0] + p), y = LoadVector(rows[1] + p), z = LoadVector(rows[2] + p);
      const Pack a = EvenLanes(x, y), b = Alternate(z, x), c = OddLanes(y, z);
      StoreVector(f, Join(Low(a), Low(b))), StoreVector(f + 4, Join(Low(c), High(a))), StoreVector(f + 8, Join(High(b), High(c)));
      continue;
    }
#pragma GCC unroll 5
    for (int k = 0; k + 1 < n; k += 2) {
      const Pack first = LoadVector(rows[k] + p), second = LoadVector(rows[k + 1] + p), even = EvenLanes(first, second),
                 odd = OddLanes(first, second);
      StoreVector(f + k, Low(even)), StoreVector(f + n + k, Low(odd));
      StoreVector(f + 2 * n + k, High(even)), StoreVector(f + 3 * n + k, High(odd));
    }
#pragma GCC unroll 4
    for (int i = 0; n % 2 == 1 && i < kLanes; ++i) f[n * i + n - 1] = rows[n - 1][p + i];
  }
  for (; p < count; ++p)
    for (int k = 0; k < n; ++k) field[n * p + k] = rows[k][p];
}

} // namespace mlgimp
