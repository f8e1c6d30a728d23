// Which pairs an O-Set loses when simplices are put into a mesh, or gains when they are taken away.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <volccd/culling/detail/o_set_touch.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Let B be the elements that stay, C simplices (tetrahedra, triangles) that come or go. Of the features that elements
/// of B have, the pairs in the minimal O-Set of B, but not in that of B with C: all of the elements of B incident to a
/// and to b are adjacent, but some x of C incident to a is apart from some element of B or C incident to b, or the
/// other way round. Both changes of Section 5.1 are this one set: what goes away with C brings these pairs, what comes
/// with C ends them.
///
/// Why not look at all pairs of the features touched: x is apart from few of the elements that touch all of inc(a),
/// mostly from none, and such an element must touch the neighbours of x at vertices that x does not have. For a pair of
/// touched features the question is asked from both sides; the answer of one is dropped.
///
/// C comes as vertices, not as elements: what has gone is in no table any more.
class OSetDifference {
 public:
  /// Vertices of an element of C; a triangle repeats one.
  using Simplex = std::array<Index, 4>;

  static constexpr std::size_t kMaxIncident = ElementTouch::kBits - 1;

  /// `absent` elements belong to the mesh, but not to B. The features for which skip_* holds have no part in it: at
  /// least those without an element of B, and those touched by C that have more than kMaxIncident.
  OSetDifference(const Features& features, const ElementVertices& vertices, ElementTouch& touch,
                 std::span<const std::uint8_t> absent)
      : features_(features), vertices_(vertices), touch_(touch), absent_(absent) {}

  /// Room by vertex, all 0; is left so.
  void set_changed(std::span<const Simplex> changed, std::vector<Index>& runs_of_vertex);
  ~OSetDifference();
  OSetDifference(const OSetDifference&) = delete;
  OSetDifference& operator=(const OSetDifference&) = delete;

  /// vf(v, f) and ee(a, b) once for each pair; consecutive calls mostly have the same v or f, or the same a.
  template <class Skip, class TakeVf, class TakeEe>
  void run(const Mesh& mesh, const Skip& skip, TakeVf&& vf, TakeEe&& ee) {
    for (Index k = 0; k < changed_.size(); ++k) {
      for_vertices(k, [&](Index v) {
        if (!skip.vertex(v)) from_vertex(k, v, skip, vf);
      });
      for_triangles(k, [&](Index f) {
        if (!skip.triangle(f)) from_triangle(k, f, mesh, skip, vf);
      });
      for_edges(k, [&](Index e) {
        if (!skip.edge(e)) from_edge(k, e, skip, ee);
      });
    }
  }

 private:
  static constexpr std::uint64_t kOfChanged = std::uint64_t{1} << kMaxIncident;

  template <class Visit>
  void for_vertices(Index k, Visit&& visit) const {
    const Simplex& s = changed_[k];
    for (std::size_t i = 0; i < corners(s); ++i) visit(s[i]);
  }
  template <class Visit>
  void for_edges(Index k, Visit&& visit) const {
    const Simplex& s = changed_[k];
    for (std::size_t i = 0; i < corners(s); ++i)
      for (std::size_t j = i + 1; j < corners(s); ++j)
        if (const Index e = features_.find_edge(s[i], s[j]); e != kNone) visit(e);
  }
  template <class Visit>
  void for_triangles(Index k, Visit&& visit) const {
    const Simplex& s = changed_[k];
    for (std::size_t out = corners(s) == 4 ? 0 : 3; out < 4; ++out)
      if (const Index f = features_.find_triangle(s[out == 0 ? 1 : 0], s[out <= 1 ? 2 : 1], s[out <= 2 ? 3 : 2]);
          f != kNone)
        visit(f);
  }
  static std::size_t corners(const Simplex& s) { return s[3] == s[0] ? 3 : 4; }

