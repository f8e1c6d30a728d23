#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {
namespace {

/// A block of tetrahedra whose control points are random numbers.
class Scene {
 public:
  explicit Scene(int control_points)
      : topology_(block(ElementType::tetrahedron, 3, 3, 3).mesh()),
        motion_(topology_.mesh().vertex_count(), control_points) {
    for (Index v = 0; v < motion_.vertex_count(); ++v)
      for (int c = 0; c < control_points; ++c)
        motion_.set(v, c, {random_.uniform(), random_.uniform(), random_.uniform()});
  }

  Step step() const { return {topology_, motion_, filter_}; }
  const Motion& motion() const { return motion_; }

  std::vector<FeaturePair> pairs(FeatureKind kind, std::size_t count) {
    const Features& f = topology_.features();
    const Index firsts = kind == FeatureKind::vf ? f.vertex_slots() : f.edge_slots();
    const Index seconds = kind == FeatureKind::vf ? f.triangle_slots() : f.edge_slots();
    std::vector<FeaturePair> pairs;
    while (pairs.size() < count) {
      FeaturePair pair{static_cast<Index>(random_.below(firsts)), static_cast<Index>(random_.below(seconds))};
      if (kind == FeatureKind::ee && pair.b < pair.a) std::swap(pair.a, pair.b);
      if (is_test(f, kind, pair)) pairs.push_back(pair);
    }
    return pairs;
  }
  std::vector<std::uint8_t> verdicts(std::size_t count, double share) {
    std::vector<std::uint8_t> keep(count);
    for (auto& k : keep) k = random_.uniform() < share ? 1 : 0;
    return keep;
  }

 private:
  Topology topology_;
  Random random_{1};
  Motion motion_;
  ObjectFilter filter_;
};

void expect_tests(const TestBlock& block, const Step& step, FeatureKind kind, std::span<const FeaturePair> expected) {
  ASSERT_EQ(block.kind(), kind);
  ASSERT_EQ(block.control_points(), step.motion.control_points());
  ASSERT_EQ(std::vector<FeaturePair>(block.pairs().begin(), block.pairs().end()),
            std::vector<FeaturePair>(expected.begin(), expected.end()));
  for (std::size_t i = 0; i < block.size(); ++i) {
    ASSERT_EQ(block.pair(i), expected[i]);
    const auto vertices = test_vertices(step.features(), kind, expected[i]);
    ASSERT_EQ(block.vertices(i), vertices);
    for (int p = 0; p < 4; ++p)
      for (int c = 0; c < block.control_points(); ++c)
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_EQ(block.row(c, p, axis)[i], step.motion.point(vertices[static_cast<std::size_t>(p)], c)[axis])
              << "test " << i << " vertex " << p << " control point " << c << " axis " << axis;
  }
}

std::vector<FeaturePair> kept_of(std::span<const FeaturePair> pairs, std::span<const std::uint8_t> keep) {
  std::vector<FeaturePair> kept;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (keep[i] != 0) kept.push_back(pairs[i]);
  return kept;
}

template <class Body>
void for_each_kind(Body&& body) {
  for (const int control_points : {2, 3})
    for (const auto kind : {FeatureKind::vf, FeatureKind::ee}) {
      Scene scene(control_points);
      body(scene, kind);
    }
}

TEST(TestBlock, GathersEverySizeOnEveryInstructionSet) {
  for_each_kind([](Scene& scene, FeatureKind kind) {
    TestBlock block;
    for (std::size_t n = 0; n <= TestBlock::kCapacity; ++n) {
      const auto pairs = scene.pairs(kind, n);
      cases::InstructionSets().with_each([&](const char* target) {
        SCOPED_TRACE(target);
        block.clear();
        block.gather(scene.step(), kind, pairs);
        expect_tests(block, scene.step(), kind, pairs);
      });
      EXPECT_EQ(block.padded_size() % 8, 0u);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block.row(1, 2, 1)) % 64, 0u);
    }
  });
}

TEST(TestVertices, EdgesInLexicographicOrder) {
  Scene scene(2);
  const Features& features = scene.step().features();
  for (const FeaturePair pair : scene.pairs(FeatureKind::ee, 1000)) {
    auto a = features.edge(pair.a), b = features.edge(pair.b);
    if (b < a) std::swap(a, b);
    EXPECT_EQ(test_vertices(features, FeatureKind::ee, pair), (std::array{a[0], a[1], b[0], b[1]}));
  }
}

TEST(TestBlock, CompactsInPlace) {
  for_each_kind([](Scene& scene, FeatureKind kind) {
    TestBlock block;
    for (const std::size_t n : {0, 1, 7, 8, 50, 64})
      for (const double share : {0.0, 0.02, 0.5, 0.98, 1.0}) {
        const auto pairs = scene.pairs(kind, n);
        block.gather(scene.step(), kind, pairs);
        auto keep = scene.verdicts(block.padded_size(), share);
        std::fill(keep.begin() + static_cast<std::ptrdiff_t>(n), keep.end(), std::uint8_t{1});
        block.compact(keep);
        expect_tests(block, scene.step(), kind, kept_of(pairs, keep));
      }
  });
}

TEST(TestBlock, SurvivorsOfManyBlocksFillAnother) {
  for_each_kind([](Scene& scene, FeatureKind kind) {
    for (const double share : {0.02, 0.5, 1.0}) {
      TestBlock block, survivors;
      std::vector<FeaturePair> expected, collected;
      const auto flush = [&] {
        const auto next = std::span(expected).subspan(collected.size()).first(survivors.size());
        expect_tests(survivors, scene.step(), kind, next);
        collected.insert(collected.end(), survivors.pairs().begin(), survivors.pairs().end());
        survivors.clear();
      };
      for (int round = 0; round < 200; ++round) {
        const auto pairs = scene.pairs(kind, static_cast<std::size_t>(round % 65));
        block.gather(scene.step(), kind, pairs);
        auto keep = scene.verdicts(block.padded_size(), share);
        const auto kept = kept_of(pairs, keep);
        expected.insert(expected.end(), kept.begin(), kept.end());
        for (std::size_t begin = 0; begin < block.size();) {
          begin = survivors.append_kept(block, keep, begin);
          if (survivors.full()) flush();
        }
      }
      flush();
      EXPECT_EQ(collected, expected);
    }
  });
}

TEST(TestBlock, AnEmptyBlockTakesTheKindOfItsTests) {
  Scene two(2), three(3);
  TestBlock block, survivors;
  const auto vf = two.pairs(FeatureKind::vf, 20), ee = three.pairs(FeatureKind::ee, 20);
  const std::vector<std::uint8_t> keep(24, 1);
  block.gather(two.step(), FeatureKind::vf, vf);
  EXPECT_EQ(survivors.append_kept(block, keep), 20u);
  survivors.clear();
  block.gather(three.step(), FeatureKind::ee, ee);
  EXPECT_EQ(survivors.append_kept(block, keep, 5), 20u);
  expect_tests(survivors, three.step(), FeatureKind::ee, std::span(ee).subspan(5));
}

}  // namespace
}  // namespace volccd
