// What a worker does with tests: feature filters in order, then the narrow phase, on blocks.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include <volccd/culling/feature_filter.hpp>
#include <volccd/narrowphase/narrow_phase.hpp>
#include <volccd/pipelines/stage_clock.hpp>
#include <volccd/pipelines/statistics.hpp>

namespace volccd {

/// The stages of a chain, and what belongs to them: states and statistics, those of the filters in order, then that of
/// the narrow phase. What is referred to outlives the run.
struct TestStages {
  std::span<const std::unique_ptr<FeatureFilter>> filters;
  const NarrowPhase& narrow_phase;
  std::span<const std::unique_ptr<StageState>> states;
};

/// The tests of a worker are gathered once into blocks. What a filter keeps is collected, by kind, in a block before
/// the next stage, which runs when that block is full: blocks are full although filters keep few tests.
///
/// Tests that step.filter does not ask for are dropped: before the filters where whole scopes are excluded, else after
/// them. Reused from step to step; no allocation in steady state but for the contacts. One thread at a time.
class TestChain {
 public:
  /// Begins a step: forgets tests and contacts. `statistics`, as many as stages.states, are added to.
  void start(const Step& step, const TestStages& stages, std::span<StageStatistics> statistics, unsigned worker);

  /// Filters may from now on drop what touches only after t_max <= step.t_max. The narrow phase sees the step as it is.
  void prune(double t_max) { t_max_ = t_max; }

  /// Takes in tests and runs the first stage on them, best on multiples of TestBlock::kCapacity. Overwrites `tests`.
  void add(FeatureKind kind, std::span<FeaturePair> tests);
  /// Runs the later stages on what is left in their blocks.
  void finish();

  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }
  const NarrowCounters& counters() const { return counters_; }
  /// Tests of a kind that the narrow phase performed.
  std::uint64_t tests(FeatureKind kind) const { return tests_[static_cast<std::size_t>(kind)]; }
  StageClock& clock() { return clock_; }
  std::size_t bytes() const;

 private:
  using Blocks = std::deque<TestBlock>;  ///< before filter i; the last: before the narrow phase

  Blocks& blocks(FeatureKind kind) { return blocks_[static_cast<std::size_t>(kind)]; }
  std::size_t asked_for(FeatureKind kind, std::span<FeaturePair> tests) const;
  void run(FeatureKind kind, std::size_t stage);
  void run_filter(FeatureKind kind, std::size_t stage);
  void run_narrow_phase(const TestBlock& block);
  void keep_asked_for(const TestBlock& block, std::span<std::uint8_t> keep) const;

  const Step* step_ = nullptr;
  const TestStages* stages_ = nullptr;
  std::span<StageStatistics> statistics_;
  unsigned worker_ = 0;
  double t_max_ = 1;
  std::array<Blocks, 2> blocks_;
  std::vector<Contact> contacts_;
  NarrowCounters counters_;
  std::array<std::uint64_t, 2> tests_{};
  StageClock clock_;
};

}  // namespace volccd
