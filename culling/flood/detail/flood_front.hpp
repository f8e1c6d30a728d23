// The pairs that a flood proposes next.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/flood/detail/pair_set.hpp>
#include <volccd/culling/flood/detail/part_table.hpp>
#include <volccd/culling/stars/star_table.hpp>

namespace volccd::detail {

/// A simplex whose outer part is next to that of another one. Bit i of `common` is set if vertex i of the other one's
/// outer part belongs to both.
struct OuterNeighbour {
  Index element;
  std::uint32_t common;
};

/// The outer parts next to given ones: at a vertex with a ring that has faces alone, those with a common edge; at any
/// other vertex, all others. A path through outer parts that are next to each other exists wherever one exists through
/// parts with common vertices, because it can go around a vertex with a ring. This is determined by the parts alone,
/// whatever an edit changes elsewhere (docs/boundary_flood.md). Not thread-safe.
class OuterNeighbours {
 public:
  /// Forgets what was found; for other parts.
  void clear(Index slots) {
    ranges_.assign(slots, {kNone, 0});
    list_.clear();
  }
  /// Pre: o has an outer part. Found when it is asked for, and kept until clear(). Valid until the next call.
  std::span<const OuterNeighbour> of(const Step& step, const StarTable& table, const PartTable& parts, Index o);

  std::size_t bytes() const { return heap_bytes(ranges_, list_); }

 private:
  std::vector<std::array<Index, 2>> ranges_;  ///< by element slot: part of the list; begins with kNone if not known
  std::vector<OuterNeighbour> list_;
};

/// Memory for the flood at t = 0, to be reused.
struct StartScratch {
  std::vector<std::pair<double, Index>> along_x;
  std::vector<std::array<Index, 2>> ranks;
  std::vector<std::vector<std::array<Index, 2>>> contained;  ///< by worker: an element and a vertex in its box
  OuterNeighbours neighbours;

  std::size_t bytes() const { return heap_bytes(along_x, ranks, contained, neighbours); }
};

/// Pairs of non-adjacent simplices, each proposed once. Not thread-safe.
class FloodFront {
 public:
  /// `seen`: the pairs proposed so far. New proposals are appended to `out`.
  FloodFront(const Step& step, const StarTable& table, const PartTable& parts, PairSet& seen,
             std::vector<ElementPair>& out)
      : step_(step), table_(table), parts_(parts), seen_(seen), out_(out) {}

  /// Proposes the pair itself, unless it is adjacent.
  void propose(ElementPair pair) { propose(pair.a, pair.b); }
  /// Proposes the pairs in which one element of `pair` is replaced by a neighbour across a face that has an inside
  /// (steps of kind 1 of the theorem). The pair may be adjacent.
  void propose_neighbours(ElementPair pair);

  /// For t = 0, and for each element of the pair that has an outer part: proposes pairs with the other element replaced
  /// by neighbours across faces that have an inside, and, if the other element has an inside, pairs with this element
  /// replaced by others whose outer parts are next to its outer part and have a vertex, edge or face in common with it
  /// whose box meets that of the other element (steps of kind 2). Pre: the neighbours in `scratch` are those of this
  /// parts.
  void propose_neighbours_at_start(ElementPair pair, StartScratch& scratch);
  /// For t = 0: proposes the pairs of an element whose inside may contain one of the vertices and an element whose
  /// outer part has that vertex (seeds of kind 2).
  void propose_containing(std::span<const Index> vertices, StartScratch& scratch, Executor& executor);
  /// Whether the elements of an adjacent pair are proven to have only their common vertices in common at t = 0, because
  /// they lie on different sides of a face of one of them.
  bool apart_at_start(ElementPair pair) const {
    return beyond_a_face_at_start(pair.a, pair.b) || beyond_a_face_at_start(pair.b, pair.a);
  }

 private:
  void propose_at_start(Index outer_element, Index other, StartScratch& scratch);
  bool beyond_a_face_at_start(Index a, Index b) const;
  double moved(double coordinate, int outward) const;
  Eigen::AlignedBox3d box_at_start(Index o) const;
  std::array<std::uint8_t, 4> sides_at_start(const Eigen::AlignedBox3d& box, std::span<const Index> vertices) const;
  void rank_vertices(StartScratch& scratch, Executor& executor) const;
  bool box_contains(Index o, Index v) const;
  void propose_across_faces(Index of, Index other);
  void propose(Index a, Index b);

  const Step& step_;
  const StarTable& table_;
  const PartTable& parts_;
  PairSet& seen_;
  std::vector<ElementPair>& out_;
};

}  // namespace volccd::detail
