// Lists the orphans of which all pairs of incident elements may touch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/assignment.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// The feature pairs without a common vertex of which all pairs of incident elements are given as suspect. update() is
/// not thread-safe and uses the executor; append() may be called by several threads.
class SuspectOrphans {
 public:
  /// `pairs`: adjacent pairs of elements, and pairs of an element and itself, each once. The topology must exist as
  /// long as append() is called. O(slots + features of the elements of all pairs).
  void update(const Topology& topology, std::span<const ElementPair> pairs, Executor& executor);

  std::size_t blocks() const { return (elements_.size() + kBlockElements - 1) / kBlockElements; }
  /// Appends the orphans of a block. Each orphan is in one block.
  void append(std::size_t block, TestBatch& out) const;

  std::size_t bytes() const;

 private:
  static constexpr std::size_t kBlockElements = 16;

  /// An element and one of its partners. Bit i of a set is for the i-th feature in the list of those whose first
  /// incident element is the partner (for vertices: in the list of the partner's vertices); it is set if all incident
  /// elements of that feature are partners of the element. Features after the 64th have no bit.
  struct Partner {
    Index element;
    std::uint64_t vertices = 0, edges = 0, triangles = 0;
  };

  std::span<const Partner> partners(Index o) const;
  const Partner* find(Index o, Index partner) const;
  void find_candidates(Index o, std::vector<Index>& partner_of);
  template <std::uint64_t Partner::*kSet, class Visit>
  void visit_partners(std::span<const Index> elements, std::span<const Index> features, Index other,
                      Visit&& visit) const;
  void list(Index a, Index b, TestBatch& out) const;
  void vertices_and_triangles(Index a, Index b, TestBatch& out) const;

  const Topology* topology_ = nullptr;
  std::vector<Index> elements_, places_;  ///< elements with partners, and by slot: the place in this list, or kNone
  std::vector<std::size_t> begins_;       ///< by place: where the element's partners begin in partners_
  std::vector<Partner> partners_;
  std::vector<std::vector<Index>>
      partner_of_;  ///< by worker and element slot: the last element that it is a partner of
};

}  // namespace volccd::detail
