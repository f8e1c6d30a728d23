// The O-Set ("orphan set", Section 5.1 and Algorithm 3): the feature pairs that no pair of non-adjacent elements covers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/culling/detail/o_set_partners.hpp>
#include <volccd/culling/feature_culling.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

enum class OSetKind {
  none,
  /// VF pairs {v,f}, v not in f, and EE pairs without a common vertex, for which every (oi, oj) in inc(a) x inc(b) is
  /// adjacent (an element is adjacent to itself). With dynamic assignment each test comes out exactly once.
  minimal,
  /// Algorithm 3 as printed, but for its `return`, which has to go on with the next feature pair: a pair is in if some
  /// adjacent (oi, oj) has every element of inc(a) adjacent to oj and every element of inc(b) adjacent to oi. It contains
  /// the minimal set, and pairs that element pairs cover too.
  literal
};

struct OSetCounts {
  std::size_t vf = 0, ee = 0;
  friend bool operator==(const OSetCounts&, const OSetCounts&) = default;
};

/// Blocks of pairs, four bytes a pair and eight a row of pairs with one common feature. A pair is in exactly one block,
/// and no two pairs are the same. Read-only use is thread-safe.
///
/// An update never looks for what has to go: a feature whose incident elements changed is born anew, and a block older than
/// a feature's birth says nothing about it. Its pairs are found again, as they are now, and go to a new block. When too
/// much has gone stale, everything is compacted.
class OSet {
 public:
  /// `kind` is not none.
  explicit OSet(OSetKind kind = OSetKind::minimal);

  OSetKind kind() const { return kind_; }

  /// Everything from scratch. O(sum over features of the elements around them) expected.
  void build(const Topology& topology);

  /// Brings it up to the topology: builds at first, or if the topology's history does not reach back; otherwise only pairs
  /// with a feature whose incident elements changed are looked at, in amortised time proportional to the change. The same set as
  /// build() gives.
  void update(const Topology& topology);

  /// Topology::version() of the last build or update; 0 before.
  std::uint64_t version() const { return version_; }

  /// Blocks of at most kBlockPairs pairs.
  std::size_t blocks() const { return blocks_.size(); }
  void append(std::size_t block, TestBatch& out) const;
  static constexpr std::size_t kBlockPairs = 4096;

  /// O(blocks) after a build, O(pairs) after an update.
  OSetCounts counts() const;

  std::size_t bytes() const;

 private:
  /// Which kind of feature a row belongs to, and so what its partners are.
  enum class Rows : std::uint8_t { vertex, triangle, edge };
  using Epoch = std::uint16_t;  ///< updates since the last build or compaction

  /// Rows {owner, n, partner 1 .. n} one after the other.
  struct Block {
    std::vector<Index> rows;
    std::uint32_t pairs = 0;
    Epoch epoch = 0;
    Rows kind = Rows::vertex;
  };
  class Writer;
  struct Touched {
    std::vector<Index> vertices, triangles, edges;
  };

  template <class Visit>
  void visit(const Block& block, Visit&& pair) const;
  void bear(std::vector<Epoch>& births, const std::vector<Index>& slots, std::vector<Index>& touched);
  void collect_touched(const Topology& topology, const std::vector<const TopologyChange*>& changes);
  void start_over(const Features& features);
  void compact_if_stale(const Features& features);
  void compact();

  OSetKind kind_;
  std::uint64_t version_ = 0;
  std::vector<Block> blocks_;
  /// Epoch in which a feature was last touched, by slot: what older blocks hold of it is void.
  std::vector<Epoch> vertex_births_, triangle_births_, edge_births_;
  Epoch epoch_ = 0;
  std::size_t sound_pairs_ = 0;    ///< after the last build or compaction
  std::size_t sound_blocks_ = 0;   ///< likewise
  std::size_t written_pairs_ = 0;  ///< since then
  std::size_t births_ = 0;         ///< since then
  Touched touched_;                ///< scratch of update()
  detail::ElementVertices vertices_;
  detail::OSetPartners partners_;  ///< scratch of build() and update()
};

}  // namespace volccd
