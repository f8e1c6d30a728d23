// What assignment needs to know of a topology: adjacency, and the first element incident to each feature.
#pragma once

#include <vector>

#include <volccd/mesh/topology_watch.hpp>

namespace volccd::detail {

/// Follows a topology: built at first, then updated for the features that changes touched.
class AssignmentTable {
 public:
  /// All or nothing: if memory runs out, the table is as before.
  void update(const Topology& topology);

  bool adjacent(Index a, Index b) const { return watch_.adjacency().adjacent(a, b); }
  /// First (smallest slot) element incident to a live feature.
  Index of_vertex(Index v) const { return vertex_[v]; }
  Index of_edge(Index e) const { return edge_[e]; }
  Index of_triangle(Index f) const { return triangle_[f]; }

  std::size_t bytes() const {
    return watch_.bytes() + (vertex_.capacity() + edge_.capacity() + triangle_.capacity()) * sizeof(Index);
  }

 private:
  TopologyWatch watch_;
  std::vector<Index> vertex_, edge_, triangle_;
};

}  // namespace volccd::detail
