// Boxes that flow has sheared: what straightening keeps, and what it leaves alone.
#include "level/flow.hpp"
#include "level/seeding.hpp"
#include "physics/tips/profiles.hpp"
#include "points/face.hpp"

#include "simulation/setup.hpp"
#include "unit/largest.hpp"
#include "unit/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace mlgimp;

namespace
{

RandomNumbers Random(20261123);

/// Points of one body with nothing but boxes, faces and places.
struct Boxes {
  explicit Boxes(int dimension, int count)
      : dim(dimension), position(count * dim), half_size(count * dim), F(count * dim * dim), body(count), faces(count)
  {
    for (double &x : position) x = Random(-1, 1);
    for (double &l : half_size) l = Random(0.1, 0.3);
    for (double &f : F) f = Random(-0.2, 0.2);
    for (int p = 0; p < count; ++p)
      for (int a = 0; a < dim; ++a) F[dim * (dim * p + a) + a] += 1;
  }
  PointArrays Arrays()
  {
    PointArrays a{};
    a.count = static_cast<int>(body.size()), a.dim = dim;
    a.position = position.data(), a.half_size = half_size.data(), a.F = F.data(), a.body = body.data(), a.faces = faces.data();
    return a;
  }
  int dim;
  std::vector<double> position, half_size, F;
  std::vector<int> body, faces;
};

Model ModelOf(const std::string &law, int dim)
{
  Model model;
  model.materials.push_back(
      CreateMaterial(law, {1e9, 0.3, 1000, 1e6, 0}, dim == 2 ? GeometryKind::kPlaneStrain : GeometryKind::kSpatial));
  model.materials[0]->SplitStretched(true);
  model.bodies.push_back({"b", nullptr, 0, {}, 2});
  return model;
}

/// Adds shear of the last axis along all others.
void Shear(Boxes &boxes, double shear)
{
  const int dim = boxes.dim;
  for (std::size_t p = 0; p < boxes.body.size(); ++p)
    for (int i = 0; i < dim; ++i)
      for (int b = 0; b < dim - 1; ++b) boxes.F[dim * (dim * p + i) + dim - 1] += shear * boxes.F[dim * (dim * p + i) + b];
}

} // namespace

TEST(Flow, StraightBoxesKeepVolumesAndFaces)
{
  for (int dim : {2, 3}) {
    Boxes boxes(dim, 50);
    const Side top = static_cast<Side>(2 * dim - 1);
    Shear(boxes, 6);
    for (int &faces : boxes.faces) faces = OuterFaceBit(top);
    const PointArrays a = boxes.Arrays();
    std::vector<Face> before;
    std::vector<double> volume;
    for (int p = 0; p < a.count; ++p)
      before.push_back(PointFace(a, p, top)), volume.push_back(Determinant(a.F + dim * dim * p, dim));
    StraightenBoxes(ModelOf("j2", dim), a);
    double changed = 0, moved = 0, turned = 0, sheared = 0;
    for (int p = 0; p < a.count; ++p) {
      const Face face = PointFace(a, p, top);
      const double area = Norm(face.area_normal);
      const Vec3 normal = (1 / area) * face.area_normal, edge = face.center - a.Position(p);
      changed = Largest({changed, std::abs(Determinant(a.F + dim * dim * p, dim) / volume[p] - 1)});
      moved = Largest({moved, std::abs(Dot(face.center - before[p].center, normal))});
      turned = Largest({turned, Norm(face.area_normal - before[p].area_normal) / area});
      sheared = Largest({sheared, Norm(edge - Dot(edge, normal) * normal) / Norm(edge)});
    }
    EXPECT_LE(changed, 1e-13) << "volume, " << dim;
    EXPECT_LE(moved, 1e-13) << "face's place along its normal, m, " << dim;
    EXPECT_LE(turned, 1e-13) << "face's area and normal, " << dim;
    EXPECT_LE(sheared, 1e-13) << "shift of the face along itself, of the edge to it, " << dim;
  }
}

