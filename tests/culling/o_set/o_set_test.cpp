// O-Sets in situations that the enumeration on regular meshes does not reach: random elements on few vertices (any
// number of elements at a feature, non-manifold everywhere), and incremental updates on larger meshes.
#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/o_set/o_set.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/shell_neighbours.hpp>
#include <volccd/query/test_block.hpp>

#include "culling/topology_editor.hpp"

namespace volccd {
namespace {

Executor& serial() {
  static SerialExecutor executor;
  return executor;
}

/// A test identified by its kind and vertices (test_vertices()).
using Key = std::array<Index, 5>;

Key key(const Features& features, FeatureKind kind, FeaturePair pair) {
  const auto v = test_vertices(features, kind, pair);
  return {kind == FeatureKind::ee, v[0], v[1], v[2], v[3]};
}

/// The mesh need not be one of thickened shells: the rule is one of slots.
bool is_of_shell_neighbours(const Key& key) {
  return share_shell_vertex(key[0] != 0 ? FeatureKind::ee : FeatureKind::vf, {key[1], key[2], key[3], key[4]});
}

/// All pairs, in ascending order. Fails if a pair is repeated, shares a vertex, or has dead features, or if counts() is
/// wrong.
std::vector<Key> keys(const OSet& set, const Features& features) {
  TestBatch batch;
  for (std::size_t b = 0; b < set.blocks(); ++b) {
    const std::size_t before = batch.vf.size() + batch.ee.size();
    set.append(b, batch);
    EXPECT_LE(batch.vf.size() + batch.ee.size() - before, OSet::kBlockPairs);
  }
  EXPECT_EQ(set.counts(), (OSetCounts{batch.vf.size(), batch.ee.size()}));
  std::vector<Key> keys;
  for (const FeaturePair p : batch.vf) {
    EXPECT_FALSE(features.vertex_elements(p.a).empty() || features.triangle_elements(p.b).empty());
    EXPECT_TRUE(is_test(features, FeatureKind::vf, p));
    keys.push_back(key(features, FeatureKind::vf, p));
  }
  for (const FeaturePair p : batch.ee) {
    EXPECT_LT(p.a, p.b);
    EXPECT_FALSE(features.edge_elements(p.a).empty() || features.edge_elements(p.b).empty());
    EXPECT_TRUE(is_test(features, FeatureKind::ee, p));
    keys.push_back(key(features, FeatureKind::ee, p));
  }
  std::sort(keys.begin(), keys.end());
  EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end()) << "a pair comes twice";
  return keys;
}

std::vector<Key> built(const Topology& topology, OSetKind kind = OSetKind::minimal) {
  OSet set(kind);
  set.build(topology, serial());
  return keys(set, topology.features());
}

/// The definitions, computed literally from a table of adjacency.
std::vector<Key> by_definition(const Topology& topology, OSetKind kind) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const Index n = mesh.element_slots();
  std::vector<char> table(std::size_t{n} * n, 0);
  const auto adjacent = [&](Index a, Index b) -> char& { return table[std::size_t{a} * n + b]; };
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b)
      for (Index v : mesh.vertices(a))
        for (Index w : mesh.vertices(b)) adjacent(a, b) |= v == w;

  const auto is_in = [&](std::span<const Index> inc_a, std::span<const Index> inc_b) {
    if (kind == OSetKind::minimal)
      return std::all_of(inc_a.begin(), inc_a.end(), [&](Index oi) {
        return std::all_of(inc_b.begin(), inc_b.end(), [&](Index oj) { return adjacent(oi, oj); });
      });
    for (Index oi : inc_a)
      for (Index oj : inc_b) {
        bool in = adjacent(oi, oj) != 0;
        for (Index ok : inc_a) in &= adjacent(ok, oj) != 0;
        for (Index ol : inc_b) in &= adjacent(oi, ol) != 0;
        if (in) return true;
      }
    return false;
  };
  std::vector<Key> keys;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.vertex_elements(v).empty() && is_test(features, FeatureKind::vf, {v, f}) &&
          is_in(features.vertex_elements(v), features.triangle_elements(f)))
        keys.push_back(key(features, FeatureKind::vf, {v, f}));
  for (Index a = 0; a < features.edge_slots(); ++a)
    for (Index b = a + 1; b < features.edge_slots(); ++b)
      if (is_test(features, FeatureKind::ee, {a, b}) && is_in(features.edge_elements(a), features.edge_elements(b)))
        keys.push_back(key(features, FeatureKind::ee, {a, b}));
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// Vertices in clusters. Each element lies in one cluster or between two neighbouring ones, so that not all elements
/// are adjacent.
Mesh soup(Random& random, std::span<const ElementType> types, Index clusters, Index per_cluster, int elements) {
  Mesh mesh;
  mesh.add_vertices(clusters * per_cluster);
  for (int i = 0; i < elements; ++i) {
    const Index span = random.below(3) == 0 && clusters > 1 ? 2 : 1;
    const auto at = static_cast<Index>(random.below(clusters - span + 1));
    ElementSpec spec = random_element(random, span * per_cluster, types[random.below(types.size())], i);
    spec.renumber([&](Index v) { return v + at * per_cluster; });
    mesh.add_element(spec);
  }
  return mesh;
}

