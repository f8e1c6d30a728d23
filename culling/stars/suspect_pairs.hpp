// The adjacent pairs of elements that may touch elsewhere than in their common vertices.
#pragma once

#include <cstddef>
#include <span>

#include <volccd/core/executor.hpp>
#include <volccd/core/function_ref.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/detail/corner_planes.hpp>
#include <volccd/culling/stars/vertex_stars.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// All pairs of elements with a common vertex, and of an element and itself, except those that are proven to touch only
/// in their common features throughout the step (docs/clear_stars.md, "Pairs that cannot touch"):
///  1. because a common vertex has a clear star;
///  2. because they are one tetrahedron, or two with a common inner face, whose volumes have one sign;
///  3. and 4. because they have one or two common vertices, and lie on different sides of a plane through these.
/// Not thread-safe; uses the executor.
class SuspectPairs {
 public:
  /// Lists the pairs for the step of the last stars.update(). Planes through two vertices are tried if pays(a, b) for
  /// the elements. Planes take about a microsecond for each pair. Pairs without tests in step.piece.region are left
  /// out: this serves lists of orphans, but not a flood, which begins at suspect pairs wherever they are.
  void update(const Step& step, const VertexStars& stars, Executor& executor, FunctionRef<bool(Index, Index)> pays);

  /// The pairs, with a <= b, each once. Their order depends on the executor.
  std::span<const ElementPair> pairs() const { return list_.pairs(); }

  std::size_t bytes() const { return heap_bytes(list_); }

 private:
  CornerPairList list_;
};

}  // namespace volccd::detail
