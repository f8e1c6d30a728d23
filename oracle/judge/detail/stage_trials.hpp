// The parts of check_stage(): one for each kind of stage, and one for pipelines that contain it.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>

#include <volccd/core/executor.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>
#include <volccd/oracle/cases/near_degenerate.hpp>
#include <volccd/oracle/judge/stage_check.hpp>

namespace volccd::detail {

// Promises, as named in reports.
inline constexpr const char* kLosesNoContact = "loses no contact";
inline constexpr const char* kInventsNoContact = "invents no contact";
inline constexpr const char* kTimes = "times are never late, and early by no more than the tolerance";
inline constexpr const char* kCertain = "a contact that is not counted as undecided is one";
inline constexpr const char* kNear = "the features of a decided contact are near each other at its time";
inline constexpr const char* kEarlierEnd = "with an earlier end of the step, the contacts before it are the same";
inline constexpr const char* kSameOnEverySet = "the answer does not depend on the instruction set";
inline constexpr const char* kWellFormed = "contacts are well formed, in the order of the tests";
inline constexpr const char* kStarts = "find_at_start() finds contacts of run() that begin at t = 0";
inline constexpr const char* kSelects = "select() takes tests out, and leaves the others in their order";
inline constexpr const char* kSameInEveryBatch = "the answer does not depend on the batch or the worker";
inline constexpr const char* kSameAfterOtherSteps = "the answer does not depend on earlier steps";
inline constexpr const char* kOverlapsStay = "drops no pair as disjoint that overlaps at the start";
inline constexpr const char* kOnlyDrops = "takes pairs out of the batch, and changes nothing else";
inline constexpr const char* kEmitsAll = "emits every pair that meets during the step";
inline constexpr const char* kEmitsOnce = "emits each pair once, in order, by a worker of the executor";
inline constexpr const char* kComplete = "its tests contain every feature pair that it owes";
inline constexpr const char* kTests = "tests have no common vertex";
inline constexpr const char* kNoAllocation = "allocates nothing in steady state";
inline constexpr const char* kPipelinesAgree = "pipelines that contain it find the contacts of those that do not";
inline constexpr const char* kThreadsAgree = "pipelines that contain it find the same contacts with several threads";
inline constexpr const char* kOverlapsAgree = "pipelines that contain it list the same initial overlaps";

/// Data and functions shared by the parts; collects their results in the report.
class StageTrials {
 public:
  StageTrials(const StageCheckConfig& c, StageReport& report)
      : config(c), threads(make_thread_executor(std::max(2u, c.threads))), report_(report) {}

  /// Counts an answer. If it breaks the promise, text() describes it. A broken promise fails the check only if it is
  /// `required`.
  template <class Text>
  void expect(const char* promise, bool kept, Text&& text, bool required = true) {
    PromiseReport& one = find(promise, required);
    ++one.checked;
    if (kept) return;
    if (++one.broken == 1) one.example = text();
  }

  /// Whether the stage promises to lose no contact; whether it also promises to report none in excess.
  bool conservative() const { return report_.guarantee != Guarantee::approximate; }
  bool exact() const { return report_.guarantee == Guarantee::exact; }

  /// Calls body(choices, "seed N, AVX2: ") for the trials [0, count), while kernels use the instruction set of this
  /// name: the seed determines which.
  void each_trial(int count, const std::function<void(cases::Choices&, const std::string& where)>& body) const;

  static constexpr int kWarmUp = 4;
  /// Calls step(k), which prepares and runs the stage on step k of one topology, 2 * kWarmUp times, and expects that
  /// the calls after the warm-up do not allocate.
  void expect_no_allocation(const std::function<void(int k)>& step, bool required = true);

  /// Calls body(name) while kernels use another instruction set than that of the trial; the trials use all others in
  /// turn. Does nothing if there is only one.
  void with_another_set(const std::function<void(const char* name)>& body) const;

  const StageCheckConfig& config;
  SerialExecutor serial;
  std::unique_ptr<Executor> threads;

 private:
  /// Which instruction set a trial uses.
  std::size_t set_of(std::uint64_t seed) const { return config.instruction_sets ? seed % sets_.size() : 0; }

  PromiseReport& find(const char* promise, bool required);

  StageReport& report_;
  cases::InstructionSets sets_;
  mutable std::uint64_t seed_ = 0;  ///< of the trial
};

void try_stage(const BroadPhase& stage, StageTrials& trials);
void try_stage(const ElementCulling& stage, StageTrials& trials);
void try_stage(const Assignment& stage, StageTrials& trials);
void try_stage(const OrphanSource& stage, StageTrials& trials);
void try_stage(const Flood& stage, StageTrials& trials);
void try_stage(const FeatureFilter& stage, StageTrials& trials);
void try_stage(const NarrowPhase& stage, StageTrials& trials);

/// Runs pipelines in which the stage replaces that of the presets.
void try_pipelines(const Registry& registry, const StageReport& stage, StageTrials& trials);

/// Properties of a step, apart from its features, that are chosen for a trial.
struct StepChoice {
  FeatureKind kind;
  int control_points;
  bool separation;
};
StepChoice choose_step(cases::Choices& choices, int max_control_points = 3, bool separation = true);
/// Chooses t_max: 1, the time at which the features of the case touch, or any other time.
double choose_t_max(cases::Choices& choices, const cases::Case& c);

/// The test of a step as a case, for exact predicates.
cases::Case case_of(const Step& step, FeatureKind kind, FeaturePair pair);

}  // namespace volccd::detail