TEST(OSet, SoupsByDefinition) {
  Random random(11);
  const std::vector<std::vector<ElementType>> mixes = {
      {ElementType::tetrahedron},
      {ElementType::tetrahedron, ElementType::triangle},
      {ElementType::quad, ElementType::wedge, ElementType::pyramid},
      {ElementType::hexahedron, ElementType::triangle},
      {ElementType::polytope, ElementType::tetrahedron, ElementType::triangle}};
  for (const auto& mix : mixes)
    for (int round = 0; round < 12; ++round) {
      const bool large = mix.front() == ElementType::polytope || mix.front() == ElementType::hexahedron;
      const Mesh mesh = soup(random, mix, 2 + static_cast<Index>(random.below(4)), large ? 12 : 7, 14);
      for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope}) {
        const Topology topology(mesh, edges);
        for (const OSetKind kind : {OSetKind::minimal, OSetKind::literal})
          ASSERT_EQ(built(topology, kind), by_definition(topology, kind)) << to_string(mix.front()) << " " << round;
      }
    }
}

/// Elements at a feature are examined 64 at a time. Here a fan of n tetrahedra surrounds an edge, one prism touches all
/// of them, and another one only the first 66. Triangles increase the counts of the later tetrahedra, so that the first
/// ones are examined first.
TEST(OSet, MoreElementsAroundAFeatureThanBits) {
  for (const Index n : {62u, 63u, 64u, 65u, 128u, 129u, 130u}) {
    Mesh mesh;
    mesh.add_vertices(2 + (n + 1) + 2);
    std::int64_t id = 0;
    const auto add = [&](ElementType type, std::vector<Index> vertices) {
      mesh.add_element({.type = type, .vertices = std::move(vertices), .id = id++});
    };
    const auto add_prism = [&](Index sides) {
      std::vector<Index> vertices(2 * sides);
      std::iota(vertices.begin(), vertices.end(), 2u);
      ElementSpec spec = prism(std::move(vertices));
      spec.id = id++;
      mesh.add_element(spec);
    };
    for (Index i = 0; i < n; ++i) add(ElementType::tetrahedron, {0, 1, 2 + i, 3 + i});
    for (Index i = 60; i < n; ++i) add(ElementType::triangle, {3 + i, n + 3, n + 4});
    add_prism((n + 1) / 2);
    if (n > 66) add_prism(33);
    const Topology topology(std::move(mesh));
    ASSERT_EQ(built(topology), by_definition(topology, OSetKind::minimal)) << n;
  }
}

TEST(OSet, OneAloneAndTwoApart) {
  Mesh mesh;
  mesh.add_vertices(8);
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}});
  Topology topology(std::move(mesh));
  OSet set;
  set.update(topology, serial());
  EXPECT_EQ(set.counts(), (OSetCounts{4, 3})) << "all that there is inside a tetrahedron";

  TopologyEdit edit;
  edit.added.push_back({.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 7}, .id = 1});
  topology.apply(edit);
  set.update(topology, serial());
  EXPECT_EQ(set.counts(), (OSetCounts{8, 6})) << "nothing between elements that are not adjacent";

  const Topology other(block(ElementType::hexahedron, 2, 1, 1).mesh());
  set.update(other, serial());
  EXPECT_EQ(keys(set, other.features()), built(other)) << "another topology";

  const Topology empty{Mesh()};
  set.update(empty, serial());
  EXPECT_EQ(set.counts(), OSetCounts{});
}

/// Compares OSet after elements were added and removed, one by one and together, once or several times between two
/// updates.
void expect_updates_equal_rebuilds(Mesh mesh, std::vector<ElementType> types, std::uint64_t seed, int rounds,
                                   OSetKind kind = OSetKind::minimal, EdgeSet edges = EdgeSet::triangulated) {
  Topology topology(std::move(mesh), edges);
  TopologyEditor editor(topology, seed, std::move(types));
  Random& random = editor.random();
  OSet set(kind);
  for (int round = 0; round < rounds; ++round) {
    const bool leave_out = random.below(4) == 0;
    set.update(topology, serial(), leave_out);
    std::vector<Key> expected = built(topology, kind);
    if (leave_out) std::erase_if(expected, is_of_shell_neighbours);
    ASSERT_EQ(keys(set, topology.features()), expected) << "seed " << seed << ", round " << round;
    const std::uint64_t edits = random.below(10) == 0 ? Topology::kHistory + 2 : 1 + random.below(3);
    for (std::uint64_t i = 0; i < edits; ++i) editor.edit_at_random();
  }
}

TEST(OSetUpdate, Tetrahedra) {
  const std::vector<ElementType> types = {ElementType::tetrahedron};
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 3, 3, 3).mesh(), types, 1, 40);
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 1, 1, 30).mesh(), types, 2, 40);
  expect_updates_equal_rebuilds(permuted(block(ElementType::tetrahedron, 2, 2, 10), 3).mesh(), types, 3, 40);
}

