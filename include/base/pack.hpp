// Vectors of four doubles, which load, multiply, add and store as registers where the machine has them.
#pragma once

#include <cmath>
#include <cstddef>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace mlgimp
{

typedef double Pack __attribute__((vector_size(32)));
typedef double HalfPack __attribute__((vector_size(16)));
inline constexpr int kLanes = 4; // size

/// As many doubles as one register holds, and the number of registers.
#ifdef __AVX512VL__
typedef double WidePack __attribute__((vector_size(64)));
inline constexpr int kRegisters = 32; // size
#else
typedef Pack WidePack;
inline constexpr int kRegisters = 16; // size
#endif
inline constexpr int kWideLanes = sizeof(WidePack) / sizeof(double);

/// The doubles at x, which need not be aligned.
template <class Vector = Pack> inline Vector LoadVector(const double *x)
{
  typedef Vector Unaligned __attribute__((aligned(8)));
  return *reinterpret_cast<const Unaligned *>(x);
}
template <class Vector> inline void StoreVector(double *x, Vector value)
{
  typedef Vector Unaligned __attribute__((aligned(8)));
  *reinterpret_cast<Unaligned *>(x) = value;
}

/// to += weight from, of `size` numbers.
inline void AddTimes(double weight, const double *from, double *to, std::ptrdiff_t size)
{
  std::ptrdiff_t c = 0;
  for (; c + kLanes <= size; c += kLanes) StoreVector(to + c, LoadVector(to + c) + weight * LoadVector(from + c));
  for (; c < size; ++c) to[c] += weight * from[c];
}

/// One number in all lanes.
inline Pack Spread(double x) { return Pack{x, x, x, x}; }

/// The first `count` lanes of x; zero in the others, also where they hold no number.
inline Pack FirstLanes(Pack x, int count)
{
  typedef long long Bits __attribute__((vector_size(32)));
  const Bits lane = {0, 1, 2, 3}, last = {count, count, count, count};
  return reinterpret_cast<Pack>(reinterpret_cast<Bits>(x) & (lane < last));
}

// Of one number or of all lanes; named apart from the functions of std, which compilers turn into branches.
inline double Least(double a, double b) { return a < b ? a : b; }
inline double Most(double a, double b) { return a > b ? a : b; }
#ifdef __AVX__
inline Pack Least(Pack a, Pack b) { return _mm256_min_pd(a, b); }
inline Pack Most(Pack a, Pack b) { return _mm256_max_pd(a, b); }
#else
inline Pack Least(Pack a, Pack b) { return a < b ? a : b; }
inline Pack Most(Pack a, Pack b) { return a > b ? a : b; }
#endif
inline Pack Root(Pack x) { return Pack{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])}; }
inline Pack Floor(Pack x) { return Pack{std::floor(x[0]), std::floor(x[1]), std::floor(x[2]), std::floor(x[3])}; }

/// How many lanes from the first one on are equal to x, at least one.
inline int CountEqual(Pack lanes, double x)
{
#ifdef __AVX__
  const int differ = ~_mm256_movemask_pd(reinterpret_cast<__m256d>(lanes == Spread(x)));
#else
  const int differ = ~((lanes[0] == x) | (lanes[1] == x) << 1 | (lanes[2] == x) << 2 | (lanes[3] == x) << 3);
#endif
  return __builtin_ctz(static_cast<unsigned>(differ & ~1));
}

inline HalfPack Low(Pack x) { return __builtin_shufflevector(x, x, 0, 1); }
inline HalfPack High(Pack x) { return __builtin_shufflevector(x, x, 2, 3); }

/// As many lanes from the first one on as a Vector has.
template <class Vector> inline Vector First(Pack x)
{
  if constexpr (sizeof(Vector) == sizeof(Pack))
    return x;
  else
    return Low(x);
}

inline Pack Join(HalfPack low, HalfPack high) { return __builtin_shufflevector(low, high, 0, 1, 2, 3); }

/// (a0, b0, a2, b2), (a1, b1, a3, b3), (a0, b1, a2, b3) and (a1, b0, a3, b2).
inline Pack EvenLanes(Pack a, Pack b) { return __builtin_shufflevector(a, b, 0, 4, 2, 6); }
inline Pack OddLanes(Pack a, Pack b) { return __builtin_shufflevector(a, b, 1, 5, 3, 7); }
inline Pack Alternate(Pack a, Pack b) { return __builtin_shufflevector(a, b, 0, 5, 2, 7); }
inline Pack Swapped(Pack a, Pack b) { return __builtin_shufflevector(a, b, 1, 4, 3, 6); }

} // namespace mlgimp
