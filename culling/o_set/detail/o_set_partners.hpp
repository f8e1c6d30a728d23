// Finds the features that form an O-Set pair with given features.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <volccd/culling/o_set/detail/o_set_blocks.hpp>
#include <volccd/culling/o_set/detail/o_set_touch.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd::detail {

/// The elements at a feature.
template <OSetBlocks::Owner kind>
std::span<const Index> elements_at(const Features& features, Index feature) {
  if constexpr (kind == OSetBlocks::Owner::edge) return features.edge_elements(feature);
  if constexpr (kind == OSetBlocks::Owner::triangle) return features.triangle_elements(feature);
  return features.vertex_elements(feature);
}

/// For a feature a, let I(a) be the set of elements adjacent to every element of inc(a). {a,b} is in the minimal O-Set
/// iff inc(b) is a subset of I(a). {a,b} is in the literal set (Algorithm 3) iff inc(b) intersects I(a) and inc(a)
/// intersects I(b): a pair (oi, oj) passes both loops of the algorithm iff oi is in I(b) and oj is in I(a), which
/// implies that they are adjacent.
///
/// All this depends on the incident elements alone: features with the same ones are searched for once. A prism of a
/// thickened shell has two vertices and an edge with the same elements at each corner.
///
/// I(a) consists of the elements with a vertex of a, and of further elements, which must have another common vertex
/// with each element of inc(a). These are searched for around the element of inc(a) that has the fewest neighbours.
///
/// A partner b is examined once, for its first incident element; in the literal case, where that element need not be in
/// I(a), for its first incident element in I(a).
class OSetPartners {
 public:
  using Owner = OSetBlocks::Owner;

  OSetPartners(const Topology& topology, OSetKind kind, bool leave_out_shell_neighbours, ElementTouch& touch)
      : mesh_(topology.mesh()),
        features_(topology.features()),
        adjacency_(topology.adjacency()),
        literal_(kind == OSetKind::literal),
        leave_out_shell_neighbours_(leave_out_shell_neighbours),
        touch_(touch) {}

  /// For each a of `features`, which are ascending and have the same incident elements, calls begin(a) and then, once
  /// for each b that forms an O-Set pair with a and for which wanted(a, b) is true, report(b). b is a triangle for a
  /// vertex, a vertex for a triangle, and an edge for an edge. What is not wanted for one a must not be wanted for a
  /// later one.
  template <Owner owner, class Wanted, class Begin, class Report>
  void find(std::span<const Index> features, Wanted&& wanted, Begin&& begin, Report&& report) {
    constexpr Owner kind = partner_of(owner);
    const Index first = features.front();
    if (features.size() == 1) {  // as in most meshes of volumes
      begin(first);
      const Labels labels = labels_of<owner>(first);
      return visit<owner>(
          first, [&](Index b) { return wanted(first, b) && is_test<owner>(labels, labels_of<kind>(b)); }, report);
    }
    partners_.clear();
    visit<owner>(
        first, [&](Index b) { return wanted(first, b); },
        [&](Index b) {
          partners_.push_back({b, labels_of<kind>(b)});
        });
    for (const Index a : features) {
      begin(a);
      const Labels labels = labels_of<owner>(a);
      for (const Partner& b : partners_)
        if (wanted(a, b.feature) && is_test<owner>(labels, b.labels)) report(b.feature);
    }
  }

 private:
  /// Vertices of a feature, or those of the shell mesh that they correspond to if pairs with a common one are left out.
  using Labels = std::array<Index, 3>;
  struct Partner {
    Index feature;
    Labels labels;
  };
  static constexpr Owner partner_of(Owner owner) {
    return owner == Owner::edge ? owner : owner == Owner::vertex ? Owner::triangle : Owner::vertex;
  }

  template <Owner owner>
  static bool is_test(const Labels& a, const Labels& b) {
    if constexpr (owner == Owner::edge) return a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1];
    if constexpr (owner == Owner::vertex) return a[0] != b[0] && a[0] != b[1] && a[0] != b[2];
    return a[0] != b[0] && a[1] != b[0] && a[2] != b[0];
  }
  template <Owner kind>
  std::span<const Index> vertices_of(const Index& feature) const {
    if constexpr (kind == Owner::edge) return features_.edge(feature);
    if constexpr (kind == Owner::triangle) return features_.triangle(feature);
    return {&feature, 1};
  }
  /// Features of element o; at least those that it is the first element of.
  template <Owner kind>
  std::span<const Index> features_of(Index o) const {
    if constexpr (kind == Owner::edge) return literal_ ? features_.element_edges(o) : features_.own_edges(o);
    if constexpr (kind == Owner::triangle)
      return literal_ ? features_.element_triangles(o) : features_.own_triangles(o);
    return mesh_.vertices(o);
  }
  template <Owner kind>
  Labels labels_of(Index feature) const {
    Labels labels{};
    const std::span<const Index> vertices = vertices_of<kind>(feature);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      labels[i] = leave_out_shell_neighbours_ ? shell_vertex(vertices[i]) : vertices[i];
    return labels;
  }

  /// Calls found(b) once for each b that forms an O-Set pair with a, as far as their elements decide, and for which
  /// wanted(b) is true.
  template <Owner owner, class Wanted, class Found>
  void visit(Index a, Wanted&& wanted, Found&& found) {
    constexpr Owner kind = partner_of(owner);
    const std::span<const Index> inc_a = elements_at<owner>(features_, a);
    find_covering(vertices_of<owner>(a), inc_a);
    for (const Index o : touch_.accepted_elements())
      for (const Index b : features_of<kind>(o)) {
        if (!wanted(b)) continue;
        const std::span<const Index> inc = elements_at<kind>(features_, b);
        const bool in_set = literal_ ? first_covering(inc) == o && some_touches_all(inc_a, inc)
                                     : inc.front() == o && covers(inc.subspan(1));
        if (in_set) found(b);
      }
  }

  /// Accepts the elements of I(a) in touch_, for a feature with these vertices and incident elements.
  void find_covering(std::span<const Index> vertices, std::span<const Index> inc);
  void find_far(std::span<const Index> vertices, std::span<const Index> inc);
  Index pivot(std::span<const Index> vertices, std::span<const Index> inc) const;

  bool covers(std::span<const Index> inc) const {
    return std::ranges::all_of(inc, [&](Index o) { return touch_.accepted(o); });
  }
  Index first_covering(std::span<const Index> inc) const {
    return *std::ranges::find_if(inc, [&](Index o) { return touch_.accepted(o); });
  }
  bool some_touches_all(std::span<const Index> some, std::span<const Index> all) const;

  const Mesh& mesh_;
  const Features& features_;
  const Adjacency& adjacency_;
  const bool literal_, leave_out_shell_neighbours_;
  ElementTouch& touch_;
  std::vector<Partner> partners_;
};

}  // namespace volccd::detail
