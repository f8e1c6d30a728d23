// The simplicial complex of a mesh: every volume element becomes a fan of tetrahedra, every quad two triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/query/roles/assignment.hpp>

namespace volccd::detail {

/// The tetrahedra of the fan of an element connect its vertex of smallest slot with the triangles of its boundary that
/// do not contain that vertex. The fans of neighbours agree on their common faces (diagonal rule, mesh/features.hpp). A
/// simplex has the vertex slots of the mesh and the object of its element. Its orientation is determined by the node
/// order of the element, or by the face stream of a polytope, never by positions. Every feature of the mesh is a
/// simplex of the complex; a triangle of a degenerate polytope that is not in a tetrahedron of the fan is added as a
/// triangle.
///
/// A mesh of tetrahedra and triangles is its own complex and is not copied. Not thread-safe.
class SimplexComplex {
 public:
  /// Updates the complex for the topology. The time is proportional to the size of the change. Where the complex is
  /// built anew, all workers of the executor build its features.
  void update(const Topology& topology, Executor& executor);

  /// The topology of the complex; its elements are the simplices.
  const Topology& topology() const { return own_ ? *own_ : *mesh_; }
  bool is_mesh() const { return !own_; }

  /// Replaces the features of the complex by those of the mesh, in the tests after the positions `vf_begin` and
  /// `ee_begin`. Tests with a feature that the mesh does not have (a diagonal inside an element) are dropped.
  void to_mesh_features(TestBatch& tests, std::size_t vf_begin, std::size_t ee_begin) const;

  std::size_t bytes() const;

 private:
  struct Fan {
    std::int64_t first_id = 0;
    int count = 0;
  };

  void build(const Topology& topology, Executor& executor);
  void edit(const Topology& topology);
  void append_fan(const Mesh& mesh, Index element, std::vector<ElementSpec>& out);

  const Topology* mesh_ = nullptr;
  std::unique_ptr<Topology> own_;
  TopologyDelta delta_;
  std::vector<Fan> fans_;  ///< indexed by element slot of the mesh
  std::int64_t next_id_ = 0;
  std::vector<Index> edges_, triangles_;  ///< for each feature of the complex the feature of the mesh, or kNone
};

}  // namespace volccd::detail
