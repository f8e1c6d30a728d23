// Invariant 2 by full enumeration: every VF and EE pair without a common vertex is in the O-Set, or is owned by exactly
// one pair of non-adjacent elements. On small meshes of every element type and of mixed types, with permuted ids and
// both edge sets.
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/assignment/all_pairs.hpp>
#include <volccd/culling/assignment/dynamic_assignment.hpp>
#include <volccd/culling/assignment/static_assignment.hpp>
#include <volccd/culling/o_set/o_set_source.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/roles/broad_phase.hpp>

#include "support/stages.hpp"

namespace volccd {
namespace {

using test::prepared;

/// A test identified by the vertices of its features, so that tests of two tables of features can be compared.
using FeatureTest = std::vector<Index>;
using Counts = std::map<FeatureTest, int>;

FeatureTest vf_test(const Features& features, FeaturePair pair) {
  const auto& f = features.triangle(pair.b);
  return {0, pair.a, f[0], f[1], f[2]};
}
FeatureTest ee_test(const Features& features, FeaturePair pair) {
  auto e = features.edge(pair.a), g = features.edge(pair.b);
  if (g < e) std::swap(e, g);
  return {1, e[0], e[1], g[0], g[1]};
}

void count(const Features& features, const TestBatch& batch, Counts& counts) {
  for (const FeaturePair pair : batch.vf) ++counts[vf_test(features, pair)];
  for (const FeaturePair pair : batch.ee) {
    EXPECT_LT(pair.a, pair.b);
    ++counts[ee_test(features, pair)];
  }
}

bool share_a_vertex(std::span<const Index> a, std::span<const Index> b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}
bool adjacent(const Mesh& mesh, Index a, Index b) { return share_a_vertex(mesh.vertices(a), mesh.vertices(b)); }

/// All tests, with the elements incident to their features.
template <class Visit>
void for_each_test(const Features& features, Visit&& visit) {
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f) {
      if (features.vertex_elements(v).empty() || features.triangle_elements(f).empty()) continue;
      if (share_a_vertex({&v, 1}, features.triangle(f))) continue;
      visit(vf_test(features, {v, f}), features.vertex_elements(v), features.triangle_elements(f));
    }
  for (Index e = 0; e < features.edge_slots(); ++e)
    for (Index g = e + 1; g < features.edge_slots(); ++g) {
      if (features.edge_elements(e).empty() || features.edge_elements(g).empty()) continue;
      if (share_a_vertex(features.edge(e), features.edge(g))) continue;
      visit(ee_test(features, {e, g}), features.edge_elements(e), features.edge_elements(g));
    }
}

std::set<FeatureTest> naive_minimal(const Topology& topology) {
  std::set<FeatureTest> set;
  for_each_test(topology.features(),
                [&](const FeatureTest& test, std::span<const Index> inc_a, std::span<const Index> inc_b) {
                  for (const Index oi : inc_a)
                    for (const Index oj : inc_b)
                      if (!adjacent(topology.mesh(), oi, oj)) return;
                  set.insert(test);
                });
  return set;
}

/// Algorithm 3, corrected to continue with the next feature pair where the paper's has `return`.
std::set<FeatureTest> naive_literal(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  std::set<FeatureTest> set;
  for_each_test(topology.features(),
                [&](const FeatureTest& test, std::span<const Index> inc_a, std::span<const Index> inc_b) {
                  const auto all_adjacent = [&](std::span<const Index> elements, Index o) {
                    return std::all_of(elements.begin(), elements.end(), [&](Index k) { return adjacent(mesh, k, o); });
                  };
                  for (const Index oi : inc_a)
                    for (const Index oj : inc_b)
                      if (adjacent(mesh, oi, oj) && all_adjacent(inc_a, oj) && all_adjacent(inc_b, oi))
                        set.insert(test);
                });
  return set;
}

struct Harness {
  explicit Harness(const Topology& t) : topology(t), motion(t.mesh().vertex_count(), 2) {}

  Step step() const { return {topology, motion, filter}; }

