// Adjacency of elements: two elements are adjacent when they share at least one vertex; an element is adjacent to itself.
#pragma once

#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Decides adjacency of two elements by comparing vertex slots in registers, a nanosecond or so for tetrahedra, without
/// lists of neighbours. Elements of up to four and up to eight vertices are held padded in one block; larger polytopes
/// fall back to their sorted vertex lists.
class AdjacencyTest {
 public:
  /// For the live elements of `mesh`. O(elements).
  void build(const Mesh& mesh);
  /// Brings the given slots up to date with `mesh` after an edit.
  void update(const Mesh& mesh, std::span<const Index> slots);

  bool adjacent(Index a, Index b) const;

  std::size_t bytes() const;

 private:
  const Mesh* mesh_ = nullptr;
  int stride_ = 4;             ///< ids a slot: 4 if no element has more than four vertices, else 8
  std::vector<Index> ids_;     ///< stride_ ids a slot; short elements repeat their first vertex
  std::vector<Index> large_;   ///< 1 for slots with more than 8 vertices, empty if there are none
};

/// Appends to `out` the live elements adjacent to o, itself included, ascending, each once.
/// `out` is cleared first. O(k log k), k = sum of incident elements of its vertices.
class Features;
void adjacent_elements(const Mesh& mesh, const Features& features, Index o, std::vector<Index>& out);

}  // namespace volccd
