// The storage of the pairs of an O-Set: an append-only list of blocks; there is no random access.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/o_set/o_set.hpp>

namespace volccd::detail {

/// Pairs are stored in rows {owner, n, partner 1 .. n}, and rows in blocks. Each block has the epoch (the number of the
/// update) in which it was written. When a feature is renewed in an epoch, its pairs in blocks of earlier epochs become
/// invalid without being searched for. When too many pairs are invalid, all valid pairs are rewritten; this cost is
/// amortised over the renewals.
class OSetBlocks {
 public:
  static constexpr std::size_t kBlockPairs = OSet::kBlockPairs;

  /// The kind of feature to which a row belongs: vertex and triangle rows contain VF pairs, edge rows contain EE pairs.
  enum class Owner : std::uint8_t { vertex, triangle, edge };
  class Writer;
  using Epoch = std::uint16_t;
  struct Block {
    std::vector<Index> rows;
    std::uint32_t pairs = 0;
    Owner kind = Owner::vertex;
    Epoch epoch = 0;
    std::size_t bytes() const { return heap_bytes(rows); }
  };
  /// Blocks that a thread writes on its own; the pairs belong to the set after append(), in the present epoch.
  using Part = std::vector<Block>;

  /// Removes all pairs and begins epoch 0.
  void start_over(const Features& features);
  /// Ends a build: the present pairs become the baseline for later compactions, and unused memory is released.
  void settle();
  /// Begins the epoch of a new update.
  void next_epoch(const Features& features);
  void compact_if_stale(const Features& features);
  void append(Part&& part);

  /// Invalidates all pairs of the feature that were written in earlier epochs.
  void renew(Owner kind, Index slot) {
    Epoch& epoch = epochs(kind)[slot];
    renewals_ += epoch != epoch_;
    epoch = epoch_;
  }
  /// Whether the feature was renewed in this epoch, and whether all were, as in epoch 0.
  bool is_new(Owner kind, Index slot) const { return epochs(kind)[slot] == epoch_; }
  bool all_new() const { return epoch_ == 0; }

  std::size_t size() const { return blocks_.size(); }
  void append(std::size_t block, TestBatch& out) const;
  /// Numbers of valid pairs.
  OSetCounts counts() const;
  std::size_t bytes() const { return heap_bytes(blocks_, epochs_[0], epochs_[1], epochs_[2]); }

 private:
  static constexpr Epoch kLastEpoch = 0xffff;

  std::vector<Epoch>& epochs(Owner kind) { return epochs_[static_cast<std::size_t>(kind)]; }
  const std::vector<Epoch>& epochs(Owner kind) const { return epochs_[static_cast<std::size_t>(kind)]; }
  void fit(const Features& features);
  template <class Visit>
  void visit(const Block& block, Visit&& pair) const;
  void compact();

  std::vector<Block> blocks_;
  std::array<std::vector<Epoch>, 3> epochs_;  ///< by kind and slot: the epoch in which the feature was last renewed
  Epoch epoch_ = 0;
  std::size_t written_ = 0;          ///< pairs written since the last compaction
  std::size_t renewals_ = 0;         ///< renewals since the last compaction
  std::size_t baseline_pairs_ = 0;   ///< pairs after the last compaction
  std::size_t baseline_blocks_ = 0;  ///< blocks after the last compaction
};

/// Writes blocks of one kind. Empty rows are dropped; a row that exceeds a block continues in the next block. Rows must
/// be flushed, otherwise they are lost.
class OSetBlocks::Writer {
 public:
  Writer(Part& part, Owner kind) : part_(part), kind_(kind) {}

  void begin_row(Index owner) {
    end_row();
    row_ = end_;
    rows_[end_] = owner;
    end_ += 2;
  }
  void add(Index partner) {
    if (pairs_ == kBlockPairs) break_row();
    rows_[end_++] = partner;
    ++pairs_;
  }
  void flush();

 private:
  void end_row() {
    if (end_ == 0) return;
    const std::size_t length = end_ - row_ - 2;
    rows_[row_ + 1] = static_cast<Index>(length);
    if (length == 0) end_ = row_;
  }
  void break_row();

  Part& part_;
  Owner kind_;
  std::vector<Index> rows_ = std::vector<Index>(3 * kBlockPairs + 2);  ///< a pair in each row, and a row without any
  std::size_t row_ = 0, end_ = 0;                                      ///< where the last row begins and ends
  std::uint32_t pairs_ = 0;
};

}  // namespace volccd::detail