TEST(Flow, LittleShearElasticBoxesAndThoseWithinStay)
{
  for (int dim : {2, 3}) {
    Boxes little(dim, 20), elastic(dim, 20), within(dim, 20);
    for (Boxes *boxes : {&little, &elastic})
      for (int &faces : boxes->faces) faces = OuterFaceBit(static_cast<Side>(2 * dim - 1));
    for (Boxes *boxes : {&elastic, &within}) Shear(*boxes, 6);
    const std::vector<double> F = little.F, of_elastic = elastic.F, of_within = within.F;
    StraightenBoxes(ModelOf("j2", dim), little.Arrays());
    StraightenBoxes(ModelOf("neo_hookean", dim), elastic.Arrays());
    StraightenBoxes(ModelOf("j2", dim), within.Arrays());
    EXPECT_EQ(little.F, F) << dim;
    EXPECT_EQ(elastic.F, of_elastic) << dim;
    EXPECT_EQ(within.F, of_within) << dim;
  }
}

TEST(Flow, BoxesEndAtTheAxis)
{
  Boxes boxes(2, 50);
  std::vector<double> radius(50);
  for (int p = 0; p < 50; ++p) boxes.position[2 * p] = Random(0.05, 0.5);
  Shear(boxes, 1);
  PointArrays a = boxes.Arrays();
  a.initial_radius = radius.data();
  const std::vector<double> F = boxes.F;
  const auto reach = [&](int p, int k) {
    return std::abs(boxes.F[4 * p + k]) * boxes.half_size[2 * p + k] / boxes.position[2 * p];
  };
  std::vector<double> volume, least;
  for (int p = 0; p < 50; ++p) volume.push_back(Determinant(a.F + 4 * p, 2)), least.push_back(reach(p, 0) * reach(p, 1));
  StraightenBoxes(ModelOf("j2", 2), a);
  int ended = 0;
  for (int p = 0; p < 50; ++p) {
    const bool changed = !std::equal(&F[4 * p], &F[4 * p] + 4, &boxes.F[4 * p]);
    const double most = std::max(reach(p, 0), reach(p, 1));
    EXPECT_NEAR(Determinant(a.F + 4 * p, 2) / volume[p], 1, 1e-13) << "volume";
    EXPECT_LE(most, std::max(1 + 1e-13, least[p] < 1 ? 0 : HUGE_VAL)) << "reach of the edges, of the radius";
    EXPECT_LE(changed ? std::abs(most - std::max(1.0, least[p])) : 0, 1e-13) << "the same of a box that was shortened";
    ended += changed;
  }
  EXPECT_GT(ended, 5);
  EXPECT_LT(ended, 45);
}

/// A slender cone or wedge that passes points at the axis or at a plane of symmetry: none of their faces there comes to the
/// surface.
TEST(Flow, TheAxisIsNoSurface)
{
  constexpr double kAngle = 20, kDepth = 1.3; // degrees, cells
  for (const GeometryKind kind : {GeometryKind::kAxisymmetric, GeometryKind::kPlaneStrain}) {
    Model model;
    model.geometry.kind = kind;
    AddBody(model, CreateBoxRegion({{0, 0}, {3, 4}}), "j2", {1e9, 0.3, 1000, 1e6, 0});
    model.materials[0]->SplitStretched(true);
    model.indenter.emplace();
    model.indenter->surface = CreateCone(kind, kAngle, 0);
    const GridGeometry geometry = {{0, 0}, 1, {8, 8}, 1};
    const BoundaryConditions sides = {{BoundaryKind::kSymmetry, BoundaryKind::kFree, BoundaryKind::kFixed, BoundaryKind::kFree},
                                      {0, 8, 0, 8, 0, 0}};
    Grid grid;
    Points points;
    ASSERT_EQ(grid.Create(PETSC_COMM_SELF, geometry, OneBlock(geometry)), PETSC_SUCCESS);
    ASSERT_EQ(points.Create(PETSC_COMM_SELF, kind, 0, model.materials[0]->Traits().history), PETSC_SUCCESS);
    const Seeding seeding(model, {{geometry}, [](Vec3) { return 0; }, 2}, 0, sides, 0);
    ASSERT_EQ(seeding.Fill(grid.Nodes(), points), PETSC_SUCCESS);
    ExposePoints(model, {geometry, sides}, points, {0, 4 - kDepth});
    const PointArrays a = points.Arrays();
    int exposed = 0;
    for (int p = 0; p < a.count; ++p) {
      const bool at_side = a.position[2 * p] < 0.5, within = a.position[2 * p + 1] < 3.5;
      EXPECT_EQ(at_side ? a.faces[p] & OuterFaceBit(kXLower) : 0, 0) << "at height " << a.position[2 * p + 1];
      exposed += at_side && within && a.faces[p] != 0;
    }
    EXPECT_GE(exposed, 1) << "by their faces upward";
  }
}
