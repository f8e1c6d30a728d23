// The stars of vertices in a mesh of any elements, as far as the topology determines them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/detail/boundary_rings.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd::detail {

/// The star of a vertex consists of all elements at the vertex.
enum class StarKind : std::uint8_t {
  unused,
  /// Volume elements only, and each of their faces at the vertex is an inner face.
  interior,
  /// Volume elements only, whose faces at the vertex are inner faces and boundary faces, or shells only, all of whose
  /// faces are boundary faces. The sides of the boundary faces that do not contain the vertex form one closed ring.
  ring,
  /// Anything else, and every star that contains a polytope.
  irregular
};

/// A face of a volume element is an inner face if it has exactly two elements, which have all its vertices in opposite
/// cyclic order; a boundary face if it has a single element; otherwise irregular. A shell is a boundary face.
enum class FaceKind : std::uint8_t { none, inner, boundary, irregular };

/// A ring of directed sides of faces, in no particular order: (first vertex, second vertex).
using RingSides = std::vector<std::array<Index, 2>>;

/// The kinds of all stars and faces of a topology (docs/clear_stars.md, condition 1). Not thread-safe; uses the
/// executor.
class StarTable {
 public:
  /// Updates the table for the topology. The time is proportional to the size of the change. Returns the extent of the
  /// change.
  TopologyDelta::Extent update(const Topology& topology, Executor& executor);

  StarKind kind(Index v) const { return kinds_[v]; }
  /// Vertices whose stars changed in the last update.
  const std::vector<Index>& changed_vertices() const { return changed_vertices_; }
  /// Whether the star of v consists of shells. Pre: its kind is `ring`.
  static bool has_shells(const Topology& topology, Index v) {
    return is_shell(topology.mesh().type(topology.features().vertex_elements(v)[0]));
  }
  /// For StarKind::ring: the sides that form the ring, in `scratch`. Each forms a triangle with v; all rings of an
  /// orientable part have the same orientation. Empty for other kinds.
  const RingSides& ring(const Topology& topology, Index v, RingSides& scratch) const;

  /// The kinds of the faces of element o, in the order of its face stream.
  const std::array<FaceKind, 6>& faces(Index o) const { return faces_[o]; }
  /// Whether two tetrahedra have an inner face in common.
  bool share_inner_face(const Mesh& mesh, Index a, Index b) const;
  /// The boundary faces that have a vertex v with a ring and judged[v] != 0. A quad becomes four triangles, so that
  /// each vertex is tested with the two triangles of the mesh and with the two that have it in common.
  std::vector<RingFace> boundary_faces(const Topology& topology, std::span<const std::uint8_t> judged) const;

  std::size_t bytes() const { return heap_bytes(delta_, kinds_, changed_vertices_, faces_, scratch_); }

 private:
  void sync_vertices(const Topology& topology, TopologyDelta::Extent changed);
  void set_faces(const Topology& topology, Index o);
  StarKind kind_of(const Topology& topology, Index v, RingSides& scratch) const;
  bool find_sides(const Topology& topology, Index v, RingSides& sides) const;

  TopologyDelta delta_;
  std::vector<StarKind> kinds_;                 ///< by vertex
  std::vector<std::array<FaceKind, 6>> faces_;  ///< by element slot
  std::vector<Index> changed_vertices_;
  std::vector<RingSides> scratch_;  ///< by worker
};

/// The face of a tetrahedron opposite to its vertex i, outward for positive volume.
inline std::array<Index, 3> face_opposite(std::span<const Index> vertices, std::size_t i) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  return {vertices[kFaces[i][0]], vertices[kFaces[i][1]], vertices[kFaces[i][2]]};
}

/// Calls visit(face, number) for each face of an element with a face stream; `face` contains vertex slots in cyclic
/// order, outward for a volume element of positive volume.
template <class Visit>
void visit_faces(const Mesh& mesh, Index o, Visit&& visit) {
  const std::span<const Index> v = mesh.vertices(o);
  std::array<Index, 4> face;
  std::size_t number = 0;
  volccd::visit_faces(face_stream(mesh.type(o)), [&](std::span<const std::uint8_t> numbers) {
    for (std::size_t j = 0; j < numbers.size(); ++j) face[j] = v[numbers[j]];
    visit(std::span<const Index>(face.data(), numbers.size()), number++);
  });
}

}  // namespace volccd::detail
