// The broad-phase strategy: candidate pairs of elements whose swept bounds overlap.
#pragma once

#include <span>

#include <volccd/core/function_ref.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/stage.hpp>

namespace volccd {

/// Receives candidates in batches, from several workers at once; `worker` is the executor's. The span is valid during
/// the call only.
using PairSink = FunctionRef<void(std::span<const ElementPair> pairs, unsigned worker)>;

/// Which pairs a query wants.
enum class PairRange {
  nonadjacent,  ///< elements without a common vertex (what O-Sets leave to the element level, Section 5.1)
  every         ///< adjacent pairs too, and each live element with itself (o, o)
};

/// Guarantee (conservative): each unordered pair {a,b} of elements that take part (Step::takes_part), in the range
/// asked for, whose closed swept volumes come within step.separation of each other is emitted exactly once, a <= b,
/// except pairs that step.filter drops (ObjectFilter::drops). Bounds are rounded outward.
class BroadPhase : public Stage {
 public:
  static constexpr const char* kRole = "broad-phase";

  /// Emits the pairs of the step that prepare() was called with last. Called once a step, on one thread; spreads its
  /// work over the executor by itself. Batches are of at most kMaxBatch pairs. The set of pairs does not depend on the
  /// number of workers; their order and grouping may. Pre: prepare() saw this step and this executor.
  virtual void run(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const = 0;

  /// Seconds that the last prepare() spent on the bounds of vertices, a part that the paper lists by itself (Figure
  /// 11); 0 if the stage does not measure it.
  virtual double bounds_seconds(const StageState& state) const {
    (void)state;
    return 0;
  }

  static constexpr std::size_t kMaxBatch = 1024;
};

}  // namespace volccd
