// The pairs that a flood goes on to.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <volccd/culling/detail/pair_set.hpp>
#include <volccd/culling/detail/star_classes.hpp>

namespace volccd::detail {

/// Pairs of non-adjacent simplices, each proposed once. Outer elements are those that the broad phase pairs
/// (Step::subset), the others inner ones; every proposed pair has an inner element. One thread at a time.
class FloodFront {
 public:
  /// `seen`: what was proposed before. Proposals are appended to `out`.
  FloodFront(const Step& step, const StarTable& stars, const StarClasses& classes, PairSet& seen,
             std::vector<ElementPair>& out)
      : step_(step), stars_(stars), classes_(classes), seen_(seen), out_(out) {}

  /// Over faces of either element to an inner one.
  void around(ElementPair pair);
  /// The pair itself.
  void again(ElementPair pair) { propose(pair.a, pair.b); }
  /// The same for all adjacent pairs that have common vertices in suspect stars only.
  void around_suspect_stars();

  /// For t = 0: inner elements that may contain one of the vertices, paired with an outer element at that vertex; and
  /// what lies around adjacent pairs that overlap, as around_at_start() goes on.
  void from_start(std::span<const Index> vertices, std::vector<std::pair<double, Index>>& scratch);
  /// Of an outer and an inner element: from the outer to all outer ones that share a vertex with it, from the inner
  /// over faces to inner ones.
  void around_at_start(ElementPair pair);

  /// A vertex, the smallest, of each part of the outer elements that is connected over common vertices. `scratch` keeps
  /// its memory.
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
