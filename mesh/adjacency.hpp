// Adjacency of elements: two elements are adjacent when they share at least one vertex; an element is adjacent to
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/detail/share_id.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Decides adjacency of two elements by comparing vertex slots in registers, a nanosecond or so for tetrahedra, without
/// lists of neighbours. Elements of up to four, or up to eight vertices are held padded in one block; larger polytopes
/// fall back to their sorted vertices. Read-only use is thread-safe. A member that throws for lack of memory leaves it
/// as it was.
class AdjacencyTest {
 public:
  /// For the live elements of `mesh`. O(elements).
  void build(const Mesh& mesh);
  /// Brings the given slots up to date with `mesh` after an edit that emptied or filled them. Time proportional to
  /// their number; all slots, when larger elements than before make the block wider.
  void update(const Mesh& mesh, std::span<const Index> slots);

  /// Whether the live elements a and b have a common vertex.
  bool adjacent(Index a, Index b) const {
    if (stride_ == 4) return detail::share_id<4>(block(a), block(b));
    if (large_.size() == 0) return detail::share_id<8>(block(a), block(b));
    return adjacent_large(a, b);
  }

  std::size_t bytes() const { return ids_.capacity() * sizeof(Index) + large_.bytes(); }

 private:
  const Index* block(Index o) const { return ids_.data() + std::size_t{o} * stride_; }
  bool adjacent_large(Index a, Index b) const;
  void store(const Mesh& mesh, Index o) noexcept;
  void update_large(const Mesh& mesh, std::span<const Index> slots);

  std::uint32_t stride_ = 4;     ///< ids a slot: 4 if no element has more than four vertices, else 8
  std::vector<Index> ids_;       ///< stride_ ids a slot; short elements repeat their first vertex
  detail::IncidencePool large_;  ///< ascending vertices of slots with more than 8; no lists if there are none
};

/// Replaces `out` by the live elements adjacent to o, itself included, ascending, each once. O(k log k), k = sum of
/// incident elements of its vertices.
void adjacent_elements(const Mesh& mesh, const Features& features, Index o, std::vector<Index>& out);

}  // namespace volccd
