// The storage of the pairs of an O-Set: an append-only list of blocks; there is no random access.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/culling/assignment.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Pairs are stored in rows {owner, n, partner 1 .. n}, and rows in blocks. Each block has the epoch (the number of the
/// update) in which it was written. When a feature is renewed in an epoch, its pairs in blocks of earlier epochs become
/// invalid without being searched for. When too many pairs are invalid, all valid pairs are rewritten; this cost is
/// amortised over the renewals.
class OSetBlocks {
 public:
  static constexpr std::size_t kBlockPairs = 1024;

  /// The kind of feature to which a row belongs: vertex and triangle rows contain VF pairs, edge rows contain EE pairs.
  enum class Rows : std::uint8_t { vertex, triangle, edge };
  class Part;
  class Writer;

  /// Removes all pairs and begins epoch 0.
  void start_over(const Features& features);
  /// Ends a build: the present pairs become the baseline for later compactions, and unused memory is released.
  void settle();
  /// Begins the epoch of a new update.
  void next_epoch(const Features& features);
  void compact_if_stale(const Features& features);
  /// Blocks that a thread writes on its own; the pairs belong to the set after append().
  Part new_part() const;
  void append(Part&& part);

  /// Invalidates all pairs of the feature that were written in earlier epochs.
  void renew_vertex(Index v) { renew(vertices_, v); }
  void renew_triangle(Index f) { renew(triangles_, f); }
  void renew_edge(Index e) { renew(edges_, e); }
  /// Whether the feature was renewed in this epoch.
  bool vertex_is_new(Index v) const { return vertices_[v] == epoch_; }
  bool edge_is_new(Index e) const { return edges_[e] == epoch_; }

  std::size_t size() const { return blocks_.size(); }
  void append(std::size_t block, TestBatch& out) const;
  /// Numbers of valid pairs.
  void count(std::size_t& vf, std::size_t& ee) const;
  std::size_t bytes() const;

 private:
  using Epoch = std::uint16_t;
  static constexpr Epoch kLastEpoch = 0xffff;

  struct Block {
    std::vector<Index> rows;
    std::uint32_t pairs = 0;
    Epoch epoch = 0;
    Rows kind = Rows::vertex;
  };

  void renew(std::vector<Epoch>& epochs, Index slot) {
    renewals_ += epochs[slot] != epoch_;
    epochs[slot] = epoch_;
  }
  template <class Visit>
  void visit(const Block& block, Visit&& pair) const;
  void compact();

  std::vector<Block> blocks_;
  std::vector<Epoch> vertices_, triangles_, edges_;  ///< by slot: the epoch in which the feature was last renewed
  Epoch epoch_ = 0;
  std::size_t written_ = 0;          ///< pairs written since the last compaction
  std::size_t renewals_ = 0;         ///< renewals since the last compaction
  std::size_t baseline_pairs_ = 0;   ///< pairs after the last compaction
  std::size_t baseline_blocks_ = 0;  ///< blocks after the last compaction
};

class OSetBlocks::Part {
 private:
  friend class OSetBlocks;
  friend class OSetBlocks::Writer;

  std::vector<Block> blocks_;
  std::size_t written_ = 0;
  Epoch epoch_ = 0;
};

/// Writes blocks of one kind. Empty rows are dropped; a row that exceeds a block continues in the next block. Rows must
/// be flushed, otherwise they are lost.
class OSetBlocks::Writer {
 public:
  Writer(Part& part, Rows kind) : part_(part), kind_(kind) {}

  void begin_row(Index owner) {
    row_ = rows_.size();
    rows_.push_back(owner);
    rows_.push_back(0);
  }
  void add(Index partner) {
    if (pairs_ == kBlockPairs) break_row();
    rows_.push_back(partner);
    ++pairs_;
  }
  void end_row() {
    const std::size_t length = rows_.size() - row_ - 2;
    rows_[row_ + 1] = static_cast<Index>(length);
    if (length == 0) rows_.resize(row_);
  }
  void flush();

 private:
  void break_row();

  Part& part_;
  Rows kind_;
  std::vector<Index> rows_;
  std::size_t row_ = 0;
  std::uint32_t pairs_ = 0;
};

}  // namespace volccd::detail
