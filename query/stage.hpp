// What all stages of a pipeline have in common: make_state() once, prepare() once a step, then run() on batches.
#pragma once

#include <memory>

#include <volccd/core/executor.hpp>
#include <volccd/core/stage.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Base of the stage interfaces: BroadPhase, ElementCulling, Assignment, OrphanSource, Flood, FeatureFilter,
/// NarrowPhase. Each adds its run(step, state, ...), and kRole, the name of its role in a pipeline.
///
/// Stages are immutable: one stage object may serve several workspaces in several threads at once. All that changes is
/// in the state. A state serves one step at a time:
///  - prepare() runs alone;
///  - run() is called concurrently by the workers of the executor that prepare() saw, each call with its worker's
///    number in [0, executor.workers()). It may read all of the state and may write what belongs to its worker alone.
///  - The step given to run() is that of the last prepare(); its t_max may be smaller.
/// prepare() and run() throw std::bad_alloc if memory runs out, and what their own header says. After an exception a
/// state is not used again.
class Stage {
 public:
  virtual ~Stage() = default;

  virtual std::unique_ptr<StageState> make_state() const { return std::make_unique<StageState>(); }

  /// Brings `state`, made by make_state() of this stage, up to the step: builds what it lacks, and updates what it
  /// holds from earlier steps, which may have had another motion or another topology (TopologyDelta tells what
  /// changed). May use the executor. No allocation in steady state (same topology).
  virtual void prepare(const Step& step, StageState& state, Executor& executor) const {
    (void)step, (void)state, (void)executor;
  }
};

}  // namespace volccd