TEST(OSetUpdate, TetrahedraAndTriangles) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Shape shape = block(ElementType::tetrahedron, 2, 2, 4);
  shape.append(block(ElementType::triangle, 6, 5, 0), 1);
  expect_updates_equal_rebuilds(shape.mesh(), types, 4, 40);
}

TEST(OSetUpdate, SoupsOfSimplices) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Random random(21);
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    expect_updates_equal_rebuilds(soup(random, types, 8, 6, 70), types, 100 + seed, 30);
}

/// The features have more elements than a word has bits, so that the update processes them in several parts.
TEST(OSetUpdate, ManyElementsAroundAFeature) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Random random(22);
  for (std::uint64_t seed = 0; seed < 3; ++seed)
    expect_updates_equal_rebuilds(soup(random, types, 3, 9, 420), types, 200 + seed, 12);
}

/// Simplices are added and removed between elements in which not all pairs of vertices are edges, and not all triples
/// are triangles.
TEST(OSetUpdate, SimplicesAmongOthers) {
  using enum ElementType;
  const std::vector<ElementType> types = {tetrahedron, tetrahedron, tetrahedron, triangle,
                                          triangle,    triangle,    hexahedron,  quad};
  Random random(23);
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope})
      expect_updates_equal_rebuilds(soup(random, types, 5, 9, 50), {tetrahedron, triangle}, 300 + seed, 30,
                                    OSetKind::minimal, edges);
}

TEST(OSetUpdate, OtherElements) {
  expect_updates_equal_rebuilds(block(ElementType::hexahedron, 4, 3, 3).mesh(), {ElementType::hexahedron}, 5, 15);
  expect_updates_equal_rebuilds(
      mixed_block(2, 2).mesh(),
      {ElementType::tetrahedron, ElementType::wedge, ElementType::pyramid, ElementType::quad, ElementType::polytope}, 6,
      25);
}

TEST(OSetUpdate, Literal) {
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 2, 2, 3).mesh(), {ElementType::tetrahedron}, 7, 20,
                                OSetKind::literal);
}

/// A hundred small changes and their reversal: invalid entries are removed by compaction, so that memory does not grow.
TEST(OSetUpdate, NothingPilesUp) {
  Topology topology(block(ElementType::tetrahedron, 3, 3, 8).mesh());
  const std::vector<Key> before = built(topology);
  TopologyEditor editor(topology, 8, {ElementType::tetrahedron});
  OSet set;
  set.update(topology, serial());
  std::size_t max = 0;
  for (int round = 0; round < 150; ++round) {
    editor.edit(6, 0, 0);
    set.update(topology, serial());
    editor.put_everything_back();
    set.update(topology, serial());
    max = std::max(max, set.blocks());
  }
  EXPECT_EQ(keys(set, topology.features()), before);
  OSet fresh;
  fresh.build(topology, serial());
  EXPECT_LE(max, 3 * fresh.blocks() + 80);
  EXPECT_LE(set.bytes(), 4 * fresh.bytes() + 200'000);
}

/// The pairs of all blocks, in their order.
std::vector<std::pair<std::vector<FeaturePair>, std::vector<FeaturePair>>> contents(const OSet& set) {
  std::vector<std::pair<std::vector<FeaturePair>, std::vector<FeaturePair>>> blocks;
  for (std::size_t b = 0; b < set.blocks(); ++b) {
    TestBatch batch;
    set.append(b, batch);
    blocks.emplace_back(batch.vf, batch.ee);
  }
  return blocks;
}

// The mesh has more features than the threads process in one part.
TEST(ThreadsOSet, TheSameBlocksForAnyNumberOfThreads) {
  Topology topology(permuted(block(ElementType::tetrahedron, 12, 12, 40), 5).mesh());
  TopologyEditor editor(topology, 10, {ElementType::tetrahedron});
  std::vector<std::unique_ptr<Executor>> executors;
  for (const unsigned threads : {3, 8}) executors.push_back(make_thread_executor(threads));
  OSet expected;
  std::vector<OSet> sets(executors.size());
  for (int round = 0; round < 3; ++round) {
    expected.update(topology, serial());
    ASSERT_GT(expected.blocks(), 40u);
    for (std::size_t i = 0; i < sets.size(); ++i) {
      sets[i].update(topology, *executors[i]);
      EXPECT_TRUE(contents(sets[i]) == contents(expected)) << "round " << round << ", executor " << i;
    }
    editor.edit(400, 0, 0);
  }
}

TEST(OSetUpdate, DownToNothingAndBack) {
  Topology topology(block(ElementType::tetrahedron, 2, 2, 2).mesh());
  const std::vector<Key> before = built(topology);
  TopologyEditor editor(topology, 9, {ElementType::tetrahedron});
  OSet set;
  set.update(topology, serial());
  editor.remove_region(1000);
  ASSERT_EQ(topology.mesh().element_count(), 0u);
  set.update(topology, serial());
  EXPECT_EQ(set.counts(), OSetCounts{});
  editor.put_everything_back();
  set.update(topology, serial());
  EXPECT_EQ(keys(set, topology.features()), before);
}

}  // namespace
}  // namespace volccd
