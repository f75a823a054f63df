// The storage of points: removing, reordering, and moving points between ranks keep every field of every point.
#include "points/points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

using namespace mlgimp;

namespace
{

constexpr int kLoads = 2, kHistoryComponents = 5;

/// A value that tells point, field and component apart.
double Value(std::int64_t id, PointField field, int component)
{
  return static_cast<double>(id) + field / 16.0 + component / 256.0;
}

void Write(Points &points, int p, std::int64_t id)
{
  for (int f = 0; f < kPointFields; ++f) {
    const PointFieldInfo &info = points.Table()[f];
    void *const data = points.Field(static_cast<PointField>(f));
    for (int c = 0; c < info.components; ++c) {
      const int place = info.components * p + c;
      if (info.type == FieldType::kReal)
        static_cast<double *>(data)[place] = Value(id, static_cast<PointField>(f), c);
      else if (info.type == FieldType::kInt64)
        static_cast<std::int64_t *>(data)[place] = id;
      else
        static_cast<int *>(data)[place] = f == kFaces ? static_cast<int>(id % 3 == 0) : static_cast<int>(id % 1000 + f);
    }
  }
}

/// Numbers of the points as they are stored, after a look at all other fields.
std::vector<std::int64_t> Read(Points &points)
{
  const PointArrays a = points.Arrays();
  for (int p = 0; p < a.count; ++p) {
    const std::int64_t id = a.id[p];
    const double *const reals[] = {a.position, a.velocity,  a.F,          a.stress,  a.short_wave_stress,
                                   a.mass,     a.half_size, a.load_share, a.history, a.initial_position};
    const PointField fields[] = {kPosition, kVelocity, kDeformation, kStress,  kShortWaveStress,
                                 kMass,     kHalfSize, kLoadShare,   kHistory, kInitialPosition};
    for (std::size_t k = 0; k < std::size(fields); ++k) {
      const int components = points.Table()[fields[k]].components;
      for (int c = 0; c < components; ++c) EXPECT_EQ(reals[k][components * p + c], Value(id, fields[k], c)) << "point " << id;
    }
    EXPECT_EQ(a.body[p], id % 1000 + kBody);
    EXPECT_EQ(a.faces[p], id % 3 == 0);
  }
  return {a.id, a.id + a.count};
}

void Fill(Points &points, std::int64_t first, int count)
{
  ASSERT_EQ(points.Create(PETSC_COMM_SELF, GeometryKind::kPlaneStrain, kLoads, kHistoryComponents), PETSC_SUCCESS);
  ASSERT_EQ(points.Resize(count), PETSC_SUCCESS);
  for (int p = 0; p < count; ++p) Write(points, p, first + p);
}

std::vector<std::int64_t> Sorted(std::vector<std::int64_t> numbers)
{
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

} // namespace

TEST(Points, RemoveTakesTheseAndNoOthers)
{
  std::mt19937 generator(7);
  for (int n = 0; n < 60; ++n) {
    constexpr int kCount = 12;
    Points points;
    Fill(points, 100, kCount);
    std::vector<int> holes;
    std::vector<std::int64_t> kept;
    for (int p = 0; p < kCount; ++p) {
      if (std::uniform_real_distribution<double>(0, 1)(generator) < n / 59.0)
        holes.push_back(p);
      else
        kept.push_back(100 + p);
    }
    points.Remove(holes);
    EXPECT_EQ(Sorted(Read(points)), kept);
  }
}

TEST(Points, ReorderPutsThemInOrder)
{
  Points points;
  Fill(points, 0, 5);
  points.Reorder({3, 1, 4, 0, 2});
  EXPECT_EQ(Read(points), (std::vector<std::int64_t>{3, 1, 4, 0, 2}));
}

TEST(Points, SurfacePointsFollowTheStorage)
{
  Points points;
  const std::vector<int> *surface = nullptr;
  Fill(points, 0, 7); // 0, 3, 6 have a face
  surface = &points.SurfacePoints();
  EXPECT_EQ(*surface, (std::vector<int>{0, 3, 6}));
  const long version = points.Version();
  points.Reorder({1, 0, 2, 3, 4, 6, 5});
  surface = &points.SurfacePoints();
  EXPECT_EQ(*surface, (std::vector<int>{1, 3, 5}));
  points.Remove({1});
  surface = &points.SurfacePoints();
  EXPECT_EQ(*surface, (std::vector<int>{3, 5}));
  EXPECT_GT(points.Version(), version);
}

TEST(Points, GrowingKeepsThem)
{
  Points points;
  Fill(points, 40, 3);
  ASSERT_EQ(points.Resize(1000), PETSC_SUCCESS);
  ASSERT_EQ(points.Resize(3), PETSC_SUCCESS);
  EXPECT_EQ(Read(points), (std::vector<std::int64_t>{40, 41, 42}));
}

/// Every rank has 30 points, with numbers from 1000 times its own on; point k goes to rank (k + rank) mod ranks, but
/// those with k mod 5 = 4, which stay.
TEST(PointsOnRanks, MoveToTheirRanksInOrder)
{
  constexpr int kCount = 30;
  PetscMPIInt rank, ranks;
  Points points;
  Migrants migrants;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Fill(points, 1000 * rank, kCount);
  std::vector<std::int64_t> arriving;
  for (int k = 0; k < kCount; ++k)
    if (k % 5 != 4) migrants.points.push_back(k), migrants.ranks.push_back((k + rank) % ranks);
  for (int source = 0; source < ranks; ++source)
    for (int k = 0; k < kCount; ++k)
      if (k % 5 != 4 && (k + source) % ranks == rank) arriving.push_back(1000 * source + k);
  ASSERT_EQ(MovePoints(PETSC_COMM_WORLD, points, points, migrants), PETSC_SUCCESS);
  const std::vector<std::int64_t> numbers = Read(points);
  ASSERT_EQ(numbers.size(), kCount / 5 + arriving.size());
  EXPECT_EQ(std::vector<std::int64_t>(numbers.begin() + kCount / 5, numbers.end()), arriving) << "by source rank and place";
  for (int p = 0; p < kCount / 5; ++p) EXPECT_EQ(numbers[p] % 5, 4) << "stayed";
}

TEST(PointsOnRanks, CopiesKnowTheirOrigins)
{
  PetscMPIInt rank, ranks;
  Points points, copies;
  Migrants migrants;
  std::vector<PetscSFNode> origins;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Fill(points, 1000 * rank, 4);
  Fill(copies, 0, 0);
  for (int to = 0; to < ranks; ++to)
    for (int k = 0; k < 4; k += 2) migrants.points.push_back(k), migrants.ranks.push_back(to);
  ASSERT_EQ(CopyPoints(PETSC_COMM_WORLD, points, copies, migrants, &origins), PETSC_SUCCESS);
  EXPECT_EQ(points.Count(), 4);
  const std::vector<std::int64_t> numbers = Read(copies);
  ASSERT_EQ(numbers.size(), 2U * ranks);
  ASSERT_EQ(origins.size(), numbers.size());
  for (int k = 0; k < 2 * ranks; ++k) {
    EXPECT_EQ(numbers[k], 1000 * (k / 2) + 2 * (k % 2));
    EXPECT_EQ(origins[k].rank, k / 2);
    EXPECT_EQ(origins[k].index, 2 * rank + k % 2);
  }
}
