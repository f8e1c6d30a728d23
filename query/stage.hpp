// What all stages of a pipeline have in common: make_state() is called once, prepare() once per step, then run() on
// batches.
#pragma once

#include <memory>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/stage.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// A named number of one step, which adds up over steps.
struct StageCounter {
  const char* name;  ///< a literal, e.g. "bounds_seconds"
  double value;
};

/// Base of the stage interfaces BroadPhase, OrphanSource and Flood (by way of WorkSource), ElementCulling, Assignment,
/// FeatureFilter and NarrowPhase. Each interface adds its own run(step, state, ...) and kRole, the name of its role in
/// a pipeline.
///
/// Stages are immutable: several threads may use one stage object at once, with different workspaces. All changes are
/// made to the state. A state is used for one step at a time:
///  - prepare() runs alone.
///  - run() is called concurrently by the workers of the executor that was given to prepare(); each call gets the
///    number of its worker in [0, executor.workers()). It may read the whole state and may write only the part of its
///    worker, or what the stage synchronises itself.
///  - prepare() is called at most once for a step, and only for stages that work in it; a flood is prepared for each
///  step,
///    because it then decides whether it takes the step. The step given to run() is that of the last prepare(): the
///    same objects with the same contents, except that t_max may be smaller. run() may rely on everything that
///    prepare() computed from it.
///  - Whether a run is observed (StageObserver) changes nothing about these calls.
/// prepare() and run() throw std::bad_alloc if memory is exhausted, and the errors that their own headers list. After
/// an exception the state must not be used again.
class Stage {
 public:
  /// The options of a stage that has none, which needs no constructor with a parameter either.
  struct Config {};
  virtual ~Stage() = default;

  virtual std::unique_ptr<StageState> make_state() const { return std::make_unique<StageState>(); }

  /// Updates `state`, which make_state() of this stage created, for the step: builds missing data, and updates data
  /// from earlier steps, which may have had another motion or another topology (TopologyDelta determines the changes).
  /// May use the executor. Does not allocate in steady state (same topology).
  virtual void prepare(const Step& step, StageState& state, Executor& executor) const {
    (void)step, (void)state, (void)executor;
  }

  /// Whether it reads Piece::cut_stars. Ranks exchange these elements only for a pipeline with such a stage.
  virtual bool uses_cut_stars() const { return false; }

  /// Appends what the stage measured in the last step besides its inputs, outputs and times (Statistics).
  virtual void append_counters(const StageState& state, std::vector<StageCounter>& out) const {
    (void)state, (void)out;
  }
};

}  // namespace volccd
