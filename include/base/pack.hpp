// Vectors of four and eight doubles that load, multiply, add and store as registers where the machine has them.
#pragma once

namespace mlgimp
{

typedef double Pack __attribute__((vector_size(32)));

/// The doubles at x, which need not be aligned.
template <class Vector> inline Vector LoadVector(const double *x)
{
  typedef Vector Unaligned __attribute__((aligned(8)));
  return *reinterpret_cast<const Unaligned *>(x);
}
template <class Vector> inline void StoreVector(double *x, Vector value)
{
  typedef Vector Unaligned __attribute__((aligned(8)));
  *reinterpret_cast<Unaligned *>(x) = value;
}

inline double Lane(Pack x, int k) { return x[k]; }

#ifdef __AVX512F__

typedef double WidePack __attribute__((vector_size(64)));
typedef WidePack HighPack; ///< a WidePack that begins with four zeros

inline WidePack Join(Pack low, Pack high) { return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7); }
inline HighPack MakeHigh(Pack high) { return Join(Pack{}, high); }
inline Pack Low(WidePack x) { return __builtin_shufflevector(x, x, 0, 1, 2, 3); }
inline Pack High(WidePack x) { return __builtin_shufflevector(x, x, 4, 5, 6, 7); }
inline double Lane(WidePack x, int k) { return x[k]; }

#else // pairs: compilers split a vector that is wider than any register into single doubles

struct WidePack {
  Pack low, high;
};
struct HighPack {
  Pack high;
};

template <> inline WidePack LoadVector<WidePack>(const double *x) { return {LoadVector<Pack>(x), LoadVector<Pack>(x + 4)}; }
inline void StoreVector(double *x, WidePack value) { StoreVector(x, value.low), StoreVector(x + 4, value.high); }
inline WidePack Join(Pack low, Pack high) { return {low, high}; }
inline HighPack MakeHigh(Pack high) { return {high}; }
inline Pack Low(WidePack x) { return x.low; }
inline Pack High(WidePack x) { return x.high; }
inline double Lane(WidePack x, int k) { return k < 4 ? x.low[k] : x.high[k - 4]; }
inline WidePack operator+(WidePack a, WidePack b) { return {a.low + b.low, a.high + b.high}; }
inline WidePack operator*(double a, WidePack x) { return {a * x.low, a * x.high}; }
inline HighPack operator*(double a, HighPack x) { return {a * x.high}; }
inline WidePack &operator+=(WidePack &a, WidePack b) { return a = a + b; }
inline WidePack &operator+=(WidePack &a, HighPack b) { return a = {a.low, a.high + b.high}; }

#endif

} // namespace mlgimp
