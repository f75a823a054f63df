// Collecting points near places, and their motion.
#include "surface/near_points.hpp"

#include "grid/cell_place.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

constexpr int kNoInterest = -2, kNone = -1; // size

/// Cells around one in which points within a cell of a place in it lie.
IndexBox Around(const NodePartition &nodes, Index cell)
{
  IndexBox box = nodes.Ghosted();
  for (int a = 0; a < nodes.Geometry().dim; ++a)
    box.lower[a] = std::max(box.lower[a], cell[a] - 1), box.upper[a] = std::min(box.upper[a], cell[a] + 2);
  return box;
}

/// F' F^-1, both by rows [dim][dim]; what is not finite stays so.
std::array<double, 9> Change(const double *before, const double *after, int dim)
{
  std::array<double, 9> inverse{}, change{};
  const double *const f = before;
  if (dim == 2) {
    inverse = {f[3], -f[1], -f[2], f[0]};
  } else {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
        inverse[3 * i + j] = f[3 * a + c] * f[3 * b + d] - f[3 * a + d] * f[3 * b + c];
      }
  }
  const double determinant = Determinant(before, dim);
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) {
      for (int k = 0; k < dim; ++k) change[dim * i + j] += after[dim * i + k] * inverse[dim * k + j];
      change[dim * i + j] /= determinant;
    }
  return change;
}

} // namespace

void NearPoints::Mark(const NodePartition &nodes, Vec3 x)
{
  ForEach(Around(nodes, Locate(nodes.Geometry(), x).cell), [&](Index cell) {
    int &first = first_[nodes.Place(cell)];
    if (first == kNoInterest) first = kNone, marked_.push_back(nodes.Place(cell));
  });
}

/// Lists the points in the box around the places, and beyond it for some steps to come.
void NearPoints::FindAround(const GridGeometry &grid, Points &points, double path)
{
  constexpr double kMarked = 2, kMargin = 1,
                   kMotion = 0.5; // size; cells: of two marked ones; for other places, and for points that move
  const double h = grid.spacing;
  const auto around_places = [&](double width) {
    Box box{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (const Place &place : places_)
      for (int a = 0; a < 3; ++a) {
        box.lower[a] = std::min(box.lower[a], place.x[a] - width * h);
        box.upper[a] = std::max(box.upper[a], place.x[a] + width * h);
      }
    return box;
  };
  const Box now = around_places(kMarked);
  bool known = points.Version() == version_ && path <= path_;
  for (int a = 0; a < grid.dim; ++a) known = known && now.lower[a] >= box_.lower[a] && now.upper[a] <= box_.upper[a];
  if (known) return;
  const PointArrays arrays = points.Arrays();
  const Box wide = around_places(kMarked + kMargin + kMotion);
  version_ = points.Version(), path_ = path + kMotion * h, box_ = around_places(kMarked + kMargin);
  around_.clear();
  for (int p = 0; p < arrays.count; ++p)
    if (wide.Contains(arrays.Position(p))) around_.push_back(p);
}

PetscErrorCode NearPoints::Begin(Grid &grid, const std::vector<Place> &places, Points &store, double path)
{
  const NodePartition &nodes = grid.Nodes();
  const int dim = nodes.Geometry().dim;
  std::vector<std::vector<double>> outgoing(nodes.Neighbours().size()), incoming;
  PetscFunctionBeginUser;
  places_ = places;
  own_ = places.size();
  asked_.assign(outgoing.size(), {});
  for (std::size_t k = 0; k < own_; ++k)
    nodes.ForEachCopy(nodes.Geometry().Nearest(places[k].x), [&](std::size_t rank, std::ptrdiff_t) {
      const Place &place = places[k];
      outgoing[rank].insert(outgoing[rank].end(), {place.x[0], place.x[1], place.x[2], static_cast<double>(place.body)});
      asked_[rank].push_back(k);
    });
  PetscCall(grid.Halo().Send(outgoing, &incoming));
  of_neighbour_.clear();
  for (const std::vector<double> &message : incoming) {
    of_neighbour_.push_back(message.size() / 4);
    for (std::size_t k = 0; k < message.size(); k += 4)
      places_.push_back({{message[k], message[k + 1], message[k + 2]}, static_cast<int>(message[k + 3])});
  }
  const std::size_t count = nodes.Ghosted().Count();
  if (first_.size() != count) first_.assign(count, kNoInterest);
  for (const std::ptrdiff_t place : marked_) first_[place] = kNoInterest;
  marked_.clear(), moved_.clear();
  for (const Place &place : places_) Mark(nodes, place.x);
  if (marked_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  FindAround(nodes.Geometry(), store, path);
  const PointArrays points = store.Arrays();
  for (const int p : around_) {
    const Vec3 x = points.Position(p);
    const Index cell = Locate(nodes.Geometry(), x).cell;
    if (!nodes.Ghosted().Contains(cell)) continue;
    int &first = first_[nodes.Place(cell)];
    if (first == kNoInterest) continue;
    Moved one{p, first, points.body[p], points.mass[p], x, {}, {}};
    std::copy_n(points.F + PointArrays::At(p, dim * dim), dim * dim, one.F.begin());
    first = static_cast<int>(moved_.size());
    moved_.push_back(one);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

NearPoints::Sum NearPoints::SumAt(const NodePartition &nodes, const Place &place) const
{
  const GridGeometry &grid = nodes.Geometry();
  const int dim = grid.dim;
  const double inverse_square = 1 / (grid.spacing * grid.spacing);
  Sum sum;
  ForEach(Around(nodes, Locate(grid, place.x).cell), [&](Index cell) {
    for (int k = first_[nodes.Place(cell)]; k >= 0; k = moved_[k].next) {
      const Moved &one = moved_[k];
      const Vec3 d = place.x - one.from;
      const double near = 1 - inverse_square * Dot(d, d), weight = one.mass * near * near * near;
      if (near <= 0 || one.body != place.body) continue;
      Vec3 to = one.to;
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j) to[i] += one.F[dim * i + j] * d[j];
      sum.weighted = sum.weighted + weight * to;
      sum.weight += weight;
    }
  });
  return sum;
}

PetscErrorCode NearPoints::Finish(Grid &grid, const PointArrays &points, std::vector<Sum> *sums)
{
  const int dim = grid.Geometry().dim;
  std::vector<std::vector<double>> outgoing(grid.Halo().Neighbours()), incoming;
  PetscFunctionBeginUser;
  for (Moved &one : moved_) {
    one.to = points.Position(one.point);
    one.F = Change(one.F.data(), points.F + PointArrays::At(one.point, dim * dim), dim);
  }
  sums->clear();
  for (std::size_t k = 0; k < own_; ++k) sums->push_back(SumAt(grid.Nodes(), places_[k]));
  std::size_t next = own_;
  for (std::size_t rank = 0; rank < of_neighbour_.size(); ++rank)
    for (std::size_t k = 0; k < of_neighbour_[rank]; ++k) {
      const Sum sum = SumAt(grid.Nodes(), places_[next++]);
      outgoing[rank].insert(outgoing[rank].end(), {sum.weighted[0], sum.weighted[1], sum.weighted[2], sum.weight});
    }
  PetscCall(grid.Halo().Send(outgoing, &incoming));
  for (std::size_t rank = 0; rank < incoming.size(); ++rank)
    for (std::size_t k = 0; k < asked_[rank].size(); ++k) {
      Sum &sum = (*sums)[asked_[rank][k]];
      const double *const more = &incoming[rank][4 * k];
      sum.weighted = sum.weighted + Vec3{more[0], more[1], more[2]};
      sum.weight += more[3];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
