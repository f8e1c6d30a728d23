// Adjacency of elements: two elements are adjacent when they share at least one vertex; an element is adjacent to
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/mesh.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>
#include <volccd/mesh/tables/share_id.hpp>

namespace volccd {

/// Stores the vertices of all elements in blocks of four ids, or of eight ids if some element has more than four
/// vertices. Polytopes with more than eight vertices have separate lists. Two elements are compared block by block in
/// vector registers, in about a nanosecond for tetrahedra. Read-only use is thread-safe.
class Adjacency {
 public:
  /// Replaces the contents by the live elements of `mesh`. O(elements). All workers of the executor take part.
  void build(const Mesh& mesh, Executor& executor = serial_executor());

  /// An edit in two phases, as in Mesh. The added elements take `slots`; afterwards the mesh has `element_slots` slots.
  /// prepare() allocates the memory without an observable change; commit() of the same edit cannot fail. The amortised
  /// time is proportional to the size of the edit, except if the edit adds the first elements that are larger than a
  /// block.
  void prepare(std::span<const ElementSpec> added, std::span<const Index> slots, Index element_slots);
  void commit(std::span<const Index> removed, std::span<const ElementSpec> added, std::span<const Index> slots,
              Index element_slots) noexcept;

  /// Whether the live elements a and b have a common vertex.
  bool adjacent(Index a, Index b) const {
    if (block_ == 4) return detail::share_id<4>(block(a), block(b));
    if (large_.size() == 0) return detail::share_id<8>(block(a), block(b));
    return adjacent_large(a, b);
  }

  /// The vertices of a live element in node order, for fast random access. For an element that is smaller than its
  /// block, the first vertex is repeated at the end.
  std::span<const Index> vertices(Index o) const {
    if (large_.size() != 0 && !large_[o].empty()) return large_[o];
    return {block(o), block_};
  }

  std::size_t bytes() const { return heap_bytes(ids_, large_); }

 private:
  static constexpr std::uint32_t kMaxBlock = 8;

  const Index* block(Index o) const { return ids_.data() + std::size_t{o} * block_; }
  bool adjacent_large(Index a, Index b) const;
  void store_block(Index o, std::span<const Index> vertices);
  void widen() noexcept;

  std::uint32_t block_ = 4;       ///< number of ids per slot in ids_: 4 or 8
  detail::RawVector<Index> ids_;  ///< blocks padded with the first vertex of the element; kNone in empty slots
  detail::IncidencePool large_;   ///< vertices of the elements with more than 8; without lists if there never was such
                                  ///< an element
};

}  // namespace volccd
