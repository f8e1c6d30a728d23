// Runs single stages: state, prepare() and run() in one call, on the calling thread.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <volccd/query/roles/element_culling.hpp>
#include <volccd/query/roles/feature_filter.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd::test {

/// A new state of the stage, prepared for the step.
inline std::unique_ptr<StageState> prepared(const Stage& stage, const Step& step) {
  SerialExecutor executor;
  std::unique_ptr<StageState> state = stage.make_state();
  stage.prepare(step, *state, executor);
  return state;
}

/// A state in which select() may be called.
inline std::unique_ptr<StageState> prepared_to_select(const FeatureFilter& stage, const Step& step) {
  SerialExecutor executor;
  std::unique_ptr<StageState> state = prepared(stage, step);
  stage.prepare_select(step, *state, executor);
  return state;
}

inline void run_stage(const ElementCulling& stage, const Step& step, PairBatch& batch) {
  stage.run(step, *prepared(stage, step), 0, batch);
}

/// select() and run() on all tests of the block.
inline void run_stage(const FeatureFilter& stage, const Step& step, const TestBlock& block,
                      std::span<std::uint8_t> keep) {
  const auto state = prepared_to_select(stage, step);
  std::vector<FeaturePair> tests(block.pairs().begin(), block.pairs().end());
  tests.resize(stage.select(step, *state, 0, block.kind(), tests));
  for (std::size_t i = 0, next = 0; i < block.size(); ++i)
    if (next < tests.size() && tests[next] == block.pair(i))
      ++next;
    else
      keep[i] = 0;
  stage.run(step, *state, 0, block, keep);
}

/// Runs all tests in blocks, and appends the contacts.
inline void run_stage(const NarrowPhase& stage, const Step& step, FeatureKind kind, std::span<const FeaturePair> tests,
                      std::vector<Contact>& contacts, NarrowCounters& counters) {
  const auto state = prepared(stage, step);
  TestBlock block;
  for (; !tests.empty(); tests = tests.subspan(block.size())) {
    block.gather(step, kind, tests.first(std::min(tests.size(), TestBlock::kCapacity)));
    stage.run(step, *state, 0, block, contacts, counters);
  }
}

}  // namespace volccd::test
