// Lists the orphans of which all pairs of incident elements may touch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/roles/assignment.hpp>

namespace volccd::detail {

/// The feature pairs without a common vertex of which all pairs of incident elements are given as suspect. From step to
/// step few pairs of elements become suspect or cease to be: the orphans of elements all of whose neighbours have the
/// same partners as at the last update are kept. update() is not thread-safe and uses the executor; append() may be
/// called by several threads.
class SuspectOrphans {
 public:
  /// `pairs`: adjacent pairs of elements, and pairs of an element and itself, each once, in any order. Without the
  /// orphans of shell neighbours (query/shell_neighbours.hpp) if they are to be left out.
  /// O(slots + pairs + features of the elements of new pairs, and of their neighbours).
  void update(const Topology& topology, std::span<const ElementPair> pairs, Executor& executor,
              bool leave_out_shell_neighbours = false);

  std::size_t blocks() const { return (now_.elements.size() + kBlockElements - 1) / kBlockElements; }
  /// Appends the orphans of a block. Each orphan is in one block.
  void append(std::size_t block, TestBatch& out) const;

  std::size_t bytes() const { return heap_bytes(delta_, now_, before_, fresh_, renewed_, near_, counts_, partner_of_); }

 private:
  static constexpr std::size_t kBlockElements = 16;

  /// An element and one of its partners. Bit i of a set is for the i-th feature in the list of those whose first
  /// incident element is the partner (for vertices: in the list of the partner's vertices); it is set if all incident
  /// elements of that feature are partners of the element. Features after the 64th have no bit.
  struct Partner {
    Index element;
    std::uint64_t vertices = 0, edges = 0, triangles = 0;
  };

  /// The orphans of consecutive elements with their partners of equal or higher slots.
  struct Block {
    TestBatch tests;
    std::array<std::size_t, kBlockElements + 1> vf, ee;  ///< by element of the block: where its tests begin
    std::size_t bytes() const { return heap_bytes(tests.vf, tests.ee); }
  };

  /// The result of an update.
  struct Lists {
    std::vector<Index> elements, places;  ///< elements with partners, ascending; by slot: the place there, or kNone
    std::vector<std::size_t> begins;      ///< by place: where the element's partners begin in `partners`
    std::vector<Partner> partners;        ///< of an element: ascending
    std::vector<Block> blocks;            ///< there may be more than necessary

    Index place(Index o) const { return o < places.size() ? places[o] : kNone; }
    std::span<const Partner> of(Index o) const;
    std::size_t bytes() const { return heap_bytes(elements, places, begins, partners, blocks); }
  };

  void set_partners(std::span<const ElementPair> pairs, Executor& executor);
  bool reuse_partner_bits(std::size_t place);
  void find_candidates(std::size_t place, std::vector<Index>& partner_of);
  void fill(Block& block, std::size_t begin, std::size_t end) const;
  void keep(Index o, Block& block) const;

  const Partner* find(Index o, Index partner) const;
  template <std::uint64_t Partner::*kSet, class Visit>
  void visit_partners(std::span<const Index> elements, std::span<const Index> features, Index other,
                      Visit&& visit) const;
  bool is_orphan(FeatureKind kind, FeaturePair pair) const;
  void list(Index a, Index b, TestBatch& out) const;
  void vertices_and_triangles(Index a, Index b, TestBatch& out) const;

  const Topology* topology_ = nullptr;
  bool leave_out_shell_neighbours_ = false;
  TopologyDelta delta_;
  Lists now_, before_;
  std::vector<std::uint8_t> fresh_;    ///< by element slot: whether a vertex of the element has other elements
  std::vector<std::uint8_t> renewed_;  ///< by place: whether the element has other partners, or fresh ones
  std::vector<std::uint8_t> near_;     ///< by vertex: whether it belongs to a renewed element
  std::vector<Index> counts_;          ///< by element slot: number of partners
  std::vector<std::vector<Index>>
      partner_of_;  ///< by worker and element slot: the last element that it is a partner of
};

}  // namespace volccd::detail
