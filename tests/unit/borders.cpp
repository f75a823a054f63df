// The border of two levels as a linear map: the blended functions add up to one, and reproduce linear fields.
#include "hierarchy/transfer/merging.hpp"
#include "simulation/setup.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20240607);

/// Two empty levels: a box within 16 x 16 coarse cells that reaches the domain's upper side.
struct TwoLevels {
  explicit TwoLevels(int cell_ratio, double width) : ratio(cell_ratio)
  {
    AddBody(model, CreateBoxRegion({{0, 0}, {1, 1}}), "neo_hookean", {1e7, 0.3, 1000, NAN, NAN});
    const HierarchySettings settings = NestedLevels(model, {{0, 0}, {16, 16}}, 1, ratio, {{{3, 4}, {13, 16}}});
    LogEvents events;
    PetscCallAbort(PETSC_COMM_WORLD, RegisterLogEvents(&events));
    for (const LevelGeometry &geometry : settings.levels) {
      levels.push_back(std::make_unique<Level>(model, events));
      PetscCallAbort(PETSC_COMM_WORLD, levels.back()->Create(PETSC_COMM_SELF, geometry, OneBlock(geometry.grid)));
    }
    PetscCallAbort(PETSC_COMM_WORLD, border.Create(PETSC_COMM_SELF, *levels[0], *levels[1], ratio, width));
    Clear();
  }
  void Clear()
  {
    for (auto &level : levels) {
      level->Mesh().Arrays().ClearSums();
      std::fill_n(level->Mesh().Arrays().VelocityArray(), NodeLayout::Velocity(2) * level->Mesh().Ghosted().Count(), 0.0);
    }
  }
  NodeSums &Sums(int l, int i, int j) { return levels[l]->Mesh().Sums()[levels[l]->Mesh().Place({i, j, 0})]; }
  double *Velocity(int l, int i, int j) { return levels[l]->Mesh().Velocity(levels[l]->Mesh().Place({i, j, 0})).velocity; }
  /// Calls work(i, j) for all nodes of a level's grid.
  template <class Work> void ForEachNode(int l, Work work)
  {
    ForEach(levels[l]->Mesh().Owned(), [&](Index node) { work(node[0], node[1]); });
  }
  void Step()
  {
    ASSERT_EQ(border.CoarseToFine(), PETSC_SUCCESS);
    ASSERT_EQ(border.Advance(0, 1), PETSC_SUCCESS);
    ASSERT_EQ(border.FineToCoarse(), PETSC_SUCCESS);
  }

  int ratio;
  Model model;
  std::vector<std::unique_ptr<Level>> levels;
  LevelInterface border;
};

/// The velocities of fine nodes of speed 1 after a step whose interface nodes rest: what is left to the fine functions.
std::vector<double> Betas(TwoLevels &two)
{
  two.Clear();
  two.ForEachNode(0, [&](int i, int j) { two.Sums(0, i, j).mass = 1; });
  two.ForEachNode(1, [&](int i, int j) { two.Velocity(1, i, j)[0] = 1; });
  two.Step();
  std::vector<double> betas;
  two.ForEachNode(1, [&](int i, int j) { betas.push_back(two.Velocity(1, i, j)[0]); });
  return betas;
}

/// What the interface nodes, each of unit mass, get of the unit momentum of a fine node.
double InterfaceShare(TwoLevels &two, int i, int j)
{
  double share = 0;
  two.Clear();
  two.ForEachNode(0, [&](int a, int b) { two.Sums(0, a, b).mass = 1; });
  two.Sums(1, i, j).mass = 1e-30; // nodes without mass are left out
  two.Sums(1, i, j).momentum[0] = 1;
  two.Step();
  two.ForEachNode(0, [&](int a, int b) { share += two.ratio * two.Velocity(0, a, b)[0]; });
  return share;
}

} // namespace

