#include <volccd/culling/assignment/all_pairs.hpp>

#include <algorithm>

#include <volccd/culling/assignment/detail/append_tests.hpp>

namespace volccd {

namespace {

bool contains(std::span<const Index> list, Index value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

/// Appends all tests of two elements without a common vertex. They have no common feature, and no test shares a vertex.
void apart_pair(const Step& step, ElementPair pair, const FeatureMask& mask, TestBatch& out) {
  const Features& features = step.features();
  detail::for_each_unmasked(step.mesh().vertices(pair.a), mask.vertices_a, [&](Index v) {
    detail::append_vf({&v, 1}, features.element_triangles(pair.b), out.vf);
  });
  detail::for_each_unmasked(step.mesh().vertices(pair.b), mask.vertices_b, [&](Index v) {
    detail::append_vf({&v, 1}, features.element_triangles(pair.a), out.vf);
  });
  if ((mask.edges_a | mask.edges_b) == 0)
    return detail::append_ee(features.element_edges(pair.a), features.element_edges(pair.b), out.ee);
  detail::for_each_unmasked(features.element_edges(pair.a), mask.edges_a, [&](Index e) {
    detail::for_each_unmasked(features.element_edges(pair.b), mask.edges_b, [&](Index g) {
      out.ee.push_back({std::min(e, g), std::max(e, g)});
    });
  });
}

/// Appends all tests of two adjacent elements, or of an element with itself. A pair of features that both elements have
/// is appended once.
void adjacent_pair(const Step& step, ElementPair pair, const FeatureMask& mask, TestBatch& out) {
  const Features& features = step.features();
  const auto add = [&](FeatureKind kind, FeaturePair test, std::vector<FeaturePair>& list) {
    if (is_test(features, kind, test)) list.push_back(test);
  };
  const auto vertices_a = step.mesh().vertices(pair.a), vertices_b = step.mesh().vertices(pair.b);
  const auto triangles_a = features.element_triangles(pair.a), triangles_b = features.element_triangles(pair.b);
  const auto edges_a = features.element_edges(pair.a), edges_b = features.element_edges(pair.b);
  detail::for_each_unmasked(vertices_a, mask.vertices_a, [&](Index v) {
    for (const Index f : triangles_b) add(FeatureKind::vf, {v, f}, out.vf);
  });
  if (pair.a != pair.b)
    detail::for_each_unmasked(vertices_b, mask.vertices_b, [&](Index v) {
      const bool common = contains(vertices_a, v);
      for (const Index f : triangles_a)
        if (!common || !contains(triangles_b, f)) add(FeatureKind::vf, {v, f}, out.vf);
    });
  detail::for_each_unmasked(edges_a, mask.edges_a, [&](Index e) {
    const bool common = contains(edges_b, e);
    detail::for_each_unmasked(edges_b, mask.edges_b, [&](Index g) {
      if (!common || e < g || !contains(edges_a, g)) add(FeatureKind::ee, {std::min(e, g), std::max(e, g)}, out.ee);
    });
  });
}

}  // namespace

void AllPairs::run(const Step& step, StageState&, unsigned, const PairBatch& batch, TestBatch& out) const {
  const Adjacency& adjacency = step.topology.adjacency();
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const ElementPair pair = batch.pairs[i];
    if (adjacency.adjacent(pair.a, pair.b))
      adjacent_pair(step, pair, batch.masks[i], out);
    else
      apart_pair(step, pair, batch.masks[i], out);
  }
}

StageDescriptor<Assignment> describe_all_pairs() {
  return describe_stage<Assignment, AllPairs>("all-pairs", "all tests of every element pair", Guarantee::exact);
}

}  // namespace volccd
