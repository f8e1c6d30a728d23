// Finds the features that make an O-Set pair with a given one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/culling/detail/o_set_vertices.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// For a feature a, let I(a) be the elements adjacent to every element of inc(a). {a,b} is in the minimal O-Set iff
/// inc(b) is within I(a). {a,b} is in the literal set (Algorithm 3) iff inc(b) meets I(a) and inc(a) meets I(b): an
/// adjacent pair (oi, oj) passes both of its loops iff oi is in I(b) and oj in I(a), which makes them adjacent.
///
/// I(a) holds the elements with a vertex of a, and some others, which must touch each element of inc(a) elsewhere: they are
/// looked for around the element of inc(a) that has the fewest elements around it.
///
/// Holds scratch memory per vertex and per element slot, so that one call costs nothing beyond the elements around a.
class OSetPartners {
 public:
  /// Room for the present slots.
  void fit(const Features& features, const ElementVertices& vertices, Index element_slots) {
    features_ = &features;
    vertices_ = &vertices;
    touching_.resize(features.vertex_slots(), 0);
    marks_.resize(element_slots, 0);
  }

  /// Calls take(f) for each triangle that makes an O-Set pair with vertex v, once.
  template <class Take>
  void triangles_of_vertex(bool literal, Index v, Take&& take) {
    const std::span<const Index> inc = features_->vertex_elements(v);
    find_covering({&v, 1}, inc);
    visit(
        literal, inc, [&](Index o) { return features_->element_triangles(o); },
        [&](Index f) { return features_->triangle_elements(f); }, [](Index) { return true; },
        [&](Index f) {
          const auto& t = features_->triangle(f);
          return t[0] != v && t[1] != v && t[2] != v;
        },
        take);
  }

  /// Calls take(v) for each vertex that makes an O-Set pair with triangle f and for which wanted(v), once.
  template <class Wanted, class Take>
  void vertices_of_triangle(const Mesh& mesh, bool literal, Index f, Wanted&& wanted, Take&& take) {
    const std::array<Index, 3> t = features_->triangle(f);
    const std::span<const Index> inc = features_->triangle_elements(f);
    find_covering(t, inc);
    visit(
        literal, inc, [&](Index o) { return mesh.vertices(o); },
        [&](Index v) { return features_->vertex_elements(v); }, wanted,
        [&](Index v) { return v != t[0] && v != t[1] && v != t[2]; }, take);
  }

  /// Calls take(e2) for each edge that makes an O-Set pair with edge e and for which wanted(e2), once.
  template <class Wanted, class Take>
  void edges_of_edge(bool literal, Index e, Wanted&& wanted, Take&& take) {
    const std::array<Index, 2> ends = features_->edge(e);
    const std::span<const Index> inc = features_->edge_elements(e);
    find_covering(ends, inc);
    visit(
        literal, inc, [&](Index o) { return features_->element_edges(o); },
        [&](Index e2) { return features_->edge_elements(e2); }, wanted,
        [&](Index e2) {
          const auto& other = features_->edge(e2);
          return other[0] != ends[0] && other[0] != ends[1] && other[1] != ends[0] && other[1] != ends[1];
        },
        take);
  }

  std::size_t bytes() const {
    return touching_.capacity() * sizeof(touching_[0]) + marks_.capacity() * sizeof(marks_[0]) +
           (covering_.capacity() + touched_.capacity()) * sizeof(Index);
  }

 private:
  /// covering_ = I(a) for a feature with these vertices and incident elements, each marked.
  void find_covering(std::span<const Index> vertices, std::span<const Index> inc);
  void find_far(std::span<const Index> vertices, std::span<const Index> inc);
  Index pivot(std::span<const Index> vertices, std::span<const Index> inc) const;
  void touch(std::span<const Index> inc);
  void untouch();
  std::uint64_t touched_by(Index o) const {
    std::uint64_t bits = 0;
    for (Index w : (*vertices_)[o]) bits |= touching_[w];
    return bits;
  }
  void next_mark();
  bool covers(Index o) const { return marks_[o] == mark_; }

  /// Each feature b of the elements of I(a) is looked at once, from the first element of inc(b) that is in I(a): if all have
  /// to be, from the first of all.
  template <class OfElement, class Incident, class Wanted, class Disjoint, class Take>
  void visit(bool literal, std::span<const Index> inc_a, OfElement&& features_of, Incident&& incident, Wanted&& wanted,
             Disjoint&& disjoint, Take&& take) {
    for (Index o : covering_)
      for (Index b : features_of(o)) {
        if (!wanted(b)) continue;
        const std::span<const Index> inc_b = incident(b);
        if (literal) {
          if (first_covering(inc_b) == o && disjoint(b) && some_touches_all(inc_a, inc_b)) take(b);
        } else if (inc_b[0] == o && disjoint(b) && all_cover(inc_b)) {
          take(b);
        }
      }
  }
  bool all_cover(std::span<const Index> elements) const {
    return std::all_of(elements.begin() + 1, elements.end(), [&](Index o) { return covers(o); });
  }
  Index first_covering(std::span<const Index> elements) const {
    return *std::find_if(elements.begin(), elements.end(), [&](Index o) { return covers(o); });
  }
  bool some_touches_all(std::span<const Index> some, std::span<const Index> all) const;

  const Features* features_ = nullptr;
  const ElementVertices* vertices_ = nullptr;
  std::vector<std::uint64_t> touching_;  ///< by vertex: bit k: it is in element k of the part of inc(a) at hand; else 0
  std::vector<Index> touched_;           ///< vertices where it is not 0
  /// By element: mark_ if it is in I(a), mark_ + 1 if it is known not to be, less if not looked at yet.
  std::vector<std::uint32_t> marks_;
  std::uint32_t mark_ = 0;
  std::vector<Index> covering_;
};

}  // namespace volccd::detail
