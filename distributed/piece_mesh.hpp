// The part of a mesh that a rank holds, as a mesh of its own.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::distributed {

/// Some elements of a mesh, the whole, with all their vertices. Vertices and elements keep their ids, and vertex slots
/// are ascending with those of the whole, so that features, the order of vertices in a test, and contacts are those of
/// the whole. Nothing is kept of the whole but slots, which its edits make invalid.
class PieceMesh {
 public:
  /// Makes this the piece of the given elements, which are slots of live ones, ascending. The present piece remains if
  /// the whole has not been edited since, and if it contains the elements and at most a quarter more. `vertex_group`:
  /// the vertices of the whole come in groups of this many consecutive slots, of which the piece holds all or none (3
  /// for the solid meshes of thickened shells, otherwise 1). Expected time O(elements + vertices of the whole).
  void update(const Topology& whole, std::span<const Index> elements, Index vertex_group, Executor& executor);

  /// Pre, here and below: update() was called.
  const Topology& topology() const { return *topology_; }
  /// The motion of the vertices of the piece. Valid until the next call. O(vertices of the piece).
  const Motion& motion_of(const Motion& whole);

  /// Slots in the whole.
  Index whole_vertex(Index v) const { return vertices_[v]; }
  Index whole_element(Index o) const { return elements_[o]; }

 private:
  void build(const Topology& whole, Executor& executor);

  std::vector<Index> elements_, vertices_;  ///< of the piece, by slot: slots of the whole, ascending
  std::optional<Topology> topology_;
  std::uint64_t whole_version_ = 0;
  Index vertex_group_ = 0;
  Motion motion_;
};

}  // namespace volccd::distributed