  /// Tests of all live element pairs in the range.
  void run(const Assignment& assignment, StageState& state, PairRange range, TestBatch& out) const {
    SerialExecutor executor;
    assignment.prepare(step(), state, executor);
    const Mesh& mesh = topology.mesh();
    std::vector<ElementPair> pairs;
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b)
        if (mesh.is_live(a) && mesh.is_live(b) && (range == PairRange::every || !adjacent(mesh, a, b)))
          pairs.push_back({a, b});
    PairBatch batch;
    batch.assign(pairs);
    assignment.run(step(), state, 0, batch, out);
  }
  void run(const OrphanSource& orphans, StageState& state, TestBatch& out) const {
    SerialExecutor executor;
    orphans.prepare(step(), state, executor);
    Work work;
    for (std::size_t b = 0; b < orphans.blocks(state); ++b) orphans.run(step(), state, 0, b, work);
    out.vf.insert(out.vf.end(), work.tests.vf.begin(), work.tests.vf.end());
    out.ee.insert(out.ee.end(), work.tests.ee.begin(), work.tests.ee.end());
  }
  Counts counts(const TestBatch& tests) const {
    Counts counts;
    count(topology.features(), tests, counts);
    return counts;
  }

  /// The tests of all element pairs.
  Counts tests(const Assignment& assignment) const {
    TestBatch out;
    run(assignment, *assignment.make_state(), PairRange::every, out);
    return counts(out);
  }
  /// The tests of non-adjacent element pairs, and the orphans.
  Counts tests(const Assignment& assignment, StageState& owners, const OrphanSource& orphans, StageState& set) const {
    TestBatch out;
    run(assignment, owners, PairRange::nonadjacent, out);
    run(orphans, set, out);
    return counts(out);
  }
  Counts tests(const Assignment& assignment, const OrphanSource& orphans) const {
    return tests(assignment, *assignment.make_state(), orphans, *orphans.make_state());
  }

  const Topology& topology;
  Motion motion;
  ObjectFilter filter;
};

std::set<FeatureTest> keys(const Counts& counts) {
  std::set<FeatureTest> set;
  for (const auto& [test, n] : counts) set.insert(test);
  return set;
}

std::vector<std::pair<std::string, Shape>> shapes() {
  std::vector<std::pair<std::string, Shape>> list;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron,
        ElementType::polytope, ElementType::triangle, ElementType::quad}) {
    list.emplace_back(to_string(type), block(type, 2, 2, 2));
    list.emplace_back(std::string("one ") + to_string(type), block(type, 1, 1, 1));
    Shape two = block(type, 3, 1, 1);
    two.append(block(type, 2, 1, 1), 7);
    list.emplace_back(std::string("two objects of ") + to_string(type), two);
  }
  list.emplace_back("mixed", mixed_block(1, 1));
  list.emplace_back("mixed, two layers", mixed_block(1, 2));
  return list;
}

template <class Check>
void for_each_topology(Check&& check) {
  for (const auto& [name, shape] : shapes())
    for (const std::uint64_t seed : {0u, 1u, 2u})
      for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope}) {
        const Topology topology(seed == 0 ? shape.mesh() : permuted(shape, seed).mesh(), edges);
        SCOPED_TRACE(name + ", seed " + std::to_string(seed) + (edges == EdgeSet::polytope ? ", polytope edges" : ""));
        check(topology);
        if (::testing::Test::HasFailure()) return;
      }
}

void expect_each_once(const Topology& topology, const Counts& counts) {
  std::size_t tests = 0;
  for_each_test(topology.features(), [&](const FeatureTest& test, std::span<const Index>, std::span<const Index>) {
    ++tests;
    const auto found = counts.find(test);
    ASSERT_EQ(found == counts.end() ? 0 : found->second, 1) << ::testing::PrintToString(test);
  });
  EXPECT_EQ(counts.size(), tests) << "tests that are none";
}

TEST(ExactlyOnce, DynamicAssignmentWithTheMinimalOSet) {
  for_each_topology([](const Topology& topology) {
    expect_each_once(topology, Harness(topology).tests(DynamicAssignment({}), OSetSource({OSetKind::minimal})));
  });
}

TEST(ExactlyOnce, StaticAssignmentOnAllPairs) {
  for_each_topology(
      [](const Topology& topology) { expect_each_once(topology, Harness(topology).tests(StaticAssignment({}))); });
}

