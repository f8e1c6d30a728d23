// Adjacent pairs of elements that are left out touch only in their common features.
#include <volccd/culling/stars/suspect_pairs.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/stars/suspect_orphans.hpp>
#include "culling/stars/ends_in_loop.hpp"
#include "culling/stars/jittered_block.hpp"

namespace volccd::detail {
namespace {

constexpr auto kAlways = [](Index, Index) { return true; };

void update(SuspectPairs& pairs, const Step& step, Executor& executor) {
  SerialExecutor serial;
  VertexStars stars;
  stars.update(step, serial);
  pairs.update(step, stars, executor, kAlways);
}

TEST(SuspectPairs, AnInterruptedListLeavesNothingToTheNext) {
  SerialExecutor serial;
  EndsInLoop interrupted(0);
  SuspectPairs suspects;
  const JitteredBlock large(ElementType::tetrahedron, 3, 0.6, 3), small(ElementType::tetrahedron, 1, 0.6, 3);
  EXPECT_THROW(update(suspects, large.step(), interrupted), std::runtime_error);
  update(suspects, small.step(), serial);
  for (const ElementPair pair : suspects.pairs()) EXPECT_LT(pair.b, small.topology().mesh().element_slots());
}

/// A pair with a clear star at a common vertex is never listed, nor one tetrahedron whose volume has a sign, nor two
/// with a common face and the same sign; all other pairs that no plane separates are listed once.
TEST(SuspectPairs, ListEachPairOnce) {
  SerialExecutor serial;
  for (const double amount : {0.01, 0.6}) {
    const JitteredBlock block(ElementType::tetrahedron, 3, amount, 3);
    const Mesh& mesh = block.topology().mesh();
    VertexStars stars;
    stars.update(block.step(), serial);
    SuspectPairs suspects;
    suspects.update(block.step(), stars, serial, kAlways);
    if (amount < 0.1) {
      EXPECT_TRUE(suspects.pairs().empty());
      continue;
    }
    std::vector<ElementPair> pairs(suspects.pairs().begin(), suspects.pairs().end());
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
    std::size_t listed = 0;
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b) {
        std::size_t common = 0, clear = 0;
        for (const Index v : mesh.vertices(a))
          if (const auto of_b = mesh.vertices(b); std::find(of_b.begin(), of_b.end(), v) != of_b.end())
            ++common, clear += stars.suspect(v) ? 0 : 1;
        const bool is_listed = std::binary_search(pairs.begin(), pairs.end(), ElementPair{a, b});
        const bool one_sign = stars.volume_sign(a) * stars.volume_sign(b) == 1;
        listed += is_listed ? 1 : 0;
        if (common == 0 || clear > 0 || (common >= 3 && one_sign)) {
          EXPECT_FALSE(is_listed) << a << ' ' << b;
        } else if (common >= 3) {
          EXPECT_TRUE(is_listed) << a << ' ' << b;
        }
      }
    EXPECT_EQ(listed, pairs.size());
    EXPECT_GT(listed, 100u);
  }
}

/// Orphans whose features' boxes meet, by whether their reference point is in the region.
TestBatch orphans_in(const Step& step, const TestBatch& orphans, const Region& region) {
  const auto box_of = [&](std::span<const Index> vertices) {
    MotionBox box;
    extend(box, step.motion, vertices, step.motion.control_points());
    return enlarged(box, step.separation);
  };
  const auto belongs = [&](std::span<const Index> a, std::span<const Index> b) {
    const MotionBox of_a = box_of(a), of_b = box_of(b);
    const Vec3 point = of_a.low.cwiseMax(of_b.low);
    return (point.array() <= of_a.high.cwiseMin(of_b.high).array()).all() && region.contains(point);
  };
  TestBatch found;
  const Features& features = step.features();
  for (const FeaturePair t : orphans.vf)
    if (belongs({&t.a, 1}, features.triangle(t.b))) found.vf.push_back(t);
  for (const FeaturePair t : orphans.ee)
    if (belongs(features.edge(t.a), features.edge(t.b))) found.ee.push_back(t);
  std::sort(found.vf.begin(), found.vf.end());
  std::sort(found.ee.begin(), found.ee.end());
  return found;
}

/// The orphans of a region are all those of the whole step that belong to it.
TEST(SuspectPairs, OfARegionHaveAllItsOrphans) {
  SerialExecutor serial;
  const auto orphans_of = [&](const Step& step, std::size_t& pairs) {
    SuspectPairs suspects;
    update(suspects, step, serial);
    pairs += suspects.pairs().size();
    SuspectOrphans orphans;
    orphans.update(step.topology, suspects.pairs(), serial);
    TestBatch tests;
    for (std::size_t b = 0; b < orphans.blocks(); ++b) orphans.append(b, tests);
    return tests;
  };
  Random random(5);
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron})
    for (const double separation : {0.0, 0.2}) {
      const JitteredBlock block(type, 3, 0.6, 7);
      Step step = block.step(separation);
      std::size_t all_pairs = 0, pairs = 0, belong = 0;
      const TestBatch all = orphans_of(step, all_pairs);
      for (int trial = 0; trial < 20; ++trial) {
        step.piece.region = {};
        for (int i = 0; i < 3; ++i) {
          const double cut = random.uniform(0, 3);  // at a vertex now and then
          (random.below(2) == 0 ? step.piece.region.low : step.piece.region.high)[i] =
              trial % 4 == 0 ? std::round(cut) : cut;
        }
        const TestBatch expected = orphans_in(step, all, step.piece.region);
        const TestBatch found = orphans_in(step, orphans_of(step, pairs), step.piece.region);
        EXPECT_EQ(found.vf, expected.vf) << trial;
        EXPECT_EQ(found.ee, expected.ee) << trial;
        belong += expected.size();
      }
      EXPECT_GT(belong, 50u);
      EXPECT_LT(pairs, all_pairs * 20 / 2) << "of an eighth of the block";
    }
}

}  // namespace
}  // namespace volccd::detail
