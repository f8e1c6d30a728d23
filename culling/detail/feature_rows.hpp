// Tests that rows of projections (vertex_rows.hpp) drop before their coordinates are gathered.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/culling/detail/vertex_rows.hpp>
#include <volccd/query/step.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::detail {

/// Drops a test if the projections of the two features on an axis are apart at each control point, in the same order,
/// by more than the separation: a subset of what FeatureKdopFilter drops with relative bounds. Read-only use is
/// thread-safe.
class FeatureRows {
 public:
  /// O(vertices), on all threads.
  void update(const Step& step, Executor& executor);

  /// Moves the tests that are left to the front, in their order, and returns their number. The step has the motion and
  /// the separation of the last update().
  std::size_t select(const Step& step, FeatureKind kind, std::span<FeaturePair> tests) const;

  std::size_t bytes() const { return rows_.capacity() * sizeof(VertexRow); }

 private:
  std::vector<VertexRow> rows_;
};

}  // namespace volccd::detail
