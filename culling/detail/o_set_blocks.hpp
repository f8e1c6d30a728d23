// Where an O-Set keeps its pairs: a log of blocks, in which nothing is ever looked for.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <volccd/culling/feature_culling.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Pairs lie in rows {owner, n, partner 1 .. n}, rows in blocks, and each block has the epoch (number of the update) in
/// which it was written. Old pairs become void in two ways, neither of which finds them:
/// - a feature is born (anew) in an epoch: blocks of earlier epochs say nothing about it;
/// - a single pair is erased in an epoch: blocks of earlier epochs do not hold it.
/// When too much is void, everything is written afresh: amortised over the births and erasures.
class OSetBlocks {
 public:
  static constexpr std::size_t kBlockPairs = 4096;

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

  void bear_vertex(Index v) { bear(vertices_, v); }
  void bear_triangle(Index f) { bear(triangles_, f); }
  void bear_edge(Index e) { bear(edges_, e); }
  /// In this epoch.
  bool born_vertex(Index v) const { return birth(vertices_[v]) == epoch_; }
  bool born_triangle(Index f) const { return birth(triangles_[f]) == epoch_; }
  bool born_edge(Index e) const { return birth(edges_[e]) == epoch_; }

  /// The pair need not be there.
  void erase_vf(Index v, Index f) { erase(vertices_, triangles_, erased_vf_, v, f); }
  void erase_ee(Index a, Index b) { erase(edges_, edges_, erased_ee_, std::min(a, b), std::max(a, b)); }
  bool erased_vf_now(Index v, Index f) const { return erased(erased_vf_, v, f) == epoch_; }
  bool erased_ee_now(Index a, Index b) const { return erased(erased_ee_, std::min(a, b), std::max(a, b)) == epoch_; }

  std::size_t size() const { return blocks_.size(); }
  void append(std::size_t block, TestBatch& out) const;
  /// Pairs that are not void.
  void count(std::size_t& vf, std::size_t& ee) const;
  std::size_t bytes() const;

 private:
  /// The lower bits: epoch of birth; the upper one: some pair of the feature was erased since the last compaction.
  using Life = std::uint16_t;
  using Erased = std::unordered_map<std::uint64_t, Life>;
  static constexpr Life kErased = 0x8000;
  static constexpr Life kLastEpoch = 0x7fff;

  struct Block {
    std::vector<Index> rows;
    std::uint32_t pairs = 0;
    Life epoch = 0;
    Rows kind = Rows::vertex;
  };

  static Life birth(Life life) { return life & kLastEpoch; }
  static std::uint64_t key(Index a, Index b) { return std::uint64_t{a} << 32 | b; }
  /// Epoch in which the pair was erased last, or kErased.
  static Life erased(const Erased& pairs, Index a, Index b) {
    const auto found = pairs.find(key(a, b));
    return found == pairs.end() ? kErased : found->second;
  }
  void bear(std::vector<Life>& lives, Index slot) {
    births_ += birth(lives[slot]) != epoch_;
    lives[slot] = static_cast<Life>((lives[slot] & kErased) | epoch_);
  }
  void erase(std::vector<Life>& lives_a, std::vector<Life>& lives_b, Erased& pairs, Index a, Index b) {
    lives_a[a] |= kErased;
    lives_b[b] |= kErased;
    pairs[key(a, b)] = epoch_;
  }
  template <class Visit>
  void visit(const Block& block, Visit&& pair) const;
  bool holds(const Block& block, Index owner, Index partner) const;
  void compact();

  std::vector<Block> blocks_;
  std::vector<Life> vertices_, triangles_, edges_;  ///< by slot
  Erased erased_vf_, erased_ee_;                    ///< (vertex, triangle); (smaller edge, larger edge)
  Life epoch_ = 0;
  std::size_t written_ = 0;       ///< pairs, since the last compaction
  std::size_t births_ = 0;        ///< likewise
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
