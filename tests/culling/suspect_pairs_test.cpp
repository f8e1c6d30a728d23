// Adjacent simplices that the flood leaves out touch only in their common features.
#include <volccd/culling/detail/suspect_pairs.hpp>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact_predicates.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/ends_in_loop.hpp"
#include "culling/jittered_block.hpp"

namespace volccd::detail {
namespace {

const ObjectFilter kNoFilter;

struct Pair {
  Topology topology;
  Motion motion;
};

/// Two simplices with `common` common vertices at random positions. The other vertices of each are mostly on one side.
Pair random_pair(Random& random, Index common, bool triangle, bool quadratic) {
  Shape shape;
  std::vector<double> sides(common, 0.0);
  for (const double side : {-0.7, 0.7}) {
    ElementSpec element;
    element.type = triangle && side < 0 ? ElementType::triangle : ElementType::tetrahedron;
    element.id = static_cast<std::int64_t>(shape.elements.size());
    for (Index v = 0; v < common; ++v) element.vertices.push_back(v);
    while (element.vertices.size() < (element.type == ElementType::triangle ? 3 : 4)) {
      element.vertices.push_back(static_cast<Index>(sides.size()));
      sides.push_back(side);
    }
    shape.elements.push_back(element);
  }
  const auto vector = [&] { return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); };
  std::vector<Vec3> x[3];
  const double motion = random.uniform();
  for (const double side : sides) {
    x[0].push_back((side == 0 ? 0.3 : 1) * (vector() + Vec3(side, 0, 0)));
    for (int c : {1, 2}) x[c].push_back(x[0].back() + motion * vector());
  }
  shape.positions = x[0];
  return {Topology(shape.mesh()), quadratic ? Motion::quadratic(x[0], x[1], x[2]) : Motion::linear(x[0], x[1])};
}

/// Whether features of the two elements that have no common vertex touch, in exact arithmetic.
bool touch(const Pair& pair) {
  const Features& features = pair.topology.features();
  const auto touches = [&](FeatureKind kind, FeaturePair test) {
    if (!is_test(features, kind, test)) return false;
    TestMotion motion{kind, pair.motion.control_points(), {}};
    const auto vertices = test_vertices(features, kind, test);
    for (std::size_t i = 0; i < 4; ++i) motion.points[i] = pair.motion.at(vertices[i]);
    return exact_first_touch(motion).touches;
  };
  for (const Index v : pair.topology.mesh().vertices(0))
    for (const Index f : features.element_triangles(1))
      if (touches(FeatureKind::vf, {v, f})) return true;
  for (const Index v : pair.topology.mesh().vertices(1))
    for (const Index f : features.element_triangles(0))
      if (touches(FeatureKind::vf, {v, f})) return true;
  for (const Index e : features.element_edges(0))
    for (const Index g : features.element_edges(1))
      if (touches(FeatureKind::ee, {e, g})) return true;
  return false;
}

StarClasses classes_of(const Step& step, Executor& executor) {
  StarTable stars;
  StarClasses classes;
  classes.update(step, stars, stars.update(step.topology, executor), executor);
  return classes;
}

bool is_suspect(const Pair& pair, SuspectPairs& suspects, Executor& executor) {
  const Step step{pair.topology, pair.motion, kNoFilter};
  suspects.update(step, classes_of(step, executor), executor);
  return suspects.contains(0, 1);
}

TEST(SuspectPairs, LeaveOutOnlyWhatDoesNotTouch) {
  SerialExecutor serial;
  SuspectPairs suspects;
  Random random(1);
  std::size_t left_out[3] = {}, apart[3] = {}, touching[3] = {};
  for (int i = 0; i < 6000; ++i) {
    const bool triangle = i % 5 == 0;
    const Index common = i % 2 == 0 || triangle ? 1 : 2;
    const Pair pair = random_pair(random, common, triangle, i % 3 == 0);
    const bool touches = touch(pair), left = !is_suspect(pair, suspects, serial);
    ASSERT_FALSE(touches && left) << "pair " << i;
    left_out[common] += left ? 1 : 0;
    (touches ? touching : apart)[common] += 1;
  }
  for (const Index common : {1, 2}) {
    EXPECT_GT(touching[common], 300u) << common;
    EXPECT_GT(left_out[common], 300u) << common;
    EXPECT_GT(3 * left_out[common], apart[common]) << common;
  }
}

TEST(SuspectPairs, AnInterruptedListLeavesNothingToTheNext) {
  SerialExecutor serial;
  EndsInLoop interrupted(0);
  SuspectPairs suspects;
  const JitteredBlock large(ElementType::tetrahedron, 3, 0.6, 3), small(ElementType::tetrahedron, 1, 0.6, 3);
  EXPECT_THROW(suspects.update(large.step(), classes_of(large.step(), serial), interrupted), std::runtime_error);
  suspects.update(small.step(), classes_of(small.step(), serial), serial);
  for (const ElementPair pair : suspects.pairs()) EXPECT_LT(pair.b, small.topology().mesh().element_slots());
}

/// A change of the topology that was announced to an interrupted step takes effect in the next step.
TEST(StarClasses, AnInterruptedStepIsBegunAnew) {
  SerialExecutor serial;
  const auto suspects = [&](bool interrupted) {
    StarTable stars;
    StarClasses classes;
    for (const int n : {3, 2}) {
      const JitteredBlock block(ElementType::tetrahedron, n, 0.25, 5);
      TopologyDelta::Extent changed = stars.update(block.topology(), serial);
      if (n == 2 && interrupted) {
        EndsInLoop executor(0);
        EXPECT_THROW(classes.update(block.step(), stars, changed, executor), std::runtime_error);
        changed = TopologyDelta::Extent::none;
      }
      classes.update(block.step(), stars, changed, serial);
    }
    return classes.suspects();
  };
  EXPECT_EQ(suspects(true), suspects(false));
}

/// A pair with a clear star at a common vertex is never listed; all other pairs of a star are listed once.
TEST(SuspectPairs, ListEachPairOnce) {
  SerialExecutor serial;
  for (const double amount : {0.01, 0.6}) {
    const JitteredBlock block(ElementType::tetrahedron, 3, amount, 3);
    const StarClasses classes = classes_of(block.step(), serial);
    SuspectPairs suspects;
    suspects.update(block.step(), classes, serial);
    if (amount < 0.1) {
      EXPECT_TRUE(suspects.pairs().empty());
      continue;
    }
    EXPECT_GT(suspects.pairs().size(), 100u);
    std::vector<ElementPair> pairs(suspects.pairs().begin(), suspects.pairs().end());
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
    for (const ElementPair pair : pairs) {
      EXPECT_LE(pair.a, pair.b);
      EXPECT_NE(classes.common_suspects(block.topology(), pair.a, pair.b), 0u);
      EXPECT_TRUE(suspects.contains(pair.b, pair.a));
    }
  }
}

}  // namespace
}  // namespace volccd::detail
