// Orphans of suspect pairs: those that the definition gives, after any sequence of suspects and edits.
#include <volccd/culling/stars/suspect_orphans.hpp>

#include <algorithm>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/shell_neighbours.hpp>

#include "culling/stars/ends_in_loop.hpp"
#include "culling/topology_editor.hpp"

namespace volccd::detail {
namespace {

using Pairs = std::vector<ElementPair>;

/// The pairs of elements, each with itself too, all of whose common vertices are suspect; but without a part of them.
Pairs suspect_pairs(const Topology& topology, const std::vector<std::uint8_t>& suspect, Index left_out) {
  const Mesh& mesh = topology.mesh();
  Pairs pairs;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b) {
      if (!mesh.is_live(a) || !mesh.is_live(b) || (a + 3 * b) % 11 < left_out) continue;
      bool common = false, all = true;
      for (const Index v : mesh.vertices(a))
        if (const auto of_b = mesh.vertices(b); std::find(of_b.begin(), of_b.end(), v) != of_b.end())
          common = true, all = all && suspect[v] != 0;
      if (common && all) pairs.push_back({a, b});
    }
  return pairs;
}

/// By definition: all tests of which all pairs of incident elements are given.
TestBatch orphans_of(const Features& features, const Pairs& pairs) {
  const std::set<ElementPair> given(pairs.begin(), pairs.end());
  const auto all_given = [&](std::span<const Index> of_a, std::span<const Index> of_b) {
    for (const Index x : of_a)
      for (const Index y : of_b)
        if (!given.contains({std::min(x, y), std::max(x, y)})) return false;
    return !of_a.empty() && !of_b.empty();
  };
  TestBatch tests;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (all_given(features.vertex_elements(v), features.triangle_elements(f)) &&
          is_test(features, FeatureKind::vf, {v, f}))
        tests.vf.push_back({v, f});
  for (Index e = 0; e < features.edge_slots(); ++e)
    for (Index g = e + 1; g < features.edge_slots(); ++g)
      if (all_given(features.edge_elements(e), features.edge_elements(g)) && is_test(features, FeatureKind::ee, {e, g}))
        tests.ee.push_back({e, g});
  return tests;
}

TestBatch all_of(const SuspectOrphans& orphans) {
  TestBatch tests;
  for (std::size_t block = 0; block < orphans.blocks(); ++block) orphans.append(block, tests);
  std::sort(tests.vf.begin(), tests.vf.end());
  std::sort(tests.ee.begin(), tests.ee.end());
  return tests;
}

/// The mesh need not be one of thickened shells: the rule is one of slots.
TestBatch without_shell_neighbours(const Features& features, TestBatch tests) {
  const auto remove = [&](FeatureKind kind, std::vector<FeaturePair>& pairs) {
    std::erase_if(pairs, [&](FeaturePair p) { return share_shell_vertex(kind, test_vertices(features, kind, p)); });
  };
  remove(FeatureKind::vf, tests.vf);
  remove(FeatureKind::ee, tests.ee);
  return tests;
}

void expect_same(const TestBatch& found, const TestBatch& expected, int round) {
  EXPECT_EQ(found.vf, expected.vf) << round;
  EXPECT_EQ(found.ee, expected.ee) << round;
}

/// Suspects that change a little, not at all, or altogether, with and without edits of the topology.
void expect_orphans_follow(Mesh mesh, std::vector<ElementType> types, std::uint64_t seed, int rounds) {
  Topology topology(std::move(mesh));
  TopologyEditor editor(topology, seed, std::move(types));
  Random& random = editor.random();
  const auto threads = make_thread_executor(3);
  SerialExecutor serial;
  SuspectOrphans kept;
  std::vector<std::uint8_t> suspect;
  std::size_t orphans = 0;
  for (int round = 0; round < rounds; ++round) {
    suspect.resize(topology.features().vertex_slots(), 1);
    const std::uint64_t flips = random.below(8) == 0 ? suspect.size() : random.below(4);
    for (std::uint64_t i = 0; i < flips; ++i) suspect[random.below(suspect.size())] = random.below(4) != 0;
    Pairs pairs = suspect_pairs(topology, suspect, random.below(3) == 0 ? 1 : 0);
    const TestBatch expected = orphans_of(topology.features(), pairs);
    for (std::size_t i = pairs.size(); i > 1; --i) std::swap(pairs[i - 1], pairs[random.below(i)]);
    if (random.below(8) == 0) {
      EndsInLoop interrupted(static_cast<int>(random.below(5)));
      EXPECT_THROW(kept.update(topology, pairs, interrupted), std::runtime_error);
    }
    const bool leave_out = random.below(3) == 0;
    kept.update(topology, pairs, round % 2 ? *threads : serial, leave_out);
    expect_same(all_of(kept), leave_out ? without_shell_neighbours(topology.features(), expected) : expected, round);
    orphans += expected.size();
    const std::uint64_t edits = random.below(10) == 0 ? Topology::kHistory + 2 : random.below(3);
    for (std::uint64_t i = 0; i < edits; ++i) editor.edit_at_random();
  }
  EXPECT_GT(orphans, 10u * static_cast<std::size_t>(rounds));
}

TEST(SuspectOrphans, FollowSuspectsAndEditsOfTetrahedra) {
  for (const std::uint64_t seed : {1, 2, 3, 8, 9, 10})
    expect_orphans_follow(block(ElementType::tetrahedron, 2, 2, 2).mesh(), {ElementType::tetrahedron}, seed, 40);
}

TEST(SuspectOrphans, FollowSuspectsAndEditsOfHexahedra) {
  for (const std::uint64_t seed : {4, 5, 11, 12})
    expect_orphans_follow(block(ElementType::hexahedron, 3, 2, 2).mesh(), {ElementType::hexahedron}, seed, 30);
}

TEST(SuspectOrphans, FollowSuspectsAndEditsOfMixedElements) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::wedge, ElementType::triangle,
                                          ElementType::polytope};
  for (const std::uint64_t seed : {6, 7, 13, 14, 15, 16})
    expect_orphans_follow(block(ElementType::wedge, 2, 2, 2).mesh(), types, seed, 30);
}

}  // namespace
}  // namespace volccd::detail
