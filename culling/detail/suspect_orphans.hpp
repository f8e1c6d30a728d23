// Lists the orphans of which all pairs of incident elements may touch.
#pragma once

#include <algorithm>
#include <span>

#include <volccd/culling/assignment.hpp>
#include <volccd/culling/detail/pair_set.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd::detail {

/// `suspects` contains adjacent pairs of elements, and pairs of an element and itself. Lists the pairs of features
/// without a common vertex all of whose pairs of incident elements it contains.
class SuspectOrphans {
 public:
  SuspectOrphans(const Topology& topology, const PairSet& suspects, TestBatch& out)
      : mesh_(topology.mesh()), features_(topology.features()), suspects_(suspects), out_(out) {}

  /// Appends the orphans of which one feature has a, and the other b, as its first incident element. Pre: {a, b} is
  /// one of `suspects`.
  void of_elements(Index a, Index b) {
    vertices_and_triangles(a, b);
    if (a != b) vertices_and_triangles(b, a);
    for (const Index e : features_.own_edges(a))
      for (const Index g : features_.own_edges(b)) {
        if ((a == b && e >= g) || !is_test(features_, FeatureKind::ee, {e, g})) continue;
        if (is_orphan(features_.edge_elements(e), features_.edge_elements(g)))
          out_.ee.push_back({std::min(e, g), std::max(e, g)});
      }
  }

 private:
  void vertices_and_triangles(Index a, Index b) {
    for (const Index v : mesh_.vertices(a)) {
      if (features_.first_element_of_vertex(v) != a) continue;
      for (const Index f : features_.own_triangles(b))
        if (is_test(features_, FeatureKind::vf, {v, f}) &&
            is_orphan(features_.vertex_elements(v), features_.triangle_elements(f)))
          out_.vf.push_back({v, f});
    }
  }

  bool is_orphan(std::span<const Index> inc_a, std::span<const Index> inc_b) const {
    return std::all_of(inc_a.begin(), inc_a.end(), [&](Index a) {
      return std::all_of(inc_b.begin(), inc_b.end(), [&](Index b) { return suspects_.contains({a, b}); });
    });
  }

  const Mesh& mesh_;
  const Features& features_;
  const PairSet& suspects_;
  TestBatch& out_;
};

}  // namespace volccd::detail