TEST(Borders, BlendedFunctionsAddUpToOne)
{
  for (int ratio : {2, 3})
    for (double width : {2.0, 4.0}) {
      TwoLevels two(ratio, width);
      const std::vector<double> betas = Betas(two);
      const int cells[2] = {10 * ratio, 12 * ratio};
      std::map<int, double> by_depth;
      int k = 0;
      two.ForEachNode(1, [&](int i, int j) {
        const double beta = betas[k++];
        if (std::min(i, j) < -1 || i > cells[0] + 1 || j > cells[1]) return; // no point reaches these
        EXPECT_NEAR(beta + InterfaceShare(two, i, j), 1, 1e-14) << "node " << i << ", " << j;
        const int depth = std::min({i, j, cells[0] - i}); // the upper side is the domain's
        EXPECT_EQ(beta == 0, depth <= 0) << "slaves are outside";
        EXPECT_EQ(beta == 1, depth >= width * ratio) << "the band ends";
        EXPECT_EQ(by_depth.emplace(depth, beta).first->second, beta) << "the same at the same depth";
      });
      for (int depth = 1; depth <= width * ratio; ++depth) EXPECT_GT(by_depth[depth], by_depth[depth - 1]);
    }
}

/// A linear field of velocities on the coarse nodes and the same on the fine ones is the same in the band.
TEST(Borders, LinearFieldsPass)
{
  for (int ratio : {2, 3}) {
    TwoLevels two(ratio, 4);
    double c[2][3];
    for (auto &row : c)
      for (double &value : row) value = Random(-1, 1);
    const auto field = [&](int l, int i, int j, int axis) {
      const Grid &grid = two.levels[l]->Mesh();
      return c[axis][0] + c[axis][1] * grid.Geometry().Coordinate(0, i) + c[axis][2] * grid.Geometry().Coordinate(1, j);
    };
    two.ForEachNode(0, [&](int i, int j) {
      NodeSums &sums = two.Sums(0, i, j);
      sums.mass = Random(1, 2);
      for (int axis = 0; axis < 2; ++axis) sums.momentum[axis] = sums.mass * field(0, i, j, axis);
    });
    two.ForEachNode(1, [&](int i, int j) {
      for (int axis = 0; axis < 2; ++axis) two.Velocity(1, i, j)[axis] = field(1, i, j, axis);
    });
    two.Step();
    const int cells[2] = {10 * ratio, 12 * ratio};
    for (int j = -1; j <= cells[1]; ++j)
      for (int i = -1; i <= cells[0] + 1; ++i)
        for (int axis = 0; axis < 2; ++axis) ASSERT_NEAR(two.Velocity(1, i, j)[axis], field(1, i, j, axis), 1e-13);
  }
}

