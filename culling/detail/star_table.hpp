// The connectivity of a simplicial complex that the flood uses: neighbours across faces, and stars of vertices.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/boundary_rings.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/query/element_subset.hpp>

namespace volccd::detail {

enum class StarKind : std::uint8_t {
  unused,
  /// Tetrahedra connected through their faces at the vertex, each of which has two tetrahedra.
  interior,
  /// Tetrahedra, or triangles, connected in the same way, whose boundary faces at the vertex form one closed ring.
  ring,
  irregular  ///< anything else
};

/// Memory for one ring, to be reused.
struct Ring {
  std::vector<std::array<Index, 2>> open;  ///< directed sides
  std::vector<Index> vertices;

  /// Sorts the sides into a sequence, the ring of their first vertices. Returns false if they are not one closed ring
  /// with consistent orientation. Pre: there is at least one side.
  bool order();
  std::size_t bytes() const { return heap_bytes(open, vertices); }
};

/// Base of the tables of stars: their kinds. Not thread-safe; uses the executor.
class StarKinds {
 public:
  StarKind kind(Index v) const { return kinds_[v]; }
  /// Vertices whose stars changed in the last update.
  const std::vector<Index>& changed_vertices() const { return changed_vertices_; }
  /// For StarKind::ring: the other vertices of the boundary faces at v in cyclic order, with the same orientation in
  /// all rings of an orientable part. Consecutive vertices, and the last and the first one, form a triangle with v.
  /// Empty for other kinds.
  std::span<const Index> ring(const Topology& topology, Index v, Ring& scratch) const;

 protected:
  ~StarKinds() = default;
  /// Finds the sides of the boundary faces at v that do not contain v, with the orientation of the faces. Returns false
  /// if the star is irregular.
  virtual bool find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const = 0;
  /// The kind by these sides.
  StarKind kind_by_sides(const Topology& topology, Index v, Ring& scratch) const;
  /// Begins an update, which ends with delta_.confirm(). Returns the extent of the change.
  TopologyDelta::Extent sync(const Topology& topology);
  /// Sets the kind of each changed vertex v to kind_of(v, the scratch memory of a worker).
  template <class Scratch, class KindOf>
  void set_kinds(std::vector<Scratch>& scratch, Executor& executor, KindOf&& kind_of) {
    constexpr std::size_t kGrain = 256;
    scratch.resize(executor.workers());
    executor.parallel_for(changed_vertices_.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
      for (std::size_t i = begin; i < end; ++i)
        kinds_[changed_vertices_[i]] = kind_of(changed_vertices_[i], scratch[w]);
    });
  }
  std::size_t kinds_bytes() const { return heap_bytes(delta_, kinds_, changed_vertices_); }

  TopologyDelta delta_;
  std::vector<StarKind> kinds_;  ///< by vertex

 private:
  std::vector<Index> changed_vertices_;
};

/// The table for the elements of a topology of tetrahedra and triangles.
class StarTable final : public StarKinds {
 public:
  /// The neighbour across the face opposite to vertex i of a tetrahedron.
  struct Neighbour {
    Index element = kNone;  ///< kNone: there is none, or not exactly one
    bool opposite = false;  ///< both node orders orient the complex consistently; if element is kNone: the face has
                            ///< other elements
  };

  /// The face opposite to vertex i of a tetrahedron with these vertices, oriented outward for positive volume.
  static std::array<Index, 3> face_of(std::span<const Index> vertices, std::size_t i) {
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    return {vertices[kFaces[i][0]], vertices[kFaces[i][1]], vertices[kFaces[i][2]]};
  }

  /// Updates the table for the topology. The time is proportional to the size of the change. Returns the extent of the
  /// change.
  TopologyDelta::Extent update(const Topology& topology, Executor& executor);
  const std::array<Neighbour, 4>& neighbours(Index tetrahedron) const { return neighbours_[tetrahedron]; }
  /// Whether a face of the tetrahedron has other elements, but not exactly one other tetrahedron.
  bool shares_a_face_with_several(Index tetrahedron) const {
    for (const Neighbour& across : neighbours_[tetrahedron])
      if (across.element == kNone && across.opposite) return true;
    return false;
  }
  /// How an element fits to its neighbours if the volumes of all of them have the same sign.
  enum class Fit : std::uint8_t {
    other,    ///< it is no tetrahedron, or shares a face with several
    regular,  ///< it and its neighbours lie on different sides of their common faces
    folded    ///< it and a neighbour do not
  };
  Fit fit(Index o) const { return fits_[o]; }
  /// The part of o, as bits of its vertices (ElementSubset), that is on the boundary. Boundary faces of a tetrahedron
  /// are those that do not have exactly two tetrahedra: one such face; the whole tetrahedron if there are several, or
  /// if a vertex has an irregular star; the whole element if it is a triangle.
  std::uint8_t boundary_part(Index o) const { return boundary_parts_[o]; }

  /// The boundary faces that have a vertex with a ring.
  std::vector<RingFace> boundary_faces(const Topology& topology) const;

  std::size_t bytes() const { return kinds_bytes() + heap_bytes(neighbours_, boundary_parts_, fits_, scratch_); }

 private:
  /// Scratch memory of one worker.
  struct Scratch {
    std::vector<Index> places;   ///< by element slot: its position in the current star
    std::vector<Index> corners;  ///< by vertex: one of its corners in the current star
    std::vector<Index> parents;
    Ring ring;
    std::size_t bytes() const { return heap_bytes(places, corners, parents, ring); }
  };

  void set_neighbours(const Topology& topology, Index triangle);
  template <class Visit>
  void visit_boundary(const Mesh& mesh, Index o, Visit&& visit) const;
  StarKind kind_of(const Topology& topology, Index v, Scratch& scratch) const;
  bool joins_up(const Topology& topology, Index v, Scratch& scratch) const;
  bool find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const override;
  void set_element(const Topology& topology, Index o);
  std::uint8_t boundary_part_of(const Mesh& mesh, Index o) const;
  Fit fit_of(const Mesh& mesh, Index o) const;

  std::vector<std::array<Neighbour, 4>> neighbours_;  ///< by element slot
  std::vector<std::uint8_t> boundary_parts_;          ///< by element slot
  std::vector<Fit> fits_;                             ///< by element slot
  std::vector<Scratch> scratch_;
};

}  // namespace volccd::detail
