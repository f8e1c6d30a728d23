// Which features lie on the surface, as ContactFeatures means it, of a collision mesh that splits and breaks.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/simulation/contact_features.hpp>

namespace volccd::simulation {

/// ContactFeatures::surface: the boundary that the mesh had at first, wherever its vertices' copies are now; else the
/// boundary of the mesh as it is. To be updated after each edit.
class ContactSurface {
 public:
  /// `copies`: vertices of the collision mesh for each of the simulated one (3 where shells were thickened, else 1).
  ContactSurface(const Topology& collision, ContactFeatures features, Index copies);

  /// `origins`, by vertex of the simulated mesh: the one of the mesh at first of which it is a copy, or itself.
  /// O(features).
  void update(const Topology& collision, std::span<const Index> origins);

  bool has_vertex(Index v) const { return vertex_[v] != 0; }
  bool has_edge(Index e) const { return edge_[e] != 0; }
  bool has_triangle(Index f) const { return triangle_[f] != 0; }
  /// Whether features off the surface do not collide.
  bool alone() const { return features_ != ContactFeatures::all; }
  /// Of a vertex of the collision mesh.
  Index origin(Index vertex) const;

 private:
  void mark(const Topology& collision);
  void note_first(const Topology& collision);
  std::array<Index, 3> origin_of(const std::array<Index, 3>& triangle) const;

  ContactFeatures features_;
  Index copies_;
  std::vector<Index> origins_;               ///< vertices beyond it are their own
  std::vector<std::array<Index, 3>> first_;  ///< ContactFeatures::surface: triangles, ascending
  std::vector<char> vertex_, edge_, triangle_;
};

}  // namespace volccd::simulation
