// The broad-phase strategy: finds candidate pairs of elements, whose swept bounds overlap.
#pragma once

#include <volccd/query/work_source.hpp>

namespace volccd {

/// Guarantee (conservative): each unordered pair {a,b} of live elements in step.range whose closed swept volumes come
/// within step.separation of each other is in exactly one block, with a <= b, unless step.filter drops it
/// (ObjectFilter::drops). Elements are adjacent by step.adjacency(). Bounds are rounded outward. The topology of the step
/// may have no edges and triangles (EdgeSet::none).
class BroadPhase : public WorkSource {
 public:
  static constexpr const char* kRole = "broad-phase";

  /// Number of blocks of candidate pairs for the step of the last prepare(). Called once after it; runs alone, and may
  /// use the executor. Blocks should be many and small, so that workers can share them.
  virtual std::size_t blocks(const Step& step, StageState& state, Executor& executor) const = 0;

  /// One round of pairs.
  Round next_round(const Step& step, StageState& state, std::size_t number, Executor& executor) const final {
    return {number == 0 ? blocks(step, state, executor) : 0, RoundKind::pairs};
  }
};

}  // namespace volccd