/// Points that are split and put together again are what they were.
TEST(Borders, SplitPointsBecomeTheirParents)
{
  for (int ratio : {2, 3}) {
    TwoLevels two(ratio, 4);
    constexpr int kPoints = 6;
    Level &coarse = *two.levels[0];
    PointArrays a;
    ASSERT_EQ(coarse.PointStore().Resize(kPoints), PETSC_SUCCESS);
    a = coarse.PointStore().Arrays();
    for (int p = 0; p < kPoints; ++p) {
      a.id[p] = 10 * p, a.body[p] = 0, a.faces[p] = 1 << p % 5, a.mass[p] = Random(1, 2);
      for (int d = 0; d < 2; ++d)
        a.position[2 * p + d] = Random(6, 12), a.velocity[2 * p + d] = Random(-1, 1), a.half_size[2 * p + d] = Random(0.22, 0.25);
      for (int k = 0; k < 4; ++k) a.F[4 * p + k] = (k % 3 == 0) + Random(-0.1, 0.1), a.stress[4 * p + k] = Random(-1e6, 1e6);
      for (int k = 0; k < 3; ++k) a.short_wave_stress[3 * p + k] = Random(-1e3, 1e3);
    }
    two.ForEachNode(0, [&](int i, int j) { // children of a shearing body move on
      two.Sums(0, i, j).mass = 1;
      two.Velocity(0, i, j)[0] = 0.1 * coarse.Mesh().Geometry().Coordinate(1, j);
    });
    std::vector<double> x(a.position, a.position + 2 * kPoints), v(a.velocity, a.velocity + 2 * kPoints),
        size(a.half_size, a.half_size + 2 * kPoints), mass(a.mass, a.mass + kPoints), F(a.F, a.F + 4 * kPoints),
        stress(a.stress, a.stress + 4 * kPoints), waves(a.short_wave_stress, a.short_wave_stress + 3 * kPoints);
    std::vector<int> faces(a.faces, a.faces + kPoints);

    const PointNumbers numbers(1000, ratio * ratio);
    Budgets totals;
    PointTransfer crossing(PETSC_COMM_SELF, coarse, *two.levels[1], ratio, numbers, {0, 0, 1, false, true, HUGE_VAL});
    ASSERT_EQ(crossing.SplitRing(), PETSC_SUCCESS);
    const int children = ratio * ratio;
    ASSERT_EQ(coarse.PointStore().Count(), children * kPoints);
    a = coarse.PointStore().Arrays();
    double apart = 0;
    std::vector<int> outer(kPoints, 0); // children that have the face of their parent
    for (int p = 0; p < a.count; ++p) {
      const int parent = static_cast<int>(numbers.Parent(a.id[p]) / 10);
      EXPECT_NEAR(a.mass[p], mass[parent] / children, 1e-15);
      EXPECT_NEAR(a.half_size[2 * p], size[2 * parent] / ratio, 1e-15);
      const double dy = a.position[2 * p + 1] - x[2 * parent + 1];
      EXPECT_NEAR(a.velocity[2 * p], v[2 * parent] + 0.1 * dy, 1e-14);
      apart = Largest({apart, std::abs(dy)});
      outer[parent] += a.faces[p] == faces[parent];
      const double change = numbers.ChildIndex(a.id[p]) - 0.5 * (children - 1); // of what they share, none on average
      for (int k = 0; k < 4; ++k) a.F[4 * p + k] += 1e-3 * change, a.stress[4 * p + k] += 1e3 * change;
      for (int k = 0; k < 3; ++k) a.short_wave_stress[3 * p + k] += change;
    }
    for (int p = 0; p < kPoints; ++p) EXPECT_EQ(outer[p], p % 5 < 4 ? ratio : children) << "along a side, or a load's bit";
    EXPECT_GT(apart, 0.05) << "children lie apart";

    ASSERT_EQ(MergeSiblings(PETSC_COMM_SELF, coarse, numbers, ratio, HUGE_VAL, &totals), PETSC_SUCCESS);
    EXPECT_EQ(totals.points_merged, kPoints);
    EXPECT_LE(totals.transfer_mass_error + totals.transfer_momentum_error, 1e-13);
    ASSERT_EQ(coarse.PointStore().Count(), kPoints);
    a = coarse.PointStore().Arrays();
    for (int p = 0; p < kPoints; ++p) {
      const int was = static_cast<int>(a.id[p] / 10);
      EXPECT_EQ(a.id[p], 10 * was);
      EXPECT_EQ(a.faces[p], faces[was]);
      EXPECT_NEAR(a.mass[p], mass[was], 1e-15);
      for (int d = 0; d < 2; ++d) {
        EXPECT_NEAR(a.position[2 * p + d], x[2 * was + d], 1e-14);
        EXPECT_NEAR(a.velocity[2 * p + d], v[2 * was + d], 1e-14);
        EXPECT_NEAR(a.half_size[2 * p + d], size[2 * was + d], 1e-15);
      }
      for (int k = 0; k < 4; ++k) {
        EXPECT_NEAR(a.F[4 * p + k], F[4 * was + k], 1e-15);
        EXPECT_NEAR(a.stress[4 * p + k], stress[4 * was + k], 1e-8);
      }
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(a.short_wave_stress[3 * p + k], waves[3 * was + k], 1e-11);
    }
  }
}
