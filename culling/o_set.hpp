// The O-Set ("orphan set", Section 5.1 and Algorithm 3): the feature pairs that no pair of non-adjacent elements
// covers.
#pragma once

#include <cstddef>
#include <memory>

#include <volccd/culling/assignment.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

enum class OSetKind {
  /// VF pairs {v,f}, v not in f, and EE pairs without a common vertex, for which every (oi, oj) in inc(a) x inc(b) is
  /// adjacent (an element is adjacent to itself). With dynamic assignment each test comes out exactly once.
  minimal,
  /// Algorithm 3 as printed, but for its `return`, which has to go on with the next feature pair: a pair is in if some
  /// adjacent (oi, oj) has every element of inc(a) adjacent to oj and every element of inc(b) adjacent to oi. It
  /// contains the minimal set, and pairs that non-adjacent elements cover too.
  literal
};

struct OSetCounts {
  std::size_t vf = 0, ee = 0;
  friend bool operator==(const OSetCounts&, const OSetCounts&) = default;
};

/// The pairs of one topology, each once, in blocks of at most kBlockPairs; four bytes a pair, eight for each run of
/// pairs with a feature in common, and tables for updates (40 bytes a triangle of rod-twist). Read-only use is
/// thread-safe.
class OSet {
 public:
  static constexpr std::size_t kBlockPairs = 1024;

  explicit OSet(OSetKind kind = OSetKind::minimal);
  OSet(OSet&&) noexcept;
  OSet& operator=(OSet&&) noexcept;
  ~OSet();

  OSetKind kind() const;

  /// Everything from scratch. Expected time proportional to the sum, over edges and vertices, of the elements around
  /// them.
  void build(const Topology& topology);

  /// Updates the set after topology edits: the same set as build() gives. Builds at first, and if the topology's
  /// history does not reach back. Otherwise the amortised cost is proportional to the number of pairs that contain a
  /// feature of a changed element.
  void update(const Topology& topology);

  std::size_t blocks() const;
  /// Appends a block's pairs: its VF pairs to out.vf, its EE pairs to out.ee.
  void append(std::size_t block, TestBatch& out) const;

  /// O(blocks) after a build, O(pairs) after an update.
  OSetCounts counts() const;

  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
