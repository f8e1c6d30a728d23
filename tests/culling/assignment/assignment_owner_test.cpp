// Dynamic assignment compared with the literal definition of the owner (Algorithm 5), for each element pair: with
// masks, on every element type, on objects that share vertices, on elements with more features than a mask has bits,
// and after edits.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/assignment/dynamic_assignment.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

/// Finds the elements that share vertices by comparing all of them, without the topology's tables.
class AdjacencyMatrix {
 public:
  explicit AdjacencyMatrix(const Mesh& mesh) : slots_(mesh.element_slots()), adjacent_(std::size_t{slots_} * slots_) {
    for (Index a = 0; a < slots_; ++a)
      for (Index b = 0; b < slots_; ++b) {
        const auto x = mesh.vertices(a), y = mesh.vertices(b);
        adjacent_[std::size_t{a} * slots_ + b] = std::find_first_of(x.begin(), x.end(), y.begin(), y.end()) != x.end();
      }
  }

  /// Whether (o1, o2) is the first non-adjacent pair in inc_a x inc_b.
  bool owns(std::span<const Index> inc_a, std::span<const Index> inc_b, Index o1, Index o2) const {
    for (const Index oi : inc_a)
      for (const Index oj : inc_b)
        if (!adjacent_[std::size_t{oi} * slots_ + oj]) return oi == o1 && oj == o2;
    return false;
  }

 private:
  Index slots_;
  std::vector<bool> adjacent_;
};

template <class Bits>
bool is_masked(Bits mask, std::size_t i) {
  return i < 8 * sizeof(Bits) && (mask >> i & 1) != 0;
}

void add_vf(const Topology& topology, const AdjacencyMatrix& adjacency, Index o_v, Index o_f, std::uint32_t mask,
            TestBatch& out) {
  const Features& features = topology.features();
  const auto vertices = topology.mesh().vertices(o_v);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (const Index f : features.element_triangles(o_f))
      if (!is_masked(mask, i) &&
          adjacency.owns(features.vertex_elements(vertices[i]), features.triangle_elements(f), o_v, o_f))
        out.vf.push_back({vertices[i], f});
}

/// The tests of an element pair according to the definition.
TestBatch owned_tests(const Topology& topology, const AdjacencyMatrix& adjacency, ElementPair pair,
                      const FeatureMask& mask) {
  const Features& features = topology.features();
  TestBatch out;
  add_vf(topology, adjacency, pair.a, pair.b, mask.vertices_a, out);
  if (pair.a != pair.b) add_vf(topology, adjacency, pair.b, pair.a, mask.vertices_b, out);
  const auto edges_a = features.element_edges(pair.a), edges_b = features.element_edges(pair.b);
  for (std::size_t i = 0; i < edges_a.size(); ++i)
    for (std::size_t j = 0; j < edges_b.size(); ++j) {
      if (is_masked(mask.edges_a, i) || is_masked(mask.edges_b, j)) continue;
      const Index e = edges_a[i], g = edges_b[j];
      const auto of_e = features.edge_elements(e), of_g = features.edge_elements(g);
      if (e < g && adjacency.owns(of_e, of_g, pair.a, pair.b)) out.ee.push_back({e, g});
      if (g < e && adjacency.owns(of_g, of_e, pair.b, pair.a)) out.ee.push_back({g, e});
    }
  return out;
}

/// A mask for each element: empty, or with each feature masked with probability 1/2.
FeatureMask random_mask(Random& random) {
  FeatureMask mask;
  if (random.below(2) == 0) return mask;
  const auto bits = [&] { return random.below(std::uint64_t{1} << 32); };
  mask.vertices_a = static_cast<std::uint32_t>(bits()), mask.vertices_b = static_cast<std::uint32_t>(bits());
  mask.edges_a = bits() << 32 | bits(), mask.edges_b = bits() << 32 | bits();
  return mask;
}

/// The shape as a mesh of two objects that share vertices.
Shape of_two_objects(Shape shape) {
  for (std::size_t i = 0; i < shape.elements.size(); ++i) shape.elements[i].object = i % 3 == 0 ? 1 : 2;
  return shape;
}

/// A row of prisms whose bases are polygons with `sides` sides. Each is a polytope that shares a face with the next
/// one.
Shape prisms(Index sides, Index count) {
  Shape shape;
  for (Index layer = 0; layer <= count; ++layer)
    for (Index i = 0; i < sides; ++i) shape.positions.push_back({0, 0, 0});
  for (Index k = 0; k < count; ++k) {
    ElementSpec prism{.type = ElementType::polytope, .object = 1, .id = k};
    const Index bottom = sides * k, top = bottom + sides;
    for (Index i = 0; i < 2 * sides; ++i) prism.vertices.push_back(bottom + i);
    for (const Index first : {bottom, top}) {
      prism.faces.push_back(sides);
      for (Index i = 0; i < sides; ++i) prism.faces.push_back(first + i);
    }
    for (Index i = 0; i < sides; ++i) {
      const Index j = (i + 1) % sides;
      for (const Index value : {4u, bottom + i, bottom + j, top + j, top + i}) prism.faces.push_back(value);
    }
    shape.elements.push_back(prism);
  }
  return shape;
}

