// Places in cells.
#include "grid/cell_place.hpp"

#include <cmath>

namespace mlgimp
{

CellPlace Locate(const GridGeometry &grid, Vec3 x)
{
  CellPlace place{};
  for (int a = 0; a < grid.dim; ++a) {
    const double from_first = (x[a] - grid.lower[a]) / grid.spacing, cell = std::floor(from_first);
    place.cell[a] = static_cast<int>(cell);
    place.part[a] = from_first - cell;
  }
  return place;
}

std::array<double, 8> Hats(Vec3 part, int axes)
{
  std::array<double, 8> hats{1};
  for (int a = 0, count = 1; a < axes; ++a, count *= 2)
    for (int c = 0; c < count; ++c) hats[count + c] = part[a] * hats[c], hats[c] *= 1 - part[a];
  return hats;
}

} // namespace mlgimp
