// Unique features of a mesh and their incidence with elements.
//
// Each vertex, edge and triangle is stored once. The boundary of an element is triangulated: a quad face is split by
// the diagonal through its vertex of smallest slot (= smallest id), a face of a polytope into a fan of triangles around
// that vertex. Therefore all elements that share a face have the same triangles. Edge sets:
//   triangulated   polytope edges and face diagonals; complete even if faces are not planar (default)
//   polytope       without the diagonals, as the paper counts: a hexahedron has 12 edges (Section 3.4)
//   none           neither edges nor triangles: for a mesh of which only element pairs are requested
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/core/named_values.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/mesh.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>
#include <volccd/mesh/tables/tuple_table.hpp>

namespace volccd {

namespace detail {
class FeatureEdit;

/// The incident elements of all features of one kind.
struct Incidence {
  IncidencePool elements;  ///< incident elements of each feature, ascending
  RawVector<Index> first;  ///< elements[i].front(), or kNone
  IncidencePool own;       ///< for each element, the features i with first[i] == element, ascending; empty for
                           ///< vertices

  std::size_t bytes() const { return heap_bytes(elements, first, own); }
};

/// The edges (N = 2) or the triangles (N = 3).
template <std::size_t N>
struct TupleFeatures {
  RawVector<std::array<Index, N>> tuples;  ///< vertex slots, ascending
  TupleTable<N> table;
  Incidence incidence;
  IncidencePool of_element;
  std::vector<Index> free;  ///< slots without a live feature

  std::size_t bytes() const { return heap_bytes(tuples, table, incidence, of_element, free); }
};

}  // namespace detail

enum class EdgeSet { triangulated, polytope, none };
constexpr std::array<NamedValue<EdgeSet>, 2> names_of(EdgeSet) {
  return {{{"triangulated", EdgeSet::triangulated}, {"polytope", EdgeSet::polytope}}};
}

/// The features that an edit changes. Each list is ascending and contains no slot twice.
struct FeatureChange {
  /// Features that lost all of their elements. If the slot already holds a new feature, it is in `added_*` as well.
  std::vector<Index> removed_vertices, removed_edges, removed_triangles;
  /// Features that have elements now, but had none before the edit or after its removals.
  std::vector<Index> added_vertices, added_edges, added_triangles;
  /// Live features, including new ones, whose incident elements changed.
  std::vector<Index> touched_vertices, touched_edges, touched_triangles;
};

/// A feature is live while it has incident elements. It keeps its slot during that time; afterwards another feature may
/// take the slot. Incident elements are in ascending order of slots. This is the order of inc(a) x inc(b) on which
/// assignment relies (Algorithm 5), and it does not depend on the history of edits. Read-only use is thread-safe.
class Features {
 public:
  explicit Features(EdgeSet edge_set = EdgeSet::triangulated) : edge_set_(edge_set) {}

  EdgeSet edge_set() const { return edge_set_; }

  /// Replaces the contents by the features of `mesh`. Expected time O(elements). After edits, Topology::apply() updates
  /// the features together with their mesh. All workers of the executor take part; the features do not depend on it.
  void build(const Mesh& mesh, Executor& executor = serial_executor());

  /// Numbers of slots, including those without a live feature.
  Index vertex_slots() const { return static_cast<Index>(vertex_incidence_.elements.size()); }
  Index edge_slots() const { return static_cast<Index>(edges_.tuples.size()); }
  Index triangle_slots() const { return static_cast<Index>(triangles_.tuples.size()); }
  /// Numbers of live features.
  Index vertex_count() const { return live_vertices_; }
  Index edge_count() const { return static_cast<Index>(edges_.table.size()); }
  Index triangle_count() const { return static_cast<Index>(triangles_.table.size()); }

  /// Vertex slots, ascending. The content is undefined if the feature is not live.
  const std::array<Index, 2>& edge(Index e) const { return edges_.tuples[e]; }
  const std::array<Index, 3>& triangle(Index f) const { return triangles_.tuples[f]; }

  /// Incident elements, ascending. Empty if the feature is not live (for a vertex: if no element uses it).
  std::span<const Index> vertex_elements(Index v) const { return vertex_incidence_.elements[v]; }
  std::span<const Index> edge_elements(Index e) const { return edges_.incidence.elements[e]; }
  std::span<const Index> triangle_elements(Index f) const { return triangles_.incidence.elements[f]; }

  /// The first (smallest) incident element, in a separate array for fast random access; kNone if there is none.
  Index first_element_of_vertex(Index v) const { return vertex_incidence_.first[v]; }
  Index first_element_of_edge(Index e) const { return edges_.incidence.first[e]; }
  Index first_element_of_triangle(Index f) const { return triangles_.incidence.first[f]; }

  /// The features whose first incident element is o, ascending. Each live edge and triangle is in exactly one such
  /// list.
  std::span<const Index> own_edges(Index o) const { return edges_.incidence.own[o]; }
  std::span<const Index> own_triangles(Index o) const { return triangles_.incidence.own[o]; }

  /// Edges and triangles of an element, in a local order that its type and vertex order determine; empty for an empty
  /// slot. The vertices of the element are Mesh::vertices.
  std::span<const Index> element_edges(Index o) const { return edges_.of_element[o]; }
  std::span<const Index> element_triangles(Index o) const { return triangles_.of_element[o]; }

  /// Slot of the live edge or triangle with these vertices (in any order), or kNone. O(1) expected.
  Index find_edge(Index v0, Index v1) const;
  Index find_triangle(Index v0, Index v1, Index v2) const;

  std::size_t bytes() const { return heap_bytes(vertex_incidence_, edges_, triangles_); }

 private:
  friend class detail::FeatureEdit;

  EdgeSet edge_set_;
  detail::Incidence vertex_incidence_;
  detail::TupleFeatures<2> edges_;
  detail::TupleFeatures<3> triangles_;
  Index live_vertices_ = 0;
};

/// Visits the triangulated boundary of element o: calls edge(v0, v1) for each edge of the edge set and triangle(v0, v1,
/// v2) for each triangle; nothing for EdgeSet::none. The arguments are vertex slots in no particular order. Each edge
/// and each triangle of the element is visited once.
template <class EdgeVisitor, class TriangleVisitor>
void visit_boundary(const Mesh& mesh, Index o, EdgeSet edge_set, EdgeVisitor&& edge, TriangleVisitor&& triangle);

/// The boundary triangles of live element o, each as three vertex slots in the cyclic order of its face. For a volume
/// element of positive volume in VTK's node order they are oriented outward; for a polytope they have the orientation
/// of its stored faces. If two faces of a degenerate polytope have the same triangle, it is returned twice.
std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o);

}  // namespace volccd

#include <volccd/mesh/detail/visit_boundary.hpp>
