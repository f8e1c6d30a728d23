// The adjacent pairs of simplices that may have a double point.
#pragma once

#include <cstddef>
#include <span>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/corner_planes.hpp>
#include <volccd/culling/detail/pair_set.hpp>
#include <volccd/culling/detail/star_classes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// All pairs of simplices with a common vertex, and of a simplex and itself, except those that are proven to have no
/// double point throughout the step (docs/boundary_flood.md): because a common vertex has a clear star, or because they
/// lie on different sides of a plane through all their common vertices. Only pairs with one or two common vertices are
/// tested for such a plane. Not thread-safe; uses the executor.
class SuspectPairs {
 public:
  /// Lists the pairs for the step of the last classes.update(). Tests of planes: about a microsecond for each pair of
  /// simplices that have suspect common vertices only.
  void update(const Step& step, const StarClasses& classes, Executor& executor);

  /// The pairs, with a <= b, each once. Their order depends on the executor.
  std::span<const ElementPair> pairs() const { return list_.pairs(); }
  bool contains(Index a, Index b) const { return set_.contains({a, b}); }

  std::size_t bytes() const { return heap_bytes(list_, set_); }

 private:
  CornerPairList list_;
  PairSet set_;
};

}  // namespace volccd::detail
