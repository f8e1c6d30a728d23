// The pairs that a flood proposes next.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <volccd/culling/detail/pair_set.hpp>
#include <volccd/culling/detail/star_classes.hpp>

namespace volccd::detail {

/// Pairs of non-adjacent simplices, each proposed once. Outer elements are those that the broad phase pairs
/// (Step::subset); all others are inner elements. Every proposed pair has an inner element. Not thread-safe.
class FloodFront {
 public:
  /// `seen`: the pairs proposed so far. New proposals are appended to `out`.
  FloodFront(const Step& step, const StarTable& stars, const StarClasses& classes, PairSet& seen,
             std::vector<ElementPair>& out)
      : step_(step), stars_(stars), classes_(classes), seen_(seen), out_(out) {}

  /// Proposes the pairs in which one element of `pair` is replaced by an inner neighbour across a face.
  void around(ElementPair pair);
  /// Proposes the pair itself.
  void again(ElementPair pair) { propose(pair.a, pair.b); }
  /// Does the same as around() for all adjacent pairs whose common vertices all have suspect stars.
  void around_suspect_stars();

  /// For t = 0: pairs each inner element that may contain one of the vertices with an outer element at that vertex, and
  /// proceeds from adjacent pairs that may overlap as around_at_start() does.
  void from_start(std::span<const Index> vertices, std::vector<std::pair<double, Index>>& scratch);
  /// For a pair of an outer and an inner element: proposes pairs with the outer element replaced by outer elements that
  /// share a vertex with it, and pairs with the inner element replaced by inner neighbours across faces.
  void around_at_start(ElementPair pair);

  /// One vertex, the smallest, of each part of the outer elements that is connected by common vertices. The memory of
  /// `scratch` is reused.
  static void one_of_each_part(const Step& step, std::vector<Index>& parts, std::vector<Index>& scratch);

 private:
  bool outer(Index o) const { return step_.subset->contains(o); }
  bool has_inner_neighbour(Index o) const;
  bool may_overlap_at_start(Index a, Index b) const;
  bool beyond_a_face_at_start(Index a, Index b) const;
  void from_contained(std::span<const Index> vertices, std::vector<std::pair<double, Index>>& along_x);
  void inner_neighbours(Index of, Index other);
  void propose(Index a, Index b);

  const Step& step_;
  const StarTable& stars_;
  const StarClasses& classes_;
  PairSet& seen_;
  std::vector<ElementPair>& out_;
};

}  // namespace volccd::detail
