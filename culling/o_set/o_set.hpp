// The O-Set ("orphan set", Section 5.1 and Algorithm 3): the feature pairs that no pair of non-adjacent elements
// covers.
#pragma once

#include <cstddef>
#include <memory>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/roles/assignment.hpp>

namespace volccd {

enum class OSetKind {
  /// VF pairs {v,f} with v not in f, and EE pairs without a common vertex, for which every (oi, oj) in inc(a) x inc(b)
  /// is adjacent (an element is adjacent to itself). With dynamic assignment, each test is generated exactly once.
  minimal,
  /// Algorithm 3 as printed, except that its `return` must continue with the next feature pair: a pair is in the set
  /// if, for some adjacent (oi, oj), every element of inc(a) is adjacent to oj and every element of inc(b) is adjacent
  /// to oi. It contains the minimal set, and also pairs that non-adjacent elements cover.
  literal
};

struct OSetCounts {
  std::size_t vf = 0, ee = 0;
  friend bool operator==(const OSetCounts&, const OSetCounts&) = default;
};

/// The orphans of one topology, each once, in blocks of at most kBlockPairs pairs. Memory: four bytes per pair, eight
/// for each sequence of pairs with a common feature, and tables for updates (40 bytes per triangle for rod-twist).
/// Read-only use is thread-safe.
class OSet {
 public:
  static constexpr std::size_t kBlockPairs = 1024;

  explicit OSet(OSetKind kind = OSetKind::minimal);
  OSet(OSet&&) noexcept;
  OSet& operator=(OSet&&) noexcept;
  ~OSet();

  OSetKind kind() const;

  /// Computes the whole set, with the pairs of shell neighbours. The expected time is proportional to the number of
  /// incident elements, summed over all edges and vertices. The same set, in the same blocks, for any number of
  /// threads.
  void build(const Topology& topology, Executor& executor);

  /// Updates the set after topology edits; the result is the same set as that of build(), without the pairs of shell
  /// neighbours (query/shell_neighbours.hpp) if they are to be left out. Computes the whole set at first, if the last
  /// update differed in what is left out, and if the topology's history does not contain it. Otherwise the amortised
  /// cost is proportional to the number of pairs that contain a feature of a changed element.
  void update(const Topology& topology, Executor& executor, bool leave_out_shell_neighbours = false);

  std::size_t blocks() const;
  /// Appends the pairs of a block: its VF pairs to out.vf, its EE pairs to out.ee.
  void append(std::size_t block, TestBatch& out) const;

  /// O(blocks) after a build, O(pairs) after an update.
  OSetCounts counts() const;

  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
