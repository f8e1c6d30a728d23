// The simplicial complex of a mesh: every volume element as a fan of tetrahedra, every quad as two triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/culling/assignment.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd::detail {

/// The fan of an element goes from its vertex of smallest slot over the triangles of its boundary that do not have that
/// vertex; fans of neighbours agree on their common faces (diagonal rule, mesh/features.hpp). A simplex has the vertex
/// slots of the mesh and the object of its element. Its orientation follows from the node order of the element, or from
/// the face stream of a polytope, never from positions. Every feature of the mesh is a simplex of the complex; a
/// triangle of a degenerate polytope that no tetrahedron of the fan has is added as a triangle.
///
/// A mesh of tetrahedra and triangles is its own complex: nothing is stored. One thread at a time.
class SimplexComplex {
 public:
  /// Brings the complex up to the topology. Time proportional to the change.
  void update(const Topology& topology);

  /// Elements are the simplices.
  const Topology& topology() const { return own_ ? *own_ : *mesh_; }
  bool is_mesh() const { return !own_; }

  /// Replaces the features of the complex by those of the mesh, in tests that were appended behind `vf_begin` and
  /// `ee_begin`; tests with a feature that the mesh does not have (a diagonal inside an element) are dropped.
  void to_mesh_features(TestBatch& tests, std::size_t vf_begin, std::size_t ee_begin) const;

  std::size_t bytes() const;

 private:
  struct Fan {
    std::int64_t first_id = 0;
    int count = 0;
  };

  void build(const Topology& topology);
  void edit(const Topology& topology);
  void append_fan(const Mesh& mesh, Index element, std::vector<ElementSpec>& out);

  const Topology* mesh_ = nullptr;
  std::unique_ptr<Topology> own_;
  TopologyDelta delta_;
  std::vector<Fan> fans_;  ///< by element slot of the mesh
  std::int64_t next_id_ = 0;
  std::vector<Index> edges_, triangles_;  ///< features of the complex to those of the mesh, or kNone
};

}  // namespace volccd::detail
