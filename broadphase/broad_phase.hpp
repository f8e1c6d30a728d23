// The broad-phase strategy: candidate pairs of elements whose swept bounds overlap.
#pragma once

#include <memory>
#include <span>

#include <volccd/core/executor.hpp>
#include <volccd/core/function_ref.hpp>
#include <volccd/core/stage.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Receives candidates in batches, from several workers at once; `worker` is the executor's. The span is valid during the
/// call only.
using PairSink = FunctionRef<void(std::span<const ElementPair> pairs, unsigned worker)>;

/// Which pairs a query wants.
enum class PairRange {
  nonadjacent,  ///< elements without a common vertex (what O-Sets leave to the element level, Section 5.1)
  every         ///< adjacent pairs too, and each live element with itself (o, o)
};

/// Guarantee (conservative): each unordered pair {a,b} of live elements in the range asked for whose closed swept volumes come
/// within step.separation of each other is emitted exactly once, a <= b, except pairs that step.filter drops
/// (ObjectFilter::drops). Bounds are rounded outward.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  virtual std::unique_ptr<StageState> make_state() const = 0;

  /// Builds, refits or restructures the acceleration structure in `state` for this step. Notices by itself whether the state
  /// is fresh, or was made for another topology or version. No allocation in steady state (same topology).
  virtual void update(const Step& step, StageState& state, Executor& executor) const = 0;

  /// Emits the pairs of the step that update() was called with last. Batches are of at most kMaxBatch pairs. The set of
  /// pairs does not depend on the number of workers; their order and grouping may.
  virtual void query(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const = 0;

  static constexpr std::size_t kMaxBatch = 1024;
};

}  // namespace volccd
