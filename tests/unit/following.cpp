// Boxes around a contact and along paths.
#include "hierarchy/following.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace mlgimp;

namespace
{

/// Five levels in the plane, cells of 16 m at the coarsest and 1 m at the finest, the surface at 1000 m.
LevelRules Rules(int dim = 2)
{
  LevelRules rules;
  rules.domain = {{0, 0, 0}, {1280, 1280, dim == 3 ? 1280.0 : 0.0}};
  rules.cell_size = 16, rules.dim = dim, rules.levels = 5, rules.border_cells = 3;
  rules.blend_widths.assign(4, 4.0);
  return rules;
}

FollowSettings Contact()
{
  FollowSettings settings;
  settings.kind = FollowKind::kContact;
  settings.margins.resize(5), settings.paths.resize(5);
  return settings;
}

ContactPlace At(double x, double half_width, int dim = 2)
{
  ContactPlace place;
  place.tip = dim == 3 ? Vec3{x, x, 1000 - half_width / 2} : Vec3{x, 1000 - half_width / 2, 0};
  place.half_width = place.reach = half_width, place.surface = place.top = 1000;
  return place;
}

/// Each box in the next coarser one as deep as its border needs, on its cell lines, around the contact.
void ExpectSound(const LevelRules &rules, const std::vector<Box> &boxes, const ContactPlace &place, int active)
{
  EXPECT_EQ(FindMisplaced(rules, boxes), 0);
  for (int k = 1; k < rules.levels; ++k)
    for (int axis = 0; axis < rules.dim; ++axis) {
      const double cell = rules.CellSize(k - 1), lower = boxes[k].lower[axis] / cell, upper = boxes[k].upper[axis] / cell;
      EXPECT_EQ(lower, std::round(lower));
      EXPECT_EQ(upper, std::round(upper));
      if (axis == rules.dim - 1 || k >= active) continue;
      const double left = place.tip[axis] - place.reach - boxes[k].lower[axis];
      const double right = boxes[k].upper[axis] - place.tip[axis] - place.reach;
      const double needed = std::max(rules.Border(k), 0.6 * place.half_width) - 1e-9;
      EXPECT_TRUE(left >= needed || boxes[k].lower[axis] == 0) << left;
      EXPECT_TRUE(right >= needed || boxes[k].upper[axis] == 1280) << right;
    }
}

} // namespace

TEST(Following, boxes_hold_the_contact_and_each_other)
{
  for (int dim : {2, 3})
    for (double x : {0.0, 17.3, 600.0, 1279.0})
      for (double half_width : {0.0, 3.0, 40.0, 200.0})
        for (int active = 1; active <= 5; ++active)
          ExpectSound(Rules(dim), BoxesAround(Rules(dim), Contact(), At(x, half_width, dim), active), At(x, half_width, dim),
                      active);
}

TEST(Following, boxes_lie_on_a_side_of_the_domain_or_four_cells_from_it)
{
  const LevelRules rules = Rules();
  for (double x = 0; x < 400; x += 1.7) {
    const std::vector<Box> boxes = BoxesAround(rules, Contact(), At(x, 10), 5);
    for (int k = 1; k < 5; ++k) EXPECT_TRUE(boxes[k].lower[0] == 0 || boxes[k].lower[0] >= 4 * rules.CellSize(k - 1)) << x;
  }
}

TEST(Following, contact_that_grows_by_decades_ends_levels_and_moves_seldom)
{
  const LevelRules rules = Rules();
  const BoxPlan whole{std::vector<Box>(5, rules.domain), 5};
  BoxPlan plan, next;
  int moves = 0, ends = 0;
  ASSERT_TRUE(FollowContact(rules, Contact(), At(600, 0), whole, &plan)) << "from the whole domain to the tip";
  for (double half_width = 0.1; half_width < 400; half_width *= 1.01)
    if (const ContactPlace place = At(600, half_width); FollowContact(rules, Contact(), place, plan, &next)) {
      ++moves, ends += next.active < plan.active;
      EXPECT_LE(next.active, plan.active) << "a level that ends does not come back while the contact grows";
      plan = next;
      ExpectSound(rules, plan.boxes, place, plan.active);
      EXPECT_FALSE(FollowContact(rules, Contact(), place, plan, &next)) << "nothing to do twice";
    }
  EXPECT_EQ(plan.active, 2) << "64 cells of 8 m are more than 400 m, 64 of 4 m are fewer";
  EXPECT_EQ(ends, 3);
  EXPECT_LE(moves, 30) << "a quarter more each time";
  for (double half_width = 400; half_width > 1; half_width /= 1.01)
    if (FollowContact(rules, Contact(), At(600, half_width), plan, &next)) plan = next;
  EXPECT_EQ(plan.active, 5) << "on the way back levels begin";
}

TEST(Following, margins_are_cells_of_their_level)
{
  FollowSettings settings = Contact();
  settings.margins[4] = {30, 50};
  const std::vector<Box> boxes = BoxesAround(Rules(), settings, At(600, 20), 5);
  EXPECT_EQ(boxes[4].lower[0], 550) << "600 - 20 - 30, on lines of 2 m";
  EXPECT_EQ(boxes[4].upper[0], 650);
  EXPECT_EQ(boxes[4].lower[1], 940) << "the tip at 990, less 50";
}

TEST(Following, paths_move_boxes_by_whole_cells)
{
  const LevelRules rules = Rules();
  FollowSettings settings = Contact();
  settings.kind = FollowKind::kPath;
  settings.start = {rules.domain,
                    {{288, 288, 0}, {672, 672, 0}},
                    {{384, 384, 0}, {576, 576, 0}},
                    {{432, 432, 0}, {528, 528, 0}},
                    {{456, 456, 0}, {504, 504, 0}}};
  settings.paths[4][0] = PiecewiseLinear({0, 1}, {0, 10});
  BoxPlan next;
  const BoxPlan now{settings.start, 5};
  EXPECT_EQ(FindMisplaced(rules, settings.start), 0);
  EXPECT_FALSE(FollowPath(rules, settings, 0.09, now, &next)) << "less than half a cell of the coarser level";
  ASSERT_TRUE(FollowPath(rules, settings, 0.31, now, &next));
  EXPECT_EQ(next.boxes[4].lower[0], 460) << "3.1 m are nearest to 2 cells of 2 m";
  EXPECT_EQ(next.boxes[4].upper[0], 508);
  EXPECT_EQ(next.boxes[4].lower[1], 456);
  settings.paths[4][0] = PiecewiseLinear({0, 1}, {0, 100});
  ASSERT_TRUE(FollowPath(rules, settings, 1, now, &next));
  EXPECT_EQ(FindMisplaced(rules, next.boxes), 4) << "out of level 3";
  settings.paths[1][1] = PiecewiseLinear({0, 1}, {0, -400});
  ASSERT_TRUE(FollowPath(rules, settings, 1, now, &next));
  EXPECT_EQ(FindMisplaced(rules, next.boxes), 1) << "out of the domain";
}
