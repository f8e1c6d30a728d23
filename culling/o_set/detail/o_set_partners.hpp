// Finds the features that form an O-Set pair with a given feature.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <vector>

#include <volccd/culling/o_set/detail/o_set_touch.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd::detail {

/// For a feature a, let I(a) be the set of elements adjacent to every element of inc(a). {a,b} is in the minimal O-Set
/// iff inc(b) is a subset of I(a). {a,b} is in the literal set (Algorithm 3) iff inc(b) intersects I(a) and inc(a)
/// intersects I(b): a pair (oi, oj) passes both loops of the algorithm iff oi is in I(b) and oj is in I(a), which
/// implies that they are adjacent.
///
/// I(a) consists of the elements with a vertex of a, and of further elements, which must have another common vertex
/// with each element of inc(a). These are searched for around the element of inc(a) that has the fewest neighbours.
///
/// A partner b is examined once, for its first incident element; in the literal case, where that element need not be in
/// I(a), for its first incident element in I(a).
class OSetPartners {
 public:
  OSetPartners(const Topology& topology, bool literal, ElementTouch& touch)
      : mesh_(topology.mesh()),
        features_(topology.features()),
        adjacency_(topology.adjacency()),
        literal_(literal),
        touch_(touch) {}

  /// Calls report(f) once for each triangle f that forms an O-Set pair with vertex v.
  template <class Report>
  void triangles_of_vertex(Index v, Report&& report) {
    const auto apart = [&](Index f, Index) {
      const auto& t = features_.triangle(f);
      return t[0] != v && t[1] != v && t[2] != v;
    };
    const auto of_element = [&](Index o) {
      return literal_ ? features_.element_triangles(o) : features_.own_triangles(o);
    };
    const auto incident = [&](Index f) { return features_.triangle_elements(f); };
    visit({&v, 1}, features_.vertex_elements(v), of_element, incident, apart, report);
  }

  /// Calls report(v) once for each vertex v that forms an O-Set pair with triangle f and for which wanted(v) is true.
  template <class Wanted, class Report>
  void vertices_of_triangle(Index f, Wanted&& wanted, Report&& report) {
    const std::array<Index, 3> t = features_.triangle(f);
    const auto apart = [&](Index v, Index o) {
      const bool once = literal_ || features_.first_element_of_vertex(v) == o;
      return once && v != t[0] && v != t[1] && v != t[2] && wanted(v);
    };
    const auto of_element = [&](Index o) { return mesh_.vertices(o); };
    const auto incident = [&](Index v) { return features_.vertex_elements(v); };
    visit(t, features_.triangle_elements(f), of_element, incident, apart, report);
  }

  /// Calls report(e2) once for each edge e2 that forms an O-Set pair with edge e and for which wanted(e2) is true.
  template <class Wanted, class Report>
  void edges_of_edge(Index e, Wanted&& wanted, Report&& report) {
    const std::array<Index, 2> a = features_.edge(e);
    const auto apart = [&](Index e2, Index) {
      if (!wanted(e2)) return false;
      const auto& b = features_.edge(e2);
      return b[0] != a[0] && b[0] != a[1] && b[1] != a[0] && b[1] != a[1];
    };
    const auto of_element = [&](Index o) { return literal_ ? features_.element_edges(o) : features_.own_edges(o); };
    const auto incident = [&](Index e2) { return features_.edge_elements(e2); };
    visit(a, features_.edge_elements(e), of_element, incident, apart, report);
  }

 private:
  /// Accepts the elements of I(a) in touch_, for a feature with these vertices and incident elements.
  void find_covering(std::span<const Index> vertices, std::span<const Index> inc);
  void find_far(std::span<const Index> vertices, std::span<const Index> inc);
  Index pivot(std::span<const Index> vertices, std::span<const Index> inc) const;

  /// Finds the partners of a feature with these vertices and incident elements, among the features of_element(o).
  template <class OfElement, class Incident, class Wanted, class Report>
  void visit(std::span<const Index> vertices, std::span<const Index> inc_a, OfElement&& of_element, Incident&& incident,
             Wanted&& wanted, Report&& report) {
    find_covering(vertices, inc_a);
    const auto visit_all = [&](auto literal) {
      for (Index o : touch_.accepted_elements())
        for (Index b : of_element(o)) {
          if (!wanted(b, o)) continue;
          const std::span<const Index> inc = incident(b);
          if (literal() ? first_covering(inc) == o && some_touches_all(inc_a, inc) : others_cover(inc)) report(b);
        }
    };
    literal_ ? visit_all(std::true_type()) : visit_all(std::false_type());
  }
  bool others_cover(std::span<const Index> inc) const {
    for (std::size_t i = 1; i < inc.size(); ++i)
      if (!touch_.accepted(inc[i])) return false;
    return true;
  }
  Index first_covering(std::span<const Index> inc) const {
    return *std::find_if(inc.begin(), inc.end(), [&](Index o) { return touch_.accepted(o); });
  }
  bool some_touches_all(std::span<const Index> some, std::span<const Index> all) const;

  const Mesh& mesh_;
  const Features& features_;
  const Adjacency& adjacency_;
  const bool literal_;
  ElementTouch& touch_;
};

}  // namespace volccd::detail