  template <class Skip, class Take>
  void from_vertex(Index k, Index v, const Skip& skip, Take&& take) {
    if (!find_gained(k, {&v, 1}, features_.vertex_elements(v))) return;
    each_partner([&](Index o) { return features_.element_triangles(o); },
                 [&](Index y, auto&& visit) { for_triangles(y, visit); },
                 [&](Index f) { return features_.triangle_elements(f); },
                 [&](Index f) {
                   if (!skip.triangle(f)) take(v, f);
                 });
  }
  template <class Skip, class Take>
  void from_triangle(Index k, Index f, const Mesh& mesh, const Skip& skip, Take&& take) {
    const std::array<Index, 3> t = features_.triangle(f);
    if (!find_gained(k, t, features_.triangle_elements(f))) return;
    each_partner([&](Index o) { return mesh.vertices(o); }, [&](Index y, auto&& visit) { for_vertices(y, visit); },
                 [&](Index v) { return features_.vertex_elements(v); },
                 [&](Index v) {
                   if (!skip.vertex(v) && !found_from({&v, 1}, features_.vertex_elements(v))) take(v, f);
                 });
  }
  template <class Skip, class Take>
  void from_edge(Index k, Index e, const Skip& skip, Take&& take) {
    const std::array<Index, 2> ends = features_.edge(e);
    if (!find_gained(k, ends, features_.edge_elements(e))) return;
    each_partner([&](Index o) { return features_.element_edges(o); },
                 [&](Index y, auto&& visit) { for_edges(y, visit); },
                 [&](Index e2) { return features_.edge_elements(e2); },
                 [&](Index e2) {
                   if (skip.edge(e2)) return;
                   if (e2 < e && found_from(features_.edge(e2), features_.edge_elements(e2))) return;
                   take(e, e2);
                 });
  }

  /// take(b) for the features b of the gained elements of which all elements of B touch all of those of a, once.
  /// Everything is all over memory: candidates are collected first, so that some are on the way while others are
  /// collected.
  template <class OfElement, class OfChanged, class Incident, class Take>
  void each_partner(OfElement&& of_element, OfChanged&& of_changed, Incident&& incident, Take&& take) {
    candidates_.clear();
    const auto collect = [&](Index b) {
      if (touch_.first_visit(b)) candidates_.push_back({b, incident(b)});
    };
    for (Index o : gained_)
      for (Index b : of_element(o)) collect(b);
    for (Index y : gained_changed_) of_changed(y, collect);
    for (const Candidate& c : candidates_)
      if (!c.inc.empty()) prefetch(c.inc[0]);
    for (const Candidate& c : candidates_)
      if (covered(c.inc)) take(c.b);
    touch_.clear();
  }
  void prefetch(Index o) const {
    __builtin_prefetch(vertices_[o].data());
    touch_.prefetch(o);
  }

  /// False if nothing is gained, or if it is for an earlier element of C to ask: then no bits are set. Otherwise base_
  /// = elements of B in inc(a), each with its bit set; gained_, gained_changed_ = elements of B and of C that touch all
  /// of them, but not all elements of C incident to a.
  bool find_gained(Index k, std::span<const Index> a, std::span<const Index> inc);
  /// Adds those that have none of the vertices with the bit kOfChanged.
  void gain_apart_from_changed();
  /// Whether all elements of B in inc touch all of base_.
  bool covered(std::span<const Index> inc);
  /// Whether the pair {a,b}, b with these vertices and incident elements, is also found from b.
  bool found_from(std::span<const Index> b, std::span<const Index> inc) const;
  bool apart(const Simplex& x, std::span<const Index> vertices) const;

  std::span<const Index> changed_at(Index v) const;
  template <class Visit>
  bool any_changed(std::span<const Index> vertices, Visit&& visit) const {
    for (Index k : changed_at(vertices[0])) {
      bool incident = true;
      for (std::size_t i = 1; i < vertices.size() && incident; ++i) {
        const std::span<const Index> other = changed_at(vertices[i]);
        incident = std::find(other.begin(), other.end(), k) != other.end();
      }
      if (incident && visit(k)) return true;
    }
    return false;
  }
  bool in_base(Index o) const { return absent_.empty() || absent_[o] == 0; }

  const Features& features_;
  const ElementVertices& vertices_;
  ElementTouch& touch_;
  std::span<const std::uint8_t> absent_;  ///< by element; empty: none

  std::span<const Simplex> changed_;
  std::vector<Index>* runs_of_vertex_ = nullptr;  ///< by vertex: 1 + start of its run in entries_; 0: none
  std::vector<Index> runs_;                       ///< by vertex of C: {n, elements of C, ascending}
  std::vector<Index> base_, of_a_, gained_, gained_changed_;
  struct Candidate {
    Index b;
    std::span<const Index> inc;
  };
  std::vector<Candidate> candidates_;
};

}  // namespace volccd::detail
