#include <gtest/gtest.h>

#include <cmath>

#include <volccd/simulation/topology/element_cutting.hpp>

#include "edit_checks.hpp"

namespace volccd::simulation {
namespace {

constexpr double kSnap = 0.15;

/// The plane z = 1.37 through a block of 4 x 3 x 3, with the blade starting at x = -1.
Cut level_cut() {
  Cut cut;
  cut.point = Vec3(-1, 0, 1.37);
  cut.length = 100;
  return cut;
}

/// A plane near the middle of a block of that size, rotated at random, with the blade starting outside.
Cut random_cut(Random& random) {
  Cut cut;
  cut.direction = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
  cut.normal = cut.direction.unitOrthogonal();
  cut.point = Vec3(2, 1.5, 1.5) + random.uniform(-0.5, 0.5) * cut.normal - 4 * cut.direction;
  cut.length = 100;
  return cut;
}

MovingMesh random_block(std::uint64_t seed) {
  Shape shape = permuted(block(ElementType::tetrahedron, 4, 3, 3), seed);
  shape.positions = jittered(shape.positions, 0.05, seed);
  MovingMesh body(shape);
  Random random(seed);
  for (Vec3& v : body.v) v = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return body;
}

void expect_sound(const MovingMesh& body, double volume, double area, const Cut& cut, double depth) {
  EXPECT_NEAR(total_volume(body), volume, 1e-12 * volume);
  EXPECT_GT(min_volume(body), 0);
  const Boundary boundary = boundary_of(body);
  EXPECT_LE(boundary.max_elements, 2);
  EXPECT_TRUE(boundary.pairs);
  // A face that does not match a face of its neighbour would be on the boundary, and count as an outer face.
  EXPECT_NEAR(boundary.outer_area, area, 1e-10 * area);
  for (const auto& face : boundary.parted)
    for (const Vec3& corner : face) {
      EXPECT_LT(std::abs((corner - cut.point).dot(cut.normal)), 0.6);
      EXPECT_LT((corner - cut.point).dot(cut.direction), depth + 1e-6);
    }
}

TEST(ElementCutting, FullCutPartsABlockOfAnyShapeInTwo) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    MovingMesh body = random_block(seed);
    Random random(seed);
    const Cut cut = random_cut(random);
    const double volume = total_volume(body), area = boundary_of(body).outer_area;
    const double min = std::pow(kSnap, 3) * min_volume(body);
    const Vec3 before = momentum(body, tet_masses(body));
    const TopologyProposal proposal = propose_cut(body.topology, body.x, cut, cut.length, kSnap);
    EXPECT_FALSE(proposal.shapes_of_parents);
    body.apply(proposal);
    expect_sound(body, volume, area, cut, cut.length);
    EXPECT_EQ(components(body).size(), 2u);
    EXPECT_GT(min_volume(body), min) << "a tetrahedron is bisected three times at most, none of them near its end";
    for (const auto& half : components(body)) EXPECT_EQ(euler_characteristic(body, half), 1);
    EXPECT_NEAR((momentum(body, tet_masses(body)) - before).norm(), 0, 1e-12 * volume);
    EXPECT_TRUE(propose_cut(body.topology, body.x, cut, cut.length, kSnap).empty());
    EXPECT_LT(body.mesh().element_count(), 3 * 216u);
  }
}

TEST(ElementCutting, BladeThatAdvancesPartsWhatItHasPassed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    MovingMesh body = random_block(seed);
    Random random(seed);
    const Cut cut = random_cut(random);
    const double volume = total_volume(body), area = boundary_of(body).outer_area;
    const double min = std::pow(kSnap, 3) * min_volume(body);
    double parted = 0;
    bool partly = false;
    for (double depth = 0; depth < 8; depth += 0.47) {
      SCOPED_TRACE(depth);
      body.apply(propose_cut(body.topology, body.x, cut, depth, kSnap));
      expect_sound(body, volume, area, cut, depth);
      EXPECT_TRUE(propose_cut(body.topology, body.x, cut, depth, kSnap).empty());
      EXPECT_GT(min_volume(body), min);
      const double now = boundary_of(body).parted_area;
      EXPECT_GE(now, parted - 1e-12);
      partly |= now > parted && components(body).size() == 1;
      parted = now;
    }
    EXPECT_TRUE(partly);
    EXPECT_EQ(components(body).size(), 2u);
    EXPECT_LT(body.mesh().element_count(), 3 * 216u);
  }
}

TEST(ElementCutting, WithoutSnappingTheSidesAreTheHalfSpaces) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    MovingMesh body = random_block(seed);
    Random random(seed);
    const Cut cut = random_cut(random);
    body.apply(propose_cut(body.topology, body.x, cut, cut.length, 0));
    const auto sides = components(body);
    ASSERT_EQ(sides.size(), 2u);
    double extent[2][2] = {{1, -1}, {1, -1}};
    for (std::size_t s = 0; s < 2; ++s)
      for (Index o : sides[s])
        for (Index v : body.mesh().vertices(o)) {
          const double d = (body.x[v] - cut.point).dot(cut.normal);
          extent[s][0] = std::min(extent[s][0], d), extent[s][1] = std::max(extent[s][1], d);
        }
    const std::size_t lower = extent[0][0] < extent[1][0] ? 0 : 1;
    EXPECT_LT(extent[lower][1], 1e-12);
    EXPECT_GT(extent[1 - lower][0], -1e-12);
  }
}

