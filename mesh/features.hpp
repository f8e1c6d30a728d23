// Unique features of a mesh and their incidence with elements.
//
// Vertices, edges and triangles, each once. The boundary of an element is triangulated: a quad face is split by the
// diagonal through its vertex of smallest slot (= smallest id), a face of a polytope into a fan around it, so that all
// elements that share a face agree. Edge sets:
//   triangulated   polytope edges and face diagonals: complete also where faces are not planar (default)
//   polytope       without the diagonals: the paper's counts, a hexahedron has 12 edges (Section 3.4)
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/detail/tuple_table.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

namespace detail {
class FeatureEdit;
}

enum class EdgeSet { triangulated, polytope };

/// Which features a change of topology touched. All lists ascend and hold no slot twice.
struct FeatureChange {
  /// Features that died (vertices: are used by no element any more). Their slots may already stand for new features:
  /// those are in `added_*` too.
  std::vector<Index> removed_vertices, removed_edges, removed_triangles;
  /// New features (vertices: used now, but not by any element before or not after the removals).
  std::vector<Index> added_vertices, added_edges, added_triangles;
  /// Live features, new ones included, whose incident elements changed.
  std::vector<Index> touched_vertices, touched_edges, touched_triangles;
};

/// Feature slots are stable while the feature lives; a dead feature has no incident elements and its slot is used
/// again. Incident elements ascend by slot: the order of inc(a) x inc(b) that assignment relies on (Algorithm 5),
/// independent of the history of changes. Read-only use is thread-safe.
class Features {
 public:
  explicit Features(EdgeSet edge_set = EdgeSet::triangulated) : edge_set_(edge_set) {}

  EdgeSet edge_set() const { return edge_set_; }

  /// Everything from scratch. O(elements) expected. Topology::apply() changes features with their mesh.
  void build(const Mesh& mesh);

  /// Ranges of slots, dead ones included.
  Index vertex_slots() const { return static_cast<Index>(vertex_elements_.size()); }
  Index edge_slots() const { return static_cast<Index>(edges_.size()); }
  Index triangle_slots() const { return static_cast<Index>(triangles_.size()); }
  /// Live features.
  Index vertex_count() const { return live_vertices_; }
  Index edge_count() const { return static_cast<Index>(edge_table_.size()); }
  Index triangle_count() const { return static_cast<Index>(triangle_table_.size()); }

  /// Vertex slots, ascending. Undefined content for a dead slot.
  const std::array<Index, 2>& edge(Index e) const { return edges_[e]; }
  const std::array<Index, 3>& triangle(Index f) const { return triangles_[f]; }

  /// Incident elements, ascending; empty: the feature is dead (vertex: unused).
  std::span<const Index> vertex_elements(Index v) const { return vertex_elements_[v]; }
  std::span<const Index> edge_elements(Index e) const { return edge_elements_[e]; }
  std::span<const Index> triangle_elements(Index f) const { return triangle_elements_[f]; }

  /// Features of an element, in a fixed local order given by its type and vertex order; empty for an empty slot. Its
  /// vertices are Mesh::vertices.
  std::span<const Index> element_edges(Index o) const { return element_edges_[o]; }
  std::span<const Index> element_triangles(Index o) const { return element_triangles_[o]; }

  /// Slot of a live edge or triangle with these vertices (any order), or kNone. O(1) expected.
  Index find_edge(Index v0, Index v1) const;
  Index find_triangle(Index v0, Index v1, Index v2) const;

  std::size_t bytes() const;

 private:
  friend class detail::FeatureEdit;

  EdgeSet edge_set_;
  std::vector<std::array<Index, 2>> edges_;
  std::vector<std::array<Index, 3>> triangles_;
  detail::TupleTable<2> edge_table_;
  detail::TupleTable<3> triangle_table_;
  detail::IncidencePool vertex_elements_, edge_elements_, triangle_elements_;
  detail::IncidencePool element_edges_, element_triangles_;
  std::vector<Index> free_edges_, free_triangles_;
  Index live_vertices_ = 0;
};

/// Visits the triangulated boundary of element o: edge(v0, v1) for each edge of the edge set, triangle(v0, v1, v2) for
/// each triangle, as vertex slots in any order; each edge and each triangle of the element once.
template <class EdgeVisitor, class TriangleVisitor>
void visit_boundary(const Mesh& mesh, Index o, EdgeSet edge_set, EdgeVisitor&& edge, TriangleVisitor&& triangle);

}  // namespace volccd

#include <volccd/mesh/detail/visit_boundary.hpp>
