// Where an O-Set keeps its pairs: an append-only list of blocks; there is no random access.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/culling/assignment.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Pairs lie in rows {owner, n, partner 1 .. n}, rows in blocks, and each block has the epoch (number of the update) in
/// which it was written. When a feature is renewed in an epoch, its pairs in blocks of earlier epochs become void
/// without being looked up. When too much is void, everything is written again: amortised over the renewals.
class OSetBlocks {
 public:
  static constexpr std::size_t kBlockPairs = 1024;

  /// Which kind of feature a row belongs to: vertex and triangle rows hold VF pairs, edge rows EE pairs.
  enum class Rows : std::uint8_t { vertex, triangle, edge };
  class Writer;

  /// Empty, epoch 0.
  void start_over(const Features& features);
  /// Takes what is there as a new beginning: drops spare memory.
  void settle();
  /// All that follows belongs to a new update.
  void next_epoch(const Features& features);
  void compact_if_stale(const Features& features);

  /// All pairs of the feature that earlier epochs wrote become void.
  void renew_vertex(Index v) { renew(vertices_, v); }
  void renew_triangle(Index f) { renew(triangles_, f); }
  void renew_edge(Index e) { renew(edges_, e); }
  /// In this epoch.
  bool vertex_is_new(Index v) const { return vertices_[v] == epoch_; }
  bool edge_is_new(Index e) const { return edges_[e] == epoch_; }

  std::size_t size() const { return blocks_.size(); }
  void append(std::size_t block, TestBatch& out) const;
  /// Pairs that are not void.
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
  std::vector<Epoch> vertices_, triangles_, edges_;  ///< by slot: when the feature was renewed last
  Epoch epoch_ = 0;
  std::size_t written_ = 0;       ///< pairs, since the last compaction
  std::size_t renewals_ = 0;      ///< likewise
  std::size_t sound_pairs_ = 0;   ///< after the last compaction
  std::size_t sound_blocks_ = 0;  ///< likewise
};

/// Fills blocks of one kind. Rows that turn out empty are dropped; a row that does not fit goes on in the next block.
/// What is not flushed is lost.
class OSetBlocks::Writer {
 public:
  Writer(OSetBlocks& blocks, Rows kind) : blocks_(blocks), kind_(kind) {}

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

  OSetBlocks& blocks_;
  Rows kind_;
  std::vector<Index> rows_;
  std::size_t row_ = 0;
  std::uint32_t pairs_ = 0;
};

}  // namespace volccd::detail
