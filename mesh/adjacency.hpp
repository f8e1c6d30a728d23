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

/// The vertices of all elements, in blocks of four ids, or of eight where an element has more than four vertices; larger
/// polytopes have a list of their own. Two elements are compared block by block in registers, which takes about a
/// nanosecond for tetrahedra. Read-only use is thread-safe.
class Adjacency {
 public:
  /// For the live elements of `mesh`. O(elements).
  void build(const Mesh& mesh);

  /// An edit in two parts, as in Mesh: elements that go, and elements that come then, in `slots`; the mesh will have
  /// `element_slots` slots. prepare() allocates the memory and changes nothing that can be seen; commit() of the same edit
  /// cannot fail. Amortised time proportional to the edit, except for the first element that is larger than a block.
  void prepare(std::span<const ElementSpec> added, std::span<const Index> slots, Index element_slots);
  void commit(std::span<const Index> removed, std::span<const ElementSpec> added, std::span<const Index> slots,
              Index element_slots) noexcept;

  /// Whether the live elements a and b have a common vertex.
  bool adjacent(Index a, Index b) const {
    if (block_ == 4) return detail::share_id<4>(block(a), block(b));
    if (large_.size() == 0) return detail::share_id<8>(block(a), block(b));
    return adjacent_large(a, b);
  }

  /// The vertices of a live element in node order, for random access. An element that is smaller than its block repeats
  /// its first vertex at the end.
  std::span<const Index> vertices(Index o) const {
    if (large_.size() != 0 && !large_[o].empty()) return large_[o];
    return {block(o), block_};
  }

  std::size_t bytes() const { return ids_.capacity() * sizeof(Index) + large_.bytes(); }

 private:
  static constexpr std::uint32_t kMaxBlock = 8;

  const Index* block(Index o) const { return ids_.data() + std::size_t{o} * block_; }
  bool adjacent_large(Index a, Index b) const;
  void store(Index o, std::span<const Index> vertices);
  void widen() noexcept;

  std::uint32_t block_ = 4;      ///< ids of a slot in ids_: 4 or 8
  std::vector<Index> ids_;       ///< padded with the first vertex; kNone in empty slots
  detail::IncidencePool large_;  ///< vertices of the slots with more than 8; no lists if there never was one
};

/// Replaces `out` by the live elements adjacent to o, itself included, ascending, each once. O(k log k), k = sum of
/// incident elements of its vertices.
void adjacent_elements(const Mesh& mesh, const Features& features, Index o, std::vector<Index>& out);

}  // namespace volccd
