// The broad-phase strategy: finds candidate pairs of elements, whose swept bounds overlap.
#pragma once

#include <span>

#include <volccd/core/function_ref.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/stage.hpp>

namespace volccd {

/// Receives candidates in batches, from several workers concurrently. `worker` is the number of the executor's worker.
/// The span is valid during the call only.
using PairSink = FunctionRef<void(std::span<const ElementPair> pairs, unsigned worker)>;

/// Which element pairs the caller requests.
enum class PairRange {
  nonadjacent,  ///< pairs of elements without a common vertex (O-Sets cover the others, Section 5.1)
  every         ///< also pairs of adjacent elements, and the self pair (o, o) of each live element
};

/// Guarantee (conservative): each unordered pair {a,b} of elements that take part (Step::takes_part), in the requested
/// range, the closed swept volumes of whose parts (Step::part) come within step.separation of each other is emitted
/// exactly once, with a <= b, unless step.filter drops it (ObjectFilter::drops). Bounds are rounded outward.
class BroadPhase : public Stage {
 public:
  static constexpr const char* kRole = "broad-phase";

  /// Emits the candidate pairs of the step of the last prepare(). Called once per step, on one thread; distributes its
  /// work over the executor itself. A batch has at most kMaxBatch pairs. The set of pairs does not depend on the number
  /// of workers; their order and grouping may. Pre: prepare() was called with this step and this executor.
  virtual void run(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const = 0;

  /// Seconds that the last prepare() spent on the bounds of vertices, which the paper reports separately (Figure 11); 0
  /// if the stage does not measure this time.
  virtual double bounds_seconds(const StageState& state) const {
    (void)state;
    return 0;
  }

  static constexpr std::size_t kMaxBatch = 1024;
};

}  // namespace volccd
