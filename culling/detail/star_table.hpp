// What the flood must know of a simplicial complex apart from positions: faces, and stars of vertices.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/incidence_pool.hpp>
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

/// Of the elements of a topology of tetrahedra and triangles. One thread at a time.
class StarTable {
 public:
  /// Across the face opposite to vertex i of a tetrahedron.
  struct Neighbour {
    Index element = kNone;  ///< kNone: a boundary face, which no other element has
    bool opposite = false;  ///< both node orders together orient the complex
  };

  /// Brings the table up to the topology. Time proportional to the change. Returns the extent of the change.
  TopologyDelta::Extent update(const Topology& topology);
  /// Vertices whose stars changed in the last update that returned `edits`.
  const std::vector<Index>& changed_vertices() const { return changed_vertices_; }

  StarKind kind(Index v) const { return kinds_[v]; }
  /// StarKind::ring: the other vertices of the boundary faces at v, in cyclic order, oriented alike in all rings of an
  /// orientable part; consecutive ones and the last with the first span a face with v.
  std::span<const Index> ring(Index v) const { return rings_[v]; }
  const std::array<Neighbour, 4>& neighbours(Index tetrahedron) const { return neighbours_[tetrahedron]; }
  /// A triangle, a tetrahedron with a boundary face, or an element with a vertex of an irregular star.
  bool on_boundary(Index o) const { return on_boundary_[o] != 0; }

  std::size_t bytes() const;

 private:
  void set_neighbours(const Topology& topology, Index triangle);
  void set_star(const Topology& topology, Index v);
  void set_boundary(const Topology& topology, Index o);
  bool order_ring(Index v);

  TopologyDelta delta_;
  std::vector<std::array<Neighbour, 4>> neighbours_;  ///< by element slot
  std::vector<std::uint8_t> on_boundary_;
  std::vector<StarKind> kinds_;  ///< by vertex
  IncidencePool rings_;
  std::vector<Index> changed_vertices_;
  // Scratch of set_star.
  struct Side {
    std::array<Index, 2> ends;    ///< the edge opposite to v of a face at v, ascending
    std::array<Index, 2> corner;  ///< corners of the link at these ends
    bool swapped;                 ///< the face's element has the ends in the other order
    friend bool operator<(const Side& x, const Side& y) { return x.ends < y.ends; }
  };
  std::vector<Side> sides_;
  std::vector<Index> parents_, corners_, ring_;
  std::vector<std::array<Index, 2>> open_;
};

}  // namespace volccd::detail
