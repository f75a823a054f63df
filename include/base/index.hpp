// Places in the index space of a grid, which has three axes: in two dimensions the third has one layer.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace mlgimp
{

using Index = std::array<int, 3>;

inline constexpr double kLargestWhole = 9007199254740992; ///< exact; 2^53: doubles hold whole numbers up to it exactly

struct IndexHash {
  std::size_t operator()(Index at) const
  {
    std::uint64_t hash = 0;
    for (const int one : at) hash = (hash ^ static_cast<std::uint32_t>(one)) * 0x9e3779b97f4a7c15ULL, hash ^= hash >> 29;
    return hash;
  }
};

inline Index operator+(Index a, Index b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Index operator-(Index a, Index b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// The indices lower <= i < upper along each axis.
struct IndexBox {
  Index lower{}, upper{};

  int Size(int axis) const { return upper[axis] - lower[axis]; }
  bool Empty() const { return Size(0) <= 0 || Size(1) <= 0 || Size(2) <= 0; }
  std::int64_t Count() const { return Empty() ? 0 : std::int64_t(Size(0)) * Size(1) * Size(2); }
  bool Contains(Index at) const
  {
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] < lower[axis] || at[axis] >= upper[axis]) return false;
    return true;
  }
  /// Where an index stands among all, the first axis fastest.
  std::int64_t Place(Index at) const
  {
    return (std::int64_t(at[2] - lower[2]) * Size(1) + at[1] - lower[1]) * Size(0) + at[0] - lower[0];
  }
  /// The index that stands there.
  Index At(std::int64_t place) const
  {
    const int x = Size(0), y = Size(1);
    return lower + Index{static_cast<int>(place % x), static_cast<int>(place / x % y), static_cast<int>(place / x / y)};
  }
  /// Grows to contain an index.
  void Include(Index at)
  {
    for (int axis = 0; axis < 3; ++axis)
      lower[axis] = std::min(lower[axis], at[axis]), upper[axis] = std::max(upper[axis], at[axis] + 1);
  }
};
/// A box without indices that grows from nothing.
inline constexpr IndexBox kNowhere = {{1 << 30, 1 << 30, 1 << 30}, {-(1 << 30), -(1 << 30), -(1 << 30)}};

inline IndexBox Intersection(const IndexBox &a, const IndexBox &b)
{
  IndexBox both;
  for (int axis = 0; axis < 3; ++axis) {
    both.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
    both.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
  }
  return both;
}

/// Calls work(index) for all indices of a box, the first axis fastest.
template <class Work> void ForEach(const IndexBox &box, Work work)
{
  for (int k = box.lower[2]; k < box.upper[2]; ++k)
    for (int j = box.lower[1]; j < box.upper[1]; ++j)
      for (int i = box.lower[0]; i < box.upper[0]; ++i) work(Index{i, j, k});
}

} // namespace mlgimp
