#include <volccd/culling/assignment/static_assignment.hpp>

#include <volccd/culling/assignment/detail/append_tests.hpp>

namespace volccd {

namespace {

/// Appends the tests of vertices that belong to o1 and triangles that belong to o2.
void vertex_tests(const Step& step, Index o1, Index o2, bool adjacent, std::uint32_t mask, TestBatch& out) {
  const Features& features = step.features();
  detail::for_each_unmasked(step.mesh().vertices(o1), mask, [&](Index v) {
    if (features.first_element_of_vertex(v) != o1) return;
    if (!adjacent) return detail::append_vf({&v, 1}, features.own_triangles(o2), out.vf);
    for (const Index f : features.own_triangles(o2))
      if (is_test(features, FeatureKind::vf, {v, f})) out.vf.push_back({v, f});
  });
}

void edge_tests(const Step& step, ElementPair pair, bool adjacent, const FeatureMask& mask, TestBatch& out) {
  const Features& features = step.features();
  if (!adjacent && (mask.edges_a | mask.edges_b) == 0)
    return detail::append_ee(features.own_edges(pair.a), features.own_edges(pair.b), out.ee);
  const bool itself = pair.a == pair.b;
  detail::for_each_unmasked(features.element_edges(pair.a), mask.edges_a, [&](Index e) {
    if (features.first_element_of_edge(e) != pair.a) return;
    detail::for_each_unmasked(features.element_edges(pair.b), mask.edges_b, [&](Index g) {
      if (features.first_element_of_edge(g) != pair.b || (itself && g <= e)) return;
      const FeaturePair test{std::min(e, g), std::max(e, g)};
      if (!adjacent || is_test(features, FeatureKind::ee, test)) out.ee.push_back(test);
    });
  });
}

}  // namespace

std::string StaticAssignment::incomplete_on_nonadjacent() const {
  return "static assignment gives some feature pairs to adjacent elements although non-adjacent ones cover them, so "
         "that the O-Set lacks them (Section 5.2); use assignment=dynamic-assignment, or orphans=none";
}

void StaticAssignment::run(const Step& step, StageState&, unsigned, const PairBatch& batch, TestBatch& out) const {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const ElementPair pair = batch.pairs[i];
    const bool adjacent = step.topology.adjacency().adjacent(pair.a, pair.b);
    vertex_tests(step, pair.a, pair.b, adjacent, batch.masks[i].vertices_a, out);
    if (pair.a != pair.b) vertex_tests(step, pair.b, pair.a, adjacent, batch.masks[i].vertices_b, out);
    edge_tests(step, pair, adjacent, batch.masks[i], out);
  }
}

StageDescriptor<Assignment> describe_static_assignment() {
  return describe_stage<Assignment, StaticAssignment>(
      "static-assignment", "each feature is tested by the first element that has it (Algorithm 4)", Guarantee::exact);
}

}  // namespace volccd
