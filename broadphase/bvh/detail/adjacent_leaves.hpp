// Which elements of two leaves of a tree are adjacent, so that a traversal need not compare their vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/incidence_pool.hpp>

namespace volccd::detail {

/// For each leaf, the leaves at or after it that have elements adjacent to its own. A leaf is named by its first
/// position in a list in leaf order, which is a multiple of the leaf size. The table stays valid while elements keep
/// their positions and vertices; other elements may be removed, or added at later positions. Read-only use is
/// thread-safe.
class AdjacentLeaves {
 public:
  /// Bit 8 i + j of a mask: element i of the earlier leaf is adjacent to element j of the later one.
  static constexpr Index kMaskRow = 8;

  /// The adjacent leaves of one leaf, in no particular order, and a mask for each. `leaves` is padded with kNone to a
  /// multiple of kPadding.
  struct Row {
    const Index* leaves;
    const std::uint64_t* masks;
    std::size_t size;  ///< without padding
  };
  static constexpr std::size_t kPadding = 8;

  void clear();

  /// Makes the table for the elements `slots`, by position, anew, unless it has most of their leaves. kNone: no
  /// element. `vertices`: number of vertices of the mesh. The time is proportional to the number of pairs of adjacent
  /// elements, divided by the number of threads. Has no leaves if there are more than kMaxElements. Pre: leaf_size <=
  /// kMaskRow.
  void update(std::span<const Index> slots, Index leaf_size, const Adjacency& adjacency, Index vertices,
              Executor& executor);

  /// Removes the leaves of these positions, whose elements were reordered or replaced, from the table.
  void remove(Index begin, Index end);

  bool has(Index leaf) const { return leaf < elements_ && known_[leaf] != 0; }

  Row row(Index leaf) const {
    const Block& block = blocks_[leaf / kBlock];
    return {block.leaves.data() + begins_[leaf], block.masks.data() + begins_[leaf], sizes_[leaf]};
  }

  std::size_t bytes() const { return heap_bytes(blocks_, begins_, sizes_, known_, scratch_); }

 private:
  static constexpr Index kMaxElements = kNone / kMaskRow;  ///< so that places do not overflow
  static constexpr Index kBlock = 1024;  ///< number of positions; the rows of the leaves there are stored together

  struct Block {
    std::vector<Index> leaves;
    std::vector<std::uint64_t> masks;
    std::size_t bytes() const { return heap_bytes(leaves, masks); }
  };
  struct LeafVertex {
    Index vertex;
    std::uint64_t elements;
  };
  struct Scratch {
    std::vector<Index> entries;  ///< by leaf: its entry in the present row, or kNone
    std::vector<LeafVertex> vertices;
    std::size_t bytes() const { return heap_bytes(entries, vertices); }
  };

  void collect_vertices(std::span<const Index> slots, const Adjacency& adjacency, Index leaf, Scratch& scratch) const;
  void make_block(std::span<const Index> slots, const Adjacency& adjacency, const IncidencePool& places, Index block,
                  Scratch& scratch);

  Index elements_ = 0, leaf_size_ = 1, forgotten_ = 0;
  std::vector<Block> blocks_;
  std::vector<Index> begins_, sizes_;  ///< by leaf: of its row in its block
  std::vector<std::uint8_t> known_;    ///< by leaf
  std::vector<Scratch> scratch_;       ///< by worker
};

}  // namespace volccd::detail