TEST(ExactlyOnce, AllPairsMissNothing) {
  for_each_topology([](const Topology& topology) {
    std::set<FeatureTest> all;
    for_each_test(topology.features(), [&](const FeatureTest& test, auto&&, auto&&) { all.insert(test); });
    const Harness harness(topology);
    EXPECT_EQ(keys(harness.tests(AllPairs({}))), all);
    for (const OSetKind kind : {OSetKind::minimal, OSetKind::literal})
      EXPECT_EQ(keys(harness.tests(AllPairs({}), OSetSource({kind}))), all);
  });
}

TEST(OSetByDefinition, MinimalAndLiteral) {
  for_each_topology([](const Topology& topology) {
    const Harness harness(topology);
    for (const OSetKind kind : {OSetKind::minimal, OSetKind::literal}) {
      const OSetSource source({kind});
      TestBatch listed;
      harness.run(source, *source.make_state(), listed);
      const Counts orphans = harness.counts(listed);
      EXPECT_EQ(keys(orphans), kind == OSetKind::minimal ? naive_minimal(topology) : naive_literal(topology));
      for (const auto& [test, n] : orphans) ASSERT_EQ(n, 1) << ::testing::PrintToString(test);
    }
  });
}

TEST(AllPairs, EachElementPairGivesItsDistinctFeaturePairs) {
  for_each_topology([](const Topology& topology) {
    const Mesh& mesh = topology.mesh();
    const Features& features = topology.features();
    const Harness harness(topology);
    const AllPairs culling({});
    const auto state = prepared(culling, harness.step());
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b) {
        std::set<FeatureTest> expected;
        for (const auto& [x, y] : {std::pair{a, b}, std::pair{b, a}}) {
          for (const Index v : mesh.vertices(x))
            for (const Index f : features.element_triangles(y))
              if (!share_a_vertex({&v, 1}, features.triangle(f))) expected.insert(vf_test(features, {v, f}));
          for (const Index e : features.element_edges(x))
            for (const Index g : features.element_edges(y))
              if (!share_a_vertex(features.edge(e), features.edge(g))) expected.insert(ee_test(features, {e, g}));
        }
        PairBatch batch;
        batch.assign(std::vector<ElementPair>{{a, b}});
        TestBatch out;
        culling.run(harness.step(), *state, 0, batch, out);
        Counts counts;
        count(features, out, counts);
        ASSERT_EQ(keys(counts), expected) << a << " " << b;
        ASSERT_EQ(out.vf.size() + out.ee.size(), expected.size()) << a << " " << b;
      }
  });
}

/// Removes random elements and adds them again, some with two vertices replaced by others.
void random_edit(Random& random, Topology& topology, std::vector<ElementSpec>& out, const Shape& shape) {
  TopologyEdit edit;
  const std::uint64_t back = random.below(out.size() + 1);
  for (std::uint64_t i = 0; i < back; ++i) {
    const std::size_t at = random.below(out.size());
    edit.added.push_back(out[at]);
    out.erase(out.begin() + static_cast<std::ptrdiff_t>(at));
  }
  for (Index o = 0; o < topology.mesh().element_slots(); ++o)
    if (topology.mesh().is_live(o) && random.below(6) == 0) {
      edit.removed.push_back(o);
      for (const ElementSpec& spec : shape.elements)
        if (spec.id == topology.mesh().element_id(o)) out.push_back(spec);
    }
  topology.apply(edit);
}

TEST(OSetUpdate, EqualsARebuildOverRandomEdits) {
  Random random(5);
  for (const auto& [name, shape] : shapes())
    for (const OSetKind kind : {OSetKind::minimal, OSetKind::literal}) {
      Topology topology(shape.mesh());
      const DynamicAssignment assignment({});
      const OSetSource orphans({kind});
      const auto owners = assignment.make_state(), set = orphans.make_state();
      std::vector<ElementSpec> out;
      for (int round = 0; round < 25; ++round) {
        const Harness harness(topology);
        SCOPED_TRACE(name + ", round " + std::to_string(round));
        const Counts updated = harness.tests(assignment, *owners, orphans, *set);
        ASSERT_EQ(updated, harness.tests(assignment, orphans));
        if (kind == OSetKind::minimal) expect_each_once(topology, updated);
        // There are sometimes several edits between two updates, and sometimes more than the history stores.
        const std::uint64_t edits = random.below(8) == 0 ? Topology::kHistory + 2 : 1 + random.below(3);
        for (std::uint64_t i = 0; i < edits; ++i) random_edit(random, topology, out, shape);
      }
    }
}

