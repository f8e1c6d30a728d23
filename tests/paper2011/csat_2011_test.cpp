// CSAT as printed, compared with exact arithmetic and with the stage that has rounding bounds.
#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/csat/csat.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/paper2011/csat_2011.hpp>

#include "narrowphase/query_set.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

const ObjectFilter kEverything;

/// All pairs of elements, including adjacent ones; some are swapped.
PairBatch all_pairs(const Mesh& mesh, bool swapped) {
  std::vector<ElementPair> pairs;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b) pairs.push_back(swapped ? ElementPair{b, a} : ElementPair{a, b});
  PairBatch batch;
  batch.assign(pairs);
  return batch;
}

bool touch(const Step& step, FeatureKind kind, FeaturePair pair) {
  TestMotion motion{kind, 2, {}};
  const auto vertices = test_vertices(step.features(), kind, pair);
  for (std::size_t i = 0; i < 4; ++i) motion.points[i] = step.motion.at(vertices[i]);
  return exact_first_touch(motion).touches;
}

bool vertex_touches(const Step& step, Index v, Index element) {
  for (const Index f : step.features().element_triangles(element))
    if (!is_test(step.features(), FeatureKind::vf, {v, f}) || touch(step, FeatureKind::vf, {v, f})) return true;
  return false;
}

bool edge_touches(const Step& step, Index e, Index element) {
  for (const Index g : step.features().element_edges(element)) {
    const FeaturePair pair = {std::min(e, g), std::max(e, g)};
    if (!is_test(step.features(), FeatureKind::ee, pair) || touch(step, FeatureKind::ee, pair)) return true;
  }
  return false;
}

struct Culled {
  std::size_t vertices = 0, edges = 0, pairs = 0;
};

/// Checks that no masked feature of a pair (no feature at all if the pair was dropped) touches the other element.
void expect_apart(const Step& step, ElementPair pair, const FeatureMask& mask, bool dropped, Culled& culled) {
  const auto check = [&](std::span<const Index> features, std::uint64_t bits, Index other, auto touches,
                         std::size_t& count) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!dropped && (bits >> i & 1) == 0) continue;
      ++count;
      EXPECT_FALSE(touches(step, features[i], other));
    }
  };
  check(step.mesh().vertices(pair.a), mask.vertices_a, pair.b, vertex_touches, culled.vertices);
  check(step.mesh().vertices(pair.b), mask.vertices_b, pair.a, vertex_touches, culled.vertices);
  check(step.features().element_edges(pair.a), mask.edges_a, pair.b, edge_touches, culled.edges);
  culled.pairs += dropped ? 1 : 0;
}

TEST(Csat2011, CullsOnlyWhatDoesNotTouch) {
  const auto stage = describe_csat_2011().make({});
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge}) {
    const cases::Scene scene = cases::colliding(to_string(type), block(type, 3, 2, 1), 5, 0.05);
    const Step step{scene.topology, scene.motion, kEverything};
    PairBatch batch = all_pairs(step.mesh(), type == ElementType::wedge);
    run_stage(*stage, step, batch);
    Culled culled;
    for (std::size_t i = 0; i < batch.contact_free.size(); i += 3)
      expect_apart(step, batch.contact_free[i], {}, true, culled);
    for (std::size_t i = 0; i < batch.size(); i += 3) expect_apart(step, batch.pairs[i], batch.masks[i], false, culled);
    // Edges of a grid of hexahedra or wedges are nearly parallel, so that few of their cross products are useful axes.
    EXPECT_TRUE(culled.pairs > 3 || type != ElementType::tetrahedron);
    EXPECT_GT(culled.vertices, 20u) << scene.name;
    EXPECT_GT(culled.edges, 20u) << scene.name;
  }
}

TEST(Csat2011, CullsWhatCsatDoesWhereRoundingDoesNotMatter) {
  const auto plain = describe_csat_2011().make({});
  const auto bounded = describe_csat().make({{"axis", "face"}, {"mode", "features"}});
  std::size_t dropped = 0;
  for (const cases::Scene& scene : cases::small_scenes(8, 0.2)) {
    const Step step{scene.topology, scene.motion, kEverything};
    PairBatch found = all_pairs(step.mesh(), false), expected = found;
    run_stage(*plain, step, found);
    run_stage(*bounded, step, expected);
    EXPECT_EQ(found.pairs, expected.pairs) << scene.name;
    EXPECT_EQ(found.contact_free, expected.contact_free) << scene.name;
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      const FeatureMask &x = found.masks[i], &y = expected.masks[i];
      ASSERT_EQ(x.vertices_a, y.vertices_a) << scene.name;
      ASSERT_EQ(x.vertices_b, y.vertices_b) << scene.name;
      ASSERT_EQ(x.edges_a, y.edges_a) << scene.name;
      ASSERT_EQ(x.edges_b, 0u);
    }
    dropped += found.contact_free.size();
  }
  EXPECT_GT(dropped, 20u);
}