std::vector<std::pair<std::string, Shape>> owner_shapes() {
  std::vector<std::pair<std::string, Shape>> list;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron,
        ElementType::polytope, ElementType::triangle, ElementType::quad}) {
    list.emplace_back(to_string(type), block(type, 4, 2, 2));
    list.emplace_back(std::string("joined objects of ") + to_string(type), of_two_objects(block(type, 4, 2, 1)));
    Shape two = block(type, 3, 2, 1);
    two.append(block(type, 2, 2, 1), 7);
    list.emplace_back(std::string("two objects of ") + to_string(type), two);
  }
  list.emplace_back("mixed", mixed_block(1, 2));
  list.emplace_back("mixed, joined objects", of_two_objects(mixed_block(1, 1)));
  list.emplace_back("prisms", prisms(20, 5));
  return list;
}

/// A stage and its state, as a pipeline has them.
struct AssignmentWithState {
  DynamicAssignment assignment;
  std::unique_ptr<StageState> state = assignment.make_state();
  ObjectFilter filter;

  TestBatch tests(const Topology& topology, const PairBatch& batch) {
    const Motion motion(topology.mesh().vertex_count(), 2);
    const Step step{topology, motion, filter};
    SerialExecutor executor;
    assignment.prepare(step, *state, executor);
    TestBatch out;
    assignment.run(step, *state, 0, batch, out);
    return out;
  }
};

void sort_tests(TestBatch& tests) {
  std::sort(tests.vf.begin(), tests.vf.end());
  std::sort(tests.ee.begin(), tests.ee.end());
}

/// Compares the tests of all pairs of live elements, including adjacent pairs and self pairs: of all pairs at once, and
/// of some pairs alone.
void expect_owned_tests(const Topology& topology, AssignmentWithState& stage, Random& random) {
  const Mesh& mesh = topology.mesh();
  const AdjacencyMatrix adjacency(mesh);
  PairBatch all;
  TestBatch expected;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b) {
      if (!mesh.is_live(a) || !mesh.is_live(b)) continue;
      PairBatch one;
      one.assign(std::vector<ElementPair>{{a, b}});
      one.masks[0] = random_mask(random);
      TestBatch tests = owned_tests(topology, adjacency, one.pairs[0], one.masks[0]);
      all.pairs.push_back(one.pairs[0]), all.masks.push_back(one.masks[0]);
      expected.vf.insert(expected.vf.end(), tests.vf.begin(), tests.vf.end());
      expected.ee.insert(expected.ee.end(), tests.ee.begin(), tests.ee.end());
      if (random.below(16) != 0) continue;
      TestBatch found = stage.tests(topology, one);
      sort_tests(tests), sort_tests(found);
      ASSERT_EQ(found.vf, tests.vf) << a << " " << b;
      ASSERT_EQ(found.ee, tests.ee) << a << " " << b;
    }
  TestBatch found = stage.tests(topology, all);
  sort_tests(found), sort_tests(expected);
  ASSERT_EQ(found.vf, expected.vf);
  ASSERT_EQ(found.ee, expected.ee);
}

TEST(DynamicAssignmentOwner, IsTheOneByDefinition) {
  Random random(3);
  for (const auto& [name, shape] : owner_shapes())
    for (const std::uint64_t seed : {0u, 1u, 2u})
      for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope}) {
        SCOPED_TRACE(name + ", seed " + std::to_string(seed) + (edges == EdgeSet::polytope ? ", polytope edges" : ""));
        const Topology topology(seed == 0 ? shape.mesh() : permuted(shape, seed).mesh(), edges);
        AssignmentWithState stage;
        ASSERT_NO_FATAL_FAILURE(expect_owned_tests(topology, stage, random));
      }
}

/// Elements are removed and added again, sometimes as another object, sometimes by several edits at once and by more
/// edits than the history stores.
TEST(DynamicAssignmentOwner, IsTheOneByDefinitionAfterEdits) {
  Random random(4);
  for (const auto& [name, shape] : owner_shapes()) {
    const Shape numbered = permuted(shape, 5);
    Topology topology(numbered.mesh());
    const Mesh& mesh = topology.mesh();
    AssignmentWithState stage;
    std::vector<ElementSpec> out;
    for (int round = 0; round < 8; ++round) {
      SCOPED_TRACE(name + ", round " + std::to_string(round));
      ASSERT_NO_FATAL_FAILURE(expect_owned_tests(topology, stage, random));
      const std::size_t edits = round == 5 ? Topology::kHistory + 2 : 1 + random.below(3);
      for (std::size_t i = 0; i < edits; ++i) {
        TopologyEdit edit;
        std::swap(edit.added, out);
        for (ElementSpec& spec : edit.added) spec.object = static_cast<std::int32_t>(1 + random.below(3));
        for (Index o = 0; o < mesh.element_slots(); ++o) {
          if (!mesh.is_live(o) || random.below(5) != 0) continue;
          edit.removed.push_back(o);
          for (const ElementSpec& spec : numbered.elements)
            if (spec.id == mesh.element_id(o)) out.push_back(spec);
        }
        topology.apply(edit);
      }
    }
  }
}

}  // namespace
}  // namespace volccd
