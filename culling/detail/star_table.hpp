// What the flood must know of a simplicial complex apart from positions: faces, and stars of vertices.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd::detail {

enum class StarKind : std::uint8_t {
  unused,
  /// Tetrahedra whose faces at the vertex have two tetrahedra each, connected through these faces.
  interior,
  /// Tetrahedra, or triangles, connected in the same way, whose boundary faces at the vertex form one closed ring.
  ring,
  irregular  ///< anything else
};

/// Of the elements of a topology of tetrahedra and triangles. One thread at a time; uses the executor.
class StarTable {
 public:
  /// Across the face opposite to vertex i of a tetrahedron.
  struct Neighbour {
    Index element = kNone;  ///< kNone: none, or not exactly one
    bool opposite = false;  ///< both node orders together orient the complex; without an element: the face has others
  };

  /// The face opposite to vertex i of a tetrahedron with these vertices, oriented outward where its volume is positive.
  static std::array<Index, 3> face_of(std::span<const Index> vertices, std::size_t i) {
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    return {vertices[kFaces[i][0]], vertices[kFaces[i][1]], vertices[kFaces[i][2]]};
  }

  /// Brings the table up to the topology. Time proportional to the change. Returns the extent of the change.
  TopologyDelta::Extent update(const Topology& topology, Executor& executor);
  /// Vertices whose stars changed in the last update that returned `edits`.
  const std::vector<Index>& changed_vertices() const { return changed_vertices_; }

  StarKind kind(Index v) const { return kinds_[v]; }
  /// Room for one ring, reused.
  struct Ring {
    std::vector<std::array<Index, 2>> open;
    std::vector<Index> vertices;
  };
  /// StarKind::ring: the other vertices of the boundary faces at v, in cyclic order, oriented alike in all rings of an
  /// orientable part; consecutive ones and the last with the first span a face with v. Empty for other kinds.
  std::span<const Index> ring(const Topology& topology, Index v, Ring& scratch) const;
  const std::array<Neighbour, 4>& neighbours(Index tetrahedron) const { return neighbours_[tetrahedron]; }
  /// A tetrahedron one of whose faces has other elements, but not just one tetrahedron.
  bool shares_a_face_with_several(Index tetrahedron) const {
    for (const Neighbour& across : neighbours_[tetrahedron])
      if (across.element == kNone && across.opposite) return true;
    return false;
  }
  /// A triangle, a tetrahedron with a face that not exactly two have, or an element with a vertex of an irregular star.
  bool on_boundary(Index o) const { return on_boundary_[o] != 0; }

  std::size_t bytes() const;

 private:
  /// Of one worker.
  struct Scratch {
    std::vector<Index> places;   ///< by element slot: its place in the star at hand
    std::vector<Index> corners;  ///< by vertex: one of its corners in the star at hand
    std::vector<Index> parents;
    std::vector<std::array<Index, 2>> open;
  };

  void set_neighbours(const Topology& topology, Index triangle);
  StarKind kind_of(const Topology& topology, Index v, Scratch& scratch) const;
  bool joins_up(const Topology& topology, Index v, Scratch& scratch) const;
  void find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const;
  static bool order_ring(std::vector<std::array<Index, 2>>& open, std::vector<Index>& ring);
  void set_kinds(const Topology& topology, std::size_t count, const Index* vertices, Executor& executor);
  void set_boundary(const Topology& topology, Index o);

  TopologyDelta delta_;
  std::vector<std::array<Neighbour, 4>> neighbours_;  ///< by element slot
  std::vector<std::uint8_t> on_boundary_;
  std::vector<StarKind> kinds_;  ///< by vertex
  std::vector<Index> changed_vertices_;
  std::vector<Scratch> scratch_;
};

}  // namespace volccd::detail
