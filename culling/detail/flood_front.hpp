// The pairs that a flood proposes next.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/pair_set.hpp>
#include <volccd/culling/detail/star_classes.hpp>
#include <volccd/culling/detail/suspect_pairs.hpp>

namespace volccd::detail {

/// The outer parts next to given ones: at a vertex with a ring that has faces alone, those with a common edge; at any
/// other vertex, all others. A path through outer parts that are next to each other exists wherever one exists through
/// parts with common vertices, because it can go around a vertex with a ring. Not thread-safe.
class OuterNeighbours {
 public:
  /// Forgets what was found; for another topology or subset.
  void clear(Index slots) {
    ranges_.assign(slots, {kNone, 0});
    list_.clear();
  }
  /// Pre: o has an outer part. Found when it is asked for, and kept until clear(). Valid until the next call.
  std::span<const Index> of(const Step& step, const StarTable& stars, Index o);

  std::size_t bytes() const { return heap_bytes(ranges_, list_); }

 private:
  std::vector<std::array<Index, 2>> ranges_;  ///< by element slot: part of the list; begins with kNone if not known
  std::vector<Index> list_;
};

/// Memory for the flood at t = 0, to be reused.
struct StartScratch {
  std::vector<std::pair<double, Index>> along_x;
  std::vector<std::array<Index, 2>> ranks;
  std::vector<std::vector<std::array<Index, 2>>> contained;  ///< by worker: an element and a vertex in its box
  OuterNeighbours neighbours;

  std::size_t bytes() const { return heap_bytes(along_x, ranks, contained, neighbours); }
};

/// Pairs of non-adjacent simplices, each proposed once. The subset of the step holds the outer part of each simplex:
/// the whole simplex, a face, or nothing. A simplex that is not outer as a whole has an inside. Not thread-safe.
class FloodFront {
 public:
  /// `seen`: the pairs proposed so far. New proposals are appended to `out`.
  FloodFront(const Step& step, const StarTable& stars, const SuspectPairs& suspects, PairSet& seen,
             std::vector<ElementPair>& out)
      : step_(step), stars_(stars), suspects_(suspects), seen_(seen), out_(out) {}

  /// Proposes the pairs in which one element of `pair` is replaced by a neighbour across a face that has an inside.
  void around(ElementPair pair);
  /// Proposes the pair itself.
  void again(ElementPair pair) { propose(pair.a, pair.b); }
  /// Does the same as around() for all adjacent pairs that may have double points.
  void around_suspect_pairs();

  /// For t = 0: forms the pairs of an element whose inside may contain one of the vertices and an element whose outer
  /// part has that vertex. Then proceeds from adjacent pairs that may overlap, as around_at_start() does. Pre for both:
  /// the neighbours in `scratch` are those of this subset.
  void from_start(std::span<const Index> vertices, StartScratch& scratch, Executor& executor);
  /// For each element of the pair that has an outer part: proposes pairs with this element replaced by others whose
  /// outer parts are next to it and whose boxes meet, if the other element has an inside; and pairs with the other
  /// element replaced by neighbours across faces that have an inside.
  void around_at_start(ElementPair pair, StartScratch& scratch);

  /// One vertex, the smallest, of each set of outer parts that is connected by common vertices. The memory of
  /// `scratch` is reused.
  static void one_of_each_part(const Step& step, std::vector<Index>& parts, std::vector<Index>& scratch);

 private:
  bool outer(Index o) const { return step_.subset->contains(o); }
  bool has_inside(Index o) const { return !step_.subset->contains_whole(o); }
  void proceed_at_start(Index outer_element, Index other, StartScratch& scratch);
  bool beyond_a_face_at_start(Index a, Index b) const;
  double moved(double coordinate, int outward) const;
  Eigen::AlignedBox3d box_at_start(std::span<const Index> vertices) const;
  void rank_vertices(StartScratch& scratch, Executor& executor) const;
  void from_contained(std::span<const Index> vertices, StartScratch& scratch, Executor& executor);
  bool box_contains(Index o, Index v) const;
  void inner_neighbours(Index of, Index other);
  void propose(Index a, Index b);

  const Step& step_;
  const StarTable& stars_;
  const SuspectPairs& suspects_;
  PairSet& seen_;
  std::vector<ElementPair>& out_;
};

}  // namespace volccd::detail
