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

/// The incident elements of all features of one kind.
struct Incidence {
  IncidencePool elements;    ///< of each feature, ascending
  std::vector<Index> first;  ///< elements[i].front(), or kNone
  IncidencePool own;         ///< for each element, the features i with first[i] == element, ascending; not for vertices
};

}  // namespace detail

enum class EdgeSet { triangulated, polytope };

/// The features that an edit changes. All lists ascend and hold no slot twice.
struct FeatureChange {
  /// Features that lost all of their elements. The slot may hold a new feature already: then it is in `added_*` too.
  std::vector<Index> removed_vertices, removed_edges, removed_triangles;
  /// Features that have elements now, but had none before the edit, or none between its removals and its additions.
  std::vector<Index> added_vertices, added_edges, added_triangles;
  /// Live features, new ones included, whose incident elements changed.
  std::vector<Index> touched_vertices, touched_edges, touched_triangles;
};

/// A feature is live while it has incident elements, and keeps its slot as long; later the slot is used again. Incident
/// elements ascend by slot: the order of inc(a) x inc(b) that assignment relies on (Algorithm 5), independent of the
/// history of edits. Read-only use is thread-safe.
class Features {
 public:
  explicit Features(EdgeSet edge_set = EdgeSet::triangulated) : edge_set_(edge_set) {}

  EdgeSet edge_set() const { return edge_set_; }

  /// Everything from scratch. O(elements) expected. Topology::apply() changes features with their mesh.
  void build(const Mesh& mesh);

  /// Ranges of slots, those of no live feature included.
  Index vertex_slots() const { return static_cast<Index>(vertex_incidence_.elements.size()); }
  Index edge_slots() const { return static_cast<Index>(edges_.size()); }
  Index triangle_slots() const { return static_cast<Index>(triangles_.size()); }
  /// Live features.
  Index vertex_count() const { return live_vertices_; }
  Index edge_count() const { return static_cast<Index>(edge_table_.size()); }
  Index triangle_count() const { return static_cast<Index>(triangle_table_.size()); }

  /// Vertex slots, ascending. Undefined content unless the feature is live.
  const std::array<Index, 2>& edge(Index e) const { return edges_[e]; }
  const std::array<Index, 3>& triangle(Index f) const { return triangles_[f]; }

  /// Incident elements, ascending; none if the feature is not live (a vertex: not used).
  std::span<const Index> vertex_elements(Index v) const { return vertex_incidence_.elements[v]; }
  std::span<const Index> edge_elements(Index e) const { return edge_incidence_.elements[e]; }
  std::span<const Index> triangle_elements(Index f) const { return triangle_incidence_.elements[f]; }

  /// The first (smallest) of the incident elements, in an array of its own for random access; kNone if there is none.
  Index first_element_of_vertex(Index v) const { return vertex_incidence_.first[v]; }
  Index first_element_of_edge(Index e) const { return edge_incidence_.first[e]; }
  Index first_element_of_triangle(Index f) const { return triangle_incidence_.first[f]; }

  /// The features of which o is the first incident element, ascending: each live edge and triangle is in one such list.
  std::span<const Index> own_edges(Index o) const { return edge_incidence_.own[o]; }
  std::span<const Index> own_triangles(Index o) const { return triangle_incidence_.own[o]; }

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
  detail::Incidence vertex_incidence_, edge_incidence_, triangle_incidence_;
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
