// The features on the surface, in the sense of ContactFeatures, of a collision mesh that splits and breaks.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/simulation/contact/contact_features.hpp>

namespace volccd::simulation {

/// For ContactFeatures::surface, those triangles of the present boundary whose vertices are, or are copies of, the
/// vertices of a triangle of the initial boundary; otherwise the boundary of the present mesh. update() must be called
/// after each edit.
class ContactSurface {
 public:
  /// `copies`: number of vertices of the collision mesh for each vertex of the simulated mesh (3 if shells were
  /// thickened, else 1).
  ContactSurface(const Topology& collision, ContactFeatures features, Index copies);

  /// `origins`, by vertex of the simulated mesh: the vertex of the initial mesh of which it is a copy, or itself.
  /// O(features).
  void update(const Topology& collision, std::span<const Index> origins);

  bool has_vertex(Index v) const { return vertex_[v] != 0; }
  bool has_edge(Index e) const { return edge_[e] != 0; }
  bool has_triangle(Index f) const { return triangle_[f] != 0; }
  /// Whether only features on the surface collide.
  bool alone() const { return features_ != ContactFeatures::all; }
  /// The vertex of the initial collision mesh of which a vertex of the collision mesh is a copy, or itself.
  Index origin(Index vertex) const;

 private:
  void mark(const Topology& collision);
  void note_first(const Topology& collision);
  std::array<Index, 3> origin_of(const std::array<Index, 3>& triangle) const;

  ContactFeatures features_;
  Index copies_;
  std::vector<Index> origins_;               ///< a vertex beyond its end is its own origin
  std::vector<std::array<Index, 3>> first_;  ///< ContactFeatures::surface: triangles, ascending
  std::vector<char> vertex_, edge_, triangle_;
};

}  // namespace volccd::simulation
