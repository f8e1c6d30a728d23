// The feature pairs of a pair of elements.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/culling/element_culling.hpp>
#include <volccd/mesh/step.hpp>

namespace volccd::detail {

/// Bit i of a FeatureMask member; features beyond the bits are never masked.
template <class Mask>
bool masked(Mask mask, std::size_t i) {
  return i < 8 * sizeof(Mask) && (mask >> i & 1) != 0;
}

template <std::size_t N, std::size_t M>
bool share_vertex(const std::array<Index, N>& a, const std::array<Index, M>& b) {
  for (Index v : a)
    for (Index w : b)
      if (v == w) return true;
  return false;
}

/// vf(v, f) for V(a) x T(b), vf(v, f) for V(b) x T(a), ee(e1, e2) for E(a) x E(b), but for features that are masked or for
/// which from_a(feature's incident elements), from_b(..) is false. The two elements differ.
template <class FromA, class FromB, class Vf, class Ee>
void for_each_feature_pair(const Step& step, ElementPair pair, const FeatureMask& mask, FromA&& from_a, FromB&& from_b,
                           Vf&& vf, Ee&& ee) {
  const Features& features = step.features();
  const auto vertices_with_triangles = [&](Index o, std::uint32_t vertex_mask, auto&& from, Index other, auto&& from_other) {
    const std::span<const Index> vertices = step.mesh().vertices(o);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (masked(vertex_mask, i) || !from(features.vertex_elements(vertices[i]))) continue;
      for (Index f : features.element_triangles(other))
        if (from_other(features.triangle_elements(f))) vf(vertices[i], f);
    }
  };
  vertices_with_triangles(pair.a, mask.vertices_a, from_a, pair.b, from_b);
  vertices_with_triangles(pair.b, mask.vertices_b, from_b, pair.a, from_a);
  const std::span<const Index> edges_a = features.element_edges(pair.a), edges_b = features.element_edges(pair.b);
  for (std::size_t i = 0; i < edges_a.size(); ++i) {
    if (masked(mask.edges_a, i) || !from_a(features.edge_elements(edges_a[i]))) continue;
    for (std::size_t j = 0; j < edges_b.size(); ++j)
      if (!masked(mask.edges_b, j) && from_b(features.edge_elements(edges_b[j]))) ee(edges_a[i], edges_b[j]);
  }
}

/// Those of an element with itself: each VF pair, each unordered EE pair.
template <class From, class Vf, class Ee>
void for_each_inner_pair(const Step& step, Index o, const FeatureMask& mask, From&& from, Vf&& vf, Ee&& ee) {
  const Features& features = step.features();
  const std::span<const Index> vertices = step.mesh().vertices(o), edges = features.element_edges(o);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (masked(mask.vertices_a | mask.vertices_b, i) || !from(features.vertex_elements(vertices[i]))) continue;
    for (Index f : features.element_triangles(o))
      if (from(features.triangle_elements(f))) vf(vertices[i], f);
  }
  const std::uint64_t edge_mask = mask.edges_a | mask.edges_b;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (masked(edge_mask, i) || !from(features.edge_elements(edges[i]))) continue;
    for (std::size_t j = i + 1; j < edges.size(); ++j)
      if (!masked(edge_mask, j) && from(features.edge_elements(edges[j]))) ee(edges[i], edges[j]);
  }
}

/// Appends to a batch what has no common vertex; EE pairs with the smaller edge first.
class TestWriter {
 public:
  TestWriter(const Features& features, TestBatch& out) : features_(features), out_(out) {}

  void vf(Index v, Index f) { out_.vf.push_back({v, f}); }
  void ee(Index e1, Index e2) { out_.ee.push_back(e1 < e2 ? FeaturePair{e1, e2} : FeaturePair{e2, e1}); }
  void vf_if_apart(Index v, Index f) {
    if (!share_vertex(std::array{v}, features_.triangle(f))) vf(v, f);
  }
  void ee_if_apart(Index e1, Index e2) {
    if (!share_vertex(features_.edge(e1), features_.edge(e2))) ee(e1, e2);
  }

 private:
  const Features& features_;
  TestBatch& out_;
};

}  // namespace volccd::detail