TEST(Assignment, MasksAreHonoured) {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.append(block(ElementType::hexahedron, 1, 1, 1), 2);
  const Topology topology(shape.mesh());
  const Features& features = topology.features();
  const Harness harness(topology);
  const Index tet = 0, hex = 6;
  PairBatch batch;
  batch.assign(std::vector<ElementPair>{{tet, hex}});
  batch.masks = {{0b0101, 0b11, 0b100010, 0b1000}};
  std::set<Index> vertices, edges_a, edges_b;
  for (const int i : {0, 2}) vertices.insert(topology.mesh().vertices(tet)[static_cast<std::size_t>(i)]);
  for (const int i : {0, 1}) vertices.insert(topology.mesh().vertices(hex)[static_cast<std::size_t>(i)]);
  for (const int i : {1, 5}) edges_a.insert(features.element_edges(tet)[static_cast<std::size_t>(i)]);
  edges_b.insert(features.element_edges(hex)[3]);
  const AllPairs all({});
  const StaticAssignment fixed({});
  const DynamicAssignment dynamic({});
  for (const Assignment* assignment : std::initializer_list<const Assignment*>{&all, &fixed, &dynamic}) {
    const auto state = prepared(*assignment, harness.step());
    PairBatch open = batch;
    open.masks = {FeatureMask{}};
    TestBatch masked, unmasked;
    assignment->run(harness.step(), *state, 0, batch, masked);
    assignment->run(harness.step(), *state, 0, open, unmasked);
    std::erase_if(unmasked.vf, [&](FeaturePair p) { return vertices.contains(p.a); });
    std::erase_if(unmasked.ee, [&](FeaturePair p) {
      return edges_a.contains(p.a) || edges_a.contains(p.b) || edges_b.contains(p.a) || edges_b.contains(p.b);
    });
    for (auto* tests : {&masked.vf, &masked.ee, &unmasked.vf, &unmasked.ee}) std::sort(tests->begin(), tests->end());
    EXPECT_EQ(masked.vf, unmasked.vf);
    EXPECT_EQ(masked.ee, unmasked.ee);
    EXPECT_FALSE(masked.vf.empty() && masked.ee.empty());
  }
}

TEST(Assignment, SaysWhereItIsIncomplete) {
  EXPECT_EQ(AllPairs({}).incomplete_on_every() + AllPairs({}).incomplete_on_nonadjacent(), "");
  EXPECT_EQ(StaticAssignment({}).incomplete_on_every(), "");
  EXPECT_NE(StaticAssignment({}).incomplete_on_nonadjacent(), "");
  EXPECT_NE(DynamicAssignment({}).incomplete_on_every(), "");
  EXPECT_EQ(DynamicAssignment({}).incomplete_on_nonadjacent(), "");
}

/// The texts above say that there are meshes on which tests are missing; this checks it.
TEST(Assignment, IsIncompleteWhereItSaysSo) {
  const Topology topology(block(ElementType::hexahedron, 2, 2, 2).mesh());
  const Harness harness(topology);
  std::set<FeatureTest> all;
  for_each_test(topology.features(), [&](const FeatureTest& test, auto&&, auto&&) { all.insert(test); });
  EXPECT_LT(keys(harness.tests(DynamicAssignment({}))).size(), all.size());
  const Topology slab(block(ElementType::hexahedron, 4, 1, 1).mesh());
  const Harness of_slab(slab);
  all.clear();
  for_each_test(slab.features(), [&](const FeatureTest& test, auto&&, auto&&) { all.insert(test); });
  EXPECT_LT(keys(of_slab.tests(StaticAssignment({}), OSetSource({}))).size(), all.size());
}

}  // namespace
}  // namespace volccd
