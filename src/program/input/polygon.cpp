// Compares all pairs of edges: cases have some thousand vertices at most.
#include "program/input/read_case.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr double kRounding = 1e-12; ///< rounding; of a product of lengths: written vertices are on a line no better

/// Sign of the area of a triangle: 1 where c lies to the left of the line from a to b, 0 where it lies on it.
int Orientation(Vec3 a, Vec3 b, Vec3 c)
{
  const Vec3 u = b - a, v = c - a;
  const double area = u[0] * v[1] - u[1] * v[0], size = Norm(u) * Norm(v);
  return std::abs(area) <= kRounding * size ? 0 : area > 0 ? 1 : -1;
}

/// For a place on the line through a and b: whether it lies between them.
bool Between(Vec3 a, Vec3 b, Vec3 x)
{
  return x[0] >= std::min(a[0], b[0]) && x[0] <= std::max(a[0], b[0]) && x[1] >= std::min(a[1], b[1]) &&
         x[1] <= std::max(a[1], b[1]);
}

/// Whether two edges without a common vertex meet.
bool Meet(Vec3 a, Vec3 b, Vec3 c, Vec3 d)
{
  const int abc = Orientation(a, b, c), abd = Orientation(a, b, d), cda = Orientation(c, d, a), cdb = Orientation(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && Between(a, b, c)) || (abd == 0 && Between(a, b, d)) || (cda == 0 && Between(c, d, a)) ||
         (cdb == 0 && Between(c, d, b));
}

std::string Two(std::size_t a, std::size_t b) { return Format("{} and {}", a + 1, b + 1); }

/// Vertices in units of the polygon's size, so that products of lengths are numbers.
std::vector<Vec3> Scaled(const std::vector<Vec3> &vertices)
{
  double size = 0;
  std::vector<Vec3> scaled;
  for (const Vec3 &v : vertices) size = std::max({size, std::abs(v[0] - vertices[0][0]), std::abs(v[1] - vertices[0][1])});
  for (const Vec3 &v : vertices) scaled.push_back({(v[0] - vertices[0][0]) / size, (v[1] - vertices[0][1]) / size});
  return scaled;
}

} // namespace

std::string WrongPolygon(const std::vector<Vec3> &vertices)
{
  const std::size_t n = vertices.size();
  std::vector<std::size_t> order(n);
  for (std::size_t k = 0; k < n; ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return vertices[a] < vertices[b]; });
  for (std::size_t k = 1; k < n; ++k)
    if (vertices[order[k - 1]] == vertices[order[k]])
      return Format("vertices {} are the same", Two(std::min(order[k - 1], order[k]), std::max(order[k - 1], order[k])));
  const std::vector<Vec3> v = Scaled(vertices);
  if (std::all_of(v.begin(), v.end(), [&](Vec3 x) { return Orientation(v[0], v[1], x) == 0; }))
    return "all vertices are on a line";
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 a = v[i], b = v[(i + 1) % n], next = v[(i + 2) % n];
    if (Orientation(a, b, next) == 0 && Dot(next - b, a - b) > 0)
      return Format("its outline turns back at vertex {}", (i + 1) % n + 1);
    for (std::size_t j = i + 2; j < n; ++j)
      if (!(i == 0 && j == n - 1) && Meet(a, b, v[j], v[(j + 1) % n]))
        return Format("the edges from vertices {} meet", Two(i, j));
  }
  return "";
}

} // namespace mlgimp
