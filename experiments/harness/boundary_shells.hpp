// The boundary of a mesh as triangle shells: the input of a method for surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

/// The shells are the triangles that belong to exactly one volume element, oriented as in that element, and all
/// triangles of shells (a quad has two). They have the object of their first element. Interior vertices are left out,
/// and the others are renumbered. Edits of the mesh become edits of the shells, so that stages can update their states.
/// Not thread-safe.
class BoundaryShells {
 public:
  /// If one of the vertex slots group * i .. group * i + group - 1 of the mesh is on the boundary, all of them are
  /// kept, in their order. `group` is 3 for thickened shells (mesh/shells.hpp), so that shell neighbours can still be
  /// recognised, else 1.
  explicit BoundaryShells(Index group = 1) : group_(group) {}

  /// Updates the shells to the mesh and its motion. O(elements) if the mesh changed, then O(vertices).
  void update(const Topology& mesh, const Motion& motion);

  /// Valid after the first update(). The references remain valid.
  const Topology& topology() const { return *topology_; }
  const Motion& motion() const { return motion_; }
  /// Wall-clock time that the last update spent in Topology::apply, that is, on the edit that a method for surfaces
  /// would receive. 0 if the shells did not change, and for the first update. The time to find the boundary is not
  /// included.
  double edit_seconds() const { return edit_seconds_; }

 private:
  /// Vertex slots of the mesh, ascending.
  using Key = std::array<Index, 3>;
  struct Face {
    Key oriented;
    std::int32_t object;
    Index slot;  ///< of the shell
  };
  using Faces = std::map<Key, Face>;

  std::vector<Face> faces_of(const Topology& mesh) const;
  std::vector<std::int64_t> add_vertices(const std::vector<Face>& faces, Index mesh_vertices);
  ElementSpec element(const Face& face);
  void build(const std::vector<Face>& faces);
  void edit(const std::vector<Face>& faces, std::vector<std::int64_t> new_vertex_ids);

  Index group_;
  std::uint64_t version_ = 0;  ///< of the mesh
  std::optional<Topology> topology_;
  Motion motion_;
  double edit_seconds_ = 0;
  std::int64_t next_id_ = 0;
  Faces faces_;                   ///< live shells
  std::vector<Index> of_mesh_;    ///< by vertex of the mesh: vertex of the shells, or kNone
  std::vector<Index> of_shells_;  ///< by vertex of the shells: vertex of the mesh
};

}  // namespace volccd