TEST(ElementCutting, PartedAreaIsThatOfTheSection) {
  MovingMesh body(block(ElementType::tetrahedron, 4, 3, 3));
  body.apply(propose_cut(body.topology, body.x, level_cut(), 100, 0.3));
  EXPECT_NEAR(boundary_of(body).parted_area, 2 * 12, 1e-12);

  // The plane contains a layer of vertices: nothing is subdivided, but the sides separate.
  Cut through = level_cut();
  through.point.z() = 2;
  MovingMesh layers(block(ElementType::tetrahedron, 4, 3, 3));
  layers.apply(propose_cut(layers.topology, layers.x, through, 100, 0.3));
  EXPECT_EQ(layers.mesh().element_count(), 216u);
  EXPECT_NEAR(boundary_of(layers).parted_area, 2 * 12, 1e-12);
  EXPECT_EQ(components(layers).size(), 2u);
}

TEST(ElementCutting, PartialCutEndsBehindTheEdge) {
  MovingMesh body(block(ElementType::tetrahedron, 4, 3, 3));
  body.apply(propose_cut(body.topology, body.x, level_cut(), 3.2, kSnap));  // the edge is at x = 2.2
  EXPECT_EQ(components(body).size(), 1u);
  const double half = boundary_of(body).parted_area / 2;
  EXPECT_LT(half, 2.2 * 3);
  EXPECT_GT(half, 1.2 * 3);  // less than an element behind
}

TEST(ElementCutting, CrossingCutsMakeFourQuarters) {
  MovingMesh body = random_block(7);
  const double volume = total_volume(body);
  Cut second = level_cut();
  second.normal = Vec3(0, 0.8, 0.6), second.point = Vec3(-1, 1.4, 1.4);
  for (double depth = 0; depth < 8; depth += 0.61)
    for (const Cut& cut : {level_cut(), second}) body.apply(propose_cut(body.topology, body.x, cut, depth, kSnap));
  EXPECT_EQ(components(body).size(), 4u);
  EXPECT_NEAR(total_volume(body), volume, 1e-12 * volume);
  EXPECT_GT(min_volume(body), 0);
  // The second cut divides both sides of the first one, each by its own numbering, so that they need not match any
  // more.
  for (const auto& quarter : components(body)) EXPECT_EQ(euler_characteristic(body, quarter), 1);
}

TEST(ElementCutting, PiecesKnowTheirParents) {
  MovingMesh body = random_block(3);
  std::vector<double> before;
  const auto ids = by_id(body);
  for (Index o : body.elements()) before.push_back(tet_volume(body, o));
  const TopologyProposal proposal = propose_cut(body.topology, body.x, level_cut(), 100, kSnap);
  body.apply(proposal);
  const ElementHeritage heritage = heritage_of(proposal, body.mesh());
  ASSERT_EQ(heritage.added.size(), proposal.edit.added.size());
  std::map<Index, double> volume;
  for (std::size_t i = 0; i < heritage.added.size(); ++i)
    volume[heritage.parents[i]] += tet_volume(body, heritage.added[i]);
  EXPECT_EQ(volume.size(), heritage.removed.size());
  for (const auto& [parent, sum] : volume) EXPECT_NEAR(sum, before[parent], 1e-14);
  for (const auto& [id, vertices] : ids) EXPECT_NE(body.mesh().find_element(id), kNone) << "one piece keeps the id";
}

TEST(ElementCutting, CutsOneObjectOnly) {
  const Shape one = block(ElementType::tetrahedron, 2, 2, 2);
  Shape two;
  two.append(one, 0).append(Shape(one).translate(Vec3(5, 0, 0)), 1).append(block(ElementType::hexahedron, 1, 1, 3), 2);
  MovingMesh body(two);
  Cut cut = level_cut();
  cut.object = 1;
  body.apply(propose_cut(body.topology, body.x, cut, 100, kSnap));
  EXPECT_EQ(components(body).size(), 4u);
  cut.object = 2;
  EXPECT_THROW(propose_cut(body.topology, body.x, cut, 100, kSnap), InputError);
  EXPECT_THROW(propose_cut(body.topology, body.x, cut, 100, 0.5), ConfigError);

  Shape joined = one;
  for (std::size_t i = 0; i < joined.elements.size(); i += 2) joined.elements[i].object = 1;
  const MovingMesh mixed(joined);
  EXPECT_THROW(propose_cut(mixed.topology, mixed.x, cut = level_cut(), 100, kSnap), InputError);
}

TEST(ElementCutting, DepthFollowsTime) {
  Cut cut;
  cut.begin = 2, cut.speed = 3, cut.length = 4;
  EXPECT_EQ(covered_depth(cut, 1), 0);
  EXPECT_EQ(covered_depth(cut, 3), 3);
  EXPECT_EQ(covered_depth(cut, 30), 4);
}

}  // namespace
}  // namespace volccd::simulation
