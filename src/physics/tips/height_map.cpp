// Tips by maps of heights.
#include "physics/tips/height_map.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

TablePlace LowestPlace(const HeightTable &table)
{
  const double lowest = *std::min_element(table.heights.begin(), table.heights.end());
  double x = 0, y = 0, count = 0, nearest = HUGE_VAL;
  TablePlace place{};
  const auto for_each_lowest = [&](const auto &work) {
    for (int j = 0; j < table.rows; ++j)
      for (int i = 0; i < table.columns; ++i)
        if (table.At(i, j) == lowest) work(i, j);
  };
  for_each_lowest([&](int i, int j) { x += i, y += j, ++count; });
  for_each_lowest([&](int i, int j) {
    const double away = std::hypot(i - x / count, j - y / count);
    if (away < nearest) nearest = away, place = {i, j};
  });
  return place;
}

double RimHeight(const HeightTable &table)
{
  double lowest = HUGE_VAL;
  for (int j = 0; j < table.rows; ++j)
    for (int i = 0; i < table.columns; ++i)
      if (i == 0 || j == 0 || i == table.columns - 1 || j == table.rows - 1) lowest = std::min(lowest, table.At(i, j));
  return lowest - *std::min_element(table.heights.begin(), table.heights.end());
}

namespace
{

/// Weights of four neighbours for a value and its derivative, at a part t of the way between the second and the third.
struct CubicWeights {
  double value[4], slope[4];
};
CubicWeights WeightsAt(double t)
{
  const double t2 = t * t, t3 = t2 * t;
  return {{(-t + 2 * t2 - t3) / 2, (2 - 5 * t2 + 3 * t3) / 2, (t + 4 * t2 - 3 * t3) / 2, (t3 - t2) / 2},
          {(-1 + 4 * t - 3 * t2) / 2, (-10 * t + 9 * t2) / 2, (1 + 8 * t - 9 * t2) / 2, (3 * t2 - 2 * t) / 2}};
}

class MapTip : public IndenterSurface
{
public:
  explicit MapTip(const HeightTable &table) : table_(table), lowest_(LowestPlace(table)), rim_(RimHeight(table))
  {
    const double zero = table.At(lowest_.column, lowest_.row);
    for (double &height : table_.heights) height -= zero;
  }

  /// To first order the distance from a graph z(x, y).
  SurfaceGap Gap(Vec3 x) const override
  {
    Vec3 slope;
    const double height = Height(x, &slope), up = 1 / std::sqrt(1 + Dot(slope, slope));
    return {(height - x[2]) * up, up * slope + Vec3{0, 0, -up}};
  }
  double Width(double height) const override
  {
    double nearest = HUGE_VAL;
    for (int j = 0; j < table_.rows; ++j)
      for (int i = 0; i < table_.columns; ++i)
        if (table_.At(i, j) > height) nearest = std::min(nearest, Norm(Place(i, j)));
    return 2 * nearest;
  }
  bool MayBeMirrored(int axis) const override
  {
    constexpr double kRounding = 1e-5; // rounding: of heights in single precision
    const double size = *std::max_element(table_.heights.begin(), table_.heights.end());
    const int middle = axis == 0 ? 2 * lowest_.column : 2 * lowest_.row;
    for (int j = 0; j < table_.rows; ++j)
      for (int i = 0; i < table_.columns; ++i) {
        const int other = middle - (axis == 0 ? i : j);
        if (other < 0 || other >= (axis == 0 ? table_.columns : table_.rows)) continue;
        const double mirrored = axis == 0 ? table_.At(other, j) : table_.At(i, other);
        if (std::abs(table_.At(i, j) - mirrored) > kRounding * size) return false;
      }
    return true;
  }
  Vec3 Farthest(Vec3 direction) const override
  {
    Vec3 farthest{};
    bool at_rim = false;
    for (int j = 0; j < table_.rows; ++j)
      for (int i = 0; i < table_.columns; ++i)
        if (const Vec3 place = Place(i, j); Dot(place - farthest, direction) > 0)
          farthest = place, at_rim = i == 0 || j == 0 || i == table_.columns - 1 || j == table_.rows - 1;
    return at_rim ? Vec3{HUGE_VAL, HUGE_VAL, HUGE_VAL} : farthest;
  }
  HeightRange KnownHeights() const override { return {0, rim_}; }

private:
  Vec3 Place(int i, int j) const { return {(i - lowest_.column) * table_.dx, (j - lowest_.row) * table_.dy, table_.At(i, j)}; }

  /// Heights of the table, and beyond its rim those of a straight continuation.
  double Continued(int i, int j) const
  {
    const int column = std::clamp(i, 0, table_.columns - 1), row = std::clamp(j, 0, table_.rows - 1);
    const int inner_column = std::clamp(2 * column - i, 0, table_.columns - 1);
    const int inner_row = std::clamp(2 * row - j, 0, table_.rows - 1);
    return column == i && row == j ? table_.At(i, j) : 2 * table_.At(column, row) - table_.At(inner_column, inner_row);
  }

  double Height(Vec3 x, Vec3 *slope) const
  {
    const double column = x[0] / table_.dx + lowest_.column, row = x[1] / table_.dy + lowest_.row;
    const double u = std::clamp(column, 0.0, table_.columns - 1.0), v = std::clamp(row, 0.0, table_.rows - 1.0);
    const int i = std::min(static_cast<int>(u), table_.columns - 2), j = std::min(static_cast<int>(v), table_.rows - 2);
    const CubicWeights a = WeightsAt(u - i), b = WeightsAt(v - j);
    double height = 0;
    *slope = {};
    for (int l = 0; l < 4; ++l)
      for (int k = 0; k < 4; ++k) {
        const double z = Continued(i + k - 1, j + l - 1);
        height += a.value[k] * b.value[l] * z;
        (*slope)[0] += a.slope[k] * b.value[l] * z / table_.dx;
        (*slope)[1] += a.value[k] * b.slope[l] * z / table_.dy;
      }
    return height + (column - u) * table_.dx * (*slope)[0] + (row - v) * table_.dy * (*slope)[1];
  }

  HeightTable table_;
  TablePlace lowest_;
  double rim_;
};

} // namespace

std::unique_ptr<IndenterSurface> CreateMapTip(const HeightTable &table) { return std::make_unique<MapTip>(table); }

} // namespace mlgimp