TEST(Csat2011, CullsNothingThatItWasNotMadeFor) {
  const cases::Scene scene = cases::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 1, 1), 5, 0.1);
  Motion curved(scene.motion.vertex_count(), 3);
  for (Index v = 0; v < curved.vertex_count(); ++v)
    for (int c = 0; c < 3; ++c) curved.set(v, c, scene.motion.position(v, 0.5 * c));
  const auto stage = describe_csat_2011().make({});
  const auto filter = describe_csat_filter_2011().make({});
  const Step with_separation{scene.topology, scene.motion, kEverything, 0.01};
  const Step on_curves{scene.topology, curved, kEverything};
  for (const Step& step : {with_separation, on_curves}) {
    PairBatch batch = all_pairs(step.mesh(), false);
    const std::size_t before = batch.size();
    run_stage(*stage, step, batch);
    EXPECT_EQ(batch.size(), before);
    for (const FeatureMask& mask : batch.masks)
      ASSERT_EQ(mask.vertices_a | mask.vertices_b | mask.edges_a | mask.edges_b, 0u);
    TestBlock block;
    const Index last = step.mesh().element_slots() - 1;
    const FeaturePair pair = {step.features().element_edges(0)[0], step.features().element_edges(last)[0]};
    block.gather(step, FeatureKind::ee, {&pair, 1});
    std::vector<std::uint8_t> keep(block.padded_size(), 1);
    run_stage(*filter, step, block, keep);
    EXPECT_EQ(keep[0], 1);
  }
}

/// Whether feature-csat-2011 keeps the tests.
std::vector<std::uint8_t> kept(const QuerySet& set) {
  const auto filter = describe_csat_filter_2011().make({});
  std::vector<std::uint8_t> all;
  const Step step = set.step();
  TestBlock block;
  for (auto rest = set.pairs(); !rest.empty(); rest = rest.subspan(block.size())) {
    block.gather(step, set.kind(), rest.first(std::min(rest.size(), TestBlock::kCapacity)));
    std::vector<std::uint8_t> keep(block.padded_size(), 1);
    run_stage(*filter, step, block, keep);
    all.insert(all.end(), keep.begin(), keep.begin() + static_cast<std::ptrdiff_t>(block.size()));
  }
  return all;
}

TEST(CsatFilter2011, DropsOnlyWhatDoesNotTouch) {
  Random random(41);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::vector<Query> queries(4000);
    for (Query& q : queries)
      for (std::size_t i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) q[i][k] = i < 4 ? random.uniform(-1, 1) : q[i - 4][k] + random.uniform(-0.3, 0.3);
    const QuerySet set(kind, queries);
    const std::vector<std::uint8_t> keep = kept(set);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < keep.size(); ++i) {
      if (keep[i]) continue;
      ++dropped;
      ASSERT_FALSE(touch(set.step(), kind, set.pairs()[i])) << i;
    }
    EXPECT_GT(dropped, 400u);
    EXPECT_LT(dropped, 3900u);
  }
}

TEST(CsatFilter2011, ZeroCountsAsNotSeparated) {
  // The vertex is in the plane of the triangle at t = 0 or at t = 1, and apart from it at other times.
  const std::array<Vec3, 3> f = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  std::vector<Query> queries;
  for (const auto& [from, to] : {std::pair{0.0, 1.0}, {1.0, 0.0}, {0.5, 1.0}})
    queries.push_back({Vec3(0.25, 0.25, from), f[0], f[1], f[2], Vec3(0.25, 0.25, to), f[0], f[1], f[2]});
  EXPECT_EQ(kept(QuerySet(FeatureKind::vf, queries)), (std::vector<std::uint8_t>{1, 1, 0}));
  for (Query& q : queries)  // two edges that cross in the projection along z
    for (std::size_t i : {0u, 4u}) {
      const double z = q[i].z();
      q[i] = Vec3(-1, 0, z), q[i + 1] = Vec3(1, 0, z), q[i + 2] = Vec3(0, -1, 0), q[i + 3] = Vec3(0, 1, 0);
    }
  EXPECT_EQ(kept(QuerySet(FeatureKind::ee, queries)), (std::vector<std::uint8_t>{1, 1, 0}));
}

}  // namespace
}  // namespace volccd::test
