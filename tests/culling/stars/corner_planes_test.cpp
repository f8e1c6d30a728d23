// Pairs of elements that a plane through their common vertex or edge separates touch nowhere else.
#include <volccd/culling/stars/detail/corner_planes.hpp>

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/executor.hpp>
#include <volccd/core/random.hpp>
#include <volccd/culling/stars/suspect_pairs.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/exact_contacts.hpp"
#include "culling/random_vector.hpp"

namespace volccd::detail {
namespace {

const ObjectFilter kAnyObject;

struct Pair {
  Topology topology;
  Motion motion;
};

/// Two elements with one or two common vertices, an edge, at random positions. The other vertices of each are mostly on
/// one side. Everything turns by up to 40 degrees, and vertices move a little by themselves. The edge is sometimes as
/// short as a separation.
Pair random_pair(Random& random, const std::array<ElementType, 2>& types, Index common, bool quadratic) {
  Shape shape;
  std::vector<double> sides(common, 0.0);
  for (const std::size_t e : {0, 1}) {
    ElementSpec element;
    element.type = types[e];
    element.id = static_cast<std::int64_t>(e);
    for (Index v = 0; v < common; ++v) element.vertices.push_back(v);
    while (element.vertices.size() < static_cast<std::size_t>(vertex_count(types[e]))) {
      element.vertices.push_back(static_cast<Index>(sides.size()));
      sides.push_back(e == 0 ? -1 : 1);
    }
    shape.elements.push_back(element);
  }
  std::vector<Vec3> x[3];
  const double edge = random.uniform() < 0.3 ? 0.04 : 1;
  const double distance = random.uniform(0.3, 1), amount = random.uniform(0, 0.3), turn = random.uniform(-0.7, 0.7);
  const Vec3 axis = random_vector(random).normalized();
  for (std::size_t v = 0; v < sides.size(); ++v) {
    const bool is_common = sides[v] == 0;
    const Vec3 place = is_common ? Vec3(0, 0, v == 0 ? 0 : edge) : Vec3(distance * sides[v], 0, 0.5);
    const Vec3 at = place + (is_common ? 0.2 * edge : 1) * random_vector(random);
    x[0].push_back(at);
    for (int c : {1, 2})
      x[c].push_back(Eigen::AngleAxisd(turn * (quadratic ? 0.5 * c : 1), axis) * at + amount * random_vector(random));
  }
  shape.positions = x[0];
  return {Topology(shape.mesh()), quadratic ? Motion::quadratic(x[0], x[1], x[2]) : Motion::linear(x[0], x[1])};
}

/// Whether features of two elements that have no common vertex touch, or come within the separation.
bool elements_touch(const Step& step) {
  bool touch = false;
  visit_touching(step, [&](std::span<const Index> a, std::span<const Index> b) {
    touch = touch || (a.size() == 1 && b.size() == 1 && a[0] != b[0]);
  });
  return touch;
}

bool left_out_of_corners(const Step& step, Index common) {
  CornerPairs pairs;
  std::vector<ElementPair> remaining;
  pairs.begin();
  if (!pairs.add(step, 0, 0, 1, common == 2 ? 1 : kNone)) return false;
  pairs.decide(step, 0, remaining);
  return remaining.empty();
}

/// The same by the list of the flood, which visits the pairs of a star.
bool left_out_of_list(const Step& step) {
  SerialExecutor serial;
  VertexStars stars;
  SuspectPairs suspects;
  stars.update(step, serial);
  suspects.update(step, stars, serial, [](Index, Index) { return true; });
  const std::span<const ElementPair> pairs = suspects.pairs();
  return std::find(pairs.begin(), pairs.end(), ElementPair{0, 1}) == pairs.end();
}

constexpr std::array<std::array<ElementType, 2>, 4> kTypes{{{ElementType::hexahedron, ElementType::hexahedron},
                                                            {ElementType::tetrahedron, ElementType::tetrahedron},
                                                            {ElementType::wedge, ElementType::hexahedron},
                                                            {ElementType::triangle, ElementType::tetrahedron}}};

template <class LeftOut>
void expect_left_out_do_not_touch(std::span<const std::array<ElementType, 2>> types, double max_separation,
                                  LeftOut&& left_out) {
  for (const auto& type : types)
    for (const Index common : {1, 2}) {
      SCOPED_TRACE(to_string(type[0]) + std::string(" and ") + to_string(type[1]) + ", " + std::to_string(common));
      Random random(common);
      std::size_t count = 0;
      for (int i = 0; i < 800; ++i) {
        const bool linear = type[0] == ElementType::hexahedron || type[1] == ElementType::hexahedron || i % 3 != 0;
        const Pair pair = random_pair(random, type, common, !linear);
        const Step step{pair.topology, pair.motion, kAnyObject, max_separation * random.uniform()};
        if (!left_out(step, common)) continue;
        ++count;
        ASSERT_FALSE(elements_touch(step)) << "pair " << i;
      }
      EXPECT_GT(count, 20u);
    }
}

TEST(CornerPairs, LeaveOutOnlyWhatDoesNotTouch) {
  expect_left_out_do_not_touch(kTypes, 0,
                               [](const Step& step, Index common) { return left_out_of_corners(step, common); });
}

TEST(CornerPairs, LeaveOutOnlyWhatStaysApart) {
  expect_left_out_do_not_touch(kTypes, 0.1,
                               [](const Step& step, Index common) { return left_out_of_corners(step, common); });
}

TEST(SuspectPairs, LeaveOutOnlyWhatDoesNotTouch) {
  constexpr std::array simplices{kTypes[1], kTypes[3]};
  expect_left_out_do_not_touch(simplices, 0, [](const Step& step, Index) { return left_out_of_list(step); });
}

/// The motion with each vertex but the first displaced by up to `distance`: those of the first element that are not
/// common towards the second one, those of the second one towards the first one, and the common edge's other vertex
/// to any side.
Motion displaced(const Pair& pair, Index common, double distance, Random& random) {
  const Motion& motion = pair.motion;
  const std::span<const Index> first = pair.topology.mesh().vertices(0);
  const auto in_first = [&](Index v) { return std::find(first.begin(), first.end(), v) != first.end(); };
  Vec3 sums[2] = {Vec3::Zero(), Vec3::Zero()};
  for (Index v = common; v < motion.vertex_count(); ++v)
    for (int c = 0; c < motion.control_points(); ++c) sums[in_first(v) ? 0 : 1] += motion.point(v, c);
  const Vec3 way = (sums[1].normalized() - sums[0].normalized() + 0.7 * random_vector(random)).normalized();
  const Vec3 edge_way = random_vector(random).normalized();
  Motion moved = motion;
  for (Index v = 1; v < motion.vertex_count(); ++v) {
    const Vec3 by = v < common ? edge_way : in_first(v) ? way : Vec3(-way);
    for (int c = 0; c < motion.control_points(); ++c) moved.set(v, c, motion.point(v, c) + distance * by);
  }
  return moved;
}

/// The greatest separation with which a pair is left out, up to `most`.
double greatest_separation(const Pair& pair, Index common, double max) {
  double good = 0, bad = max;
  for (int i = 0; i < 30; ++i) {
    const double middle = (good + bad) / 2;
    (left_out_of_corners({pair.topology, pair.motion, kAnyObject, middle}, common) ? good : bad) = middle;
  }
  return good;
}

// The greatest separation with which a pair is left out is small enough.
TEST(CornerPairs, AreLeftOutUpToASeparationThatMayPartThem) {
  for (const Index common : {1, 2}) {
    Random random(10 + common);
    std::size_t count = 0;
    for (int i = 0; i < 1500; ++i) {
      const Pair pair = random_pair(random, kTypes[1], common, i % 3 == 0);
      if (!left_out_of_corners({pair.topology, pair.motion, kAnyObject}, common)) continue;
      const double separation = greatest_separation(pair, common, 1);
      ++count;
      for (int k = 0; k < 8; ++k) {
        const Motion motion = displaced(pair, common, separation * (1 - 0x1p-20), random);
        ASSERT_FALSE(elements_touch({pair.topology, motion, kAnyObject}))
            << "pair " << i << ", common: " << common << ", separation " << separation;
      }
    }
    EXPECT_GT(count, 100u);
  }
}

/// Two tetrahedra of which one has a vertex that moves in a face of the other, apart from rounding, and otherwise lies
/// on the other side of it: rounding decides whether they touch.
TEST(CornerPairs, AreLeftOutOnlyIfCertain) {
  for (const Index common : {1, 2}) {
    Random random(common);
    std::size_t touching = 0;
    for (int i = 0; i < 3000; ++i) {
      const Pair pair = random_pair(random, kTypes[1], common, false);
      std::vector<Vec3> x;
      for (Index v = 0; v < pair.motion.vertex_count(); ++v) x.push_back(random_vector(random));
      // The first element has the vertices 0 to 3, the second one the common ones and the rest.
      const Vec3 u = x[1] - x[0], w = x[2] - x[0], normal = u.cross(w);
      for (Index v = 3; v < x.size(); ++v) {
        const double side = normal.dot(x[v] - x[0]);
        if (v == 3 ? side > 0 : side < 0) x[v] -= 2 * side / normal.squaredNorm() * normal;
      }
      const auto in_face = [&] { return x[0] + random.uniform(0.2, 0.5) * u + random.uniform(0.2, 0.4) * w; };
      x.back() = in_face();
      std::vector<Vec3> to = x;
      to.back() = in_face();
      const Motion motion = Motion::linear(x, to);
      const Step step{pair.topology, motion, kAnyObject};
      const bool touch = elements_touch(step);
      ASSERT_FALSE(touch && left_out_of_corners(step, common)) << "pair " << i;
      touching += touch ? 1 : 0;
    }
    EXPECT_GT(touching, 100u);
  }
}

/// Planes that turn with the edge, at values near the ends of the range of doubles.
TEST(CornerPairs, AreLeftOutOnlyWithinTheRangeOfDoubles) {
  Random random(7);
  std::size_t left_out[3] = {};
  for (int i = 0; i < 120; ++i) {
    const Pair pair = random_pair(random, kTypes[0], 2, false);
    const std::array<double, 3> scales{1, 0x1p-560, 0x1p600};
    for (std::size_t k = 0; k < 3; ++k) {
      std::vector<Vec3> x[2];
      for (int c : {0, 1})
        for (Index v = 0; v < pair.motion.vertex_count(); ++v) x[c].push_back(scales[k] * pair.motion.point(v, c));
      const Motion motion = Motion::linear(x[0], x[1]);
      left_out[k] += left_out_of_corners({pair.topology, motion, kAnyObject}, 2) ? 1 : 0;
    }
  }
  EXPECT_GT(left_out[0], 5u);
  EXPECT_EQ(left_out[1], 0u);
  EXPECT_EQ(left_out[2], 0u);
}

}  // namespace
}  // namespace volccd::detail
